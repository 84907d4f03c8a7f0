#include "hal_host.h"

bool hal_joint_angle(hal *machine, int axis, uint32_t *angle_turn32) {
  return machine->joint_angle(machine->machine, axis, angle_turn32);
}

bool hal_gyro_rate(hal *machine, int axis, float *rate_rad_s) {
  return machine->gyro_rate(machine->machine, axis, rate_rad_s);
}

float hal_mean_current_a(hal *machine, int axis) { return machine->mean_current_a(machine->machine, axis); }

bool hal_camera(hal *machine, int axis, hal_camera_frame *frame) {
  return machine->camera(machine->machine, axis, frame);
}

hal_health hal_axis_health(hal *machine, int axis) { return machine->axis_health(machine->machine, axis); }

void hal_power_bridge(hal *machine, int axis, bool on) { machine->power_bridge(machine->machine, axis, on); }

float hal_current_a(hal *machine, int axis) { return machine->current_a(machine->machine, axis); }

float hal_bus_voltage_v(hal *machine) { return machine->bus_voltage_v(machine->machine); }

void hal_set_duty(hal *machine, int axis, float duty) { machine->set_duty(machine->machine, axis, duty); }

void hal_set_scales(hal *machine, const hal_scales *scales) { machine->set_scales(machine->machine, scales); }
