// SPDX-License-Identifier: Apache-2.0
// identify: friction and plant from recorded runs.
//
//   identify fit RECORDING.csv [--structure RECORDING.csv] [--json FILE] [--residuals FILE]
//   identify plan --lowest-rad A --highest-rad B --torque-nm T --fastest-rad-s V [--identified FILE [--structure]]
//                 [--json FILE]
//   identify design --identified RESULT.json [--wishes FILE] --parameters FILE --json FILE
//   identify paper-damping --slope 308.1 --inertia 23.5 --viscous 11.876
//
// Exit codes, as of sim_host: 0 all parameters, 1 some were refused, 2 wrong input.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <fstream>

#include "commands/design_command.hpp"
#include "commands/output_files.hpp"
#include "gain_design/device_parameters.hpp"
#include "gain_design/identified_plant_json.hpp"
#include "identification/identification.hpp"
#include "identification/result_json.hpp"
#include "json_text.hpp"
#include "test_plan/test_plan_json.hpp"
#include "test_plan/test_plan_text.hpp"

namespace identification = trackservo::identification;
namespace commissioning = trackservo::commissioning;
namespace gain_design = trackservo::gain_design;

namespace {

constexpr int kRefused = 1;
constexpr int kWrongInput = 2;

struct FitOptions {
  std::string recording;
  std::string structure;
  std::filesystem::path json;
  std::filesystem::path residuals;
};

std::ofstream open_for_writing(const std::filesystem::path& path) {
  std::ofstream file(path);
  if (!file) {
    throw std::runtime_error(fmt::format("{}: cannot be written; give a path in an existing folder.", path.string()));
  }
  return file;
}

void print_table(const identification::Identification& result) {
  fmt::print("{:<24} {:>12} {:>26} {:>12}  {}\n", "parameter", "value", "95 % interval", "paper's", "unit");
  for (const identification::Parameter& parameter : result.parameters) {
    const std::string value = parameter.refused.empty() ? fmt::format("{:.5g}", parameter.value) : "refused";
    fmt::print("{:<24} {:>12} {:>12.5g} .. {:<10.5g} {:>12.5g}  {}\n", parameter.name, value, parameter.interval.low,
               parameter.interval.high, parameter.paper, parameter.unit);
  }
  fmt::print("Damping ratio in pre-sliding {:.3g}; the paper assumes {:.3g}, which gives sigma1 = {:.5g} Nm s/rad.\n",
             result.damping_ratio, identification::kPaperDampingRatio, result.eq15_damping_nm_s_rad);
  for (const identification::Parameter& parameter : result.parameters) {
    if (!parameter.refused.empty()) {
      fmt::print("Refused: {}\n", parameter.refused);
    }
  }
}

int fit(const FitOptions& options) {
  const identification::Recording recording = identification::load_recording(options.recording);
  const identification::Recording structure =
      options.structure.empty() ? identification::Recording{} : identification::load_recording(options.structure);
  const identification::Identification result = identification::identify(recording);
  print_table(result);
  nlohmann::ordered_json json = identification::to_json(result, recording, structure);
  if (result.complete()) {
    json["plant"] = gain_design::plant_rows(gain_design::read_identified_plant({options.recording, json}));
  }
  for (const auto& warning : json["warnings"]) {
    fmt::print("{}\n", warning.get<std::string>());
  }
  if (!options.json.empty()) {
    open_for_writing(options.json) << json.dump(2) << '\n';
  }
  if (!options.residuals.empty()) {
    std::ofstream file = open_for_writing(options.residuals);
    identification::write_residuals(file, result, recording);
  }
  return result.complete() ? 0 : kRefused;
}

struct PlanOptions {
  commissioning::MotionLimits limits;
  double start_rad = 0;
  std::string identified;
  bool structure = false;
  std::filesystem::path json;
};

// Results of a first look, from its file.
commissioning::RoughMachine load_rough_machine(const std::string& path) {
  try {
    const nlohmann::json result = trackservo::parse_json(trackservo::read_text(path));
    if (result.at("format") != "trackservo-identification" || result.at("version") != 1) {
      throw std::runtime_error(fmt::format("{}: is not of format trackservo-identification, version 1.", path));
    }
    const nlohmann::json& rough = result.at("rough");
    return {rough.at("coulomb_nm"), rough.at("bristle_rad"), rough.at("stribeck_rad_s"), rough.at("inertia_kg_m2")};
  } catch (const trackservo::TextFileError& error) {
    throw std::runtime_error(fmt::format("{}:{}: {}.", path, error.line(), error.what()));
  } catch (const nlohmann::json::exception& error) {
    throw std::runtime_error(
        fmt::format("{}: is not a result of 'identify fit --json' with a block \"rough\" ({}).", path, error.what()));
  }
}

commissioning::TestPlan test_plan_of(const PlanOptions& options) {
  if (options.identified.empty()) {
    return commissioning::first_look(options.limits);
  }
  const commissioning::RoughMachine machine = load_rough_machine(options.identified);
  return options.structure ? commissioning::structure_look(options.limits, machine)
                           : commissioning::test_plan_for(options.limits, machine);
}

void plan(const PlanOptions& options) {
  const commissioning::TestPlan test_plan = test_plan_of(options);
  commissioning::print(test_plan, options.start_rad);
  if (!options.json.empty()) {
    open_for_writing(options.json) << commissioning::to_json(test_plan, options.start_rad).dump(2) << '\n';
  }
}

void add_plan(CLI::App& app, PlanOptions& options) {
  CLI::App *command = app.add_subcommand("plan", "plan the experiments: where, how fast, with what torque, how long");
  command->add_option("--lowest-rad", options.limits.lowest_rad, "lowest joint angle that the axis may reach")
      ->required();
  command->add_option("--highest-rad", options.limits.highest_rad, "highest joint angle that the axis may reach")
      ->required();
  command->add_option("--fastest-rad-s", options.limits.rate_rad_s, "largest joint rate")->required();
  command->add_option("--torque-nm", options.limits.torque_nm, "largest torque")->required();
  command->add_option("--start-rad", options.start_rad, "present joint angle, to predict the duration")
      ->check(CLI::Range(-1e3, 1e3));
  CLI::Option *identified = command->add_option("--identified", options.identified,
                                                "result of the first look; without it, this plans the first look");
  command->add_flag("--structure", options.structure, "plan the chirps that measure structural resonances")
      ->needs(identified);
  trackservo::sim::OutputFiles(*command).file("--json", options.json, "file for the test plan");
  command->callback([&options] { plan(options); });
}

struct DampingOptions {
  double slope_nm_rad = 0;
  double inertia_kg_m2 = 0;
  double viscous_nm_s_rad = 0;
  double damping_ratio = identification::kPaperDampingRatio;
};

void add_paper_damping(CLI::App& app, DampingOptions& options) {
  CLI::App *command =
      app.add_subcommand("paper-damping", "compute sigma1 from the slope in pre-sliding, eqs (15) and (16)");
  command->add_option("--slope", options.slope_nm_rad, "du/dtheta = sigma0 [Nm/rad]")
      ->required()
      ->check(CLI::PositiveNumber);
  command->add_option("--inertia", options.inertia_kg_m2, "J [kg m2]")->required()->check(CLI::PositiveNumber);
  command->add_option("--viscous", options.viscous_nm_s_rad, "sigma2 [Nm s/rad]")
      ->required()
      ->check(CLI::NonNegativeNumber);
  command->add_option("--damping-ratio", options.damping_ratio, "damping ratio; the paper assumes 1/sqrt(2)")
      ->check(CLI::PositiveNumber);
  command->callback([&options] {
    fmt::print("{:.2f}\n", identification::paper_damping_nm_s_rad(options.inertia_kg_m2, options.slope_nm_rad,
                                                                  options.viscous_nm_s_rad, options.damping_ratio));
  });
}

}  // namespace

