#include "hal_host.h"

uint32_t hal_joint_angle_turn32(hal *machine, int axis) { return machine->joint_angle_turn32(machine->machine, axis); }

bool hal_gyro_rate(hal *machine, int axis, float *rate_rad_s) {
  return machine->gyro_rate(machine->machine, axis, rate_rad_s);
}

float hal_mean_current_a(hal *machine, int axis) { return machine->mean_current_a(machine->machine, axis); }

bool hal_camera(hal *machine, int axis, hal_camera_frame *frame) {
  return machine->camera(machine->machine, axis, frame);
}

float hal_current_a(hal *machine, int axis) { return machine->current_a(machine->machine, axis); }

float hal_bus_voltage_v(hal *machine) { return machine->bus_voltage_v(machine->machine); }

void hal_set_duty(hal *machine, int axis, float duty) { machine->set_duty(machine->machine, axis, duty); }
