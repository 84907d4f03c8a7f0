// SPDX-License-Identifier: Apache-2.0
#include "board/board_machine.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace trackservo::target {
namespace {

using sim::kAzimuth;
using sim::kPitch;

constexpr Instant kPwmPeriod = 50 * kUnitsPerMicrosecond;
constexpr double kHeatSinkCelsius = 40.0;

struct Pin {
  char port;
  unsigned number;
};

// The two legs of a bridge, and its signals.
struct Bridge {
  Pin high[Timer::kLegs];
  Pin low[Timer::kLegs];
  unsigned function;
  Pin enable;
  Pin fault;
  Pin enable_read_back;
  Pin second_break;  // channel B of STO
  unsigned second_break_function;
  Pin brake;
  Pin brake_contact;
};

constexpr Pin kStoA = {'C', 2};

constexpr Bridge kBridges[] = {
    {{{'A', 8}, {'A', 9}}, {{'B', 13}, {'B', 14}}, 6, {'C', 8}, {'B', 12}, {'B', 1}, {'C', 3}, 6, {'B', 15}, {'B', 5}},
    {{{'C', 6}, {'C', 7}}, {{'A', 7}, {'B', 0}}, 4, {'C', 9}, {'A', 6}, {'B', 2}, {'B', 6}, 10, {'B', 9}, {'B', 7}},
};

// 10 kOhm, B = 3435 K, to ground, with 10 kOhm to the reference.
std::uint32_t thermistor_counts(double celsius) {
  const double ratio = std::exp(3435.0 * (1.0 / (celsius + 273.15) - 1.0 / 298.15));
  return static_cast<std::uint32_t>(std::lround(4096.0 * ratio / (1.0 + ratio)));
}

std::uint32_t clipped_counts(double counts) {
  return static_cast<std::uint32_t>(std::clamp(std::lround(counts), 0L, 4095L));
}

// The chip reads the encoders at instants within a step.
const sim::PlantConfig& exact(const sim::PlantConfig& plant) {
  if (plant.mechanics.pwm_periods_per_step != 1) {
    throw std::invalid_argument(fmt::format("{}: mechanics.pwm_periods_per_step is {}; the emulated board needs 1",
                                            plant.name, plant.mechanics.pwm_periods_per_step));
  }
  return plant;
}

}  // namespace

BoardMachine::BoardMachine(const std::vector<std::uint8_t>& image, const sim::PlantConfig& plant, sim::VirtualBus& bus,
                           const Options& options)
    : bus_(bus),
      tracker_(exact(plant), options.seed),
      adc_(plant.adc),
      chip_(image),
      can_(bus, chip_.fdcan1),
      encoder_{BissEncoder(chip_.violations, [this] { return tracker_.read_encoder(kAzimuth); }),
               BissEncoder(chip_.violations, [this] { return tracker_.read_encoder(kPitch); })},
      gyro_{FibreGyro(chip_.timeline, chip_.usart1), FibreGyro(chip_.timeline, chip_.usart3)},
      gyro_phase_(options.gyro_phase),
      late_step_(chip_.timeline.add([this] { step(stepped_at_ + kPwmPeriod); })),
      sto_alarm_(chip_.timeline.add([this] { follow_sto(); })) {
  tracker_.place(options.joint_angle_rad);
  if (options.holding_brakes) {
    tracker_.fit_holding_brakes();
  }
  chip_.spi1.connect(&encoder_[kAzimuth]);
  chip_.spi3.connect(&encoder_[kPitch]);
  chip_.adc1.measures([this](unsigned channel) { return adc_counts(1, channel); });
  chip_.adc2.measures([this](unsigned channel) { return adc_counts(2, channel); });
  for (const char port : {'A', 'B', 'C'}) {
    chip_.port(port).monitor([this] { update_inputs(); });
  }
  chip_.timeline.set(late_step_, kPwmPeriod + kPwmPeriod / 4);
  chip_.power_on();
  for (int axis = 0; axis < sim::kAxes; ++axis) {
    set_driver_fault(axis, false);
  }
}

// --- PWM to motor ---

