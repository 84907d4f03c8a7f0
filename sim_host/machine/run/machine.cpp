// SPDX-License-Identifier: Apache-2.0
#include "machine/run/machine.hpp"

#include <algorithm>
#include <cmath>

#include "machine/run/start_firmware.hpp"
#include "machine/run/tick_sequence.hpp"

namespace trackservo::sim {

// The HAL's functions are C: they find the machine behind the pointer that was handed to `hal`.
namespace {

// The board's check of the clock against its other oscillator, as hal/chips/stm32g4/clock_check.h does it: every 100
// ms, wrong three times in a row. Here it always takes the longest time.
constexpr double kClockLimit = 0.0184;
constexpr int kClockCheckTicks = 400;
constexpr std::uint32_t kTick_us = 1000;

BadConverter bad_current(const AdcConfig& adc, std::uint64_t seed, int axis) {
  return {seed, "broken.current", axis, -adc.current_full_scale_a, adc.current_full_scale_a};
}

}  // namespace

struct MachineHal {
  static Machine& of(void *machine) { return *static_cast<Machine *>(machine); }

  static void sample(void *machine, int axis, hal_axis_samples *samples) {
    Machine& m = of(machine);
    const std::size_t i = static_cast<std::size_t>(axis);
    const std::uint32_t last_angle_turn32 = samples->joint_angle_turn32;
    *samples = m.samples_.axis[i];
    m.bad_sensors_[i].apply(m.broken_.axis[i], last_angle_turn32, samples);
    samples->mean_current_a = static_cast<float>(m.mean_current_a_[i]);
  }

  static hal_health axis_health(void *machine, int axis) {
    const std::size_t i = static_cast<std::size_t>(axis);
    const hal_health health = of(machine).broken_.axis[i].health;
    if (health != HAL_GOOD) {
      return health;
    }
    return of(machine).tripped_[i]                              ? HAL_OVER_CURRENT
           : of(machine).clock_wrong_ticks_ >= kClockCheckTicks ? HAL_CLOCK_WRONG
                                                                : HAL_GOOD;
  }

  // A bridge in fault has opened its terminals by itself.
  static void power_bridge(void *machine, int axis, bool on) {
    const std::size_t i = static_cast<std::size_t>(axis);
    const BrokenAxis& broken = of(machine).broken_.axis[i];
    of(machine).tripped_[i] = of(machine).tripped_[i] && on;
    const bool tripped = broken.health == HAL_OVER_CURRENT || broken.health == HAL_POWER_STAGE ||
                         broken.health == HAL_SAFE_TORQUE_OFF || broken.health == HAL_SAFE_TORQUE_FAULT ||
                         of(machine).tripped_[i];
    of(machine).tracker_.open_terminals(axis, !on || tripped || broken.motor_open);
    if (tripped) {
      release_brake(machine, axis, false);
    }
  }

  static void release_brake(void *machine, int axis, bool release) {
    const std::size_t i = static_cast<std::size_t>(axis);
    of(machine).tracker_.power_brake(axis, release && of(machine).broken_.axis[i].health != HAL_SAFE_TORQUE_OFF);
  }

  // An axis without a brake reports one that is open.
  static bool brake_is_released(void *machine, int axis) {
    const std::size_t i = static_cast<std::size_t>(axis);
    return of(machine).broken_.axis[i].brake_reads_open.value_or(of(machine).tracker_.brake_is_open(axis));
  }

  static std::uint32_t status(void *machine) {
    std::uint32_t bits = HAL_STATUS_STO_A | HAL_STATUS_STO_B | HAL_STATUS_RAM_PARITY | HAL_STATUS_WRITE_PROTECTION |
                         HAL_STATUS_FLASH_BANKS;
    for (const int axis : {kAzimuth, kPitch}) {
      const std::uint32_t bit = axis == kAzimuth ? HAL_STATUS_BRAKE_AZIMUTH : HAL_STATUS_BRAKE_PITCH;
      bits |= brake_is_released(machine, axis) ? bit : 0U;
      const bool off = of(machine).broken_.axis[static_cast<std::size_t>(axis)].health == HAL_SAFE_TORQUE_OFF;
      bits &= off ? ~static_cast<std::uint32_t>(HAL_STATUS_STO_A | HAL_STATUS_STO_B) : ~0U;
    }
    return bits;
  }

  // The current loop sees the injected current as missing, and adds it to its set-point.
  static float current_a(void *machine, int axis) {
    const std::size_t i = static_cast<std::size_t>(axis);
    return static_cast<float>(of(machine).reported_current_a_[i] - of(machine).injected_a_[i]);
  }

  static float bus_voltage_v(void *machine) { return static_cast<float>(of(machine).bus_voltage_v_); }

  static void set_duty(void *machine, int axis, float duty) {
    const std::size_t i = static_cast<std::size_t>(axis);
    const double sign = of(machine).broken_.axis[i].motor_reversed ? -1.0 : 1.0;
    of(machine).next_duty_[i] = sign * static_cast<double>(duty);
  }

  static std::uint32_t clock_us(void *machine) { return of(machine).clock_us_; }

  static void take_strobes(void *machine, hal_strobes *strobes) {
    std::vector<std::uint32_t>& edges = of(machine).strobes_;
    strobes->flooded = edges.size() > HAL_STROBES;
    strobes->count = strobes->flooded ? 0 : static_cast<std::uint32_t>(edges.size());
    std::copy_n(edges.begin(), strobes->count, strobes->at_us);
    edges.clear();
  }

