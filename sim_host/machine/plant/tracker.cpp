// SPDX-License-Identifier: Apache-2.0
#include "machine/plant/tracker.hpp"

#include <cmath>

#include "machine/plant/base_spectrum.hpp"
#include "machine/sensors/rounding.hpp"

namespace trackservo::sim {

namespace {

constexpr double kPwmShare = 1.0 / kPwmPerTick;  // of a tick

// How far a joint turns before the functions of its angle are evaluated again. Until then they are linear in the angle:
// the error of the finest one, cogging of 24 per turn, is 3e-6 of its amplitude.
constexpr double kShapeReach_rad = 1e-4;

// Duty that the bridge can realise: whole timer counts within -1..1.
double realised_duty(double duty, double counts, double count) {
  if (!(duty >= -1.0)) {
    return std::isnan(duty) ? 0.0 : -1.0;
  }
  return nearest_whole((duty > 1.0 ? 1.0 : duty) * counts) * count;
}

std::array<MotorConfig, kAxes> motors_of(const PlantConfig& plant) {
  return {plant.axis[kAzimuth].motor, plant.axis[kPitch].motor};
}

double step_s_of(const PlantConfig& plant) { return plant.mechanics.pwm_periods_per_step * kPwmPeriod_s; }

std::optional<Structure> structure_of(const PlantConfig& plant, int axis) {
  const std::optional<StructureConfig>& config = plant.axis[static_cast<std::size_t>(axis)].structure;
  return config ? std::optional<Structure>(Structure(*config, axis_inertia_kg_m2(plant, axis, 0.0), step_s_of(plant)))
                : std::nullopt;
}

}  // namespace

Tracker::Axis::Axis(const AxisConfig& config, const PlantConfig& plant, std::uint64_t seed, int index)
    : load(config.load, seed, index),
      structure(structure_of(plant, index)),
      base(config.base_sway, seed, index),
      sensors(config, kPwmPeriod_s, kTick_s, seed, index),
      adc(plant.adc, seed, index) {}

Tracker::Tracker(const PlantConfig& plant, std::uint64_t seed)
    : periods_(plant.mechanics.pwm_periods_per_step),
      step_s_(step_s_of(plant)),
      per_step_s_(1.0 / step_s_),
      step_share_(periods_ * kPwmShare),
      axis_{Axis(plant.axis[kAzimuth], plant, seed, kAzimuth), Axis(plant.axis[kPitch], plant, seed, kPitch)},
      motors_(motors_of(plant), kPwmPeriod_s),
      joints_(plant.axis, plant.friction_model, plant.maxwell_slip, step_s_),
      brake_config_{plant.axis[kAzimuth].holding_brake, plant.axis[kPitch].holding_brake},
      base_motion_(base_motion_lines(plant)),
      gyro_mounting_{plant.axis[kAzimuth].gyro.mounting, plant.axis[kPitch].gyro.mounting},
      gravity_(plant),
      drift_(plant.maxwell_slip),
      drifts_(plant.friction_model == FrictionModel::kMaxwellSlip),
      inertia_base_kg_m2_(plant.axis[kAzimuth].inertia_kg_m2),
      inertia_swing_kg_m2_(plant.axis[kAzimuth].inertia_swing_kg_m2),
      pitch_inertia_kg_m2_(plant.axis[kPitch].inertia_kg_m2),
      bus_(plant.supply, kPwmPeriod_s),
      pwm_counts_(plant.supply.pwm_counts),
      pwm_count_(1.0 / pwm_counts_) {
  place({0.0, 0.0});
}

void Tracker::place(const std::array<double, kAxes>& joint_angle_rad) {
  for (std::size_t i = 0; i < kAxes; ++i) {
    Axis& axis = axis_[i];
    joints_.place(joint_angle_rad[i], i);
    axis.sensors.encoder.place(joint_angle_rad[i]);
    sensed_[i] = {joint_angle_rad[i], 0.0};
    base_rate_rad_s_[i] = base_rate_rad_s(i, base_state(0.0), joint_angle_rad[kAzimuth], 0.0);
  }
  shapes_known_ = false;
  bus_.settle(0.0);
}

void Tracker::fit_holding_brakes() {
  for (std::size_t i = 0; i < kAxes; ++i) {
    if (brake_config_[i]) {
      axis_[i].brake.emplace(*brake_config_[i], step_s_);
    }
  }
}

void Tracker::power_brake(int axis, bool on) {
  if (std::optional<HoldingBrake>& brake = axis_[static_cast<std::size_t>(axis)].brake) {
    brake->power(on);
  }
}

bool Tracker::brake_is_open(int axis) const {
  const std::optional<HoldingBrake>& brake = axis_[static_cast<std::size_t>(axis)].brake;
  return !brake || brake->is_open();
}

TruthState Tracker::truth() const {
  TruthState truth;
  truth.time_s = static_cast<double>(steps_) * kPwmPeriod_s;
  truth.bus_voltage_v = bus_.voltage_v();
  const BaseState base = base_motion_.at(truth.time_s);
  truth.base = base.attitude;
  truth.base_turns_rad_s = base.rate_rad_s;
  for (std::size_t i = 0; i < kAxes; ++i) {
    const Axis& axis = axis_[i];
    truth.joint_angle_rad[i] = joints_.angle_rad()[i];
    truth.joint_rate_rad_s[i] = joints_.rate_rad_s()[i];
    truth.base_rate_rad_s[i] = base_rate_rad_s_[i];
    truth.inertial_angle_rad[i] = optics_angle_rad(i) + axis.base.angle_rad(tick_fraction_);
    truth.inertial_rate_rad_s[i] = optics_rate_rad_s(i) + base_rate_rad_s_[i];
    truth.motor_torque_nm[i] = motor_nm_[i];
    truth.friction_torque_nm[i] = joints_.friction_torque_nm()[i];
    truth.load_torque_nm[i] = load_nm_[i];
    truth.end_stop_torque_nm[i] = joints_.stop_torque_nm()[i];
    truth.current_a[i] = motors_.current_a()[i];
  }
  const double pitch_rad = truth.joint_angle_rad[kPitch];
  const StageRates stage = stage_rates(base.rate_rad_s, truth.joint_angle_rad[kAzimuth]);
  truth.line_of_sight_rad_s = {
      std::cos(pitch_rad) * truth.inertial_rate_rad_s[kAzimuth] - std::sin(pitch_rad) * stage.x_rad_s,
      truth.inertial_rate_rad_s[kPitch]};
  return truth;
}

// A bridge with open terminals returns its motor's current through its diodes, which a stiff supply does not notice.
double Tracker::drawn_a() const {
  const auto of = [this](std::size_t i) {
    const double current_a = motors_.current_a()[i];
    return motors_.is_open(i) && bus_.has_capacitor() ? -std::abs(current_a) : duty_[i] * current_a;
  };
  return of(kAzimuth) + of(kPitch);
}

TickSamples Tracker::sample_tick() {
  TickSamples samples;
  for (std::size_t i = 0; i < kAxes; ++i) {
    samples.axis[i] = axis_[i].sensors.sample();
  }
  samples.bus_voltage_v = axis_[kAzimuth].adc.voltage_v(bus_.voltage_v());
  return samples;
}

PwmSample Tracker::sample_pwm(int axis) {
  const auto i = static_cast<std::size_t>(axis);
  if (bus_sampled_at_ != steps_) {
    bus_sampled_at_ = steps_;
    bus_sample_v_ = axis_[kAzimuth].adc.voltage_v(bus_.voltage_v());
  }
  return {axis_[i].adc.current_a(motors_.current_a()[i]), bus_sample_v_};
}

// At a fraction 0..1 of the present tick.
BaseState Tracker::base_state(double u) const {
  return base_motion_.moves() ? base_motion_.at((static_cast<double>(steps_ - step_in_tick_) * kPwmShare + u) * kTick_s)
                              : BaseState{};
}

// About the axis of a joint.
double Tracker::base_rate_rad_s(std::size_t axis, const BaseState& base, double azimuth_rad, double u) const {
  const double sway_rad_s = axis_[axis].base.rate_rad_s(u);
  if (!base_motion_.moves()) {
    return sway_rad_s;
  }
  const StageRates stage = stage_rates(base.rate_rad_s, azimuth_rad);
  return sway_rad_s + (axis == kAzimuth ? stage.z_rad_s : -stage.y_rad_s);
}

void Tracker::begin_tick() {
  if (base_motion_.moves()) {
    gravity_.turn_base(base_state(0.0).attitude);
    shapes_known_ = false;
  }
  if (!shapes_known_ || has_left_the_shapes()) {
    renew_shapes();
  }
  for (std::size_t i = 0; i < kAxes; ++i) {
    Axis& axis = axis_[i];
    const LoadOfTick<double> load = axis.load.begin_tick();
    set_lane(load_.wind_nm, i, load.wind_nm);
    set_lane(load_.wind_change_nm, i, load.wind_change_nm);
    set_lane(load_.cable_nm, i, load.cable_nm);
    set_lane(load_.cable_stiffness_nm_rad, i, load.cable_stiffness_nm_rad);
    axis.base.begin_tick();
    set_lane(sway_.start_rad_s, i, axis.base.rate().start_rad_s);
    set_lane(sway_.linear_rad_s, i, axis.base.rate().linear_rad_s);
    set_lane(sway_.square_rad_s, i, axis.base.rate().square_rad_s);
    const FrictionDrift::Factors drift =
        drifts_ ? drift_.at(static_cast<double>(steps_) * kPwmPeriod_s, load_nm_[i]) : FrictionDrift::Factors{};
    joints_.set_friction_factors(eccentricity_factor_[i] * drift.level, drift.viscosity, i);
  }
}

bool Tracker::has_left_the_shapes() const {
  const auto travel_rad = [this](std::size_t i) { return std::abs(joints_.angle_rad()[i] - shape_angle_rad_[i]); };
  return travel_rad(kAzimuth) > kShapeReach_rad || travel_rad(kPitch) > kShapeReach_rad;
}

void Tracker::renew_shapes() {
  for (std::size_t i = 0; i < kAxes; ++i) {
    shape_angle_rad_[i] = joints_.angle_rad()[i];
    eccentricity_factor_[i] = joints_.eccentricity_factor(i);
    motors_.renew_shape(shape_angle_rad_[i], i);
  }
  shapes_known_ = true;
  const Gravity::Torque gravity = gravity_.torque({shape_angle_rad_[kAzimuth], shape_angle_rad_[kPitch]});
  for (std::size_t i = 0; i < kAxes; ++i) {
    const auto row = static_cast<Eigen::Index>(i);
    gravity_nm_[i] = gravity.load_nm[row];
    gravity_by_azimuth_nm_rad_[i] = gravity.slope_nm_rad(row, kAzimuth);
    gravity_by_pitch_nm_rad_[i] = gravity.slope_nm_rad(row, kPitch);
  }
  azimuth_inertia_kg_m2_ = inertia_base_kg_m2_;
  if (inertia_swing_kg_m2_ > 0.0) {
    const double cosine = std::cos(2.0 * shape_angle_rad_[kPitch]);
    const double sine = std::sin(2.0 * shape_angle_rad_[kPitch]);
    azimuth_inertia_kg_m2_ += 0.5 * inertia_swing_kg_m2_ * (1.0 + cosine);
    inertia_slope_kg_m2_rad_ = -inertia_swing_kg_m2_ * sine;
    inertia_curve_kg_m2_rad2_ = -2.0 * inertia_swing_kg_m2_ * cosine;
  }
}

double Tracker::azimuth_inertia_kg_m2(double pitch_travel_rad) const {
  return azimuth_inertia_kg_m2_ +
         pitch_travel_rad * (inertia_slope_kg_m2_rad_ + 0.5 * pitch_travel_rad * inertia_curve_kg_m2_rad2_);
}

Pair Tracker::gravity_nm(Pair travel_rad) const {
  return gravity_nm_ + gravity_by_azimuth_nm_rad_ * travel_rad[kAzimuth] +
         gravity_by_pitch_nm_rad_ * travel_rad[kPitch];
}

// Angles and rates in the middle of the step, extrapolated from the last one: second order, explicit, and used only for
// slow quantities (coupling, gravity, cable, back-EMF).
void Tracker::predict_step() {
  Step& step = step_;
  const double start = step_in_tick_ * kPwmShare;
  step.middle = start + 0.5 * step_share_;
  step.end = start + step_share_;
  step.rate_rad_s = joints_.predicted_rate_rad_s();
  step.travel_rad = joints_.angle_rad() + 0.5 * step_s_ * joints_.rate_rad_s() - shape_angle_rad_;
  const double azimuth_rate = step.rate_rad_s[kAzimuth] + axis_[kAzimuth].base.rate_rad_s(step.middle);
  const double inertia_slope = inertia_slope_kg_m2_rad_ + step.travel_rad[kPitch] * inertia_curve_kg_m2_rad2_;
  step.inertia_kg_m2 = Pair{azimuth_inertia_kg_m2(step.travel_rad[kPitch]), pitch_inertia_kg_m2_};
  step.drag_nm_s_rad = Pair{inertia_slope * step.rate_rad_s[kPitch], 0.0};
  step.coupling_nm = Pair{0.0, -0.5 * inertia_slope * azimuth_rate * azimuth_rate};
  step.base_end_rad_s = sway_.at(step.end);
  if (base_motion_.moves()) {
    add_base_motion(step);
  }
}

// The inertial rates that the base gives the stage, and their torques, from the Lagrangian in tracker.hpp.
void Tracker::add_base_motion(Step& step) const {
  const double azimuth_rad = shape_angle_rad_[kAzimuth] + step.travel_rad[kAzimuth];
  const double pitch_rad = shape_angle_rad_[kPitch] + step.travel_rad[kPitch];
  const BaseState base = base_state(step.middle);
  const StageRates stage = stage_rates(base.rate_rad_s, azimuth_rad);
  const double stage_x_rad_s2 =
      stage_rates(base.acceleration_rad_s2, azimuth_rad).x_rad_s + step.rate_rad_s[kAzimuth] * stage.y_rad_s;
  const double sine = std::sin(pitch_rad);
  const double cosine = std::cos(pitch_rad);
  const double cosine_twice = cosine * cosine - sine * sine;
  const double azimuth_rad_s = step.rate_rad_s[kAzimuth] + base_rate_rad_s(kAzimuth, base, azimuth_rad, step.middle);
  const double pitch_rad_s = step.rate_rad_s[kPitch] + base_rate_rad_s(kPitch, base, azimuth_rad, step.middle);
  const double across_rad_s = cosine * azimuth_rad_s - sine * stage.x_rad_s;
  step.coupling_nm[kAzimuth] =
      inertia_swing_kg_m2_ * (sine * across_rad_s * stage.y_rad_s - sine * cosine * stage_x_rad_s2 -
                              cosine_twice * step.rate_rad_s[kPitch] * stage.x_rad_s) -
      pitch_inertia_kg_m2_ * pitch_rad_s * stage.x_rad_s;
  step.coupling_nm[kPitch] = inertia_swing_kg_m2_ * across_rad_s * (cosine * stage.x_rad_s + sine * azimuth_rad_s);

  const BaseState end = base_state(step.end);
  const double end_azimuth_rad = azimuth_rad + 0.5 * step_s_ * step.rate_rad_s[kAzimuth];
  for (std::size_t i = 0; i < kAxes; ++i) {
    step.base_end_rad_s[i] = base_rate_rad_s(i, end, end_azimuth_rad, step.end);
  }
}

// The back-EMF is that of the middle of the joints' step.
void Tracker::step_motors(const std::array<double, kAxes>& duty) {
  duty_ = Pair{realised_duty(duty[kAzimuth], pwm_counts_, pwm_count_),
               realised_duty(duty[kPitch], pwm_counts_, pwm_count_)};
  const Pair angle_rad = shape_angle_rad_ + step_.travel_rad;
  motor_sum_nm_ += motors_.step(duty_ * bus_.voltage_v(), step_.rate_rad_s, angle_rad, bus_.voltage_v());
}

void Tracker::step_joints() {
  const Step& step = step_;
  motor_nm_ = motor_sum_nm_ * (1.0 / periods_);
  motor_sum_nm_ = Pair{};
  const Pair angle_rad = shape_angle_rad_ + step.travel_rad;
  const Pair wind_nm = load_.wind_torque_nm(step.middle);
  Pair load_nm = wind_nm + load_.cable_torque_nm(angle_rad) + gravity_nm(step.travel_rad) + step.coupling_nm - push_nm_;
  const Pair base_drag_nm = step.drag_nm_s_rad * 0.5 * (base_rate_rad_s_ + step.base_end_rad_s);
  const Pair base_change_rad_s = step.base_end_rad_s - base_rate_rad_s_;
  Pair inertia_kg_m2 = step.inertia_kg_m2;
  Pair structure_push_nm{};
  Pair structure_drag_nm_s_rad{};
  for (std::size_t i = 0; i < kAxes; ++i) {
    Axis& axis = axis_[i];
    if (axis.structure) {
      const double behind_nm = axis.structure->is_in_the_wind() ? wind_nm[i] : 0.0;
      load_nm[i] -= behind_nm;
      const Structure::Reaction reaction =
          axis.structure->reaction(inertia_kg_m2[i], base_change_rad_s[i] * per_step_s_, behind_nm);
      structure_push_nm[i] = reaction.push_nm;
      structure_drag_nm_s_rad[i] = reaction.drag_nm_s_rad;
      inertia_kg_m2[i] *= 1.0 - axis.structure->share();
    }
    if (axis.brake) {
      axis.brake->advance();
      joints_.brake(axis.brake->torque_nm(), i);
    }
  }
  const Pair base_push_nm = inertia_kg_m2 * base_change_rad_s * per_step_s_;
  joints_.step(inertia_kg_m2, motor_nm_ - load_nm - base_drag_nm - base_push_nm + structure_push_nm,
               step.drag_nm_s_rad + structure_drag_nm_s_rad);
  const Pair rate_rad_s = joints_.mean_rate_rad_s();
  load_nm_ = load_nm + joints_.stop_torque_nm() + base_drag_nm + step.drag_nm_s_rad * rate_rad_s;
  for (std::size_t i = 0; i < kAxes; ++i) {
    if (axis_[i].structure) {
      axis_[i].structure->commit(rate_rad_s[i]);
      load_nm_[i] += structure_drag_nm_s_rad[i] * rate_rad_s[i] - structure_push_nm[i];
    }
  }
  base_rate_rad_s_ = step.base_end_rad_s;
}

// Of gyro and camera, against the base: the joint's, or behind its spring.
double Tracker::optics_angle_rad(std::size_t axis) const {
  const std::optional<Structure>& structure = axis_[axis].structure;
  const double twist_rad = structure && structure->carries_optics() ? structure->twist_rad() : 0.0;
  return joints_.angle_rad()[axis] + twist_rad;
}

double Tracker::optics_rate_rad_s(std::size_t axis) const {
  const std::optional<Structure>& structure = axis_[axis].structure;
  return structure && structure->carries_optics() ? structure->rate_rad_s() : joints_.rate_rad_s()[axis];
}

// At a fraction 0..1 of the present tick. On a base that does not turn, mountings differ only by what the joints turn.
std::array<double, kAxes> Tracker::sensed_rates(double u) const {
  Eigen::Vector3d base_rad_s = Eigen::Vector3d::Zero();
  if (base_motion_.moves()) {
    base_rad_s = base_state(u).rate_rad_s;
  }
  const std::array<double, kAxes> joint_rad{joints_.angle_rad()[kAzimuth], joints_.angle_rad()[kPitch]};
  std::array<double, kAxes> sensed{};
  for (std::size_t i = 0; i < kAxes; ++i) {
    const double inertial_rad_s = optics_rate_rad_s(i) + base_rate_rad_s_[i];
    double sensed_rad_s = inertial_rad_s;
    switch (gyro_mounting_[i]) {
      case GyroMounting::kLineOfSight:
        if (i == kAzimuth) {
          sensed_rad_s = std::cos(joint_rad[kPitch]) * inertial_rad_s -
                         std::sin(joint_rad[kPitch]) * stage_rates(base_rad_s, joint_rad[kAzimuth]).x_rad_s;
        }
        break;
      case GyroMounting::kStage:
        sensed_rad_s = i == kAzimuth ? inertial_rad_s : base_rate_rad_s_[i];
        break;
      case GyroMounting::kBase:
        sensed_rad_s = base_rate_rad_s_[i];
        if (i == kPitch) {
          sensed_rad_s += stage_rates(base_rad_s, joint_rad[kAzimuth]).y_rad_s - base_rad_s.y();
        }
        break;
      case GyroMounting::kJoint:
      default:
        break;
    }
    sensed[i] = sensed_rad_s;
  }
  return sensed;
}

// In each PWM period of the step; angle and rate are linear within a step.
void Tracker::advance_sensors(double u) {
  const std::array<double, kAxes> sensed_rad_s = sensed_rates(u);
  for (std::size_t i = 0; i < kAxes; ++i) {
    const SensedState now{joints_.angle_rad()[i], sensed_rad_s[i]};
    for (int left = periods_ - 1; left > 0; --left) {
      const double share = static_cast<double>(left) / periods_;
      axis_[i].sensors.advance({now.joint_angle_rad - share * (now.joint_angle_rad - sensed_[i].joint_angle_rad),
                                now.gyro_rate_rad_s - share * (now.gyro_rate_rad_s - sensed_[i].gyro_rate_rad_s)});
    }
    axis_[i].sensors.advance(now);
    sensed_[i] = now;
  }
}

void Tracker::step_pwm(const std::array<double, kAxes>& duty) {
  if (step_in_tick_ == 0) {
    begin_tick();
  }
  const int period = step_in_tick_ % periods_;
  if (period == 0) {
    predict_step();
  }
  step_motors(duty);
  if (period == periods_ - 1) {
    step_joints();
    advance_sensors(step_.end);
    tick_fraction_ = step_.end;
  }
  bus_.step(drawn_a());
  ++steps_;
  step_in_tick_ = step_in_tick_ + 1 == kPwmPerTick ? 0 : step_in_tick_ + 1;
}

}  // namespace trackservo::sim