bool BoardMachine::is_bridge_on(int axis) {
  const Timer& timer = axis == kAzimuth ? chip_.tim1 : chip_.tim8;
  return is_driver_enabled(axis) && timer.is_main_output_enabled();
}

double BoardMachine::take_duty(int axis) {
  const Bridge& bridge = kBridges[axis];
  Timer& timer = axis == kAzimuth ? chip_.tim1 : chip_.tim8;
  const auto legs = timer.take_mean_legs();
  bool driven = legs[0].has_value() && legs[1].has_value() && is_bridge_on(axis);
  for (std::size_t leg = 0; driven && leg < Timer::kLegs; ++leg) {
    for (const Pin pin : {bridge.high[leg], bridge.low[leg]}) {
      if (!chip_.port(pin.port).has_function(pin.number, bridge.function)) {
        chip_.violations.add(
            fmt::format("P{}{} does not drive its bridge with the timer's signal", pin.port, pin.number));
        driven = false;
      }
    }
  }
  return driven ? *legs[0] - *legs[1] : 0.0;
}

bool BoardMachine::run_after_tick(double after_s) {
  constexpr int kPatience_periods = 200;
  const std::uint64_t before = ticks_;
  for (int period = 0; ticks_ == before; ++period) {
    if (period == kPatience_periods) {
      return false;
    }
    run(sim::kPwmPeriod_s);
  }
  run(after_s);
  return true;
}

// One PWM period of the plant, which ends `at`, and the other actions at this rate.
void BoardMachine::step(Instant at) {
  stepped_at_ = at;
  chip_.timeline.set(late_step_, stepped_at_ + kPwmPeriod + kPwmPeriod / 4);
  for (std::size_t i = 0; i < sim::kAxes; ++i) {
    const int axis = static_cast<int>(i);
    duty_[i] = take_duty(axis);
    tracker_.open_terminals(axis, !is_bridge_on(axis));
    tracker_.power_brake(axis, is_brake_powered(axis));
  }
  tracker_.step_pwm(duty_);
  update_inputs();
  for (std::size_t i = 0; i < sim::kAxes; ++i) {
    const sim::PwmSample sample = tracker_.sample_pwm(static_cast<int>(i));
    current_a_[i] = sample.current_a + (is_bridge_on(static_cast<int>(i)) ? short_current_a_[i] : 0.0);
    bus_voltage_v_ = sample.bus_voltage_v;
  }
  bus_.advance(seconds_of(kPwmPeriod));
  can_.pump(chip_.timeline.now());
  const bool ticking = chip_.tim6.is_running();
  step_in_tick_ = ticking && !ticking_ ? 0 : (step_in_tick_ + 1) % sim::kPwmPerTick;
  ticking_ = ticking;
  ticks_ += ticking && step_in_tick_ == 0 ? 1 : 0;
  if (step_in_tick_ == gyro_phase_) {
    for (std::size_t i = 0; i < sim::kAxes; ++i) {
      const sim::Gyro::Reading reading = tracker_.read_gyro(static_cast<int>(i));
      gyro_[i].send(reading.rate_rad_s, reading.valid);
    }
  }
  if (step_in_tick_ == 0 && tick_listener_) {
    tick_listener_();
  }
}

// Both converters are triggered at the same time; the first one requests the values.
void BoardMachine::step_if_due() {
  if (chip_.timeline.instant() >= stepped_at_ + kPwmPeriod / 2) {
    if (chip_.tim1.is_running() && !chip_.tim1.is_around_zero()) {
      chip_.violations.add("currents are sampled in the wrong half of the PWM period");
    }
    step(chip_.timeline.instant());
  }
}

// --- sensors ---

void BoardMachine::check_pin_is_analog(char port, unsigned pin) {
  if (chip_.port(port).mode(pin) != Gpio::Mode::kAnalog) {
    chip_.violations.add(fmt::format("P{}{} is measured but not in analog mode", port, pin));
  }
}

double BoardMachine::read_current_a(std::size_t axis) const {
  return stuck_current_a_[axis].value_or(current_a_[axis]);
}

