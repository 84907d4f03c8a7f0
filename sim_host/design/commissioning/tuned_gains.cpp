// SPDX-License-Identifier: Apache-2.0
#include "design/commissioning/tuned_gains.hpp"

#include <fmt/format.h>

#include <fstream>

#include "design/commissioning/commissioning_report.hpp"
#include "design/control_design.hpp"
#include "design/margin_measurement.hpp"
#include "dictionary/refusal_text.hpp"
#include "gain_design/design_json.hpp"
#include "gain_design/identified_plant_json.hpp"

namespace trackservo::sim {
namespace {

gain_design::IdentifiedPlant identified_plant(const Commissioned& done) {
  return gain_design::read_identified_plant({axis_name(done.axis), result_of(done)});
}

bool loop_keeps_margins(const PlantConfig& plant, int axis, servo_params params, TunedGains& gains) {
  if (axis_parameters_build(&gains.design.parameters, &params.axis[axis]) != CONTROL_OK) {
    throw gain_design::GainDesignError(fmt::format("the firmware refuses the designed gains: {}",
                                                   dictionary::refusal_of(gains.design.parameters).value_or("")));
  }
  const FrequencyResponse loop = measured_near_crossover(plant, params, axis, false, gains.design.sliding);
  gains.measured = margins_of(loop);
  return keeps_margins(gains.measured, kMinMargins);
}

}  // namespace

TunedGains tune(const PlantConfig& plant, const Commissioned& commissioned) {
  const int axis = commissioned.axis;
  const ControllerSpec& all = controller_spec("pi_vob_ftc");
  TunedGains gains;
  gains.identified = identified_plant(commissioned);
  gains.before = design_axis(plant, axis, all, {});
  gains.design = gain_design::design_gains(gains.identified, gain_requirements(plant, axis, TRACKER_PI), gains.before);
  gains.kept = loop_keeps_margins(plant, axis, design_controller(plant, all, {}), gains);
  return gains;
}

void print(const TunedGains& gains) {
  const auto show = [](const char *when, const gain_design::Margins& margins) {
    fmt::print("  {:<10} gain margin {:.1f} dB, phase margin {:.1f} deg, crossover {:.1f} Hz\n", when,
               margins.gain_margin_db, margins.phase_margin_deg, margins.crossover_hz);
  };
  for (const gain_design::StructuralMode& mode : gains.identified.modes) {
    fmt::print("  resonance at {:.1f} Hz, damping {:.3f}, {:.1f} times the gain of the rigid axis\n",
               mode.frequency_rad_s / (2.0 * kPi), mode.damping, gain_design::relative_height(mode));
  }
  fmt::print("  designed gains, PI with observer and friction feedforward:\n");
  show("predicted", gains.design.sliding);
  show("measured", gains.measured);
  for (const std::string& note : gains.design.notes) {
    fmt::print("  - {}\n", note);
  }
  fmt::print(gains.kept ? "  the margins are met\n" : "  the margins are not met: keep the old gains\n");
}

void write_design(const TunedGains& gains, const std::filesystem::path& folder) {
  std::ofstream file(folder / "design.json");
  file << gain_design::to_json(gains.design, gains.before).dump(2) << '\n';
  if (!file.flush()) {
    throw std::runtime_error(
        fmt::format("{}: cannot be written; is the disk full?", (folder / "design.json").string()));
  }
}

}  // namespace trackservo::sim
