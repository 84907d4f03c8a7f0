#include "control/rate_fusion.h"

#include "base/scalar.h"

control_status rate_fusion_check(const rate_fusion_params *params) {
  if ((unsigned)params->source > (unsigned)RATE_FUSED) {
    return CONTROL_OUT_OF_RANGE;
  }
  const scalar_range range = {params->crossover_rad_s, 0.01f, 2e3f};
  return scalar_check_ranges(&range, 1);
}

void rate_fusion_reset(rate_fusion_state *state) { state->base_rate_rad_s = 0.0f; }

rate_fusion_output rate_fusion_step(rate_fusion_state *state, const rate_fusion_params *params, float gyro_rad_s,
                                    bool gyro_valid, float joint_rate_rad_s, float dt_s) {
  if (params->source == RATE_FROM_ENCODER) {
    return (rate_fusion_output){.rate_rad_s = joint_rate_rad_s, .base_rate_rad_s = 0.0f};
  }
  if (gyro_valid) {
    const float step = params->crossover_rad_s * dt_s;
    const float innovation_rad_s = gyro_rad_s - joint_rate_rad_s - state->base_rate_rad_s;
    state->base_rate_rad_s += step / (1.0f + step) * innovation_rad_s;
  }
  const bool gyro_alone = params->source == RATE_FROM_GYRO && gyro_valid;
  return (rate_fusion_output){
      .rate_rad_s = gyro_alone ? gyro_rad_s : joint_rate_rad_s + state->base_rate_rad_s,
      .base_rate_rad_s = state->base_rate_rad_s,
  };
}
