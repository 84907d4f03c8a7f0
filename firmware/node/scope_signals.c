/* SPDX-License-Identifier: Apache-2.0 */
#include "node/scope_signals.h"

#include "canopen/object_dictionary_rows.h"
#include "node/servo_node.h"

#define NAMES(first_, axis_)                                                                                         \
  OD_FIXED_TEXT(0x3002, (first_), axis_ ".reference_rad_s", axis_ " signal set-point", "Inertial rate set-point"),   \
      OD_FIXED_TEXT(0x3002, (first_) + 1, axis_ ".feedback_rad_s", axis_ " signal feedback",                         \
                    "Filtered inertial rate used by the controller"),                                                \
      OD_FIXED_TEXT(0x3002, (first_) + 2, axis_ ".rate_rad_s", axis_ " signal rate", "Unfiltered inertial rate"),    \
      OD_FIXED_TEXT(0x3002, (first_) + 3, axis_ ".joint_rate_rad_s", axis_ " signal joint rate",                     \
                    "Joint rate from the encoder"),                                                                  \
      OD_FIXED_TEXT(0x3002, (first_) + 4, axis_ ".base_rate_rad_s", axis_ " signal base rate", "Rate of the base"),  \
      OD_FIXED_TEXT(0x3002, (first_) + 5, axis_ ".torque_nm", axis_ " signal torque", "Torque command"),             \
      OD_FIXED_TEXT(0x3002, (first_) + 6, axis_ ".pi_nm", axis_ " signal PI torque", "Torque of the PI controller"), \
      OD_FIXED_TEXT(0x3002, (first_) + 7, axis_ ".disturbance_nm", axis_ " signal disturbance torque",               \
                    "Torque of the disturbance observer"),                                                           \
      OD_FIXED_TEXT(0x3002, (first_) + 8, axis_ ".friction_nm", axis_ " signal friction torque",                     \
                    "Torque of the friction feedforward"),                                                           \
      OD_FIXED_TEXT(0x3002, (first_) + 9, axis_ ".current_reference_a", axis_ " signal current set-point",           \
                    "Set-point of the current loop"),                                                                \
      OD_FIXED_TEXT(0x3002, (first_) + 10, axis_ ".current_a", axis_ " signal current",                              \
                    "Mean current of the last tick"),                                                                \
      OD_FIXED_TEXT(0x3002, (first_) + 11, axis_ ".gyro_rad_s", axis_ " signal gyro", "Gyro rate as measured")

static const od_entry kEntries[] = {
    OD_ARRAY_HEAD(0x3002, SCOPE_SIGNALS, "Scope signals", "Names of the signals that the scope can record"),
    NAMES(1, "azimuth"),
    NAMES(1 + SCOPE_SIGNALS_PER_AXIS, "pitch"),
};

const od_table scope_signals_table = {kEntries, sizeof kEntries / sizeof kEntries[0]};

#define OF_AXIS(member_) offsetof(servo_node, board.app.axis[0].member_)
#define OF_SAMPLES(member_) offsetof(servo_node, board.samples.axis[0].member_)

uint32_t scope_signal_offset(uint32_t signal) {
  static const size_t first_axis[SCOPE_SIGNALS_PER_AXIS] = {
      OF_AXIS(signals.reference.rate_rad_s),  OF_AXIS(signals.rates.feedback_rad_s),
      OF_AXIS(signals.rates.rate_rad_s),      OF_AXIS(signals.rates.joint_rate_rad_s),
      OF_AXIS(signals.rates.base_rate_rad_s), OF_AXIS(signals.torque.torque_nm),
      OF_AXIS(signals.torque.pi_nm),          OF_AXIS(signals.torque.disturbance_nm),
      OF_AXIS(signals.torque.friction_nm),    OF_AXIS(current_reference_a),
      OF_SAMPLES(sensors.mean_current_a),     OF_SAMPLES(sensors.gyro_rad_s)};
  const uint32_t index = signal - 1;
  const uint32_t which = index % SCOPE_SIGNALS_PER_AXIS;
  const size_t to_pitch = index < SCOPE_SIGNALS_PER_AXIS ? 0
                          : which < 10                   ? sizeof(servo_axis)
                                                         : sizeof(servo_axis_samples);
  return (uint32_t)(first_axis[which] + to_pitch);
}
