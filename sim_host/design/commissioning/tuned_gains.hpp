// SPDX-License-Identifier: Apache-2.0
// Gains for a commissioned axis, designed from the identified parameters and verified on the machine, like `servoctl
// tune`.
#ifndef TRACKSERVO_SIM_COMMISSIONING_TUNED_GAINS_HPP
#define TRACKSERVO_SIM_COMMISSIONING_TUNED_GAINS_HPP

#include <filesystem>

#include "design/commissioning/commissioning.hpp"
#include "gain_design/gain_design.hpp"

namespace trackservo::sim {

struct TunedGains {
  gain_design::IdentifiedPlant identified;  // resonances included
  axis_parameters before{};
  gain_design::GainDesign design;
  gain_design::Margins measured;  // sliding, on the simulated machine with all its noise
  bool kept = false;              // the measured margins are as required
};

// Designs gains from the requirements of the plant file, with PI, observer and LuGre feedforward. Throws InputFileError
// when a parameter was refused, GainDesignError when no gains meet the requirements.
TunedGains tune(const PlantConfig& plant, const Commissioned& commissioned);

// Prints to the standard output: resonances, margins, messages of the design.
void print(const TunedGains& gains);

// Writes `folder`/design.json, as `identify design` writes it. Throws std::runtime_error that names the file.
void write_design(const TunedGains& gains, const std::filesystem::path& folder);

}  // namespace trackservo::sim

#endif
