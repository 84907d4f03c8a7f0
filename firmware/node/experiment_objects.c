/* SPDX-License-Identifier: Apache-2.0 */
#include "node/experiment_objects.h"

#include <math.h>

#include "canopen/object_dictionary_rows.h"
#include "node/servo_node.h"

enum { EXPERIMENT_OBJECT = 0x2100, EXPERIMENT_COMMAND_SUB = 1 };
enum { COMMAND_START = 1, COMMAND_ABORT = 2 };

#define SETS(sub_, member_, low_, high_, preset_, unit_, name_, help_) \
  OD_F32(0x2100, sub_, OD_RW, 0, experiment_objects, member_, low_, high_, preset_, unit_, name_, help_)

#define BREAKAWAYS(sub_, which_, title_)                                                                             \
  OD_U32(0x2100, sub_, OD_RO, 0, experiment_objects, breakaway[which_].count, 0, 1000, 0, "", "Break-aways " title_, \
         "Number of break-aways detected"),                                                                          \
      OD_F32(0x2100, (sub_) + 1, OD_RO, 0, experiment_objects, breakaway[which_].mean_nm, 0.0f, 1e4f, 0.0f, "N m",   \
             "Break-away torque found " title_, "Mean of the detected break-away torques"),                          \
      OD_F32(0x2100, (sub_) + 2, OD_RO, 0, experiment_objects, breakaway[which_].deviation_nm, 0.0f, 1e4f, 0.0f,     \
             "N m", "Break-away torque spread " title_, "Standard deviation of the detected break-away torques")

static const od_entry kEntries[] = {
    OD_RECORD_HEAD(0x2100, 24, "Experiment", "Moves the axis to measure friction and inertia; see commissioning/"),
    OD_U8(0x2100, 1, OD_RW, 0, experiment_objects, command, 0, 2, 0, "", "Experiment command", "1: start; 2: abort"),
    OD_U8(0x2100, 2, OD_RO, OD_TPDO, experiment_objects, state, 0, 7, 0, "", "Experiment state",
          "0: none; 1: running; 2: done; 3: aborted; 4: travel limit exceeded; 5: speed limit exceeded; 6: time limit "
          "exceeded; 7: stopped by the drive"),
    OD_U8(0x2100, 3, OD_RO, OD_TPDO, experiment_objects, progress, 0, 100, 0, "%", "Experiment progress",
          "Elapsed share of the experiment's duration"),
    OD_U8(0x2100, 4, OD_RW, 0, experiment_objects, kind, 0, 5, 0, "", "Experiment kind",
          "1: speed sweep; 2: torque ramps; 3: hysteresis loops; 4: chirp; 5: break-away"),
    OD_U32(0x2100, 5, OD_RW, 0, experiment_objects, setup.count, 1, 1000, 1, "", "Experiment count",
           "Number of speeds, triangles, chirps or break-aways"),
    SETS(6, setup.dwell_s, 0.01f, 1e3f, 1.0f, "s", "Experiment dwell",
         "Time at each speed and direction, of a triangle, of a rising chirp, or up to full torque"),
    SETS(7, setup.low_rad_s, 1e-6f, 1e2f, 1e-3f, "rad/s", "Experiment speed",
         "Slowest speed of the sweep; base speed of the chirp"),
    SETS(8, setup.speed_ratio, 1.0f, 10.0f, 1.5f, "", "Experiment speed ratio",
         "Ratio of consecutive speeds of the sweep"),
    SETS(9, setup.acceleration_rad_s2, 1e-4f, 1e4f, 0.5f, "rad/s^2", "Experiment acceleration",
         "Acceleration of sweep and chirp"),
    SETS(10, setup.amplitude_nm, 1e-6f, 1e4f, 1.0f, "N m", "Experiment torque",
         "Torque amplitude of ramps, chirp and break-away"),
    SETS(11, setup.amplitude_rad, 1e-7f, 3.0f, 1e-3f, "rad", "Experiment angle",
         "Amplitude of hysteresis loops; motion that counts as break-away"),
    SETS(12, setup.low_hz, 0.01f, 400.0f, 2.0f, "Hz", "Experiment lowest frequency", "Start frequency of the chirp"),
    SETS(13, setup.high_hz, 0.01f, 400.0f, 50.0f, "Hz", "Experiment highest frequency", "End frequency of the chirp"),
    SETS(14, limits.travel_rad, 1e-6f, 3.0f, 0.1f, "rad", "Experiment travel limit",
         "Travel to each side of the start position"),
    SETS(15, limits.rate_rad_s, 1e-6f, 1e2f, 0.1f, "rad/s", "Experiment speed limit",
         "Joint speed above which the experiment ends"),
    SETS(16, limits.torque_nm, 1e-6f, 1e4f, 10.0f, "N m", "Experiment torque limit", "In both directions"),
    SETS(17, limits.duration_s, 1e-3f, 3600.0f, 60.0f, "s", "Experiment time limit",
         "The experiment ends after this time"),
    OD_F32(0x2100, 18, OD_RO, 0, experiment_objects, duration_s, 0.0f, 1e9f, 0.0f, "s", "Experiment duration",
           "Approximate duration with the present settings"),
    BREAKAWAYS(19, 0, "positive"),
    BREAKAWAYS(22, 1, "negative"),
};

