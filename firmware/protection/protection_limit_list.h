/* SPDX-License-Identifier: Apache-2.0 */
/* The one list of the limits that protect an axis: a row for each, in the order of object 0x2060.
 *
 * From these rows come the struct `protection_limits`, the rows of the object dictionary (with EDS, parameters.json and
 * the CAN reference page), the range check and the printed defaults of a product. Neither a sub-index nor the order of
 * existing rows may change. A user of the list defines a macro and hands it over:
 *
 *     LIMIT(sub, member, low, high, default, unit, name, help)
 *
 * Default: where no product decides. What must hold between two limits is in axis_protection.c. */
#ifndef TRACKSERVO_PROTECTION_PROTECTION_LIMIT_LIST_H
#define TRACKSERVO_PROTECTION_PROTECTION_LIMIT_LIST_H

/* clang-format off */

#define PROTECTION_LIMITS(LIMIT) PROTECTION_LIMITS_1_TO_17(LIMIT) PROTECTION_LIMITS_FROM_19(LIMIT)

/* Before 2060:18, which reports what waits. */
#define PROTECTION_LIMITS_1_TO_17(LIMIT)                                                                               \
  LIMIT(1, overspeed_rad_s, 1e-3f, 1e3f, 1.5f, "rad/s", "Over-speed limit", "Largest joint rate")                      \
  LIMIT(2, base_rate_rad_s, 1e-4f, 1e3f, 0.02f, "rad/s", "Base rate limit",                                            \
        "Fastest rotation of the base: largest difference of gyro and encoder rate (plus 2 % of the joint rate)")      \
  LIMIT(3, gyro_range_rad_s, 1e-3f, 1e3f, 8.55f, "rad/s", "Gyro range", "Measuring range from the data sheet")         \
  LIMIT(4, encoder_jump_rad, 1e-6f, 1.0f, 5e-4f, "rad", "Encoder jump limit",                                          \
        "Largest change of the position increment between consecutive ticks")                                          \
  LIMIT(5, stuck_s, 0.0f, 60.0f, 0.1f, "s", "Stuck sensor time",                                                       \
        "Identical encoder or gyro readings for this time are a fault; 0: not monitored")                              \
  LIMIT(6, speed_error_rad_s, 1e-3f, 1e3f, 0.5f, "rad/s", "Speed error limit",                                         \
        "Largest difference between set-point and rate")                                                               \
  LIMIT(7, speed_error_s, 1e-3f, 60.0f, 0.3f, "s", "Speed error time", "Longest time above the speed error limit")     \
  LIMIT(8, stall_s, 0.01f, 60.0f, 0.5f, "s", "Stall time", "Longest time at the torque limit without motion")          \
  LIMIT(9, minimum_rad, -200.0f, 200.0f, 0.0f, "rad", "Hard minimum position",                                         \
        "Lower end of the travel; 607D cannot extend it; equal to 2060:10: not monitored")                             \
  LIMIT(10, maximum_rad, -200.0f, 200.0f, 0.0f, "rad", "Hard maximum position",                                        \
        "Upper end of the travel, see 2060:9")                                                                         \
  LIMIT(11, continuous_current_a, 1e-3f, 1e4f, 8.0f, "A", "Continuous current",                                        \
        "Current that the motor can carry continuously")                                                               \
  LIMIT(12, thermal_time_s, 0.1f, 1e4f, 60.0f, "s", "Thermal time constant", "Thermal time constant of the winding")   \
  LIMIT(13, current_offset_a, 1e-4f, 1e4f, 0.5f, "A", "Current offset limit",                                          \
        "Largest reading of the current sensor without current")                                                       \
  LIMIT(14, voltage_mismatch_v, 0.01f, 1e3f, 4.0f, "V", "Voltage mismatch limit",                                      \
        "Largest difference between bridge voltage and R i + Ke w (plus 40 % of R i and L di/dt, or 2060:22 downwards)")    \
  LIMIT(15, under_voltage_v, 1.0f, 1e3f, 36.0f, "V", "Under-voltage limit",                                            \
        "Lowest bus voltage while a control loop is closed")                                                           \
  LIMIT(16, over_voltage_v, 1.0f, 1e3f, 60.0f, "V", "Over-voltage limit", "Highest bus voltage")                       \
  LIMIT(17, stopping_margin_rad, 0.0f, 10.0f, 0.005f, "rad", "Stopping margin",                                        \
        "Ramps stop this far inside 2060:9 and 2060:10; must exceed the overshoot of the loops")

