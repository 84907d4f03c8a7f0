// SPDX-License-Identifier: Apache-2.0
// The keys of a plant file, one list per table, without those of the sensors (sensor_suite.hpp). The only description
// of them; see key.hpp.
#ifndef TRACKSERVO_SIM_CONFIG_PLANT_KEYS_HPP
#define TRACKSERVO_SIM_CONFIG_PLANT_KEYS_HPP

#include "machine/base/key.hpp"
#include "machine/config/plant_config.hpp"

namespace trackservo::sim {

// End stops as written in the file: absent or [lower, upper].
struct EndStopKeys {
  std::vector<double> range_rad;
  double stiffness_nm_rad = 0;
  double restitution = 0;
};

const Keys<PlantConfig>& plant_keys();
const Keys<PlantConfig>& friction_model_keys();
const Keys<MaxwellSlipConfig>& maxwell_slip_keys();
const Keys<SupplyConfig>& supply_keys();
const Keys<AdcConfig>& adc_keys();
const Keys<BaseTiltConfig>& base_tilt_keys();
const Keys<MechanicsConfig>& mechanics_keys();
const Keys<BaseMotionLine>& base_motion_keys();
const Keys<BaseSpectrum>& base_spectrum_keys();
const Keys<AxisConfig>& axis_keys();
const Keys<EndStopKeys>& end_stop_keys();
const Keys<MotorConfig>& motor_keys();
const Keys<RippleConfig>& ripple_keys();
const Keys<CoggingConfig>& cogging_keys();
const Keys<FrictionConfig>& friction_keys();
const Keys<StribeckConfig>& stribeck_keys();
const Keys<LoadConfig>& load_keys();
const Keys<HoldingBrakeConfig>& holding_brake_keys();
const Keys<StructureConfig>& structure_keys();
const Keys<BaseSwayConfig>& base_sway_keys();
const Keys<DesignConfig>& design_keys();
const Keys<Assumption>& assumption_keys();

}  // namespace trackservo::sim

#endif
