// SPDX-License-Identifier: Apache-2.0
#include "fault_commands.hpp"

#include <fmt/format.h>

#include <filesystem>
#include <memory>

#include "command_line.hpp"
#include "judge/fault_injection/fault_matrix.hpp"
#include "judge/fault_injection/fault_scenario.hpp"
#include "judge/fault_injection/shaking_gains.hpp"
#include "judge/fault_injection/soak.hpp"
#include "machine/base/job_pool.hpp"
#include "machine/config/data_folder.hpp"
#include "studies/random_plants/monitored_plants.hpp"

namespace trackservo::sim {
namespace {

struct FaultsCommand {
  std::filesystem::path plant = data_folder() / "plants/tracker.toml";
  std::filesystem::path scenario;
  MatrixOptions matrix;
  int shaking_gains = 0;
  bool list = false;
};

// 1 when a requirement was violated.
int faults(const FaultsCommand& command) {
  if (command.list) {
    for (const FaultInjection& part : fault_injections()) {
      fmt::print("{}\n", part.name);
    }
    return 0;
  }
  const PlantConfig plant = load_plant(command.plant);
  if (!command.scenario.empty()) {
    fmt::print("{}", run_fault_scenario(plant, load_fault_scenario(command.scenario)));
    return 0;
  }
  if (command.shaking_gains > 0) {
    start_progress();
    const ShakingGains result =
        run_shaking_gains(plant, {command.shaking_gains, command.matrix.seed, command.matrix.threads}, show_progress);
    fmt::print("{}", print(result));
    return result.errors.empty() ? 0 : 1;
  }
  const std::vector<MatrixRow> rows = run_fault_matrix(plant, command.matrix);
  fmt::print("{}", print_fault_matrix(rows));
  return all_promises_kept(rows) ? 0 : 1;
}

struct SoakCommand {
  std::filesystem::path plant = data_folder() / "plants/tracker.toml";
  double hours = 24.0;
  std::uint64_t seed = 1;
  int threads = usable_threads();
  int random_plants = 0;
};

int soak(const SoakCommand& command) {
  if (command.random_plants > 0) {
    MonitoredPlantsSetup setup;
    setup.nominal = load_plant(command.plant);
    setup.scenarios = scenarios_of_experiments(data_folder());
    setup.count = command.random_plants;
    setup.seed = command.seed;
    setup.threads = command.threads;
    start_progress();
    const MonitoredPlants result = monitor_plants(setup, show_progress);
    fmt::print("{}", print(result));
    return result.false_trips.empty() ? 0 : 1;
  }
  const SoakResult result = run_soak(load_plant(command.plant), command.hours, command.seed, command.threads);
  fmt::print("{}", print_soak(result));
  return result.false_trips.empty() ? 0 : 1;
}

}  // namespace

void add_faults(CLI::App& app, int& code) {
  auto options = std::make_shared<FaultsCommand>();
  CLI::App *command =
      app.add_subcommand("faults", "inject every fault into every motion and check the firmware's reaction");
  command->add_option("--plant", options->plant, "plant file (TOML)")->check(CLI::ExistingFile);
  CLI::Option *scenario = command
                              ->add_option("--scenario", options->scenario,
                                           "run only the fault injections of this file and report them line by line")
                              ->check(CLI::ExistingFile);
  CLI::Option *instants = command
                              ->add_option("--instants,--moments", options->matrix.moments,
                                           "random injection instants per fault, motion and axis")
                              ->check(CLI::Range(1, 100000))
                              ->excludes(scenario)
                              ->capture_default_str();
  command->add_option("--seed", options->matrix.seed, "seed of all noise and injection instants")
      ->check(seed())
      ->excludes(scenario)
      ->capture_default_str();
  CLI::Option *only =
      command->add_option("--only", options->matrix.only, "only these injections (names as --list prints them)")
          ->excludes(scenario);
  command
      ->add_option("--shaking-gains", options->shaking_gains,
                   "instead: apply so many random sets of gains that shake an axis, at rest and moving, in spite of "
                   "the device's check")
      ->check(CLI::Range(1, 1000000))
      ->excludes(scenario)
      ->excludes(instants)
      ->excludes(only);
  add_threads(*command, options->matrix.threads);
  command->add_flag("--list", options->list, "only list the fault injections");
  command->callback([options, &code] { code = faults(*options); });
}

void add_soak(CLI::App& app, int& code) {
  auto options = std::make_shared<SoakCommand>();
  CLI::App *command =
      app.add_subcommand("soak", "simulate hours of operation without fault injection; no fault may be reported");
  command->add_option("--plant", options->plant, "plant file (TOML)")->check(CLI::ExistingFile);
  CLI::Option *hours = command->add_option("--hours", options->hours, "simulated hours")
                           ->check(CLI::Range(0.01, 1e5))
                           ->capture_default_str();
  command
      ->add_option("--random-plants", options->random_plants,
                   "instead: on so many machines whose numbers are all off by up to 30 %, with the motions of the "
                   "paper's experiments, identification and tuning (20 simulated minutes each)")
      ->check(CLI::Range(1, 1000000))
      ->excludes(hours);
  command->add_option("--seed", options->seed, "seed of noise, motions and random machines")
      ->check(seed())
      ->capture_default_str();
  add_threads(*command, options->threads);
  command->callback([options, &code] { code = soak(*options); });
}

}  // namespace trackservo::sim
