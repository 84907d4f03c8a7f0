// The keys of a plant file, one list per table. The only description of them; see key.hpp.
#ifndef TRACKSERVO_SIM_CONFIG_PLANT_KEYS_HPP
#define TRACKSERVO_SIM_CONFIG_PLANT_KEYS_HPP

#include "config/key.hpp"
#include "config/plant_config.hpp"

namespace trackservo::sim {

// End stops as the file says them: absent or [lower, upper].
struct EndStopKeys {
  std::vector<double> range_rad;
  double stiffness_nm_rad = 0;
  double restitution = 0;
};

Keys<PlantConfig> plant_keys();
Keys<PlantConfig> friction_model_keys();
Keys<MaxwellSlipConfig> maxwell_slip_keys();
Keys<SupplyConfig> supply_keys();
Keys<AdcConfig> adc_keys();
Keys<BaseTiltConfig> base_tilt_keys();
Keys<AxisConfig> axis_keys();
Keys<EndStopKeys> end_stop_keys();
Keys<MotorConfig> motor_keys();
Keys<RippleConfig> ripple_keys();
Keys<CoggingConfig> cogging_keys();
Keys<FrictionConfig> friction_keys();
Keys<StribeckConfig> stribeck_keys();
Keys<LoadConfig> load_keys();
Keys<StructureConfig> structure_keys();
Keys<BaseSwayConfig> base_sway_keys();
Keys<EncoderConfig> encoder_keys();
Keys<GyroConfig> gyro_keys();
Keys<DesignConfig> design_keys();
Keys<Assumption> assumption_keys();

}  // namespace trackservo::sim

#endif
