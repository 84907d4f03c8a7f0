/* SPDX-License-Identifier: Apache-2.0 */
/* A machine behind hal_host.h with two rigid axes: its currents are those that the node commands.
 *
 * Every effect of a machine on the node is a member: a changed member takes effect at the next tick. */
#ifndef TRACKSERVO_TESTS_SUPPORT_RIGID_MACHINE_H
#define TRACKSERVO_TESTS_SUPPORT_RIGID_MACHINE_H

#include <math.h>
#include <string.h>

#include "hal_host.h"
#include "node/servo_node.h"
#include "parameters/axis_dictionary.h"
#include "servo/servo_app.h"

typedef struct {
  double turns; /* joint angle */
  double rate_rad_s;
  double load_nm;     /* against positive motion */
  double friction_nm; /* dry, both directions */
  bool encoder_failed;
  bool gyro_missing;
  float gyro_error_rad_s; /* added to the correct reading */
  float current_error_a;  /* the same */
  hal_health health;
  bool powered;
  bool brake_coil_on;
  bool brake_open; /* what its contact reports */
  float duty;
  float current_a;
} rigid_axis;

typedef struct {
  hal functions;
  rigid_axis axis[SERVO_AXES];
  float bus_voltage_v;
  uint32_t status;
  uint32_t clock_us;   /* advances with rigid_machine_turn */
  hal_strobes strobes; /* cleared when they are taken */
  hal_scales scales;   /* set by the node; the readings are correct in any case */
} rigid_machine;

/* A gyro without an answer reads 0; the angle of an encoder without an answer stays. */
static inline void rigid_sample(void *machine, int axis, hal_axis_samples *samples) {
  rigid_axis *joint = &((rigid_machine *)machine)->axis[axis];
  samples->encoder_failed = joint->encoder_failed;
  if (!joint->encoder_failed) {
    samples->joint_angle_turn32 = (uint32_t)(uint64_t)((joint->turns - floor(joint->turns)) * 4294967296.0);
  }
  samples->gyro_valid = !joint->gyro_missing;
  samples->gyro_rad_s = joint->gyro_missing ? 0.0f : (float)joint->rate_rad_s + joint->gyro_error_rad_s;
  samples->mean_current_a = joint->current_a + joint->current_error_a;
}

static inline float rigid_current_a(void *machine, int axis) {
  const rigid_axis *joint = &((rigid_machine *)machine)->axis[axis];
  return joint->current_a + joint->current_error_a;
}

static inline hal_health rigid_health(void *machine, int axis) { return ((rigid_machine *)machine)->axis[axis].health; }

static inline void rigid_power(void *machine, int axis, bool on) {
  ((rigid_machine *)machine)->axis[axis].powered = on;
}

static inline void rigid_release_brake(void *machine, int axis, bool release) {
  ((rigid_machine *)machine)->axis[axis].brake_coil_on = release;
}

static inline bool rigid_brake_is_released(void *machine, int axis) {
  return ((rigid_machine *)machine)->axis[axis].brake_open;
}

static inline uint32_t rigid_status(void *machine) { return ((rigid_machine *)machine)->status; }

static inline float rigid_bus_voltage_v(void *machine) { return ((rigid_machine *)machine)->bus_voltage_v; }

static inline void rigid_set_duty(void *machine, int axis, float duty) {
  ((rigid_machine *)machine)->axis[axis].duty = duty;
}

static inline void rigid_set_scales(void *machine, const hal_scales *scales) {
  ((rigid_machine *)machine)->scales = *scales;
}

static inline uint32_t rigid_clock_us(void *machine) { return ((rigid_machine *)machine)->clock_us; }

static inline void rigid_take_strobes(void *machine, hal_strobes *strobes) {
  *strobes = ((rigid_machine *)machine)->strobes;
  ((rigid_machine *)machine)->strobes = (hal_strobes){0};
}

/* At rest at angle 0, healthy, 48 V. */
static inline void rigid_machine_init(rigid_machine *machine) {
  *machine = (rigid_machine){.functions = {.machine = machine,
                                           .sample = rigid_sample,
                                           .axis_health = rigid_health,
                                           .power_bridge = rigid_power,
                                           .current_a = rigid_current_a,
                                           .bus_voltage_v = rigid_bus_voltage_v,
                                           .set_duty = rigid_set_duty,
                                           .set_scales = rigid_set_scales,
                                           .release_brake = rigid_release_brake,
                                           .brake_is_released = rigid_brake_is_released,
                                           .status = rigid_status,
                                           .clock_us = rigid_clock_us,
                                           .tick_us = rigid_clock_us,
                                           .take_strobes = rigid_take_strobes},
                             .bus_voltage_v = 48.0f};
}

