/* SPDX-License-Identifier: Apache-2.0 */
/* LuGre step, for every parameter set that lugre_check accepts, every deflection up to 1 rad, joint rates within
 * +-1e6 rad/s and ticks of 1e-6 .. 1 s: no division by zero, no conversion out of range, no value that is not finite.
 *
 * Intervals keep no relation between two values. So the ranges of Tc and of the rate are cut in pieces, and exp(-x) is
 * replaced by its contract, a value in 0 .. 1 (test_scalar.c measures it over the whole range). */
#include "control/lugre.c"

#include "proof.h"

float scalar_exp_minus(float x) {
  REQUIRE(x >= 0.0f && x <= 3.4e38f, "a finite argument that is not negative");
  return any_float(0.0f, 1.0f);
}

/* One piece of Tc of both directions, and one piece of the rate. */
static void prove_piece(float coulomb_nm, float rate_low_rad_s, float rate_high_rad_s) {
  const float next_nm = scalar_min(1.5f * coulomb_nm, 1e4f);
  lugre_direction direction = {.coulomb_nm = any_float(coulomb_nm, next_nm),
                               .breakaway_nm = any_float(coulomb_nm, 1e4f),
                               .stribeck_speed_rad_s = any_float(1e-6f, 1e2f),
                               .viscous_nm_s_rad = any_float(0.0f, 1e4f)};
  const lugre_params params = {.stiffness_nm_rad = any_float(1e-3f, 1e9f),
                               .damping_nm_s_rad = any_float(0.0f, 1e6f),
                               .positive = direction,
                               .negative = direction};
  lugre_state state = {.deflection_rad = any_float(-1.0f, 1.0f)};
  const float torque_nm =
      lugre_step(&state, &params, any_float(rate_low_rad_s, rate_high_rad_s), any_float(1e-6f, 1.0f));
  REQUIRE(torque_nm >= -1e38f && torque_nm <= 1e38f, "finite torque");
  REQUIRE(state.deflection_rad >= -1e30f && state.deflection_rad <= 1e30f, "finite deflection");
}

int main(void) {
  static const float rates_rad_s[] = {-1e6f, -1.0f, -1e-6f, -1e-13f, 1e-13f, 1e-6f, 1.0f, 1e6f};
  for (float coulomb_nm = 1e-6f; coulomb_nm < 1e4f; coulomb_nm *= 1.5f) {
    for (int i = 0; i < 7; ++i) {
      prove_piece(coulomb_nm, rates_rad_s[i], rates_rad_s[i + 1]);
    }
  }
  return 0;
}
