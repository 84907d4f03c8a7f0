// SPDX-License-Identifier: Apache-2.0
// sim_host: the simulated tracker on the command line.
//
//   sim_host run --plant FILE --scenario FILE --controller NAME --seed N --csv FILE
//   sim_host identify --plant FILE --out DIR
//   sim_host experiments --out DIR
//   sim_host beliefs --out DIR
//   sim_host random-plants --plant FILE --out DIR
//   sim_host base-motion --out DIR
//   sim_host node-tracking --out DIR
//   sim_host bench
//   sim_host serve --plant FILE --bus slcan-tcp:PORT
//   sim_host faults [--scenario FILE]
//   sim_host soak --hours N
//   sim_host attack --seeds N
//   sim_host check --limits FILE
//   sim_host gains --plant FILE --out FILE
//   sim_host keys plant|scenario
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <exception>
#include <future>
#include <memory>
#include <optional>
#include <set>

#include "attack_command.hpp"
#include "check_command.hpp"
#include "command_line.hpp"
#include "design/commissioning/commissioning.hpp"
#include "design/commissioning/commissioning_report.hpp"
#include "design/commissioning/tuned_gains.hpp"
#include "design/design_check.hpp"
#include "fault_commands.hpp"
#include "judge/analysis/benchmark.hpp"
#include "judge/analysis/verdict.hpp"
#include "machine/config/arguments.hpp"
#include "machine/config/data_folder.hpp"
#include "machine/run/scenario_check.hpp"
#include "output_files.hpp"
#include "serve_command.hpp"
#include "studies/shared/study.hpp"
#include "study_commands.hpp"

namespace sim = trackservo::sim;

