/* SPDX-License-Identifier: Apache-2.0 */
#include "protection/fault_texts.h"

#include <stddef.h>

#include "protection/fault_phrases.h"

const fault_text *fault_text_of(fault_id fault) {
  const fault_text *of_axis = &fault_texts_of_axis[fault];
  return of_axis->name != NULL ? of_axis : &fault_texts_of_node[fault];
}

const fault_signal fault_signals[FAULT_LOG_SIGNALS] = {
    {"joint_angle", "rad"}, {"joint_rate", "rad/s"}, {"gyro", "rad/s"}, {"reference", "rad/s"},
    {"rate", "rad/s"},      {"torque", "N m"},       {"current", "A"},  {"bus_voltage", "V"},
};