#define PROTECTION_LIMITS_FROM_19(LIMIT)                                                                               \
  LIMIT(19, deceleration_rad_s2, 0.01f, 1e4f, 5.0f, "rad/s^2", "Sure deceleration",                                    \
        "Deceleration that the full motor current gives in every case: largest inertia, strongest wind")               \
  LIMIT(20, stop_deceleration_rad_s2, 1e-3f, 1e4f, 1.0f, "rad/s^2", "Least stop deceleration",                         \
        "Least deceleration of fault and command stops, whatever 6084 and 6085 are; at most half of 2060:19 counts")    \
  LIMIT(21, travel_kind, 0.0f, 2.0f, 0.0f, "", "Travel kind",                                                          \
        "0: enabled only with 2060:9 and 2060:10; 1: no end stops; 2: commissioning, at most 5 deg/s")                  \
  LIMIT(22, motor_tolerance, 0.0f, 0.9f, 0.32f, "", "Motor data tolerance",                                            \
        "How far Ke and R may differ from 2055; 0: the motor is not compared with the sensors")                        \
  LIMIT(23, back_emf_error_v, 0.01f, 1e3f, 0.5f, "V", "Back-EMF error",                                                \
        "Largest error of the back-EMF besides that of R and Ke: dead time, offsets of current and voltage")           \
  LIMIT(24, brake_release_s, 0.0f, 10.0f, 0.0f, "s", "Brake release time",                                             \
        "From current in the coil of the holding brake until the axis may move; 0: no holding brake")                  \
  LIMIT(25, brake_engage_s, 0.0f, 10.0f, 0.0f, "s", "Brake engage time",                                               \
        "Torque is held this long after a stop, until the holding brake has engaged; 0: no holding brake")             \
  LIMIT(26, brake_feedback, 0.0f, 1.0f, 0.0f, "", "Brake feedback",                                                    \
        "1: the contact of the holding brake is monitored; 0: it has none")   \
  LIMIT(27, fixed_base_rad, 0.0f, 1.0f, 0.005f, "rad", "Fixed base window",                                            \
        "Largest angle by which gyro and encoder may drift apart within 5 s; 0: the base moves, and the drift is not"  \
        " monitored")                                                                                                  \
  LIMIT(28, encoder_outlier_rad, 0.0f, 1.0f, 1e-4f, "rad", "Encoder outlier limit",                                    \
        "Largest change of the position increment that the gyro does not show; four outliers in a short time are a"    \
        " fault; 0: not monitored")                                                                                    \
  LIMIT(29, standstill_rad, 0.0f, 10.0f, 0.01f, "rad", "Standstill window",                                            \
        "Largest motion of an axis that is commanded to stand, from 1 s after its last command; needs 2060:27; 0: not" \
        " monitored")                                                                                                  \
  LIMIT(30, reduced_speed_rad_s, 1e-3f, 1e3f, 0.0872665f, "rad/s", "Reduced speed limit",                              \
        "Largest joint rate while 2062 is 1")                                                                          \
  LIMIT(31, direction_rad, 0.0f, 100.0f, 0.05f, "rad", "Direction window",                                             \
        "Largest path against the sign of the set-point while the axis accelerates that way; 0: not monitored")        \
  LIMIT(32, proof_rad_s, 0.0f, 0.1f, 3e-5f, "rad/s", "Standstill test rate",                                           \
        "By at least this a standing axis swings its gyro at 42 Hz, with 2 % of its motor's torque at most; 0: not tested")

/* clang-format on */

#endif
