/* SPDX-License-Identifier: Apache-2.0 */
#include "node/recorded_tick.h"

#include <math.h>

#include "canopen/object_dictionary_rows.h"

#define U32_HIGHEST INT64_C(0xFFFFFFFF)

#define RECORDS(sub_, member_, bound_, unit_, name_, help_) \
  OD_F32(0x2101, sub_, OD_RO, OD_TPDO, recorded_tick, member_, -(bound_), bound_, 0.0f, unit_, name_, help_)

static const od_entry kEntries[] = {
    OD_RECORD_HEAD(0x2101, 8, "Recorded tick", "Signals of the axis in the last tick, all of the same tick"),
    OD_U16(0x2101, 1, OD_RO, OD_TPDO, recorded_tick, number, 0, 0xFFFF, 0, "ms", "Recorded tick number",
           "Counts the ticks and wraps"),
    OD_U8(0x2101, 2, OD_RO, OD_TPDO, recorded_tick, kind, 0, 5, 0, "", "Recorded tick kind",
          "Kind of the experiment that gave the set-point, see 2100:4; 0: none"),
    OD_U8(0x2101, 3, OD_RO, OD_TPDO, recorded_tick, run, 0, 255, 0, "", "Recorded tick run",
          "Number of experiments started so far; wraps"),
    OD_U32(0x2101, 4, OD_RO, OD_TPDO, recorded_tick, joint_angle_turn32, 0, U32_HIGHEST, 0, "2^-32 turn",
           "Recorded tick joint angle", "Joint angle from the encoder"),
    RECORDS(5, joint_rate_rad_s, 1e3f, "rad/s", "Recorded tick joint rate", "Joint rate from the encoder"),
    RECORDS(6, inertial_rate_rad_s, 1e3f, "rad/s", "Recorded tick inertial rate",
            "Gyro rate; NaN in a tick without a reading"),
    RECORDS(7, torque_nm, 1e8f, "N m", "Recorded tick torque",
            "Torque constant times mean current since the previous tick"),
    RECORDS(8, reference, 1e8f, "", "Recorded tick reference",
            "Set-point in rad/s; in N m for torque ramps, break-away and cst; in rad (-pi to pi) for hysteresis loops"),
};

const od_table recorded_tick_table = {kEntries, sizeof kEntries / sizeof kEntries[0]};

static float reference_of(const servo_axis_command *command, stimulus_kind kind) {
  if (kind == STIMULUS_HYSTERESIS) {
    return angle_difference_rad(command->position, 0);
  }
  return command->mode == SERVO_TORQUE ? command->torque_nm : command->speed.rate_rad_s;
}

void recorded_tick_take(recorded_tick *recorded, const servo_board *board, int axis, const experiment_objects *objects,
                        bool stimulated, uint32_t tick) {
  const servo_axis_samples *samples = &board->samples.axis[axis];
  const float joint_rate_rad_s = board->app.axis[axis].signals.rates.joint_rate_rad_s;
  const float inertial_rate_rad_s =
      speed_loop_gyro_rate(&board->app.axis[axis].speed.gyro, samples->sensors.gyro_rad_s, joint_rate_rad_s);
  const stimulus_kind kind = stimulated ? objects->running.setup.kind : STIMULUS_NONE;
  *recorded = (recorded_tick){
      .number = (uint16_t)tick,
      .kind = (uint8_t)kind,
      .run = objects->started,
      .joint_angle_turn32 = samples->sensors.joint_angle_turn32,
      .joint_rate_rad_s = joint_rate_rad_s,
      .inertial_rate_rad_s = samples->sensors.gyro_valid ? inertial_rate_rad_s : NAN,
      .torque_nm = board->app.params.axis[axis].torque_constant_nm_a * samples->sensors.mean_current_a,
      .reference = reference_of(&board->command.axis[axis], kind),
  };
}
