// SPDX-License-Identifier: Apache-2.0
#include "target_arguments.hpp"

#include <fmt/format.h>

#include <cstdio>

#include "command_line.hpp"
#include "machine/config/scenario_config.hpp"
#include "machine/run/scenario_check.hpp"
#include "machine/target/fly_by.hpp"

namespace trackservo::sim {
namespace {

void refuse_without_target(const ScenarioConfig& scenario) {
  if (scenario.kind != ScenarioKind::kTracking) {
    throw scenario.lines.error("kind", "has no target", "give a scenario with kind = \"tracking\" to --target");
  }
}

// The served camera sees the target everywhere, whatever the scenario's own camera measures.
void refuse_course(const PlantConfig& plant, ScenarioConfig scenario) {
  scenario.camera.geometry = CameraGeometry::kLineOfSight;
  warn(check_scenario(plant, scenario));
}

}  // namespace

void add_target(CLI::App& command, OutputFiles& outputs, TargetArguments& arguments) {
  CLI::Option *target =
      command
          .add_option("--target", arguments.scenario,
                      "scenario file with kind = \"tracking\": its target waits at its start until an axis follows it, "
                      "and its camera sends frames onto the bus")
          ->check(CLI::ExistingFile);
  CLI::Option *camera = command
                            .add_option("--camera-id", arguments.options.camera_cob_id,
                                        "with --target: identifier of the camera's frames; counts up from node to node")
                            ->check(CLI::Range(0x181, 0x57F))
                            ->default_str("0x541")
                            ->needs(target);
  command
      .add_option(
          "--video", arguments.options.video,
          "with --target: pgm-tcp:PORT, pictures of the target for an image processor (docs/imager.md), instead of "
          "the camera's frames; 0: any free port")
      ->check([](const std::string& video) { return video.empty() ? "is empty: expected pgm-tcp:PORT" : ""; })
      ->needs(target)
      ->excludes(camera);
  outputs
      .file("--truth", arguments.options.truth_csv,
            "with --target: file for the true error of the line of sight (CSV), a row per ms of the flight")
      ->needs(target);
}

TargetOptions load_target(const TargetArguments& arguments, const PlantConfig& plant) {
  TargetOptions options = arguments.options;
  if (!arguments.scenario.empty()) {
    options.scenario = load_scenario(arguments.scenario);
    refuse_without_target(*options.scenario);
    refuse_course(plant, *options.scenario);
  }
  return options;
}

void print_start(const TargetOptions& target, bool sees_only_the_bus) {
  if (!target.scenario) {
    return;
  }
  const LineOfSight start = FlyBy(target.scenario->fly_by).at(0.0);
  const std::string result = target.video.empty()
                                 ? fmt::format("camera frames have the identifier {:03X}", target.camera_cob_id)
                                 : "there are pictures of it, and no camera frames";
  fmt::print("target: waits at azimuth {:.3f} deg, pitch {:.3f} deg; {}\n", start.angle_rad[kAzimuth] * kDegPerRad,
             start.angle_rad[kPitch] * kDegPerRad, result);
  if (sees_only_the_bus) {
    fmt::print(stderr, "target: flies when TPDO1 or TPDO2, with the mapping as delivered, shows an axis on target\n");
  }
  (void)std::fflush(stdout);
}

}  // namespace trackservo::sim
