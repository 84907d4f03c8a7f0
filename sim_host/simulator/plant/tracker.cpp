#include "plant/tracker.hpp"

#include <cmath>

#include "sensors/rounding.hpp"

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

std::optional<Structure> structure_of(const PlantConfig& plant, int axis) {
  const std::optional<StructureConfig>& config = plant.axis[static_cast<std::size_t>(axis)].structure;
  return config ? std::optional<Structure>(Structure(*config, axis_inertia_kg_m2(plant, axis, 0.0), kPwmPeriod_s))
                : std::nullopt;
}

}  // namespace

Tracker::Axis::Axis(const AxisConfig& config, const PlantConfig& plant, std::uint64_t seed, int index)
    : motor(config.motor, kPwmPeriod_s),
      joint(config, plant.friction_model, plant.maxwell_slip, kPwmPeriod_s),
      load(config.load, seed, index),
      structure(structure_of(plant, index)),
      base(config.base_sway, seed, index),
      sensors(config, kPwmPeriod_s, kTick_s, seed, index),
      adc(plant.adc, seed, index) {}

Tracker::Tracker(const PlantConfig& plant, std::uint64_t seed)
    : axis_{Axis(plant.axis[kAzimuth], plant, seed, kAzimuth), Axis(plant.axis[kPitch], plant, seed, kPitch)},
      brake_config_{plant.axis[kAzimuth].holding_brake, plant.axis[kPitch].holding_brake},
      base_motion_(plant.base_motion),
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
    axis.joint.place(joint_angle_rad[i]);
    axis.sensors.encoder.place(joint_angle_rad[i]);
    axis.base_rate_rad_s = base_rate_rad_s(i, base_state(0.0), joint_angle_rad[kAzimuth], 0.0);
  }
  shapes_known_ = false;
  bus_.settle(0.0);
}