std::uint32_t BoardMachine::adc_counts(int converter, unsigned channel) {
  step_if_due();
  const double counts_per_a = std::ldexp(0.5, adc_.resolution_bits) / adc_.current_full_scale_a;
  const double counts_per_v = std::ldexp(1.0, adc_.resolution_bits) / adc_.voltage_full_scale_v;
  if (converter == 1 && channel == 1) {
    check_pin_is_analog('A', 0);
    return clipped_counts(2048.0 + read_current_a(kAzimuth) * counts_per_a);
  }
  if (converter == 2 && channel == 2) {
    check_pin_is_analog('A', 1);
    return clipped_counts(2048.0 + read_current_a(kPitch) * counts_per_a);
  }
  if (converter == 1 && channel == 6) {
    check_pin_is_analog('C', 0);
    return clipped_counts(forced_bus_v_.value_or(bus_voltage_v_) * counts_per_v);
  }
  if (converter == 2 && channel == 7) {
    check_pin_is_analog('C', 1);
    return thermistor_counts(kHeatSinkCelsius);
  }
  chip_.violations.add(fmt::format("ADC{} measures channel {}, which is not connected", converter, channel));
  return 0;
}

// --- driver faults ---

void BoardMachine::set_driver_fault(int axis, bool fault) {
  driver_fault_[static_cast<std::size_t>(axis)] = fault;
  const Pin pin = kBridges[axis].fault;
  chip_.port(pin.port).set_input(pin.number, !fault);
}

// --- safe torque off, brakes ---

void BoardMachine::set_sto(StoChannel channel, bool permits) {
  Sto& sto = sto_[channel == StoChannel::kA ? 0 : 1];
  sto.terminal = permits;
  sto.due = sto.terminal == sto.pin ? Timeline::kNever : chip_.timeline.now() + kStoDelay;
  chip_.timeline.set(sto_alarm_, std::min(sto_[0].due, sto_[1].due));
}

void BoardMachine::follow_sto() {
  for (Sto& sto : sto_) {
    if (sto.due <= chip_.timeline.now()) {
      sto.pin = sto.terminal;
      sto.due = Timeline::kNever;
    }
  }
  chip_.timeline.set(sto_alarm_, std::min(sto_[0].due, sto_[1].due));
  update_inputs();
}

bool BoardMachine::is_driver_enabled(int axis) {
  const Pin enable = kBridges[axis].enable;
  return stuck_enable_[static_cast<std::size_t>(axis)].value_or(sto_[0].pin &&
                                                                chip_.port(enable.port).drives_high(enable.number));
}

bool BoardMachine::is_brake_powered(int axis) {
  const Pin brake = kBridges[axis].brake;
  return sto_[0].pin && chip_.port(brake.port).drives_high(brake.number);
}

// What the board feeds back to the chip. Setting an input calls this again, which then changes nothing.
void BoardMachine::update_inputs() {
  const auto set = [this](Pin pin, bool level) {
    if (chip_.port(pin.port).input(pin.number) != level) {
      chip_.port(pin.port).set_input(pin.number, level);
    }
  };
  set(kStoA, sto_[0].pin);
  for (int axis = 0; axis < sim::kAxes; ++axis) {
    const Bridge& bridge = kBridges[axis];
    Timer& timer = axis == kAzimuth ? chip_.tim1 : chip_.tim8;
    set(bridge.second_break, sto_[1].pin);
    set(bridge.enable_read_back, is_driver_enabled(axis));
    set(bridge.brake_contact, stuck_contact_[static_cast<std::size_t>(axis)].value_or(tracker_.brake_is_open(axis)));
    const bool given = chip_.port(bridge.fault.port).has_function(bridge.fault.number, bridge.function);
    timer.set_break_input(!given || !driver_fault_[static_cast<std::size_t>(axis)]);
    const bool second_given =
        chip_.port(bridge.second_break.port).has_function(bridge.second_break.number, bridge.second_break_function);
    timer.set_second_break_input(!second_given || sto_[1].pin);
  }
}

}  // namespace trackservo::target
