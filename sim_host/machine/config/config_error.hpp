// SPDX-License-Identifier: Apache-2.0
// The only error type of the configuration files.
//
// Its text is "file:line: key: reason, what would be right", for example
// "tracker.toml:31: azimuth.friction.positive.breakaway_nm: 4 is below coulomb_nm = 6, give at least 6".
// load_plant and load_scenario throw it; nothing else of the simulator throws for a bad file.
#ifndef TRACKSERVO_SIM_CONFIG_CONFIG_ERROR_HPP
#define TRACKSERVO_SIM_CONFIG_CONFIG_ERROR_HPP

#include <stdexcept>

namespace trackservo::sim {

struct ConfigError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

}  // namespace trackservo::sim

#endif
