/* SPDX-License-Identifier: Apache-2.0 */
#include "hal_host.h"

void hal_sample(hal *machine, int axis, hal_axis_samples *samples) { machine->sample(machine->machine, axis, samples); }

hal_health hal_axis_health(hal *machine, int axis) { return machine->axis_health(machine->machine, axis); }

void hal_power_bridge(hal *machine, int axis, bool on) { machine->power_bridge(machine->machine, axis, on); }

float hal_current_a(hal *machine, int axis) { return machine->current_a(machine->machine, axis); }

float hal_bus_voltage_v(hal *machine) { return machine->bus_voltage_v(machine->machine); }

void hal_set_duty(hal *machine, int axis, float duty) { machine->set_duty(machine->machine, axis, duty); }

void hal_set_scales(hal *machine, const hal_scales *scales) { machine->set_scales(machine->machine, scales); }

void hal_release_brake(hal *machine, int axis, bool release) {
  machine->release_brake(machine->machine, axis, release);
}

bool hal_brake_is_released(hal *machine, int axis) { return machine->brake_is_released(machine->machine, axis); }

uint32_t hal_status(hal *machine) { return machine->status(machine->machine); }

uint32_t hal_clock_us(hal *machine) { return machine->clock_us(machine->machine); }

uint32_t hal_tick_us(hal *machine) { return machine->tick_us(machine->machine); }

void hal_take_strobes(hal *machine, hal_strobes *strobes) { machine->take_strobes(machine->machine, strobes); }
