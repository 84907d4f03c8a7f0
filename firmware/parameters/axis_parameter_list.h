/* SPDX-License-Identifier: Apache-2.0 */
/* The one list of an axis' parameters: a row for each value that people set, in the order of the object dictionary.
 *
 * From these rows come the struct `axis_parameters`, the rows of the object dictionary (with EDS, parameters.json and
 * the CAN reference page), the copies into the blocks' parameters, the printed defaults of a product, the range check
 * and the trace for the bit comparison. To add a gain: add its row here, the member to its block's parameters, and
 * increase the number in its GROUP. Neither an index nor the order of existing rows may change: persisted parameter
 * sets and files of users name parameters by index, and the CRC of a set (2070:4) covers the struct in this order.
 *
 * A user of the list defines one macro for each kind of row and passes them:
 *
 *     GROUP(index, highest sub-index, group, name, help)    begins the struct member `group`, object `index`
 *     REAL(index, sub, flags, group, member, low, high, default, unit, name, help, to)
 *     DESIGNED(index, sub, flags, group, member, low, high, default, unit, name, help)
 *     WHOLE(index, sub, flags, group, member, low, high, default, name, help, to, type of `to`)
 *     DIRECTION(first sub, side, name)                      one direction of the seal, FRICTION_DIRECTION_ROWS
 *     END(group)
 *
 * `to` is the member of servo_axis_params that gets the value. A DESIGNED value goes into a filter or the current loop
 * by hand (axis_parameters.c). Flags: OD_GUARDED where a wrong value can hurt, DECIDES where the value decides whether
 * the loops are stable, else 0. Low, high: what a write may bring, and what axis_parameters_check demands. Default:
 * where no design rule and no product decides. */
#ifndef TRACKSERVO_PARAMETERS_AXIS_PARAMETER_LIST_H
#define TRACKSERVO_PARAMETERS_AXIS_PARAMETER_LIST_H

/* A flag beside those of the object dictionary, which has 8 bits for them: a set that is refused as unstable names the
 * one of these values that changed most (axis_tuning.c). */
enum { DECIDES = 256, DICTIONARY_FLAGS = 255 };

/* clang-format off */

/* NOLINTBEGIN(bugprone-macro-parentheses): member names and texts cannot be put in parentheses. */

/* Of lugre_direction, eq. (5): sub-indices `sub_` .. `sub_ + 3` of 0x2030. */
#define FRICTION_DIRECTION_ROWS(REAL, sub_, side_, title_)                                                             \
  REAL(0x2030, (sub_), 0, friction, side_.coulomb_nm, 1e-6f, 1e4f, 6.0f, "N m",                                        \
       "Coulomb torque " title_, "Tc of eq. (5): sliding friction at high speed, without its viscous part",            \
       speed.friction.lugre.side_.coulomb_nm)                                                                          \
  REAL(0x2030, (sub_) + 1, 0, friction, side_.breakaway_nm, 1e-6f, 1e4f, 9.0f, "N m",                                  \
       "Break-away torque " title_, "Ts of eq. (5): not less than Tc", speed.friction.lugre.side_.breakaway_nm)        \
  REAL(0x2030, (sub_) + 2, 0, friction, side_.stribeck_speed_rad_s, 1e-6f, 1e2f, 5.2e-3f, "rad/s",                     \
       "Stribeck speed " title_, "Speed at which Ts - Tc has decayed to 37 %",                                         \
       speed.friction.lugre.side_.stribeck_speed_rad_s)                                                                \
  REAL(0x2030, (sub_) + 3, 0, friction, side_.viscous_nm_s_rad, 0.0f, 1e4f, 8.0f, "N m s/rad",                         \
       "Viscous coefficient " title_, "sigma2: friction torque per speed",                                             \
       speed.friction.lugre.side_.viscous_nm_s_rad)

/* NOLINTEND(bugprone-macro-parentheses) */