const od_table experiment_objects_table = {kEntries, sizeof kEntries / sizeof kEntries[0]};

static breakaway_objects reported(const breakaway_statistics *found) {
  const float variance_nm2 = found->count > 1 ? found->square_sum_nm2 / (float)(found->count - 1) : 0.0f;
  return (breakaway_objects){.count = found->count, .mean_nm = found->mean_nm, .deviation_nm = sqrtf(variance_nm2)};
}

static stimulus_setup setup_of(const experiment_objects *objects) {
  stimulus_setup setup = objects->setup;
  setup.kind = (stimulus_kind)objects->kind;
  return setup;
}

static void report_state(experiment_objects *objects) {
  objects->state = (uint8_t)objects->running.state;
  objects->progress = objects->running.state == EXPERIMENT_IDLE
                          ? 0
                          : (uint8_t)experiment_progress_percent(&objects->running, SERVO_TICK_S);
}

static od_abort refresh(void *owner, const od_object *object) {
  experiment_objects *objects = &((servo_node_axis *)owner)->experiment;
  (void)object;
  report_state(objects); /* a command may have come since the tick */
  const stimulus_setup setup = setup_of(objects);
  objects->duration_s = stimulus_duration_s(&setup);
  objects->breakaway[0] = reported(&objects->running.stimulus.breakaway[STIMULUS_FORWARD]);
  objects->breakaway[1] = reported(&objects->running.stimulus.breakaway[STIMULUS_BACKWARD]);
  return OD_OK;
}

static bool is_command(const od_object *object) {
  return object->entry->index == EXPERIMENT_OBJECT && object->entry->sub == EXPERIMENT_COMMAND_SUB;
}

static od_abort accept(void *owner, const od_object *object, od_number value) {
  const servo_node_axis *axis = owner;
  const drive_axis *drive = &axis->drive;
  if (!is_command(object) || value.i != COMMAND_START) {
    return OD_OK;
  }
  if (axis->experiment.running.state == EXPERIMENT_RUNNING || !drive_axis_obeys_stimulus(drive) ||
      !profile_at_rest(&drive->motion.ramp)) {
    return OD_DEVICE_STATE;
  }
  const stimulus_setup setup = setup_of(&axis->experiment);
  return experiment_check(&setup, &axis->experiment.limits) == CONTROL_OK ? OD_OK : OD_INCOMPATIBLE;
}

static od_abort execute(void *owner, const od_object *object, od_number value) {
  servo_node_axis *axis = owner;
  if (is_command(object) && value.i == COMMAND_START) {
    const stimulus_setup setup = setup_of(&axis->experiment);
    (void)experiment_start(&axis->experiment.running, &setup, &axis->experiment.limits,
                           (angle_turn32)axis->drive.position); /* accept() has checked it */
    axis->experiment.started++;
  } else if (is_command(object) && value.i == COMMAND_ABORT) {
    experiment_abort(&axis->experiment.running, EXPERIMENT_ABORTED);
  }
  return OD_OK;
}

const od_hooks experiment_objects_hooks = {.refresh = refresh, .accept = accept, .execute = execute};

bool experiment_objects_step(experiment_objects *objects, const drive_axis *drive, angle_turn32 angle,
                             float joint_rate_rad_s, servo_axis_command *command, float dt_s) {
  if (!drive_axis_obeys_stimulus(drive)) {
    experiment_abort(&objects->running, EXPERIMENT_DRIVE_STOPPED);
  }
  return experiment_step(&objects->running, angle, joint_rate_rad_s, command, dt_s);
}