void Tracker::fit_holding_brakes() {
  for (std::size_t i = 0; i < kAxes; ++i) {
    if (brake_config_[i]) {
      axis_[i].brake.emplace(*brake_config_[i], kPwmPeriod_s);
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
  for (std::size_t i = 0; i < kAxes; ++i) {
    const Axis& axis = axis_[i];
    truth.joint_angle_rad[i] = axis.joint.angle_rad();
    truth.joint_rate_rad_s[i] = axis.joint.rate_rad_s();
    truth.base_rate_rad_s[i] = axis.base_rate_rad_s;
    truth.inertial_angle_rad[i] = axis.joint.angle_rad() + axis.base.angle_rad(tick_fraction_);
    truth.inertial_rate_rad_s[i] = axis.joint.rate_rad_s() + axis.base_rate_rad_s;
    truth.motor_torque_nm[i] = axis.motor_nm;
    truth.friction_torque_nm[i] = axis.joint.friction_torque_nm();
    truth.load_torque_nm[i] = axis.load_nm;
    truth.end_stop_torque_nm[i] = axis.joint.stop_torque_nm();
    truth.current_a[i] = axis.motor.current_a();
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
    const double current_a = axis_[i].motor.current_a();
    return axis_[i].motor.is_open() && bus_.has_capacitor() ? -std::abs(current_a) : duty_[i] * current_a;
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
  return {axis_[i].adc.current_a(axis_[i].motor.current_a()), bus_sample_v_};
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
    axis.load.begin_tick();
    axis.base.begin_tick();
    const FrictionDrift::Factors drift =
        drifts_ ? drift_.at(static_cast<double>(steps_) * kPwmPeriod_s, axis.load_nm) : FrictionDrift::Factors{};
    axis.joint.set_friction_factors(eccentricity_factor_[i] * drift.level, drift.viscosity);
  }
}

bool Tracker::has_left_the_shapes() const {
  const auto travel_rad = [this](std::size_t i) { return std::abs(axis_[i].joint.angle_rad() - shape_angle_rad_[i]); };
  return travel_rad(kAzimuth) > kShapeReach_rad || travel_rad(kPitch) > kShapeReach_rad;
}

void Tracker::renew_shapes() {
  for (std::size_t i = 0; i < kAxes; ++i) {
    Axis& axis = axis_[i];
    shape_angle_rad_[i] = axis.joint.angle_rad();
    eccentricity_factor_[i] = axis.joint.eccentricity_factor();
    axis.motor.renew_shape(shape_angle_rad_[i]);
  }
  shapes_known_ = true;
  gravity_torque_ = gravity_.torque(shape_angle_rad_);
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

double Tracker::gravity_nm(std::size_t axis, const std::array<double, kAxes>& travel_rad) const {
  const auto row = static_cast<Eigen::Index>(axis);
  return gravity_torque_.load_nm[row] + gravity_torque_.slope_nm_rad(row, kAzimuth) * travel_rad[kAzimuth] +
         gravity_torque_.slope_nm_rad(row, kPitch) * travel_rad[kPitch];
}

// Angles and rates in the middle of the step, extrapolated from the last one: second order, explicit, and used only for
// slow quantities (coupling, gravity, cable, back-EMF).
Tracker::Step Tracker::predicted_step() const {
  Step step;
  const double start = step_in_tick_ * kPwmShare;
  step.middle = start + 0.5 * kPwmShare;
  step.end = start + kPwmShare;
  for (std::size_t i = 0; i < kAxes; ++i) {
    const Joint& joint = axis_[i].joint;
    step.rate_rad_s[i] = joint.predicted_rate_rad_s();
    step.travel_rad[i] = joint.angle_rad() + 0.5 * kPwmPeriod_s * joint.rate_rad_s() - shape_angle_rad_[i];
  }
  const double azimuth_rate = step.rate_rad_s[kAzimuth] + axis_[kAzimuth].base.rate_rad_s(step.middle);
  const double inertia_slope = inertia_slope_kg_m2_rad_ + step.travel_rad[kPitch] * inertia_curve_kg_m2_rad2_;
  step.inertia_kg_m2 = {azimuth_inertia_kg_m2(step.travel_rad[kPitch]), pitch_inertia_kg_m2_};
  step.drag_nm_s_rad = {inertia_slope * step.rate_rad_s[kPitch], 0.0};
  step.coupling_nm = {0.0, -0.5 * inertia_slope * azimuth_rate * azimuth_rate};
  for (std::size_t i = 0; i < kAxes; ++i) {
    step.base_end_rad_s[i] = axis_[i].base.rate_rad_s(step.end);
  }
  if (base_motion_.moves()) {
    add_base_motion(step);
  }
  return step;
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
  const double end_azimuth_rad = azimuth_rad + 0.5 * kPwmPeriod_s * step.rate_rad_s[kAzimuth];
  for (std::size_t i = 0; i < kAxes; ++i) {
    step.base_end_rad_s[i] = base_rate_rad_s(i, end, end_azimuth_rad, step.end);
  }
}

void Tracker::step_axis(std::size_t i, double duty, const Step& step) {
  Axis& axis = axis_[i];
  duty_[i] = realised_duty(duty, pwm_counts_, pwm_count_);
  const double angle_rad = shape_angle_rad_[i] + step.travel_rad[i];
  axis.motor_nm = axis.motor.step(duty_[i] * bus_.voltage_v(), step.rate_rad_s[i], angle_rad, bus_.voltage_v());
  const double load_nm =
      axis.load.torque_nm(step.middle, angle_rad) + gravity_nm(i, step.travel_rad) + step.coupling_nm[i] - axis.push_nm;
  const double base_rate_end = step.base_end_rad_s[i];
  const double drag_nm_s_rad = step.drag_nm_s_rad[i];
  const double base_drag_nm = drag_nm_s_rad * 0.5 * (axis.base_rate_rad_s + base_rate_end);
  const double base_change_rad_s = base_rate_end - axis.base_rate_rad_s;
  double inertia_kg_m2 = step.inertia_kg_m2[i];
  Structure::Reaction reaction;
  if (axis.structure) {
    reaction = axis.structure->reaction(inertia_kg_m2, base_change_rad_s * (1.0 / kPwmPeriod_s));
    inertia_kg_m2 *= 1.0 - axis.structure->share();
  }
  if (axis.brake) {
    axis.brake->advance();
    axis.joint.brake(axis.brake->torque_nm());
  }
  const double base_push_nm = inertia_kg_m2 * base_change_rad_s * (1.0 / kPwmPeriod_s);
  axis.joint.step(inertia_kg_m2, axis.motor_nm - load_nm - base_drag_nm - base_push_nm + reaction.push_nm,
                  drag_nm_s_rad + reaction.drag_nm_s_rad);
  axis.load_nm = load_nm + axis.joint.stop_torque_nm() + base_drag_nm + drag_nm_s_rad * axis.joint.mean_rate_rad_s();
  if (axis.structure) {
    const double rate_rad_s = axis.joint.mean_rate_rad_s();
    axis.structure->commit(rate_rad_s);
    axis.load_nm += reaction.drag_nm_s_rad * rate_rad_s - reaction.push_nm;
  }
  axis.base_rate_rad_s = base_rate_end;
}

// `base` is its state now. On a base that does not turn, mountings differ only by what the joints turn.
void Tracker::advance_sensors(const BaseState& base) {
  const std::array<double, kAxes> joint_rad{axis_[kAzimuth].joint.angle_rad(), axis_[kPitch].joint.angle_rad()};
  for (std::size_t i = 0; i < kAxes; ++i) {
    Axis& axis = axis_[i];
    const double inertial_rad_s = axis.joint.rate_rad_s() + axis.base_rate_rad_s;
    double sensed_rad_s = inertial_rad_s;
    switch (gyro_mounting_[i]) {
      case GyroMounting::kLineOfSight:
        if (i == kAzimuth) {
          sensed_rad_s = std::cos(joint_rad[kPitch]) * inertial_rad_s -
                         std::sin(joint_rad[kPitch]) * stage_rates(base.rate_rad_s, joint_rad[kAzimuth]).x_rad_s;
        }
        break;
      case GyroMounting::kStage:
        sensed_rad_s = i == kAzimuth ? inertial_rad_s : axis.base_rate_rad_s;
        break;
      case GyroMounting::kBase:
        sensed_rad_s = axis.base_rate_rad_s;
        if (i == kPitch) {
          sensed_rad_s += stage_rates(base.rate_rad_s, joint_rad[kAzimuth]).y_rad_s - base.rate_rad_s.y();
        }
        break;
      case GyroMounting::kJoint:
      default:
        break;
    }
    axis.sensors.advance({joint_rad[i], sensed_rad_s});
  }
}

void Tracker::step_pwm(const std::array<double, kAxes>& duty) {
  if (step_in_tick_ == 0) {
    begin_tick();
  }
  const Step step = predicted_step();
  for (std::size_t i = 0; i < kAxes; ++i) {
    step_axis(i, duty[i], step);
  }
  advance_sensors(base_state(step.end));
  bus_.step(drawn_a());
  ++steps_;
  step_in_tick_ = step_in_tick_ + 1 == kPwmPerTick ? 0 : step_in_tick_ + 1;
  tick_fraction_ = step.end;
}

}  // namespace trackservo::sim
