// sim_host: the simulated tracker on the command line.
//
//   sim_host run --plant FILE --scenario FILE --controller NAME --seed N --csv FILE
//   sim_host experiments --out DIR
//   sim_host bench
//   sim_host serve --plant FILE --bus slcan-tcp:PORT
//   sim_host keys plant|scenario
#include <fmt/format.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <exception>

#include "experiments/benchmark.hpp"
#include "experiments/campaign.hpp"
#include "experiments/results.hpp"
#include "serve/server.hpp"

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
};

// A file for each case: the case's name goes before the ending when there are several.
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

void run(const RunOptions& options) {
  const sim::Study study = study_of(options);
  servo_params params = sim::design_controller(study.plant, sim::controller_spec(options.controller),
                                               {options.seed, options.friction_parameter_error, study.tracker});
  if (options.controller == "pi_best") {
    const sim::PiWish best = sim::best_pi(study);
    for (int axis = 0; axis < sim::kAxes; ++axis) {
      sim::set_pi(params, study.plant, axis, best);
    }
  }
  const std::vector<sim::StudyCase> cases = sim::cases_of(study);
  for (const sim::StudyCase& study_case : cases) {
    const sim::Trace trace =
        sim::run_scenario({&study.plant, &study.scenario, study_case.speed_rad_s, params, options.seed});
    for (const sim::Figure& figure : sim::measure(study, study_case, trace)) {
      fmt::print("{:<18} {:<9} {:<20} {:>10.4g} {}\n", study_case.name, sim::axis_name(figure.axis), figure.metric,
                 figure.value, figure.unit);
    }
    if (!options.csv.empty()) {
      const std::filesystem::path file = csv_of_case(options, cases.size(), study_case);
      sim::write_csv(trace, file);
      fmt::print("written {}\n", file.string());
    }
  }
}

struct ServeCommand {
  std::filesystem::path plant;
  sim::ServeOptions options;
  std::string speed = "realtime";
};

// Prints the address of every bus end, a line each: scripts read them.
void serve(ServeCommand command) {
  command.options.real_time = command.speed == "realtime";
  sim::serve(sim::load_plant(command.plant), command.options, [](const std::vector<std::string>& addresses) {
    for (const std::string& address : addresses) {
      fmt::print("{}\n", address);
    }
    std::fflush(stdout);
  });
}

// One line that is rewritten on a terminal, and a line per 10 % elsewhere.
void show_progress(int done, int total, const std::string& what) {
  if (isatty(STDERR_FILENO) != 0) {
    fmt::print(stderr, "\r[{:3d} %] {:<60}{}", 100 * done / total, what, done == total ? "\n" : "");
    std::fflush(stderr);
  } else if (10 * done / total > 10 * (done - 1) / total) {
    fmt::print(stderr, "[{:3d} %] {}\n", 100 * done / total, what);
  }
}

void experiments(const sim::CampaignOptions& options) {
  const sim::Campaign campaign = sim::run_campaign(options, show_progress);
  sim::write_results(campaign, TRACKSERVO_GIT, options.out_dir / "results.json");
  fmt::print("written {}\n", (options.out_dir / "results.json").string());
}

void bench(const std::filesystem::path& data_dir) {
  const sim::BenchmarkFigures figures =
      sim::run_benchmark(sim::load_plant(data_dir / "plants/tracker.toml"),
                         sim::load_scenario(data_dir / "scenarios/steady_speed.toml"), 5);
  fmt::print("real-time factor, both axes, full plant and firmware, one core  {:8.0f} x\n", figures.real_time_factor);
  fmt::print("firmware tick of 1 ms, both axes, everything on                 {:8.1f} ns\n", figures.tick_ns);
  fmt::print("firmware current loop, one axis, one PWM period                 {:8.1f} ns\n", figures.pwm_ns);
  fmt::print("plant, both axes, one PWM period of 50 us                       {:8.1f} ns\n", figures.plant_pwm_ns);
}

}  // namespace