namespace {

struct RunOptions {
  std::filesystem::path plant;
  std::filesystem::path scenario;
  std::string controller = "pi_vob_ftc";
  std::string friction;
  std::uint64_t seed = 1;
  double friction_parameter_error = 0.15;
  bool improved_loop = false;
  std::filesystem::path csv;
  std::shared_ptr<sim::OutputFiles> outputs;
};

// One file per case: the case's name is inserted before the extension when there are several.
std::filesystem::path csv_of_case(const RunOptions& options, std::size_t cases, const sim::StudyCase& study_case) {
  if (cases == 1) {
    return options.csv;
  }
  std::string name = study_case.name;
  for (char& letter : name) {
    letter = letter == ' ' || letter == '/' || letter == ',' ? '_' : letter;
  }
  std::filesystem::path file = options.csv;
  return file.replace_filename(options.csv.stem().string() + "-" + name + options.csv.extension().string());
}

void refuse_existing_csv(const RunOptions& options, const std::vector<sim::StudyCase>& cases) {
  if (options.csv.empty()) {
    return;
  }
  for (const sim::StudyCase& study_case : cases) {
    options.outputs->check("--csv", csv_of_case(options, cases.size(), study_case));
  }
}

sim::Study study_of(const RunOptions& options) {
  sim::Study study;
  study.plant = sim::load_plant(options.plant);
  study.scenario = sim::load_scenario(options.scenario);
  study.experiment = study.scenario.name;
  study.tracker = options.improved_loop ? TRACKER_PREDICTIVE : TRACKER_PI;
  for (const sim::FrictionModel model :
       {sim::FrictionModel::kLugre, sim::FrictionModel::kMaxwellSlip, sim::FrictionModel::kNone}) {
    if (options.friction == sim::friction_name(model)) {
      study.plant.friction_model = model;
    }
  }
  return study;
}

std::string value_text(const sim::Figure& figure) {
  if (std::isinf(figure.value)) {
    return "not reached";
  }
  return std::isnan(figure.value) ? "no value" : fmt::format("{:>10.4g} {}", figure.value, figure.unit);
}

// The controller's knowledge of the plant's friction, which differs from the plant's friction.
void print_assumption(const RunOptions& options) {
  if (sim::controller_spec(options.controller).friction == FRICTION_NONE) {
    fmt::print("assumed friction: none ({} does not compensate friction)\n", options.controller);
  } else if (options.friction_parameter_error == 0.0) {
    fmt::print("assumed friction: the exact parameters of the plant\n");
  } else {
    fmt::print(
        "assumed friction: every parameter {:g} % off, with signs drawn from seed {}; --friction-parameter-error 0: "
        "exact\n",
        100.0 * options.friction_parameter_error, options.seed);
  }
}

constexpr int kNotControlled = 1;

// kNotControlled when an axis did not follow its command.
int run(const RunOptions& options) {
  sim::Study study = study_of(options);
  if (options.improved_loop && study.scenario.kind != sim::ScenarioKind::kTracking) {
    throw std::invalid_argument(
        fmt::format("--improved-loop: {} is not a tracking scenario; omit the option", options.scenario.string()));
  }
  const std::vector<sim::StudyCase> cases = sim::cases_of(study);
  refuse_existing_csv(options, cases);
  sim::RunChoice choice;
  choice.controller = &sim::controller_spec(options.controller);
  choice.friction = study.plant.friction_model;
  choice.seed = options.seed;
  choice.friction_parameter_error = options.friction_parameter_error;
  if (choice.controller->least_error) {
    study.least_error = sim::design_axes(study.plant, *choice.controller,
                                         sim::design_options(study, options.seed, options.friction_parameter_error));
  }
  sim::checked_design(study, *choice.controller,
                      sim::design_options(study, options.seed, options.friction_parameter_error));
  if (options.controller == "pi_best") {
    choice.pi = sim::best_pi(study);
  }
  print_assumption(options);
  int code = 0;
  for (const sim::StudyCase& study_case : cases) {
    const sim::Trace trace = sim::run_case(study, study_case, choice);
    for (const sim::Figure& figure : sim::measure(study, study_case, trace)) {
      fmt::print("{:<18} {:<9} {:<20} {}\n", study_case.name, sim::axis_name(figure.axis), figure.metric,
                 value_text(figure));
    }
    (void)std::fflush(stdout);
    for (const std::string& sentence :
         sim::uncontrolled_axes(study.plant, study.scenario, study_case.speed_rad_s, trace)) {
      fmt::print(stderr, "sim_host: {}: {}\n", study_case.name, sentence);
      code = kNotControlled;
    }
    if (!options.csv.empty()) {
      const std::filesystem::path file = csv_of_case(options, cases.size(), study_case);
      sim::write_csv(trace, file);
      fmt::print("written {}\n", file.string());
    }
  }
  return code;
}

struct IdentifyOptions {
  std::filesystem::path plant;
  std::uint64_t seed = 1;
  std::filesystem::path out_dir;
};

struct CommissionedAndTuned {
  sim::Commissioned commissioned;
  std::optional<sim::TunedGains> gains;  // none when a parameter was refused
};

CommissionedAndTuned commission_and_tune(const sim::PlantConfig& plant, int axis, std::uint64_t seed) {
  CommissionedAndTuned done{sim::commission(plant, axis, seed), std::nullopt};
  if (done.commissioned.identification.complete()) {
    done.gains = sim::tune(plant, done.commissioned);
  }
  return done;
}

// Both axes at the same time, as if each machine had one axis: one thread each.
int identify(const IdentifyOptions& options) {
  constexpr int kRefused = 1;  // like the program identify
  int code = 0;
  const sim::PlantConfig plant = sim::load_plant(options.plant);
  sim::warn(sim::margin_warnings(plant, sim::design_controller(plant, sim::controller_spec("pi"), {})));
  const auto begin = std::chrono::steady_clock::now();
  std::array<std::future<CommissionedAndTuned>, sim::kAxes> axes;
  for (int axis = 0; axis < sim::kAxes; ++axis) {
    axes[static_cast<std::size_t>(axis)] = std::async(
        std::launch::async, [&plant, &options, axis] { return commission_and_tune(plant, axis, options.seed); });
  }
  for (int axis = 0; axis < sim::kAxes; ++axis) {
    const auto [commissioned, gains] = axes[static_cast<std::size_t>(axis)].get();
    sim::print(plant, commissioned);
    if (gains) {
      sim::print(*gains);
    } else {
      fmt::print("  no gains: the design needs the parameters that could not be determined\n");
      code = kRefused;
    }
    if (!options.out_dir.empty()) {
      const std::filesystem::path folder = options.out_dir / sim::axis_name(axis);
      sim::write_result(commissioned, folder);
      trackservo::identification::write_recording(commissioned.acquisition.recording, folder / "runs.csv");
      trackservo::identification::write_recording(commissioned.structure, folder / "structure.csv");
      if (gains) {
        sim::write_design(*gains, folder);
      }
    }
  }
  fmt::print("both axes: {:.0f} s of computing time\n",
             std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count());
  return code;
}

void bench(const std::filesystem::path& data_dir) {
  const sim::PlantConfig plant = sim::load_plant(data_dir / "plants/tracker.toml");
  const sim::BenchmarkFigures figures =
      sim::run_benchmark(plant, sim::load_scenario(data_dir / "scenarios/steady_speed.toml"), 5);
  fmt::print("processor time, best of 5 (independent of other load):\n");
  fmt::print("real-time factor, both axes, full plant and firmware, one core  {:8.0f} x\n", figures.real_time_factor);
  fmt::print("firmware tick of 1 ms, both axes, everything on                 {:8.1f} ns\n", figures.tick_ns);
  fmt::print("firmware current loop, one axis, one PWM period                 {:8.1f} ns\n", figures.pwm_ns);
  fmt::print("plant, both axes, one PWM period of 50 us                       {:8.1f} ns\n", figures.plant_pwm_ns);
}

void add_run(CLI::App& app, int& code) {
  auto options = std::make_shared<RunOptions>();
  std::vector<std::string> names;
  for (const sim::ControllerSpec& spec : sim::controller_specs()) {
    names.push_back(spec.name);
  }
  CLI::App *command = app.add_subcommand(
      "run", "run one scenario with one controller; exit code 1: an axis did not follow its set-point, 2: wrong input");
  command->add_option("--plant", options->plant, "plant file (TOML)")->required()->check(CLI::ExistingFile);
  command->add_option("--scenario", options->scenario, "scenario file (TOML)")->required()->check(CLI::ExistingFile);
  command->add_option("--controller", options->controller, "controller to run")
      ->check(CLI::IsMember(names))
      ->capture_default_str();
  command->add_option("--seed", options->seed, "seed of all noise and parameter errors")
      ->check(sim::seed())
      ->capture_default_str();
  options->outputs = std::make_shared<sim::OutputFiles>(*command);
  options->outputs->file(
      "--csv", options->csv,
      "file for the trace (CSV); for several speeds one file each, with the speed added to the name");
  command->add_option("--friction", options->friction, "friction model of the plant; default: that of the plant file")
      ->check(CLI::IsMember({"lugre", "maxwell_slip", "none"}));
  command
      ->add_option("--friction-parameter-error", options->friction_parameter_error,
                   "relative error of every friction parameter that the controller assumes, with signs drawn from the "
                   "seed; 0: the exact parameters. The studies use identified parameters instead")
      ->check(sim::share(0.5))
      ->capture_default_str();
  command->add_flag("--improved-loop", options->improved_loop,
                    "tracking only: predict the target and feed its rate forward");
  command->callback([options, &code] { code = run(*options); });
}

void add_identify(CLI::App& app, int& code) {
  auto options = std::make_shared<IdentifyOptions>();
  CLI::App *command = app.add_subcommand(
      "identify", "measure friction and inertia of both axes with the device's experiments, and design gains");
  command->add_option("--plant", options->plant, "plant file (TOML)")->required()->check(CLI::ExistingFile);
  command->add_option("--seed", options->seed, "seed of all noise")->check(sim::seed())->capture_default_str();
  sim::OutputFiles(*command).folder("--out", options->out_dir,
                                    "folder for recordings, results and residuals; each axis gets a subfolder",
                                    {"azimuth/", "pitch/"});
  command->callback([options, &code] { code = identify(*options); });
}

void add_bench(CLI::App& app) {
  auto data_dir = std::make_shared<std::filesystem::path>(sim::data_folder());
  CLI::App *command =
      app.add_subcommand("bench", "measure how fast the simulator and the firmware run on this machine");
  command->add_option("--data", *data_dir, sim::kDataHelp)->check(CLI::ExistingDirectory);
  command->callback([data_dir] { bench(*data_dir); });
}

void add_keys(CLI::App& app) {
  auto file = std::make_shared<std::string>();
  CLI::App *command = app.add_subcommand("keys", "print the reference page of the plant or scenario file");
  command->add_option("file", *file, "kind of file")->required()->check(CLI::IsMember({"plant", "scenario"}));
  command->callback(
      [file] { fmt::print("{}", *file == "plant" ? sim::plant_keys_markdown() : sim::scenario_keys_markdown()); });
}

}  // namespace

// Options that contradict each other throw here: an error of the program, which may end it.
// NOLINTNEXTLINE(bugprone-exception-escape)
int main(int argc, char **argv) {
  const std::vector<std::string> arguments(argv, argv + argc);
  const sim::ImageDevices image_devices;  // none, nor a board to serve: both are passed on to emulate_board
  const sim::ServeBoard serve_board;
  int code = 0;
  CLI::App app{"Simulator of the optical tracker with the servo firmware."};
  app.require_subcommand(1);
  add_run(app, code);
  add_identify(app, code);
  sim::add_experiments(app);
  sim::add_assumed_plants(app);
  sim::add_random_plants(app);
  sim::add_base_motion(app);
  sim::add_node_tracking(app);
  add_bench(app);
  sim::add_serve(app, code, arguments, serve_board);
  sim::add_attack(app, code);
  sim::add_faults(app, code);
  sim::add_soak(app, code);
  sim::add_check(app, code, arguments, image_devices);
  sim::add_gains(app);
  add_keys(app);
  return sim::run_program("sim_host", app, argc, argv, code);
}