/* The rate after one ms: friction holds an axis at rest and stops an axis that would reverse. */
static inline double rigid_next_rate(const rigid_axis *joint, double torque_nm, double inertia_kg_m2) {
  const double direction = joint->rate_rad_s != 0.0 ? joint->rate_rad_s : torque_nm;
  const double free_rad_s = joint->rate_rad_s + 1e-3 * torque_nm / inertia_kg_m2;
  const double rate_rad_s = free_rad_s - copysign(1e-3 * joint->friction_nm / inertia_kg_m2, direction);
  return joint->friction_nm > 0.0 && rate_rad_s * direction <= 0.0 ? 0.0 : rate_rad_s;
}

/* Current in the winding, and the voltage that an ideal current loop reports for it. */
static inline void rigid_drive(rigid_axis *joint, servo_board *board, int i) {
  const servo_axis *servo = &board->app.axis[i];
  const servo_axis_params *params = &board->app.params.axis[i];
  const float back_emf_v = params->current.back_emf_v_s_rad * (float)joint->rate_rad_s;
  joint->current_a = servo->current_reference_a;
  float voltage_v = 0.0f;
  if (servo->mode == SERVO_BRAKE) {
    joint->current_a = -back_emf_v / params->resistance_ohm;
  } else if (servo_mode_drives(servo->mode)) {
    voltage_v = params->resistance_ohm * joint->current_a + back_emf_v;
  }
  atomic_store_explicit(&board->motor[i].tick_voltage_v, voltage_v, memory_order_relaxed);
}

/* One ms of motion, instead of the PWM periods of that time. The inertia is the one that the servo's observer
 * assumes. */
static inline void rigid_machine_turn(rigid_machine *machine, servo_board *board) {
  machine->clock_us += 1000;
  for (int i = 0; i < SERVO_AXES; ++i) {
    rigid_axis *joint = &machine->axis[i];
    const servo_axis_params *params = &board->app.params.axis[i];
    rigid_drive(joint, board, i);
    const double torque_nm = (double)(joint->current_a * params->torque_constant_nm_a) - joint->load_nm;
    const double rate_rad_s = rigid_next_rate(joint, torque_nm, (double)params->speed.observer.inertia_kg_m2);
    joint->turns += 1e-3 * 0.5 * (joint->rate_rad_s + rate_rad_s) / 6.283185307179586;
    joint->rate_rad_s = rate_rad_s;
  }
}

/* The node with its default parameters on this machine and bus; false when it refuses to start. */
static inline bool rigid_machine_start_node_on(rigid_machine *machine, servo_node *node, uint8_t node_id,
                                               can_sender sender, const hal_flash *flash, const servo_node_bus *bus) {
  static axis_tuning defaults;
  const od_part part = {.table = axis_parameters_table, .values = &defaults, .prefix = ""};
  od_restore_defaults(&part, node_id);
  const axis_parameters parameters[SERVO_AXES] = {defaults.staged, defaults.staged};
  protection_limits limits[SERVO_AXES];
  for (int i = 0; i < SERVO_AXES; ++i) {
    protection_objects objects;
    const od_part limits_part = {.table = protection_objects_table, .values = &objects, .prefix = ""};
    od_restore_defaults(&limits_part, node_id);
    limits[i] = objects.written;
    limits[i].travel_kind = 1.0f; /* no end stops */
    limits[i].stuck_s = 0.0f;     /* without noise, a machine at rest always reads the same */
    limits[i].proof_rad_s = 0.0f; /* it is quite at rest */
  }
  const servo_node_config config = {node_id, sender, &machine->functions, parameters, limits, flash, 0, *bus,
                                    NULL,    NULL};
  return servo_node_start(node, &config);
}

/* The same at 1 Mbit/s; what LSS stores is in RAM. */
static inline bool rigid_machine_start_node(rigid_machine *machine, servo_node *node, uint8_t node_id,
                                            can_sender sender, const hal_flash *flash) {
  const servo_node_bus bus = {0};
  return rigid_machine_start_node_on(machine, node, node_id, sender, flash, &bus);
}

#endif
