// SPDX-License-Identifier: Apache-2.0
#include "judge/fault_injection/fault_injection.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <stdexcept>

namespace trackservo::sim {
namespace {

constexpr double kVisibleRate_rad_s = 0.015;  // half of the difference of gyro and encoder by then is beyond 0x2060:2
constexpr double kOutwards_rad = 0.002;       // beyond the end, from where it counts
constexpr double kEncoderError_rad = 3e-5;
constexpr double kPush_nm = 300.0;
constexpr double kStrongerThanMotor_nm = 60.0;
constexpr double kContinuous_a = 5.0;  // of a smaller motor, for 0x2060:11
constexpr double kThermal_s = 0.1;     // of its winding, for 0x2060:12
constexpr double kPositionWindow_rad = 0.002;
constexpr double kSpeedWindow_rad_s = 0.01;

BrokenAxis& broken(DrivenNode& node, int axis) { return node.machine().broken().axis[static_cast<std::size_t>(axis)]; }

double joint_rate_rad_s(DrivenNode& node, int axis) {
  return node.machine().truth().joint_rate_rad_s[static_cast<std::size_t>(axis)];
}

double wanted_rate_rad_s(DrivenNode& node, int axis) {
  return static_cast<double>(node.axis(axis).objects.velocity.target) * 1e-6;
}

bool always(DrivenNode&, int) { return true; }

bool turns(DrivenNode& node, int axis) { return std::abs(joint_rate_rad_s(node, axis)) > kVisibleRate_rad_s; }

void nothing(DrivenNode&, int) {}

void let_go(DrivenNode& node, int axis) { broken(node, axis).push_nm = 0.0; }

double true_current_a(DrivenNode& node, int axis) {
  return node.machine().truth().current_a[static_cast<std::size_t>(axis)];
}

// The true current and its reading differ by more than twice the limit of 0x2060:14.
bool current_is_wrong(DrivenNode& node, int axis) {
  const double true_a = node.machine().truth().current_a[static_cast<std::size_t>(axis)];
  const double reported_a = static_cast<double>(node.machine().samples().axis[axis].sensors.mean_current_a);
  const double resistance_ohm = static_cast<double>(node.node().board.app.params.axis[axis].resistance_ohm);
  const double limit_v = static_cast<double>(node.axis(axis).monitor.limits.voltage_mismatch_v);
  return resistance_ohm * std::abs(true_a - reported_a) > 2.0 * limit_v + resistance_ohm * std::abs(reported_a);
}

void end_the_travel(DrivenNode& node, int axis) {
  const float far_rad = 2.0F;  // the turn of the start position stays known
  const float margin_rad = 0.001F;
  protection_limits& limits = node.node().axis[axis].monitor.limits;
  const float here_rad = static_cast<float>(node.axis(axis).drive.position) * ANGLE_RAD_PER_TURN32;
  const bool up = joint_rate_rad_s(node, axis) >= 0.0;
  limits.minimum_rad = up ? here_rad - far_rad : here_rad + margin_rad;
  limits.maximum_rad = up ? here_rad - margin_rad : here_rad + far_rad;
  node.node().axis[axis].limits.changes++;  // on purpose, not by itself
}

FaultInjection health(const char *name, fault_id expected, hal_health reads) {
  return {name,   expected, 0, 0, false, [reads](DrivenNode& n, int a, SplitMix64&) { broken(n, a).health = reads; },
          always, nothing};
}

template <class Begin>
FaultInjection part(const char *name, fault_id expected, fault_set also, int timer_ms, Begin begin,
                    bool (*shows)(DrivenNode&, int) = always) {
  return {name, expected, also, timer_ms, false, begin, shows, nothing};
}

double motor_torque_nm(DrivenNode& node, int axis, double current_a) {
  return static_cast<double>(node.node().board.app.params.axis[axis].torque_constant_nm_a) * current_a;
}

// At 1.26 times the continuous current the winding is too warm after 0.98 times its time constant, if it was cold.
bool overloads(DrivenNode& node, int axis) { return std::abs(true_current_a(node, axis)) > 1.26 * kContinuous_a; }

bool is_off_position(DrivenNode& node, int axis) {
  const drive_position_objects& position = node.axis(axis).objects.position;
  return std::abs(static_cast<double>(position.following_error)) > static_cast<double>(position.following_error_window);
}

bool is_off_speed(DrivenNode& node, int axis) {
  const servo_axis_signals& signals = node.node().board.app.axis[axis].signals;
  const double error_rad_s = static_cast<double>(signals.reference.rate_rad_s - signals.rates.rate_rad_s);
  return std::abs(error_rad_s) > static_cast<double>(node.axis(axis).monitor.limits.speed_error_rad_s);
}

bool is_off(DrivenNode& node, int axis) { return !servo_mode_closes(node.mode(axis)); }

void monitor_position(DrivenNode& node, int axis) {
  node.write(axis, 0x6065, 0, static_cast<std::int64_t>(kPositionWindow_rad * 1e7));
  node.write(axis, 0x6066, 0, 10);
}

void monitor_speed(DrivenNode& node, int axis) {
  node.unlock();
  node.write_real(axis, 0x2060, 6, kSpeedWindow_rad_s);
  node.write_real(axis, 0x2060, 7, 0.05);
}

void fit_small_motor(DrivenNode& node, int axis) {
  node.unlock();
  node.write_real(axis, 0x2060, 11, kContinuous_a);
  node.write_real(axis, 0x2060, 12, kThermal_s);
}

// Set-points of both axes in RPDO 3, as a master sends them.
void send_setpoints(DrivenNode& node, int) {
  can_frame frame{0x401, 0, 8, {}, 0};
  std::uint8_t *place = frame.data;
  for (int axis = 0; axis < kAxes; ++axis) {
    const std::int32_t target = node.axis(axis).objects.velocity.target;
    std::memcpy(place, &target, sizeof target);
    place += sizeof target;
  }
  node.receive(frame);
}

void expect_setpoints(DrivenNode& node, int axis) {
  node.receive(can_frame{0x000, 0, 2, {0x01, 0x00}, 0});
  node.write(axis, 0x1402, 5, 20);
}

bool is_outside(DrivenNode& node, int axis) {
  const protection_limits& limits = node.axis(axis).monitor.limits;
  const double angle_rad = node.machine().truth().joint_angle_rad[static_cast<std::size_t>(axis)];
  const double allowed_rad = kOutwards_rad + kEncoderError_rad;
  return angle_rad > static_cast<double>(limits.maximum_rad) + allowed_rad ||
         angle_rad < static_cast<double>(limits.minimum_rad) - allowed_rad;
}

std::vector<FaultInjection> sensors() {
  const fault_set disagree = fault_bit(FAULT_SENSORS_DISAGREE);
  const fault_set jump = fault_bit(FAULT_ENCODER_JUMP);
  return {
      part("encoder lost", FAULT_ENCODER_LOST, 0, 0,
           [](DrivenNode& n, int a, SplitMix64&) { broken(n, a).encoder_lost = true; }),
      part("encoder jumps", FAULT_ENCODER_JUMP, 0, 0,
           [](DrivenNode& n, int a, SplitMix64& random) {
             const double size_rad = 0.002 * std::pow(250.0, random.uniform());
             broken(n, a).encoder_shift_rad = random.uniform() < 0.5 ? -size_rad : size_rad;
           }),
      part("encoder stuck", FAULT_ENCODER_STUCK, disagree | jump, 100,
           [](DrivenNode& n, int a, SplitMix64&) { broken(n, a).encoder_stuck = true; }),
      part(
          "encoder counts backwards", FAULT_SENSORS_DISAGREE, jump | fault_bit(FAULT_CURRENT_SENSOR), 0,
          [](DrivenNode& n, int a, SplitMix64&) {
            broken(n, a).encoder_reversed = true;
            broken(n, a).encoder_shift_rad = 2.0 * n.machine().truth().joint_angle_rad[static_cast<std::size_t>(a)];
          },
          turns),
      part("gyro lost", FAULT_GYRO_LOST, 0, 0,
           [](DrivenNode& n, int a, SplitMix64&) { broken(n, a).gyro_lost = true; }),
      part("gyro stuck", FAULT_GYRO_STUCK, disagree, 100,
           [](DrivenNode& n, int a, SplitMix64&) { broken(n, a).gyro_stuck = true; }),
      part(
          "gyro of the wrong sign", FAULT_SENSORS_DISAGREE, 0, 0,
          [](DrivenNode& n, int a, SplitMix64&) { broken(n, a).gyro_reversed = true; }, turns),
      part("gyro saturated", FAULT_GYRO_SATURATED, disagree, 0,
           [](DrivenNode& n, int a, SplitMix64&) {
             broken(n, a).gyro_reads_rad_s = static_cast<double>(n.axis(a).monitor.limits.gyro_range_rad_s);
           }),
      part("gyro says no number", FAULT_IMPLAUSIBLE, 0, 0,
           [](DrivenNode& n, int a, SplitMix64&) {
             broken(n, a).gyro_reads_rad_s = std::numeric_limits<double>::quiet_NaN();
           }),
  };
}

// A load that the motor can bear only for a limited time.
FaultInjection overload() {
  FaultInjection load = part(
      "load too heavy", FAULT_OVERLOAD, 0, static_cast<int>(1000.0 * kThermal_s),
      [](DrivenNode& n, int a, SplitMix64&) {
        broken(n, a).push_nm = std::copysign(motor_torque_nm(n, a, 8.0), -wanted_rate_rad_s(n, a));
      },
      overloads);
  load.end = let_go;
  load.prepare = fit_small_motor;
  load.lasting = true;
  return load;
}

std::vector<FaultInjection> electrics() {
  const fault_set motor = fault_bit(FAULT_MOTOR_CONTRADICTS) | fault_bit(FAULT_MOTOR_WEAK);  // less than 4 V
  const fault_set current = fault_bit(FAULT_CURRENT_SENSOR) | fault_bit(FAULT_OVER_CURRENT) | motor;
  const fault_set away = fault_bit(FAULT_RUNAWAY) | fault_bit(FAULT_SENSORS_DISAGREE);
  return {
      part("current sensor offset 8 A", FAULT_CURRENT_SENSOR, current, 0,
           [](DrivenNode& n, int a, SplitMix64& random) {
             broken(n, a).current_shift_a = random.uniform() < 0.5 ? -8.0 : 8.0;
           }),
      part(
          "current sensor stuck", FAULT_CURRENT_SENSOR, current | away, 0,
          [](DrivenNode& n, int a, SplitMix64&) { broken(n, a).current_stuck = true; }, current_is_wrong),
      part("current reads 24 A", FAULT_OVER_CURRENT, current, 0,
           [](DrivenNode& n, int a, SplitMix64&) { broken(n, a).current_reads_a = 24.0; }),
      part(
          "motor lead off", FAULT_CURRENT_SENSOR, current | away, 0,
          [](DrivenNode& n, int a, SplitMix64&) { broken(n, a).motor_open = true; },
          [](DrivenNode& n, int a) { return std::abs(n.node().board.app.axis[a].current_reference_a) > 1.0F; }),
      part(
          "motor leads swapped", FAULT_OVER_CURRENT, current | away, 0,
          [](DrivenNode& n, int a, SplitMix64&) { broken(n, a).motor_reversed = true; },
          [](DrivenNode& n, int a) { return std::abs(n.node().board.app.axis[a].current_reference_a) > 1.0F; }),
      // Too little to be detected under current; the axis coasts.
      part(
          "current offset 1 A, axis off", FAULT_CURRENT_OFFSET, 0, 20,
          [](DrivenNode& n, int a, SplitMix64& random) {
            broken(n, a).current_shift_a = random.uniform() < 0.5 ? -1.0 : 1.0;
            n.write(a, 0x6040, 0, 0x06);
          },
          is_off),
      overload(),
      health("short circuit", FAULT_OVER_CURRENT_TRIP, HAL_OVER_CURRENT),
      health("power stage", FAULT_POWER_STAGE, HAL_POWER_STAGE),
      health("heat sink too hot", FAULT_OVER_TEMPERATURE, HAL_TOO_HOT),
      health("safe torque off", FAULT_SAFE_TORQUE_OFF, HAL_SAFE_TORQUE_OFF),
      health("safe torque off, one channel", FAULT_SAFE_TORQUE_FAULT, HAL_SAFE_TORQUE_FAULT),
      health("clock contradicts the other oscillator", FAULT_CLOCK, HAL_CLOCK_WRONG),
      {"bus voltage low", FAULT_UNDER_VOLTAGE, 0, 0, true,
       [](DrivenNode& n, int, SplitMix64&) { n.machine().broken().bus_reads_v = 30.0; }, always, nothing},
      {"bus voltage high", FAULT_OVER_VOLTAGE, 0, 0, true,
       [](DrivenNode& n, int, SplitMix64&) { n.machine().broken().bus_reads_v = 65.0; }, always, nothing},
  };
}

// At the end of a hard stop the motor's inductance returns its energy to the bus. A capacitor that has dried out cannot
// take it.
FaultInjection dry_capacitor() {
  FaultInjection dry = part(
      "hard stop, bus capacitor dried out", FAULT_OVER_VOLTAGE, 0, 0,
      [](DrivenNode& n, int, SplitMix64&) {
        n.machine().broken().bus_capacitor_share = 0.01;
        for (int axis = 0; axis < kAxes; ++axis) {
          n.write(axis, 0x6040, 0, 0x02);
        }
      },
      [](DrivenNode& n, int a) {
        const axis_monitor& monitor = n.axis(a).monitor;  // a shorter pulse than two ticks is no fault
        return n.machine().truth().bus_voltage_v > static_cast<double>(monitor.limits.over_voltage_v) &&
               monitor.state.over_voltage_ticks > 0;
      });
  dry.both_axes = true;
  dry.needs_restart = true;  // a capacitor is replaced with the power off
  dry.prepare = [](DrivenNode& n, int) {
    for (int axis = 0; axis < kAxes; ++axis) {
      n.write(axis, 0x6085, 0, 5000000);
      n.write(axis, 0x60A4, 1, 4000000000);
    }
  };
  dry.hidden_because = "the bus is above its limit for less than two ticks";
  dry.detection = Detection::kAlways;
  return dry;
}

// A user has written a torque limit (6072) below the friction.
FaultInjection weak_torque_limit() {
  FaultInjection weak = part(
      "torque limit below friction", FAULT_SPEED_ERROR, 0, 50,
      [](DrivenNode& n, int a, SplitMix64&) { n.write(a, 0x6072, 0, 50); }, is_off_speed);
  weak.prepare = monitor_speed;
  weak.lasting = true;
  weak.weak = true;
  return weak;
}

FaultInjection jam() {
  FaultInjection jammed = part(
      "axis jams in position control", FAULT_FOLLOWING_ERROR, fault_bit(FAULT_RUNAWAY), 10,
      [](DrivenNode& n, int a, SplitMix64&) { broken(n, a).joint_held = true; }, is_off_position);
  jammed.mode = DRIVE_CYCLIC_POSITION;
  jammed.prepare = monitor_position;
  jammed.lasting = true;
  return jammed;
}

// While it turns, the travel ends a milliradian behind it.
FaultInjection end_of_travel() {
  FaultInjection end = part(
      "end of the travel", FAULT_BEYOND_TRAVEL, fault_bit(FAULT_TOO_FAST), 0,
      [](DrivenNode& n, int a, SplitMix64&) { end_the_travel(n, a); }, is_outside);
  end.hidden_because = "no set-point leads beyond the travel limit, and the axis follows none further out";
  return end;
}

// Its speed limit (2060:1) falls below its speed, so that it is braked protectively.
void lower_speed_limit(DrivenNode& node, int axis) {
  servo_node_axis& limited = node.node().axis[axis];
  limited.monitor.limits.overspeed_rad_s = static_cast<float>(0.5 * std::abs(joint_rate_rad_s(node, axis)));
  limited.limits.changes++;  // on purpose, not by itself
}

bool brakes_protectively(DrivenNode& node, int axis) { return node.mode(axis) == SERVO_PROTECTIVE_STOP; }

// The braking has its full current only above this speed, and is judged there.
bool must_slow_down(DrivenNode& node, int axis) {
  const double judged_rad_s = static_cast<double>(node.axis(axis).monitor.allowed.soft_rad_s);
  return brakes_protectively(node, axis) && std::abs(joint_rate_rad_s(node, axis)) > judged_rad_s;
}

// From the first tick of the protective stop on.
FaultInjection braking_fails(const char *name, int allowed_ms, const std::function<void(DrivenNode&, int)>& cause) {
  FaultInjection fails = part(
      name, FAULT_BRAKING_FAILS, 0, 0, [](DrivenNode& n, int a, SplitMix64&) { lower_speed_limit(n, a); },
      must_slow_down);
  fails.during = FAULT_OVER_SPEED;
  fails.go_on = [cause](DrivenNode& n, int a) {
    if (brakes_protectively(n, a)) {
      cause(n, a);
    }
  };
  fails.end = let_go;
  fails.stays = true;
  fails.allowed_ms = allowed_ms;
  fails.hidden_because = "the axis is at rest, or slower than 0.02 s times 2060:19, where its braking is not judged";
  return fails;
}

// A load that is stronger than the motor.
FaultInjection pulled_while_braking() {
  return braking_fails("pulled on while it brakes", 0, [](DrivenNode& n, int a) {
    const double motor_nm =
        motor_torque_nm(n, a, static_cast<double>(n.node().board.app.params.axis[a].current_limit_a));
    broken(n, a).push_nm = std::copysign(1.5 * motor_nm, joint_rate_rad_s(n, a));
  });
}

// Friction alone still slows the axis down, by less than half of 2060:19: it takes longer to fall behind, or the axis
// has stopped before.
FaultInjection braking_without_torque() {
  FaultInjection weak =
      braking_fails("no torque while it brakes", 130, [](DrivenNode& n, int a) { broken(n, a).motor_share = 0.0; });
  weak.lasting = true;
  return weak;
}

std::vector<FaultInjection> motions() {
  const fault_set away = fault_bit(FAULT_RUNAWAY) | fault_bit(FAULT_SPEED_ERROR) | fault_bit(FAULT_OVER_SPEED) |
                         fault_bit(FAULT_STANDSTILL_LEFT);
  return {
      {"pushed beyond the speed limit", FAULT_OVER_SPEED, away, 0, false,
       [](DrivenNode& n, int a, SplitMix64&) {
         broken(n, a).push_nm = std::copysign(kPush_nm, joint_rate_rad_s(n, a));
       },
       [](DrivenNode& n, int a) {
         return std::abs(joint_rate_rad_s(n, a)) > static_cast<double>(n.axis(a).monitor.limits.overspeed_rad_s);
       },
       let_go},
      {"driven against the motor", FAULT_RUNAWAY, away, 0, false,
       [](DrivenNode& n, int a, SplitMix64&) {
         broken(n, a).push_nm = std::copysign(kStrongerThanMotor_nm, -wanted_rate_rad_s(n, a));
       },
       [](DrivenNode& n, int a) { return std::abs(wanted_rate_rad_s(n, a) - joint_rate_rad_s(n, a)) > 0.05; }, let_go},
      // Where the set-point reverses, the torque is not at its limit for a while, and the timer waits.
      part(
          "axis blocked", FAULT_STALL, fault_bit(FAULT_RUNAWAY), 600,
          [](DrivenNode& n, int a, SplitMix64&) { broken(n, a).joint_held = true; },
          [](DrivenNode& n, int a) { return n.node().board.app.axis[a].signals.torque.limited; }),
      weak_torque_limit(),
      jam(),
      dry_capacitor(),
      end_of_travel(),
      pulled_while_braking(),
      braking_without_torque(),
  };
}

FaultInjection silent_setpoints() {
  FaultInjection silent =
      part("set-points no longer sent", FAULT_RPDO_LATE, 0, 20, [](DrivenNode&, int, SplitMix64&) {});
  silent.both_axes = true;
  silent.prepare = expect_setpoints;
  silent.keep_up = send_setpoints;
  return silent;
}

std::vector<FaultInjection> node_and_bus() {
  return {
      {"bus off", FAULT_BUS_OFF, 0, 0, true, [](DrivenNode& n, int, SplitMix64&) { servo_node_bus_off(&n.node()); },
       always, nothing},
      {"node stopped by NMT", FAULT_NODE_STOPPED, 0, 0, true,
       [](DrivenNode& n, int, SplitMix64&) {
         n.receive(can_frame{0x000, 0, 2, {0x02, 0x00}, 0});
       },
       always, nothing},
      {"master's heartbeat lost", FAULT_HEARTBEAT_LOST, 0, 50, true,
       [](DrivenNode& n, int a, SplitMix64&) {
         n.write(a, 0x1016, 1, 0x7F << 16 | 50);
         n.receive(can_frame{0x77F, 0, 1, {0x05}, 0});
       },
       always, nothing},
      silent_setpoints(),
      {"master falls silent", FAULT_MASTER_SILENT, 0, 0, true,
       [](DrivenNode& n, int, SplitMix64&) {
         for (int each = 0; each < kAxes; ++each) {
           n.write(each, 0x6007, 0, DRIVE_SILENT_FAULT);
         }
         n.fall_silent();
       },
       [](DrivenNode& n, int) {
         const servo_node_axis& azimuth = n.axis(kAzimuth);
         const servo_node_axis& pitch = n.axis(kPitch);
         const bool both =
             drive_axis_turns(&azimuth.drive, &azimuth.inputs) && drive_axis_turns(&pitch.drive, &pitch.inputs);
         return both && canopen_node_silent_ms(&n.node().canopen) + 1 >= n.node().master.longest_silence_ms;
       },
       nothing},
      health("tick late", FAULT_TICK_LATE, HAL_TIMING_LOST),
      health("program memory damaged", FAULT_IMAGE_DAMAGED, HAL_IMAGE_DAMAGED),
      health("self-test fails in operation", FAULT_SELF_TEST, HAL_NOT_READY),
  };
}

constexpr double kJustBelowBaseRate_rad_s = 0.019;
constexpr int kSlowSensorReadings = 5;
constexpr double kSeldom = 0.1;
constexpr double kUnnoticed_rad = 0.002;  // the axis may leave its set-point so far when nothing is detected

// What both rate sensors, or the motor, do wrong together. `also`: the names that are right for it.
FaultInjection witness(const char *name, fault_id expected, fault_set also, int allowed_ms, Detection detection,
                       std::function<void(DrivenNode&, int, SplitMix64&)> begin,
                       std::function<bool(DrivenNode&, int)> shows = always) {
  FaultInjection made{name, expected, also, 0, false, std::move(begin), std::move(shows), nothing};
  made.allowed_ms = allowed_ms;
  made.detection = detection;
  made.stays = true;
  return made;
}

// A change of the parts of the axis.
template <class Change>
std::function<void(DrivenNode&, int, SplitMix64&)> parts(Change change) {
  return [change](DrivenNode& n, int a, SplitMix64&) { change(broken(n, a)); };
}

// A converter that reads a current of the axis.
FaultInjection of_current(const char *name, fault_set also, int allowed_ms, Detection detection,
                          void (*change)(BadReadings&)) {
  FaultInjection made = witness(name, FAULT_MOTOR_CONTRADICTS, also, allowed_ms, detection,
                                parts([change](BrokenAxis& b) { change(b.current); }));
  made.max_deviation_rad = kUnnoticed_rad;
  return made;
}

// The converter that reads the bus voltage.
FaultInjection of_bus(const char *name, fault_set also, int allowed_ms, void (*change)(BadReadings&)) {
  FaultInjection made = witness(name, FAULT_OVER_VOLTAGE, also, allowed_ms, Detection::kTolerated,
                                [change](DrivenNode& n, int, SplitMix64&) { change(n.machine().broken().bus); });
  made.both_axes = true;
  return made;
}

FaultInjection clock_off(const char *name, fault_set also, double share) {
  FaultInjection made = witness(name, FAULT_CLOCK, also, 400, Detection::kAlways,
                                [share](DrivenNode& n, int, SplitMix64&) { n.machine().broken().clock_error = share; });
  made.both_axes = true;
  made.max_deviation_rad = 0.008;  // 5 % of 20 deg/s in 0.4 s
  return made;
}

FaultInjection bit_wrong(const char *name, std::function<void(DrivenNode&, int, SplitMix64&)> begin) {
  FaultInjection made = witness(name, FAULT_ACTIVE_SET, 0, 0, Detection::kAlways, std::move(begin));
  made.any_fault = true;
  return made;
}

bool carries_torque(DrivenNode& node, int axis) {
  return std::abs(node.node().board.app.axis[axis].current_reference_a) > 1.0F;
}

// Sensors that miss this share of the motion: their error is larger than what the motor as a witness may leave unseen.
bool motor_must_see(DrivenNode& node, int axis, double missed_share) {
  const axis_monitor& monitor = node.axis(axis).monitor;
  const motor_witness_limits limits = {monitor.limits.motor_tolerance, monitor.limits.back_emf_error_v,
                                       monitor.limits.current_offset_a, monitor.limits.voltage_mismatch_v};
  const double unseen_rad_s = static_cast<double>(motor_witness_bound_rad_s(&monitor.state.witness, &limits));
  return missed_share * std::abs(joint_rate_rad_s(node, axis)) > 1.2 * unseen_rad_s;
}

bool motor_must_see_half(DrivenNode& node, int axis) { return motor_must_see(node, axis, 0.5); }

bool motor_must_see_all(DrivenNode& node, int axis) { return motor_must_see(node, axis, 1.0); }

void flip_bit(void *bytes, std::size_t count, SplitMix64& random) {
  const std::uint64_t bit = random() % (8 * count);
  static_cast<std::uint8_t *>(bytes)[bit / 8] ^= static_cast<std::uint8_t>(1U << (bit % 8));
}

// Any bit of the real numbers that the loops use. A wrong bit of a count, such as the window of the rate estimator, can
// make a tick so long that only the watchdog ends it; that is a test of the board.
void flip_bit_in_use(servo_axis_params& params, SplitMix64& random) {
  speed_loop_params& speed = params.speed;
  const std::array<float *, 18> gains = {&speed.pi.proportional_gain,
                                         &speed.pi.integral_gain,
                                         &speed.pi.setpoint_weight,
                                         &speed.pi.tracking_rate_per_s,
                                         &speed.acceleration_inertia_kg_m2,
                                         &speed.observer.inertia_kg_m2,
                                         &speed.observer.viscous_nm_s_rad,
                                         &speed.observer.bandwidth_rad_s,
                                         &speed.observer.limit_nm,
                                         &speed.friction.gain,
                                         &speed.friction.lugre.stiffness_nm_rad,
                                         &speed.friction.lugre.damping_nm_s_rad,
                                         &speed.friction.lugre.positive.coulomb_nm,
                                         &speed.friction.lugre.positive.breakaway_nm,
                                         &speed.rate_fusion.crossover_rad_s,
                                         &params.torque_constant_nm_a,
                                         &params.resistance_ohm,
                                         &params.current_limit_a};
  flip_bit(gains[random() % gains.size()], sizeof(float), random);
}

// Common causes, and sensors that are slow, stale, intermittent or wrong now and then.
std::vector<FaultInjection> witnesses() {
  const fault_set disagree = fault_bit(FAULT_SENSORS_DISAGREE);
  const fault_set encoder_faults =
      disagree | fault_bit(FAULT_ENCODER_JUMP) | fault_bit(FAULT_ENCODER_LOST) | fault_bit(FAULT_ENCODER_ERRATIC);
  const fault_set gyro_faults = disagree | fault_bit(FAULT_GYRO_LOST) | fault_bit(FAULT_GYRO_SATURATED);
  const fault_set motor = fault_bit(FAULT_MOTOR_CONTRADICTS) | fault_bit(FAULT_MOTOR_WEAK);
  const fault_set electrical = motor | fault_bit(FAULT_CURRENT_SENSOR) | fault_bit(FAULT_OVER_CURRENT);
  const fault_set of_voltage = electrical | fault_bit(FAULT_UNDER_VOLTAGE);
  const fault_set drift = fault_bit(FAULT_SENSORS_DRIFT);
  std::vector<FaultInjection> list = {
      witness("encoder and gyro frozen with noise", FAULT_MOTOR_CONTRADICTS,
              motor | fault_bit(FAULT_RUNAWAY) | fault_bit(FAULT_NO_ANSWER), 100, Detection::kAlways,
              parts([](BrokenAxis& b) { b.sensors_show_share = 0.0; }), motor_must_see_all),
      witness("encoder and gyro at half scale", FAULT_MOTOR_CONTRADICTS, motor | fault_bit(FAULT_RUNAWAY), 500,
              Detection::kAlways, parts([](BrokenAxis& b) { b.sensors_show_share = 0.5; }), motor_must_see_half),
      witness("gyro bias 0.019 rad/s", FAULT_SENSORS_DRIFT, motor, 500, Detection::kAlways,
              parts([](BrokenAxis& b) { b.gyro_shift_rad_s = kJustBelowBaseRate_rad_s; })),
      witness("encoder creeps 0.019 rad/s", FAULT_SENSORS_DRIFT, motor, 500, Detection::kAlways,
              parts([](BrokenAxis& b) { b.encoder_creep_rad_s = kJustBelowBaseRate_rad_s; })),
      // With half of its torque an axis may also follow a reversal too late in wind (speed error).
      witness("magnets half as strong", FAULT_MOTOR_WEAK, motor | fault_bit(FAULT_SPEED_ERROR), 25000,
              Detection::kAlways, parts([](BrokenAxis& b) { b.motor_share = 0.5; }), carries_torque),
      // In a reversal the axis is slow for a while, and a reading that is one tick old differs little: 128 ms measured.
      witness("encoder one tick old in 10 % of the ticks", FAULT_ENCODER_ERRATIC, encoder_faults, 150,
              Detection::kAlways, parts([](BrokenAxis& b) { b.encoder_stale_share = kSeldom; }), turns),
      witness("encoder bit 10 wrong in 10 % of the ticks", FAULT_ENCODER_ERRATIC, encoder_faults, 150,
              Detection::kAlways, parts([](BrokenAxis& b) { b.encoder_bit_share = kSeldom; })),
      witness("encoder 5 ms late", FAULT_SENSORS_DISAGREE, encoder_faults, 500, Detection::kAlways,
              parts([](BrokenAxis& b) { b.encoder.late_readings = kSlowSensorReadings; }), turns),
      witness("gyro 5 ms late", FAULT_SENSORS_DISAGREE, gyro_faults, 500, Detection::kTolerated,
              parts([](BrokenAxis& b) { b.gyro.late_readings = kSlowSensorReadings; }), turns),
      witness("encoder renewed every 5 ms", FAULT_ENCODER_JUMP, encoder_faults | fault_bit(FAULT_ENCODER_STUCK), 500,
              Detection::kAlways, parts([](BrokenAxis& b) { b.encoder.repeats = kSlowSensorReadings; }), turns),
      witness("gyro renewed every 5 ms", FAULT_GYRO_STUCK, gyro_faults, 500, Detection::kTolerated,
              parts([](BrokenAxis& b) { b.gyro.repeats = kSlowSensorReadings; }), turns),
      witness("encoder lost in 10 % of the ticks", FAULT_ENCODER_LOST, encoder_faults, 100, Detection::kAlways,
              parts([](BrokenAxis& b) { b.encoder.lost_share = kSeldom; })),
      witness("gyro lost in 10 % of the ticks", FAULT_GYRO_LOST, gyro_faults, 500, Detection::kTolerated,
              parts([](BrokenAxis& b) { b.gyro.lost_share = kSeldom; })),
      witness("encoder garbage in 10 % of the ticks", FAULT_ENCODER_JUMP, encoder_faults, 100, Detection::kAlways,
              parts([](BrokenAxis& b) { b.encoder.garbage_share = kSeldom; })),
      witness("gyro garbage in 10 % of the ticks", FAULT_SENSORS_DISAGREE, gyro_faults, 200, Detection::kAlways,
              parts([](BrokenAxis& b) { b.gyro.garbage_share = kSeldom; })),
      // The loop of the current swings; what its voltage leaves unexplained shows it.
      of_current("current 5 periods late", electrical, 100, Detection::kAlways,
                 [](BadReadings& b) { b.late_readings = kSlowSensorReadings; }),
      of_current("current renewed every 5 periods", electrical, 100, Detection::kTolerated,
                 [](BadReadings& b) { b.repeats = kSlowSensorReadings; }),
      of_current("current lost in 10 % of the periods", electrical, 100, Detection::kTolerated,
                 [](BadReadings& b) { b.lost_share = kSeldom; }),
      of_current("current garbage in 10 % of the periods", electrical, 150, Detection::kAlways,
                 [](BadReadings& b) { b.garbage_share = kSeldom; }),
      of_bus("bus voltage 5 periods late", electrical, 500,
             [](BadReadings& b) { b.late_readings = kSlowSensorReadings; }),
      of_bus("bus voltage renewed every 5 periods", electrical, 500,
             [](BadReadings& b) { b.repeats = kSlowSensorReadings; }),
      of_bus("bus voltage lost in 10 % of the periods", electrical, 500,
             [](BadReadings& b) { b.lost_share = kSeldom; }),
      // Each axis finds by itself that its bridge does not give the voltage that was commanded; at rest, with little
      // current, that takes longer.
      of_bus("bus voltage garbage in 10 % of the periods", of_voltage, 3000,
             [](BadReadings& b) { b.garbage_share = kSeldom; }),
      // The gyro has its own clock: at 20 deg/s it differs from the encoder by 5 %, 0.0175 rad/s, which the monitor of
      // their drift (2060:27) may find before the third check of the clock. The other axis stops with that check.
      // One PWM period of the plant more or less in each tick. Other shares would make single ticks longer, which
      // shakes.
      clock_off("clock 5 % slow", drift, 0.05),
      clock_off("clock 5 % fast", drift, -0.05),
      bit_wrong(
          "bit wrong in the gains that the loops use",
          [](DrivenNode& n, int a, SplitMix64& random) { flip_bit_in_use(n.node().board.app.params.axis[a], random); }),
      bit_wrong("bit wrong in the active parameter set",
                [](DrivenNode& n, int a, SplitMix64& random) {
                  flip_bit(&n.node().axis[a].tuning.active, sizeof(axis_parameters), random);
                }),
  };
  // The full torque of an axis that sees no speed, until its back-EMF is beyond the error of the motor as a witness.
  list.front().max_overshoot_rad_s = 0.6;
  list.front().max_deviation_rad = 0.05;
  for (FaultInjection& one : list) {
    one.hidden_because = "it shows only while the axis turns or carries torque";
    if (one.detection == Detection::kTolerated) {
      one.max_deviation_rad = kUnnoticed_rad;
    }
    if (one.name == "encoder and gyro at half scale") {
      one.max_overshoot_rad_s = 0.5;  // twice the set-point
      one.lasting = true;
      one.needs_restart = true;
    }
    if (one.name == "magnets half as strong") {
      one.excitation_rad_s = 0.7;
      one.needs_restart = true;
      one.monitored_ticks = 25000;
    }
  }
  return list;
}

std::vector<FaultInjection> all_injections() {
  std::vector<FaultInjection> together;
  for (const std::vector<FaultInjection>& some : {sensors(), electrics(), motions(), node_and_bus(), witnesses()}) {
    together.insert(together.end(), some.begin(), some.end());
  }
  for (FaultInjection& one : together) {
    const bool latched = one.expected == FAULT_TICK_LATE || one.expected == FAULT_IMAGE_DAMAGED ||
                         one.expected == FAULT_SELF_TEST || one.expected == FAULT_ACTIVE_SET;
    one.needs_restart = one.needs_restart || latched;
  }
  return together;
}

}  // namespace

const std::vector<FaultInjection>& fault_injections() {
  static const std::vector<FaultInjection> list = all_injections();
  return list;
}

const std::vector<const FaultInjection *>& later_fault_injections() {
  static const std::vector<const FaultInjection *> list = {
      &fault_injection("encoder lost"),        &fault_injection("encoder jumps"),
      &fault_injection("gyro lost"),           &fault_injection("gyro saturated"),
      &fault_injection("gyro says no number"), &fault_injection("short circuit"),
      &fault_injection("power stage"),         &fault_injection("heat sink too hot"),
      &fault_injection("bus voltage low"),     &fault_injection("bus voltage high"),
      &fault_injection("node stopped by NMT")};
  return list;
}

const FaultInjection& fault_injection(const std::string& name) {
  std::string names;
  for (const FaultInjection& one : fault_injections()) {
    if (one.name == name) {
      return one;
    }
    names += (names.empty() ? "" : ", ") + one.name;
  }
  throw std::invalid_argument(fmt::format("Unknown fault injection \"{}\"; choose one of: {}", name, names));
}

int allowed_latency_ms(const FaultInjection& fault_injection) {
  if (fault_injection.allowed_ms > 0) {
    return fault_injection.allowed_ms;
  }
  int allowed = fault_table[fault_injection.expected].latency_ms;
  for (int fault = 1; fault < FAULT_COUNT; ++fault) {
    if ((fault_injection.also >> fault & 1U) != 0) {
      allowed = std::max(allowed, static_cast<int>(fault_table[fault].latency_ms));
    }
  }
  return allowed + fault_injection.timer_ms;
}

}  // namespace trackservo::sim
