/* SPDX-License-Identifier: Apache-2.0 */
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
