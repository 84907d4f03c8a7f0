// SPDX-License-Identifier: Apache-2.0
#include "check_command.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <numeric>
#include <stdexcept>
#include <thread>

#include "board_program.hpp"
#include "check/check_report.hpp"
#include "check/check_run.hpp"
#include "check/results_file.hpp"
#include "command_line.hpp"
#include "machine/config/arguments.hpp"
#include "machine/config/data_folder.hpp"
#include "machine/run/scenario_check.hpp"
#include "output_files.hpp"

namespace trackservo::sim {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kSeeds = 20;
constexpr std::size_t kImageSeeds = 3;  // the emulated board is slower
constexpr int kKept = 0;
constexpr int kNotKept = 1;

struct CheckOptions {
  fs::path data_dir = data_folder();
  fs::path plant;
  fs::path gains;
  std::vector<fs::path> scenarios;
  fs::path limits;
  fs::path learn;
  fs::path junit;
  fs::path baseline;
  bool baseline_only_reports = false;
  fs::path out_dir;
  fs::path image;
  std::vector<std::uint64_t> seeds;
  int threads = static_cast<int>(std::max(1U, std::thread::hardware_concurrency()));
};

std::vector<fs::path> scenario_files(const CheckOptions& options) {
  if (!options.scenarios.empty()) {
    return options.scenarios;
  }
  const fs::path folder = options.data_dir / "scenarios" / (options.image.empty() ? "" : "board");
  std::vector<fs::path> files = {folder / "steady_speed.toml", folder / "low_speed_start.toml", folder / "sine.toml"};
  if (options.image.empty()) {
    files.insert(files.end(), {folder / "step_disturbed.toml", folder / "tracking.toml"});
  }
  return files;
}

std::vector<ScenarioConfig> load_scenarios(const std::vector<fs::path>& files, const PlantConfig& plant) {
  std::vector<ScenarioConfig> scenarios;
  for (const fs::path& file : files) {
    ScenarioConfig scenario = load_scenario(file);
    const bool taken = scenario.name == kLoopScenario || scenario.name == "learned" || scenario.name == "baseline" ||
                       std::any_of(scenarios.begin(), scenarios.end(),
                                   [&](const ScenarioConfig& other) { return other.name == scenario.name; });
    if (taken) {
      throw scenario.lines.error("name", fmt::format("the name \"{}\" is already used in this check", scenario.name),
                                 "give each scenario its own name, other than loop, learned or baseline");
    }
    warn(check_scenario(plant, scenario));
    scenarios.push_back(std::move(scenario));
  }
  return scenarios;
}

std::size_t default_seeds(const CheckOptions& options) { return options.image.empty() ? kSeeds : kImageSeeds; }

fs::path plant_file(const CheckOptions& options) {
  return options.plant.empty() ? options.data_dir / "plants/tracker.toml" : options.plant;
}

CheckPlan plan_of(const CheckOptions& options, const ImageDevices& image_devices) {
  CheckPlan plan;
  plan.plant = load_plant(plant_file(options));
  if (!options.gains.empty()) {
    plan.gains = read_gains(options.gains, plan.plant);
  }
  plan.scenarios = load_scenarios(scenario_files(options), plan.plant);
  plan.seeds = options.seeds;
  if (plan.seeds.empty()) {
    plan.seeds.resize(default_seeds(options));
    std::iota(plan.seeds.begin(), plan.seeds.end(), 1);
  }
  refuse_repeated_seeds(plan.seeds);
  plan.threads = options.threads;
  plan.only_device = !options.image.empty();
  plan.make_device = plan.only_device ? image_devices(options.image) : make_simulated_device;
  refuse_impossible(plan);
  return plan;
}

// The files of the shipped plant need not be named.
fs::path limits_file(const CheckOptions& options) {
  if (!options.limits.empty()) {
    return options.limits;
  }
  if (!options.plant.empty()) {
    throw std::invalid_argument(
        "a plant file of your own needs limits: give --limits FILE, or write them with --learn FILE");
  }
  return options.data_dir / "limits" / (options.image.empty() ? "tracker.toml" : "tracker_board.toml");
}

// The files that no option names.
std::vector<fs::path> default_inputs(const CheckOptions& options) {
  std::vector<fs::path> files = scenario_files(options);
  if (options.plant.empty()) {
    files.push_back(plant_file(options));
  }
  if (options.plant.empty() && options.learn.empty()) {
    files.push_back(limits_file(options));
  }
  return files;
}

Limits limits_of(const CheckOptions& options, const CheckPlan& plan, const std::vector<CheckFigure>& figures) {
  Limits limits = read_limits(limits_file(options), figures, !options.scenarios.empty());
  const int seeds = static_cast<int>(plan.seeds.size());
  if (limits.for_seeds && *limits.for_seeds > seeds) {
    warn({fmt::format("{}: is meant for {} seeds; means over {} scatter more, so an unchanged firmware may fail",
                      limits.file.string(), *limits.for_seeds, seeds)});
  }
  return limits;
}

void write_artefacts(const CheckOptions& options, const CheckReport& report) {
  if (!options.junit.empty()) {
    write_junit(report, options.junit);
  }
  if (!options.out_dir.empty()) {
    write_results(report, options.out_dir / "results.json");
    write_page(report, options.out_dir / "report.html");
    fmt::print("Wrote {0}/results.json and {0}/report.html\n", options.out_dir.string());
  }
}

int check(const CheckOptions& options, const ImageDevices& image_devices) {
  const CheckPlan plan = plan_of(options, image_devices);
  const bool learns = !options.learn.empty();
  Limits limits;
  if (!learns) {
    limits = limits_of(options, plan, figures_of(plan));
  }
  std::optional<Baseline> baseline;
  if (!options.baseline.empty()) {
    baseline = read_baseline(options.baseline);
  }
  const std::vector<CheckFigure> figures = run_check(plan, show_progress);
  CheckReport report;
  report.git = TRACKSERVO_GIT;
  report.plant = plan.plant.name;
  report.gains = options.gains.empty() ? "of a new device" : options.gains.string();
  report.device = options.image.empty() ? "this build's firmware" : "image " + options.image.string();
  report.seeds = plan.seeds;
  if (learns) {
    limits = learn_limits(figures, fmt::format("plant {}, gains {}", report.plant, report.gains),
                          static_cast<int>(std::min(plan.seeds.size(), default_seeds(options))), options.learn);
  } else {
    report.limits = limits.file.string();
  }
  report.figures = judge(figures, limits);
  if (baseline) {
    report.comparison = compare(*baseline, figures, plan.seeds);
    report.worse_is_red = !options.baseline_only_reports;
  }
  print(report);
  write_artefacts(options, report);
  if (learns) {
    fmt::print("Wrote {}: {} limits\n", options.learn.string(), limits.values.size());
  }
  return report.kept() ? kKept : kNotKept;
}

}  // namespace