  // The threshold if it is within the range; the end of the range is left to fault injection.
  static void set_scales(void *machine, const hal_scales *scales) {
    Machine& m = of(machine);
    for (std::size_t i = 0; i < kAxes; ++i) {
      const auto full_scale_a = static_cast<double>(scales->current_full_scale_a[i]);
      const auto over_current_a = static_cast<double>(scales->over_current_a[i]);
      m.current_share_[i] = full_scale_a / m.adc_.current_full_scale_a;
      m.over_current_a_[i] = over_current_a < full_scale_a ? over_current_a : 0.0;
    }
    m.voltage_share_ = static_cast<double>(scales->voltage_full_scale_v) / m.adc_.voltage_full_scale_v;
  }
};

hal Machine::hal_of(Machine *machine) {
  hal table{};
  table.machine = machine;
  table.sample = MachineHal::sample;
  table.axis_health = MachineHal::axis_health;
  table.power_bridge = MachineHal::power_bridge;
  table.current_a = MachineHal::current_a;
  table.bus_voltage_v = MachineHal::bus_voltage_v;
  table.set_duty = MachineHal::set_duty;
  table.set_scales = MachineHal::set_scales;
  table.release_brake = MachineHal::release_brake;
  table.brake_is_released = MachineHal::brake_is_released;
  table.status = MachineHal::status;
  table.clock_us = MachineHal::clock_us;
  table.tick_us = MachineHal::clock_us;
  table.take_strobes = MachineHal::take_strobes;
  return table;
}

Machine::Machine(const PlantConfig& plant, std::uint64_t seed, const std::array<double, kAxes>& joint_angle_rad)
    : tracker_(plant, seed),
      hal_(hal_of(this)),
      bad_sensors_{BadSensors(seed, kAzimuth), BadSensors(seed, kPitch)},
      bad_currents_{bad_current(plant.adc, seed, kAzimuth), bad_current(plant.adc, seed, kPitch)},
      bad_bus_(seed, "broken.bus", kAzimuth, 0.0, plant.adc.voltage_full_scale_v),
      adc_(plant.adc) {
  tracker_.place(joint_angle_rad);
  samples_ = tracker_.sample_tick();
  bus_voltage_v_ = samples_.bus_voltage_v;
}

Machine::Machine(const PlantConfig& plant, const servo_params& params, std::uint64_t seed,
                 const std::array<double, kAxes>& joint_angle_rad)
    : Machine(plant, seed, joint_angle_rad) {
  start_servo(*board_, hal_, params);
}

// A period of the firmware lasts longer or shorter than one of the plant: now and then the plant takes one more, or one
// less.
void Machine::run_clock() {
  clock_periods_ += 1.0 + broken_.clock_error;
  while (clock_periods_ >= 1.0) {
    clock_periods_ -= 1.0;
    tracker_.step_pwm(duty_);
  }
}

void Machine::break_parts() {
  clock_wrong_ticks_ = std::abs(broken_.clock_error) > kClockLimit ? clock_wrong_ticks_ + 1 : 0;
  tracker_.age_capacitor(broken_.bus_capacitor_share);
  for (std::size_t i = 0; i < kAxes; ++i) {
    tracker_.hold_joint(static_cast<int>(i), broken_.axis[i].joint_held);
    tracker_.push(static_cast<int>(i), broken_.axis[i].push_nm);
    tracker_.weaken_motor(static_cast<int>(i), broken_.axis[i].motor_share);
  }
}

// The readings of the converters at the beginning of a PWM period, and the reaction of a board's hardware to them.
void Machine::convert(std::uint32_t period) {
  for (std::size_t i = 0; i < kAxes; ++i) {
    const int axis = static_cast<int>(i);
    const PwmSample sample = tracker_.sample_pwm(axis);
    if (axis == kAzimuth) {
      const double bus_v = bad_bus_.apply(broken_.bus, sample.bus_voltage_v);
      bus_voltage_v_ = voltage_share_ * broken_.bus_reads_v.value_or(bus_v);
    }
    const BrokenAxis& broken = broken_.axis[i];
    const double current_a = bad_currents_[i].apply(broken.current, sample.current_a);
    if (!broken.current_stuck) {
      reported_current_a_[i] = current_share_[i] * broken.current_reads_a.value_or(current_a + broken.current_shift_a);
    }
    if (over_current_a_[i] > 0.0 && std::abs(reported_current_a_[i]) > over_current_a_[i]) {
      tripped_[i] = true;
      tracker_.open_terminals(axis, true);
    }
    if (period == 0) {
      mean_current_a_[i] = current_sum_a_[i] / kPwmPerTick;
      current_sum_a_[i] = 0.0;
    }
    current_sum_a_[i] += reported_current_a_[i];
  }
}

// Together with the tick's set-points, which are handed over then.
void Machine::begin_injection() {
  for (std::size_t i = 0; i < kAxes; ++i) {
    injected_a_[i] = injected_nm_[i] / static_cast<double>(board_->app.params.axis[i].torque_constant_nm_a);
  }
}

void Machine::advance_period() {
  if (period_ == 0) {
    break_parts();
  }
  run_pwm_period(
      *board_, period_,
      [this](std::uint32_t period) {
        if (period == SERVO_TICK_LATENCY_PERIODS) {
          begin_injection();
        }
        convert(period);
      },
      [this] { tick_(); },
      [this](std::uint32_t) {
        run_clock();
        duty_ = next_duty_;
      });
  if (++period_ == SERVO_PWM_PER_TICK) {
    period_ = 0;
    clock_us_ += kTick_us;
    samples_ = tracker_.sample_tick();
  }
}

void Machine::advance_tick() {
  do {
    advance_period();
  } while (period_ != 0);
}

}  // namespace trackservo::sim
