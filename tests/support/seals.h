/* SPDX-License-Identifier: Apache-2.0 */
/* The seals on the test bench, as parameters of the LuGre block. */
#ifndef TRACKSERVO_TESTS_SUPPORT_SEALS_H
#define TRACKSERVO_TESTS_SUPPORT_SEALS_H

#ifdef __cplusplus
extern "C" {
#endif
#include "control/lugre.h"
#ifdef __cplusplus
}
#endif

static inline lugre_direction seal_direction(float coulomb_nm, float breakaway_nm, float stribeck_speed_rad_s,
                                             float viscous_nm_s_rad) {
  lugre_direction direction;
  direction.coulomb_nm = coulomb_nm;
  direction.breakaway_nm = breakaway_nm;
  direction.stribeck_speed_rad_s = stribeck_speed_rad_s;
  direction.viscous_nm_s_rad = viscous_nm_s_rad;
  return direction;
}

static inline lugre_params seal_of(float stiffness_nm_rad, float damping_nm_s_rad, lugre_direction positive,
                                   lugre_direction negative) {
  lugre_params params;
  params.stiffness_nm_rad = stiffness_nm_rad;
  params.damping_nm_s_rad = damping_nm_s_rad;
  params.positive = positive;
  params.negative = negative;
  return params;
}

/* The paper's published numbers (J = 23.5 kg m^2); Tc, Ts and vs are not printed there and are chosen. */
static inline lugre_params seal_of_the_paper(void) {
  const lugre_direction direction = seal_direction(10.0f, 14.0f, 0.005f, 11.876f);
  return seal_of(308.1f, 108.46f, direction, direction);
}

/* A stiff contact, s0/J about 3000 1/s^2, that differs by direction. */
static inline lugre_params stiff_seal(void) {
  return seal_of(7.0e4f, 900.0f, seal_direction(10.0f, 14.0f, 0.003f, 11.9f),
                 seal_direction(8.5f, 13.0f, 0.004f, 10.5f));
}

/* The same stiff contact, equal in both directions. */
static inline lugre_params stiff_even_seal(void) {
  const lugre_direction direction = seal_direction(10.0f, 14.0f, 0.003f, 11.9f);
  return seal_of(7.0e4f, 900.0f, direction, direction);
}

/* Canudas de Wit et al. 1995, table I; metres and newtons instead of radians and newton metres. */
static inline lugre_params classic_contact(void) {
  const lugre_direction direction = seal_direction(1.0f, 1.5f, 0.001f, 0.4f);
  return seal_of(1.0e5f, 316.227766f, direction, direction);
}

#endif