int main(int argc, char **argv) {
  try {
    CLI::App app{"Identifies friction and plant of an axis from recorded runs, and designs gains for it."};
    app.set_version_flag("--version", "identify " TRACKSERVO_VERSION, "print the version");
    app.require_subcommand(1);
    int code = 0;
    FitOptions options;
    CLI::App *command = app.add_subcommand("fit", "fit all parameters to a recording");
    command->add_option("recording", options.recording, "CSV of the runs (docs/identification.md)")->required();
    command->add_option("--structure", options.structure, "CSV of chirps for structural resonances (plan --structure)");
    trackservo::sim::OutputFiles outputs(*command);
    outputs.file("--json", options.json, "file for the result");
    outputs.file("--residuals", options.residuals, "file for the residuals (CSV)");
    command->callback([&] { code = fit(options); });
    PlanOptions plan_options;
    add_plan(app, plan_options);
    DampingOptions damping;
    add_paper_damping(app, damping);
    identification::DesignCommand design;
    identification::add_design_command(app, design);
    try {
      app.parse(argc, argv);
    } catch (const CLI::ParseError& error) {
      return app.exit(error) == 0 ? 0 : kWrongInput;
    }
    return code;
  } catch (const std::exception& error) {
    (void)std::fprintf(stderr, "identify: %s\n", error.what());
    return kWrongInput;
  }
}