#define AXIS_PARAMETERS(GROUP, REAL, DESIGNED, WHOLE, DIRECTION, END)                                                  \
  GROUP(0x2000, 6, speed_loop, "Speed loop", "PI with set-point model and acceleration feedforward")                   \
  REAL(0x2000, 1, DECIDES, speed_loop, proportional_nm_s_rad, 0.0f, 1e6f, 720.0f, "N m s/rad",                         \
       "Speed loop proportional gain", "2 zeta w J for damping ratio zeta and natural frequency w",                    \
       speed.pi.proportional_gain)                                                                                     \
  REAL(0x2000, 2, DECIDES, speed_loop, integral_nm_rad, 0.0f, 1e8f, 21600.0f, "N m/rad",                               \
       "Speed loop integral gain", "w^2 J for natural frequency w", speed.pi.integral_gain)                            \
  REAL(0x2000, 3, DECIDES, speed_loop, setpoint_weight, 0.0f, 1.0f, 0.7f, "",                                          \
       "Speed loop set-point weight", "Lower it to reduce overshoot on steps; disturbance rejection does not change",  \
       speed.pi.setpoint_weight)                                                                                       \
  REAL(0x2000, 4, 0, speed_loop, tracking_rate_per_s, 0.0f, 1e3f, 60.0f, "1/s",                                        \
       "Speed loop anti-windup rate", "How fast the integral follows the torque limit in saturation",                  \
       speed.pi.tracking_rate_per_s)                                                                                   \
  REAL(0x2000, 5, 0, speed_loop, acceleration_inertia_kg_m2, 0.0f, 1e5f, 6.0f, "kg m^2",                               \
       "Acceleration feedforward inertia", "Torque per commanded acceleration; 0: off",                                \
       speed.acceleration_inertia_kg_m2)                                                                               \
  DESIGNED(0x2000, 6, DECIDES, speed_loop, setpoint_model_rad_s, 0.0f, 1000.0f, 0.0f, "rad/s",                         \
       "Set-point model frequency", "A jump of the set-point moves as a second-order system; 0: off, else from 100")   \
  END(speed_loop)                                                                                                      \
                                                                                                                       \
  GROUP(0x2010, 3, position_loop, "Position loop", "Computes the rate set-point from the angle error")                 \
  REAL(0x2010, 1, DECIDES, position_loop, proportional_per_s, 0.01f, 1e3f, 10.0f, "1/s",                               \
       "Position loop gain", "Bandwidth of the position loop", position.proportional_per_s)                            \
  REAL(0x2010, 2, 0, position_loop, rate_limit_rad_s, 1e-5f, 1e2f, 1.0f, "rad/s",                                      \
       "Rate limit of the outer loops", "Largest rate set-point that the position and tracking loops may request",     \
       position.rate_limit_rad_s)                                                                                      \
  REAL(0x2010, 3, 0, position_loop, deceleration_rad_s2, 1e-4f, 1e4f, 1.0f, "rad/s^2",                                 \
       "Position loop deceleration", "Deceleration when approaching a distant target", position.deceleration_rad_s2)   \
  END(position_loop)                                                                                                   \
                                                                                                                       \
  GROUP(0x2011, 6, tracking_loop, "Tracking loop", "Computes the rate set-point from the camera error")                \
  WHOLE(0x2011, 1, DECIDES, tracking_loop, kind, 0, 1, 1,                                                              \
       "Tracking loop kind", "0: PI on the camera error; 1: predictive", tracker.kind, tracker_kind)                   \
  REAL(0x2011, 2, DECIDES, tracking_loop, proportional_per_s, 0.0f, 1e2f, 20.0f, "1/s",                                \
       "Tracking loop proportional gain", "Rate per camera error (kind 1: predicted error)",                           \
       tracker.proportional_per_s)                                                                                     \
  REAL(0x2011, 3, DECIDES, tracking_loop, integral_per_s2, 0.0f, 1e3f, 0.0f, "1/s^2",                                  \
       "Tracking loop integral gain", "Used by kind 0 only", tracker.integral_per_s2)                                  \
  REAL(0x2011, 4, 0, tracking_loop, estimator_rad_s, 0.1f, 50.0f, 4.0f, "rad/s",                                       \
       "Target estimator bandwidth", "Used by kind 1 only: how fast target rate and acceleration are estimated",       \
       tracker.estimator_rad_s)                                                                                        \
  REAL(0x2011, 5, 0, tracking_loop, coast_s, 0.0f, 10.0f, 0.5f, "s",                                                   \
       "Coasting time", "How long the loop continues without camera frames", tracker.coast_s)                          \
  WHOLE(0x2011, 6, 0, tracking_loop, at_loss, 0, 1, 0,                                                                 \
        "After loss of the target", "After the coasting time: 0: stands; 1: returns to where mode -1 began, as in pp", \
        at_loss, target_loss)                                                                                          \
  END(tracking_loop)                                                                                                   \
                                                                                                                       \
  GROUP(0x2020, 5, observer, "Disturbance observer", "Velocity disturbance observer with first-order Q filter")        \
  WHOLE(0x2020, 1, DECIDES, observer, on, 0, 1, 1,                                                                     \
       "Observer on", "0: off; 1: the estimated disturbance is compensated", speed.observer_on, bool)                  \
  REAL(0x2020, 2, DECIDES, observer, inertia_kg_m2, 1e-9f, 1e5f, 6.0f, "kg m^2",                                       \
       "Observer inertia", "Nominal inertia J of the axis", speed.observer.inertia_kg_m2)                              \
  REAL(0x2020, 3, 0, observer, viscous_nm_s_rad, 0.0f, 1e4f, 0.0f, "N m s/rad",                                        \
       "Observer viscous coefficient", "0: the observer or the friction feedforward compensates viscous torque",       \
       speed.observer.viscous_nm_s_rad)                                                                                \
  REAL(0x2020, 4, DECIDES, observer, bandwidth_rad_s, 0.01f, 1e3f, 220.0f, "rad/s",                                    \
       "Observer bandwidth", "Higher: less phase margin, more torque noise; adds J w to the proportional gain",        \
       speed.observer.bandwidth_rad_s)                                                                                 \
  REAL(0x2020, 5, 0, observer, limit_nm, 0.0f, 1e4f, 40.0f, "N m",                                                     \
       "Observer limit", "Largest torque that the observer may add", speed.observer.limit_nm)                          \
  END(observer)                                                                                                        \
                                                                                                                       \
  GROUP(0x2030, 14, friction, "Friction feedforward",                                                                  \
        "LuGre model of the seal, with separate values for each direction")                                            \
  WHOLE(0x2030, 1, 0, friction, model, 0, 3, 3,                                                                        \
       "Friction model", "0: off; 1: Coulomb and viscous; 2: eq. (5); 3: LuGre", speed.friction.model, friction_model) \
  REAL(0x2030, 2, 0, friction, gain, 0.0f, 1.5f, 1.0f, "",                                                             \
       "Friction feedforward gain", "Factor on the model's torque; 1: full compensation", speed.friction.gain)         \
  REAL(0x2030, 3, 0, friction, lead_limit_rad_s, 1e-6f, 1e2f, 0.087f, "rad/s",                                         \
       "Friction lead limit", "Largest difference between the model's rate and the measured rate",                     \
       speed.friction.lead_limit_rad_s)                                                                                \
  REAL(0x2030, 4, 0, friction, sign_width_rad_s, 1e-6f, 1.0f, 1.7e-4f, "rad/s",                                        \
       "Friction sign width", "Models 1 and 2: below this speed sign(v) is replaced by a linear slope",                \
       speed.friction.sign_width_rad_s)                                                                                \
  REAL(0x2030, 5, 0, friction, stiffness_nm_rad, 1e-3f, 1e9f, 30000.0f, "N m/rad",                                     \
       "Bristle stiffness", "sigma0: torque per angle in pre-sliding", speed.friction.lugre.stiffness_nm_rad)          \
  REAL(0x2030, 6, 0, friction, damping_nm_s_rad, 0.0f, 1e6f, 300.0f, "N m s/rad",                                      \
       "Bristle damping", "sigma1: damping of the bristles", speed.friction.lugre.damping_nm_s_rad)                    \
  DIRECTION(7, positive, "positive")                                                                                   \
  DIRECTION(11, negative, "negative")                                                                                  \
  END(friction)                                                                                                        \
                                                                                                                       \
  GROUP(0x2040, 5, filters, "Filters", "Filters of the measured rate")                                                 \
  DESIGNED(0x2040, 1, DECIDES, filters, notch_hz, 0.0f, 490.0f, 0.0f, "Hz",                                            \
       "Notch frequency", "0: off")                                                                                    \
  DESIGNED(0x2040, 2, DECIDES, filters, notch_width_hz, 0.001f, 980.0f, 10.0f, "Hz",                                   \
       "Notch width", "Width between the -3 dB frequencies")                                                           \
  DESIGNED(0x2040, 3, DECIDES, filters, notch_depth, 0.0f, 1.0f, 0.1f, "",                                             \
       "Notch depth", "Gain at the notch frequency")                                                                   \
  DESIGNED(0x2040, 4, DECIDES, filters, lowpass_hz, 0.0f, 490.0f, 0.0f, "Hz",                                          \
       "Low-pass frequency", "0: off")                                                                                 \
  DESIGNED(0x2040, 5, DECIDES, filters, lowpass_damping, 0.1f, 2.0f, 0.7f, "",                                         \
       "Low-pass damping", "0.7 gives the flattest pass band")                                                         \
  END(filters)                                                                                                         \
                                                                                                                       \
  GROUP(0x2050, 3, sensors, "Rate sensors", "Sensors that measure the rate")                                           \
  WHOLE(0x2050, 1, DECIDES, sensors, source, 0, 2, 2,                                                                  \
       "Rate source", "0: encoder; 1: gyro; 2: fused", speed.rate_fusion.source, rate_source)                          \
  REAL(0x2050, 2, DECIDES, sensors, crossover_rad_s, 0.01f, 2e3f, 62.8f, "rad/s",                                      \
       "Fusion crossover", "Below it the gyro is used (sees base motion), above it the encoder (less noise)",          \
       speed.rate_fusion.crossover_rad_s)                                                                              \
  WHOLE(0x2050, 3, DECIDES, sensors, window_ticks, 2, 16, 2,                                                           \
       "Rate estimator window", "Number of angles used for the slope; 2 for high-resolution encoders",                 \
       speed.rate_estimator.window_ticks, int)                                                                         \
  END(sensors)                                                                                                         \
                                                                                                                       \
  GROUP(0x2055, 6, motor, "Motor", "DC torque motor and current loop")                                                 \
  REAL(0x2055, 1, OD_GUARDED, motor, torque_constant_nm_a, 1e-6f, 1e4f, 2.5f, "N m/A",                                 \
       "Torque constant", "Kt: torque per current", torque_constant_nm_a)                                              \
  REAL(0x2055, 2, OD_GUARDED, motor, resistance_ohm, 1e-4f, 1e3f, 1.2f, "ohm",                                         \
       "Winding resistance", "R at operating temperature", resistance_ohm)                                             \
  DESIGNED(0x2055, 3, OD_GUARDED, motor, inductance_h, 1e-7f, 10.0f, 3e-3f, "H",                                       \
       "Winding inductance", "L of the winding")                                                                       \
  DESIGNED(0x2055, 4, OD_GUARDED, motor, back_emf_v_s_rad, 0.0f, 1e3f, 2.5f, "V s/rad",                                \
       "Back-EMF constant", "Ke: voltage per speed")                                                                   \
  DESIGNED(0x2055, 5, OD_GUARDED | DECIDES, motor, bandwidth_rad_s, 2.0f, 16000.0f, 6283.0f, "rad/s",                  \
       "Current loop bandwidth", "Bandwidth of the first-order closed loop")                                           \
  REAL(0x2055, 6, OD_GUARDED, motor, current_limit_a, 0.0f, 1e4f, 16.0f, "A",                                          \
       "Current limit", "In both directions", current_limit_a)                                                         \
  END(motor)                                                                                                           \
                                                                                                                       \
  GROUP(0x2056, 9, plant, "Identified plant", "The axis as identified: gains are checked against it")                  \
  REAL(0x2056, 1, OD_GUARDED | DECIDES, plant, inertia_kg_m2, 1e-9f, 1e5f, 6.0f, "kg m^2",                             \
       "Plant inertia", "Largest inertia of the axis within its travel", plant_inertia_kg_m2)                          \
  REAL(0x2056, 2, OD_GUARDED, plant, min_inertia_kg_m2, 1e-9f, 1e5f, 6.0f, "kg m^2",                                   \
       "Plant inertia minimum", "Azimuth: inertia at pitch 90 deg, also beyond its travel; its gains follow",          \
       min_inertia_kg_m2)                                                                                            \
  REAL(0x2056, 3, OD_GUARDED, plant, viscous_nm_s_rad, 0.0f, 1e4f, 8.0f, "N m s/rad",                                  \
       "Plant viscous coefficient", "Friction torque per speed of the sliding seal", plant_viscous_nm_s_rad)           \
  REAL(0x2056, 4, OD_GUARDED, plant, stiffness_nm_rad, 0.0f, 1e9f, 30000.0f, "N m/rad",                                \
       "Plant bristle stiffness", "sigma0 of the seal; 0: it has no pre-sliding", plant_stiffness_nm_rad)              \
  REAL(0x2056, 5, OD_GUARDED, plant, damping_nm_s_rad, 0.0f, 1e6f, 300.0f, "N m s/rad",                                \
       "Plant bristle damping", "sigma1 of the seal", plant_damping_nm_s_rad)                                          \
  DESIGNED(0x2056, 6, OD_GUARDED, plant, encoder_delay_s, 0.0f, 0.01f, 1e-4f, "s",                                     \
       "Plant encoder delay", "Age of the angle when the tick samples it")                                             \
  DESIGNED(0x2056, 7, OD_GUARDED, plant, gyro_delay_s, 0.0f, 0.01f, 2e-4f, "s",                                        \
       "Plant gyro delay", "Age of the gyro rate when the tick samples it, without its low-pass")                      \
  DESIGNED(0x2056, 8, OD_GUARDED, plant, gyro_bandwidth_rad_s, 1.0f, 1e6f, 2765.0f, "rad/s",                           \
       "Plant gyro bandwidth", "First-order low-pass of the gyro")                                                     \
  WHOLE(0x2056, 9, OD_GUARDED, plant, gyro_mounting, 0, 2, 0,                                                          \
       "Plant gyro mounting", "0: turns with the axis; 1: on the line of sight (azimuth: measures cross-elevation); "  \
       "2: on what carries the axis (azimuth: the base; pitch: the azimuth stage)", gyro, gyro_mounting)               \
  END(plant)

/* clang-format on */

#endif
