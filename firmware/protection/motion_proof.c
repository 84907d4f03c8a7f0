/* SPDX-License-Identifier: Apache-2.0 */
#include "protection/motion_proof.h"

#include <math.h>

#include "base/scalar.h"

enum { QUARTER_TICKS = MOTION_PROOF_PERIOD_TICKS / 4 };

/* A whole period and a quarter, so that the cosine is in it as well. */
static const float sine[MOTION_PROOF_PERIOD_TICKS + QUARTER_TICKS] = {
    0.0f,          0.258819045f,  0.5f,  0.707106781f,  0.866025404f,  0.965925826f,  1.0f,  0.965925826f,
    0.866025404f,  0.707106781f,  0.5f,  0.258819045f,  0.0f,          -0.258819045f, -0.5f, -0.707106781f,
    -0.866025404f, -0.965925826f, -1.0f, -0.965925826f, -0.866025404f, -0.707106781f, -0.5f, -0.258819045f,
    0.0f,          0.258819045f,  0.5f,  0.707106781f,  0.866025404f,  0.965925826f};

float motion_proof_impedance(const motion_proof_axis *axis, float dt_s) {
  const float w_rad_s = 2.0f * SCALAR_PI / ((float)MOTION_PROOF_PERIOD_TICKS * dt_s);
  const float inertial = axis->inertia_kg_m2 * w_rad_s;
  const float of_observer = axis->observer_rad_s / w_rad_s;
  const float pi =
      (axis->filter_gain + axis->position_per_s / w_rad_s) * (axis->proportional_gain + axis->integral_gain / w_rad_s);
  const float observed = axis->filter_gain * axis->observer_rad_s *
                         (axis->observer_inertia_kg_m2 + axis->observer_viscous_nm_s_rad / w_rad_s);
  return inertial + axis->stiffness_nm_rad / w_rad_s + axis->damping_nm_s_rad +
         pi * sqrtf(1.0f + of_observer * of_observer) + observed;
}

static void begin_window(motion_proof *proof, const motion_proof_limits *limits, const motion_proof_axis *axis,
                         float dt_s) {
  const float whole_nm = 2.0f * limits->answer_rad_s * motion_proof_impedance(axis, dt_s);
  const bool possible = scalar_within(whole_nm, limits->most_nm);
  proof->amplitude_nm = possible ? (1.0f - proof->spared) * whole_nm : 0.0f;
  proof->spoiled = proof->spoiled || !possible;
}

static void end_window(motion_proof *proof, float least_rad_s) {
  const float answer_rad_s =
      2.0f / (float)MOTION_PROOF_TICKS *
      sqrtf(proof->in_phase_rad_s * proof->in_phase_rad_s + proof->quadrature_rad_s * proof->quadrature_rad_s);
  const bool answered = answer_rad_s >= least_rad_s;
  const bool silent = !proof->spoiled && !answered;
  const float used = 1.0f - proof->spared;
  const float needed = answered ? used * 2.0f * least_rad_s / answer_rad_s : 1.0f;
  *proof = (motion_proof){.backwards = !proof->backwards,
                          .silent = silent,
                          .unanswered = silent && proof->silent,
                          .spared = scalar_clamp(1.0f - needed, 0.0f, MOTION_PROOF_MOST_SPARED)};
}

void motion_proof_step(motion_proof *proof, const motion_proof_limits *limits, const motion_proof_axis *axis,
                       float rate_rad_s, bool limited, float dt_s) {
  if (proof->tick == 0) {
    begin_window(proof, limits, axis, dt_s);
  }
  const int phase = proof->tick % MOTION_PROOF_PERIOD_TICKS;
  proof->in_phase_rad_s += rate_rad_s * sine[phase];
  proof->quadrature_rad_s += rate_rad_s * sine[phase + QUARTER_TICKS];
  proof->spoiled = proof->spoiled || limited;
  proof->tick++;
  if (proof->tick >= MOTION_PROOF_TICKS) {
    end_window(proof, limits->answer_rad_s);
  }
  const float torque_nm = proof->amplitude_nm * sine[proof->tick % MOTION_PROOF_PERIOD_TICKS];
  proof->torque_nm = proof->backwards ? -torque_nm : torque_nm;
}
