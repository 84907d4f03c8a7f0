// SPDX-License-Identifier: Apache-2.0
#include "command_line.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <set>
#include <stdexcept>

#include "design/design_check.hpp"
#include "machine/base/progress.hpp"
#include "machine/config/arguments.hpp"
#include "machine/run/scenario_check.hpp"

namespace trackservo::sim {
namespace {

double now_s() { return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count(); }

ProgressPrinter& printer() {
  static ProgressPrinter printer(stderr, isatty(STDERR_FILENO) != 0, now_s);
  return printer;
}

}  // namespace

void start_progress() { printer(); }

void warn(const std::vector<std::string>& texts) {
  static std::set<std::string> said;
  for (const std::string& text : texts) {
    if (said.insert(text).second) {
      fmt::print(stderr, "sim_host: warning: {}\n", text);
    }
  }
}

servo_params checked_design(const Study& study, const ControllerSpec& spec, const DesignOptions& options) {
  warn(check_scenario(study.plant, study.scenario));
  const servo_params params = design_controller(study.plant, spec, options);
  warn(margin_warnings(study.plant, params));
  return params;
}

void show_progress(int done, int total, const std::string& what) { printer().show(done, total, what); }

void refuse_repeated_seeds(std::vector<std::uint64_t> seeds) {
  std::sort(seeds.begin(), seeds.end());
  const auto twice = std::adjacent_find(seeds.begin(), seeds.end());
  if (twice != seeds.end()) {
    throw std::invalid_argument(fmt::format("--seeds: {} is given twice; give each seed once", *twice));
  }
}

CLI::Validator seed() { return {seed_problem, "SEED"}; }

std::optional<SeedRange> seed_range(const std::string& text) {
  const std::size_t dash = text.find('-');
  const std::string from = text.substr(0, dash);
  const std::string to = dash == std::string::npos ? from : text.substr(dash + 1);
  if (!seed_problem(from).empty() || !seed_problem(to).empty()) {
    return std::nullopt;
  }
  SeedRange range;
  range.has_first = dash != std::string::npos;
  range.first = range.has_first ? std::stoull(from) : range.first;
  range.count = std::stoull(to) - (range.has_first ? range.first : 0) + (range.has_first ? 1 : 0);
  return range;
}

CLI::Validator seed_range_check(int min, int max) {
  return {[min, max](const std::string& text) {
            const std::optional<SeedRange> range = seed_range(text);
            const bool fits = range && range->count >= static_cast<std::uint64_t>(min) &&
                              range->count <= static_cast<std::uint64_t>(max);
            return fits ? ""
                        : fmt::format("Invalid seeds \"{}\": expected a number from {} to {}, or a range as 1-1000",
                                      text, min, max);
          },
          "N or A-B"};
}

void add_threads(CLI::App& command, int& threads) {
  command.add_option("--threads", threads, "number of runs in parallel; default: the number of processors")
      ->check(CLI::Range(1, 64))
      ->capture_default_str();
}

CLI::Validator share(double most) {
  return {[most](const std::string& text) {
            double value = 0.0;
            return CLI::detail::lexical_cast(text, value) && value >= 0.0 && value <= most
                       ? ""
                       : fmt::format("Invalid share \"{}\": expected a number from 0 to {:g}", text, most);
          },
          fmt::format("0 to {:g}", most)};
}

int run_program(const char *name, CLI::App& app, int argc, char **argv, const int& code) {
  constexpr int kWrongInput = 2;
  app.set_version_flag("--version", fmt::format("{} {}", name, TRACKSERVO_VERSION), "print the version");
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : kWrongInput;
  } catch (const std::exception& error) {
    (void)std::fprintf(stderr, "%s: %s\n", name, error.what());
    return kWrongInput;
  }
  return code;
}

}  // namespace trackservo::sim