int main(int argc, char **argv) {
  CLI::App app{"The simulated optical tracker with the servo firmware on it."};
  app.require_subcommand(1);
  std::filesystem::path data_dir = TRACKSERVO_DATA_DIR;

  RunOptions run_options;
  CLI::App *run_command = app.add_subcommand("run", "run one scenario with one controller");
  run_command->add_option("--plant", run_options.plant, "plant file (TOML)")->required()->check(CLI::ExistingFile);
  run_command->add_option("--scenario", run_options.scenario, "scenario file (TOML)")
      ->required()
      ->check(CLI::ExistingFile);
  std::vector<std::string> names;
  for (const sim::ControllerSpec& spec : sim::controller_specs()) {
    names.push_back(spec.name);
  }
  run_command->add_option("--controller", run_options.controller, "controller")
      ->check(CLI::IsMember(names))
      ->capture_default_str();
  run_command->add_option("--seed", run_options.seed, "seed of all noise and parameter errors")->capture_default_str();
  run_command->add_option("--csv", run_options.csv, "write the trace here (one file per case)");
  run_command->add_option("--friction", run_options.friction, "the plant's friction, instead of its file's")
      ->check(CLI::IsMember({"lugre", "maxwell_slip", "none"}));
  run_command
      ->add_option("--friction-parameter-error", run_options.friction_parameter_error,
                   "share by which every feedforward parameter is wrong")
      ->check(CLI::Range(0.0, 0.5))
      ->capture_default_str();
  run_command->add_flag("--improved-loop", run_options.improved_loop,
                        "tracking: predict the target, feed its rate forward");

  sim::CampaignOptions campaign_options;
  bool quick = false;
  CLI::App *experiments_command = app.add_subcommand("experiments", "run all experiments of the paper");
  experiments_command->add_option("--out", campaign_options.out_dir, "folder for results.json and the CSVs")
      ->required();
  experiments_command->add_option("--data", data_dir, "folder with plants/ and scenarios/")
      ->check(CLI::ExistingDirectory);
  experiments_command->add_option("--seeds", campaign_options.seeds, "seeds to run")->capture_default_str();
  experiments_command->add_option("--threads", campaign_options.threads, "threads")
      ->check(CLI::Range(1, 64))
      ->capture_default_str();
  experiments_command->add_flag("--quick", quick, "one seed only, for a first look");

  CLI::App *bench_command = app.add_subcommand("bench", "how fast the simulator and the firmware are on this machine");
  bench_command->add_option("--data", data_dir, "folder with plants/ and scenarios/")->check(CLI::ExistingDirectory);

  ServeCommand serve_command;
  serve_command.plant = data_dir / "plants/tracker.toml";
  CLI::App *serve_app = app.add_subcommand("serve", "be a CANopen node on a bus that clients reach, until stdin ends");
  serve_app->add_option("--plant", serve_command.plant, "plant file (TOML)")
      ->check(CLI::ExistingFile)
      ->capture_default_str();
  serve_app
      ->add_option("--bus", serve_command.options.buses,
                   "slcan-tcp:PORT, slcan-pty or socketcan:INTERFACE; may be repeated")
      ->capture_default_str();
  serve_app->add_option("--node", serve_command.options.node_id, "node id")
      ->check(CLI::Range(1, 127))
      ->capture_default_str();
  serve_app->add_option("--seed", serve_command.options.seed, "seed of all noise")->capture_default_str();
  serve_app->add_option("--speed", serve_command.speed, "pace of simulated time")
      ->check(CLI::IsMember({"realtime", "max"}))
      ->capture_default_str();

  CLI::App *keys_command = app.add_subcommand("keys", "print the reference page of the plant or scenario files");
  std::string keys_of;
  keys_command->add_option("file", keys_of, "which files")->required()->check(CLI::IsMember({"plant", "scenario"}));

  CLI11_PARSE(app, argc, argv);
  try {
    if (run_command->parsed()) {
      run(run_options);
    } else if (experiments_command->parsed()) {
      campaign_options.data_dir = data_dir;
      if (quick) {
        campaign_options.seeds = {1};
      }
      experiments(campaign_options);
    } else if (serve_app->parsed()) {
      serve(serve_command);
    } else if (keys_command->parsed()) {
      fmt::print("{}", keys_of == "plant" ? sim::plant_keys_markdown() : sim::scenario_keys_markdown());
    } else {
      bench(data_dir);
    }
  } catch (const std::exception& error) {
    fmt::print(stderr, "sim_host: {}\n", error.what());
    return 2;
  }
  return 0;
}
