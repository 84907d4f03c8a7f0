/* The parameters of one axis as users set them: plain numbers in SI units, one struct, one row each in the dictionary.
 *
 * `axis_dictionary.c` gives every member its index, limits, default, unit and text. All parameters reach the blocks by
 * one function: `axis_parameters_build` designs the filters and the current loop and checks everything together. So a
 * set of gains is either applied completely or refused completely. */
#ifndef TRACKSERVO_PARAMETERS_AXIS_PARAMETERS_H
#define TRACKSERVO_PARAMETERS_AXIS_PARAMETERS_H

#include <stdint.h>

#include "servo/servo_axis.h"

/* One direction of the seal, eq. (5). */
typedef struct {
  float coulomb_nm;
  float breakaway_nm;
  float stribeck_speed_rad_s;
  float viscous_nm_s_rad;
} axis_friction_direction;

/* Only 4-byte members, so that the struct has no padding and its bytes can be compared and summed (CRC). */
typedef struct {
  struct {
    float proportional_nm_s_rad;
    float integral_nm_rad;
    float setpoint_weight;
    float tracking_rate_per_s;
    float acceleration_inertia_kg_m2; /* 0: no acceleration feedforward */
  } speed_loop;                       /* 0x2000 */
  struct {
    float proportional_per_s;
    float rate_limit_rad_s;
    float deceleration_rad_s2;
  } position_loop; /* 0x2010 */
  struct {
    uint32_t kind; /* tracker_kind */
    float proportional_per_s;
    float integral_per_s2;
    float estimator_rad_s;
    float coast_s;
  } tracking_loop; /* 0x2011 */
  struct {
    uint32_t on;
    float inertia_kg_m2;
    float viscous_nm_s_rad;
    float bandwidth_rad_s;
    float limit_nm;
  } observer; /* 0x2020 */
  struct {
    uint32_t model; /* friction_model */
    float gain;
    float lead_limit_rad_s;
    float sign_width_rad_s;
    float stiffness_nm_rad;
    float damping_nm_s_rad;
    axis_friction_direction positive;
    axis_friction_direction negative;
  } friction; /* 0x2030 */
  struct {
    float notch_hz; /* 0: off */
    float notch_width_hz;
    float notch_depth;
    float lowpass_hz; /* 0: off */
    float lowpass_damping;
  } filters; /* 0x2040 */
  struct {
    uint32_t source; /* rate_source */
    float crossover_rad_s;
    uint32_t window_ticks;
  } sensors; /* 0x2050 */
  struct {
    float torque_constant_nm_a;
    float resistance_ohm;
    float inductance_h;
    float back_emf_v_s_rad;
    float bandwidth_rad_s; /* of the current loop */
    float current_limit_a;
  } motor; /* 0x2055 */
} axis_parameters;

/* Designs and checks; `*built` is written only with CONTROL_OK. Not for the tick: about 100 us on a board. */
control_status axis_parameters_build(const axis_parameters *parameters, servo_axis_params *built);

/* CRC-32 (IEEE 802.3) over the values, to distinguish sets. */
uint32_t axis_parameters_crc(const axis_parameters *parameters);

#endif
