// SPDX-License-Identifier: Apache-2.0
#include "commands/design_command.hpp"

#include <fmt/format.h>

#include <fstream>
#include <string>

#include "commands/output_files.hpp"
#include "gain_design/design_json.hpp"
#include "gain_design/device_parameters.hpp"
#include "gain_design/gain_design.hpp"
#include "gain_design/gain_requirements_json.hpp"
#include "gain_design/identified_plant_json.hpp"
#include "units.hpp"

namespace trackservo::identification {
namespace {

void print_changes(const nlohmann::ordered_json& rows) {
  fmt::print("{:<10} {:<36} {:>12} {:>12}  {}\n", "parameter", "", "before", "designed", "unit");
  for (const auto& row : rows) {
    if (row["before"] != row["value"]) {
      fmt::print("{:<10} {:<36} {:>12.6g} {:>12.6g}  {}\n",
                 fmt::format("{}:{}", row["index"].get<std::string>(), row["sub"].get<int>()),
                 row["name"].get<std::string>(), row["before"].get<double>(), row["value"].get<double>(),
                 row["unit"].get<std::string>());
    }
  }
}

void print_rate_error(const std::string& of, const gain_design::RateError& error) {
  fmt::print("{} {:.3g} deg/s rms: disturbance {:.3g}, encoder {:.3g}, gyro {:.3g}.\n", of, error.rad_s() * kDegPerRad,
             error.disturbance_rad_s * kDegPerRad, error.encoder_rad_s * kDegPerRad, error.gyro_rad_s * kDegPerRad);
}

void print_prediction(const gain_design::GainDesign& design) {
  const auto print = [](const char *when, const gain_design::Margins& margins) {
    fmt::print("{:<12} gain margin {:.1f} dB, phase margin {:.0f} deg, crossover {:.3g} Hz\n", when,
               margins.gain_margin_db, margins.phase_margin_deg, margins.crossover_hz);
  };
  print("Sliding:", design.sliding);
  print("Pre-sliding:", design.pre_sliding);
  fmt::print("Bandwidth {:.3g} Hz, with PI alone {:.3g} Hz; torque noise {:.2g} Nm rms.\n", design.bandwidth_hz,
             design.speed_loop_bandwidth_hz, design.torque_noise_nm);
  if (design.rate_error && design.bound) {
    print_rate_error("Rate error", *design.rate_error);
    print_rate_error(fmt::format("Best linear controller with this feedback and a sensitivity of {:.2f}:",
                                 design.bound->sensitivity),
                     design.bound->error);
  }
}

void run(const DesignCommand& options) {
  const gain_design::IdentifiedPlant plant =
      gain_design::read_identified_plant(gain_design::load_input_file(options.identified));
  const gain_design::GainRequirements requirements =
      options.requirements.empty()
          ? gain_design::GainRequirements{}
          : gain_design::read_gain_requirements(gain_design::load_input_file(options.requirements));
  const axis_parameters before = gain_design::read_device_parameters(gain_design::load_input_file(options.parameters));
  const gain_design::GainDesign design = gain_design::design_gains(plant, requirements, before);
  const nlohmann::ordered_json json = gain_design::to_json(design, before);
  print_changes(json["parameters"]);
  print_prediction(design);
  for (const std::string& note : design.notes) {
    fmt::print("- {}\n", note);
  }
  std::ofstream file(options.json);
  file << json.dump(2) << '\n';
  if (!file.flush()) {
    throw std::runtime_error(options.json.string() + ": cannot be written; give a path in an existing folder");
  }
}

}  // namespace

void add_design_command(CLI::App& app, DesignCommand& options) {
  CLI::App *command =
      app.add_subcommand("design", "design gains from an identified plant and requirements (docs/gain-design.md)");
  command->add_option("--identified", options.identified, "result.json written by 'identify fit'")->required();
  command->add_option("--requirements,--wishes", options.requirements,
                      "requirements (JSON); default: the design chooses all values");
  command->add_option("--parameters", options.parameters, "objects 0x2000 to 0x205F of the device's axis, as JSON")
      ->required();
  sim::OutputFiles(*command).file("--json", options.json, "file for the design")->required();
  command->callback([&options] { run(options); });
}

}  // namespace trackservo::identification
