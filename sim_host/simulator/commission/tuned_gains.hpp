// Gains for an axis that was commissioned, designed from what was found and verified on the machine, as `servoctl tune`
// does it.
#ifndef TRACKSERVO_SIM_COMMISSION_TUNED_GAINS_HPP
#define TRACKSERVO_SIM_COMMISSION_TUNED_GAINS_HPP

#include <filesystem>

#include "commission/commission.hpp"
#include "gain_design/gain_design.hpp"

namespace trackservo::sim {

struct TunedGains {
  gain_design::IdentifiedPlant identified;  // resonances included
  axis_parameters before{};
  gain_design::GainDesign design;
  gain_design::Margins measured;  // sliding, on the simulated machine with all its noise
  bool kept = false;              // the measured margins are what was asked for
};

// From the wishes of the plant file, with PI, observer and LuGre feedforward. Throws InputFileError when a parameter
// was refused, GainDesignError when no gains can do it.
TunedGains tune(const PlantConfig& plant, const Commissioned& commissioned);

// To the standard output: resonances, margins, what the design has to say.
void print(const TunedGains& gains);

// `folder`/design.json, as `identify design` writes it. Throws std::runtime_error that names the file.
void write_design(const TunedGains& gains, const std::filesystem::path& folder);

}  // namespace trackservo::sim

#endif