void add_check(CLI::App& app, int& code, const std::vector<std::string>& arguments, const ImageDevices& image_devices) {
  auto options = std::make_shared<CheckOptions>();
  CLI::App *command =
      app.add_subcommand("check", "check that firmware and gains meet their limits on a plant; for CI see docs/ci.md");
  command->footer("Exit code: 0 all limits met, 1 a limit not met, 2 wrong input.");
  command->add_option("--plant", options->plant, "plant file (TOML); default: the shipped tracker and its limits")
      ->check(CLI::ExistingFile);
  command
      ->add_option("--gains", options->gains,
                   "gains file, written by servoctl save or sim_host gains; default: the gains of a new device")
      ->check(CLI::ExistingFile);
  command
      ->add_option("--scenario", options->scenarios,
                   "scenario file (TOML), may be repeated; default: the shipped scenarios")
      ->check(CLI::ExistingFile)
      ->expected(1)
      ->take_all();
  OutputFiles outputs(*command);
  outputs.reads([options] { return default_inputs(*options); });
  // First, so that the other files can be written into the folder that it makes.
  outputs.folder("--out", options->out_dir, "folder for results.json and report.html", {"results.json", "report.html"});
  CLI::Option *limits =
      command->add_option("--limits", options->limits, "limits file (TOML)")->check(CLI::ExistingFile);
  outputs.file("--learn", options->learn, "write limits that this run meets, instead of checking limits")
      ->excludes(limits);
  outputs.file("--junit", options->junit, "write the result as JUnit XML to this file");
  CLI::Option *baseline = command
                              ->add_option("--baseline", options->baseline,
                                           "results.json of an earlier check; a worse figure fails the check")
                              ->check(CLI::ExistingFile);
  command
      ->add_flag("--baseline-only-reports", options->baseline_only_reports,
                 "a figure worse than the baseline does not fail the check")
      ->needs(baseline);
  command
      ->add_option("--image", options->image,
                   "check this image of the board on the emulated board, instead of the firmware of this build")
      ->check(CLI::ExistingFile);
  command->add_option("--seeds", options->seeds, "seeds to run; default: 1 to 20, with --image 1 to 3")->check(seed());
  command->add_option("--threads", options->threads, "number of threads")
      ->check(CLI::Range(1, 256))
      ->capture_default_str();
  command->add_option("--data", options->data_dir, kDataHelp)->check(CLI::ExistingDirectory);
  command->callback([options, &code, &arguments, &image_devices] {
    if (!options->image.empty() && !image_devices) {
      hand_over_to_board(arguments);
    }
    code = check(*options, image_devices);
  });
}

void add_gains(CLI::App& app) {
  struct GainsOptions {
    fs::path plant;
    fs::path out;
  };
  auto options = std::make_shared<GainsOptions>();
  CLI::App *command = app.add_subcommand("gains", "design gains for a plant and write them to a gains file");
  command->add_option("--plant", options->plant, "plant file (TOML)")->required()->check(CLI::ExistingFile);
  OutputFiles(*command).file("--out", options->out, "gains file to write (TOML)")->required();
  command->callback([options] {
    write_designed_gains(load_plant(options->plant), options->out);
    fmt::print("written {}\n", options->out.string());
  });
}

}  // namespace trackservo::sim
