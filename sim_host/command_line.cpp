#include "command_line.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <set>
#include <stdexcept>

#include "config/arguments.hpp"
#include "experiments/design_check.hpp"
#include "run/scenario_check.hpp"

namespace trackservo::sim {

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

void show_progress(int done, int total, const std::string& what) {
  if (isatty(STDERR_FILENO) != 0) {
    fmt::print(stderr, "\r[{:3d} %] {:<60}{}", 100 * done / total, what, done == total ? "\n" : "");
    (void)std::fflush(stderr);
  } else if (10 * done / total > 10 * (done - 1) / total) {
    fmt::print(stderr, "[{:3d} %] {}\n", 100 * done / total, what);
  }
}

void refuse_repeated_seeds(std::vector<std::uint64_t> seeds) {
  std::sort(seeds.begin(), seeds.end());
  const auto twice = std::adjacent_find(seeds.begin(), seeds.end());
  if (twice != seeds.end()) {
    throw std::invalid_argument(fmt::format("--seeds: {} is given twice, which adds nothing; give each once", *twice));
  }
}

CLI::Validator seed() { return {seed_problem, "SEED"}; }

CLI::Validator share(double most) {
  return {[most](const std::string& text) {
            double value = 0.0;
            return CLI::detail::lexical_cast(text, value) && value >= 0.0 && value <= most
                       ? ""
                       : fmt::format("\"{}\" is no share; give 0 to {:g}", text, most);
          },
          fmt::format("0 to {:g}", most)};
}

}  // namespace trackservo::sim
