#include "experiments/control_design.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "experiments/design_check.hpp"
#include "random.hpp"

namespace trackservo::sim {
namespace {

constexpr double kRadPerDeg = kPi / 180.0;

float to_float(double value) { return static_cast<float>(value); }

// Every friction parameter is wrong by the same share, each with a sign of its own.
class WrongBy {
 public:
  WrongBy(double share, std::uint64_t seed, int axis) : share_(share), signs_(seed, "friction.parameter.error", axis) {}
  double operator()(double value) { return value * (signs_.uniform() < 0.5 ? 1.0 - share_ : 1.0 + share_); }

 private:
  double share_;
  RandomStream signs_;
};

lugre_direction wrong_direction(const StribeckConfig& truth, WrongBy& wrong) {
  const double coulomb_nm = wrong(truth.coulomb_nm);
  const double breakaway_nm = std::max(wrong(truth.breakaway_nm), coulomb_nm);
  const double stribeck_speed_rad_s = wrong(truth.stribeck_speed_rad_s);
  const double viscous_nm_s_rad = wrong(truth.viscous_nm_s_rad);
  return {to_float(coulomb_nm), to_float(breakaway_nm), to_float(stribeck_speed_rad_s), to_float(viscous_nm_s_rad)};
}

lugre_params wrong_friction(const FrictionConfig& truth, WrongBy wrong) {
  lugre_params params{};
  params.stiffness_nm_rad = to_float(wrong(truth.stiffness_nm_rad));
  params.damping_nm_s_rad = to_float(wrong(truth.damping_nm_s_rad));
  params.positive = wrong_direction(truth.positive, wrong);
  params.negative = wrong_direction(truth.negative, wrong);
  return params;
}

double nominal_inertia_kg_m2(const PlantConfig& plant, int axis) { return axis_inertia_kg_m2(plant, axis, 0.0); }

rate_source source_of(FeedbackSource feedback) {
  switch (feedback) {
    case FeedbackSource::kGyro:
      return RATE_FROM_GYRO;
    case FeedbackSource::kEncoder:
      return RATE_FROM_ENCODER;
    case FeedbackSource::kFused:
    default:
      return RATE_FUSED;
  }
}

speed_loop_params design_speed_loop(const PlantConfig& plant, int axis, const ControllerSpec& spec,
                                    const DesignOptions& options) {
  const std::size_t i = static_cast<std::size_t>(axis);
  const DesignConfig& design = plant.design[i];
  const double inertia_kg_m2 = nominal_inertia_kg_m2(plant, axis);
  const double limit_nm = plant.axis[i].motor.current_limit_a * plant.axis[i].motor.torque_constant_nm_a;
  speed_loop_params p{};
  p.rate_estimator.window_ticks = design.rate_window_ticks;
  p.rate_fusion = {source_of(design.feedback), to_float(2.0 * kPi * design.fusion_crossover_hz)};
  p.notch = biquad_pass();
  p.lowpass = biquad_pass();
  p.acceleration_inertia_kg_m2 = to_float(inertia_kg_m2);
  p.observer_on = spec.observer;
  p.observer.inertia_kg_m2 = to_float(inertia_kg_m2);
  p.observer.bandwidth_rad_s = to_float(2.0 * kPi * design.observer_bandwidth_hz);
  p.observer.limit_nm = to_float(limit_nm);
  p.friction.model = spec.friction;
  p.friction.gain = 1.0F;
  p.friction.lead_limit_rad_s = to_float(5.0 * kRadPerDeg);
  p.friction.sign_width_rad_s = to_float(0.01 * kRadPerDeg);
  p.friction.lugre =
      wrong_friction(plant.axis[i].friction, WrongBy(options.friction_parameter_error, options.seed, axis));
  return p;
}

// Natural frequency of a critically damped PI on an integrator, with a pure delay, whose closed loop is at -3 dB at
// the wanted frequency. The paper gives "about 2 Hz" for its tracking loop and 20 ms of camera delay.
double tracking_frequency_rad_s(double bandwidth_hz, double delay_s) {
  double low = 0.1;
  double high = 2.0 * kPi * bandwidth_hz;
  for (int i = 0; i < 60; ++i) {
    const double w = 0.5 * (low + high);
    const std::complex<double> s(0.0, 2.0 * kPi * bandwidth_hz);
    const std::complex<double> loop = (2.0 * w * s + w * w) / (s * s) * std::exp(-s * delay_s);
    (std::abs(loop / (1.0 + loop)) < M_SQRT1_2 ? low : high) = w;
  }
  return low;
}

target_tracker_params design_tracker(tracker_kind kind) {
  target_tracker_params p{};
  p.kind = kind;
  p.rate_limit_rad_s = to_float(60.0 * kRadPerDeg);
  p.coast_s = 0.5F;
  p.estimator_rad_s = 4.0F;
  if (kind == TRACKER_PI) {
    // 20 ms of camera, 10 ms of hold between frames, about 6 ms of speed loop.
    const double w = tracking_frequency_rad_s(2.0, 0.036);
    p.proportional_per_s = to_float(2.0 * w);
    p.integral_per_s2 = to_float(w * w);
  } else {
    p.proportional_per_s = 20.0F;
  }
  return p;
}

servo_axis_params design_axis(const PlantConfig& plant, int axis, const ControllerSpec& spec,
                              const DesignOptions& options) {
  const AxisConfig& machine = plant.axis[static_cast<std::size_t>(axis)];
  servo_axis_params p{};
  p.speed = design_speed_loop(plant, axis, spec, options);
  p.position = {10.0F, to_float(60.0 * kRadPerDeg), to_float(60.0 * kRadPerDeg)};
  p.tracker = design_tracker(options.tracker);
  p.torque_constant_nm_a = to_float(machine.motor.torque_constant_nm_a);
  p.current_limit_a = to_float(machine.motor.current_limit_a);
  const control_status status = current_loop_design(
      &p.current, to_float(machine.motor.resistance_ohm), to_float(machine.motor.inductance_h),
      to_float(machine.motor.back_emf_constant_v_s_rad),
      to_float(2.0 * kPi * plant.design[static_cast<std::size_t>(axis)].current_loop_bandwidth_hz), SERVO_PWM_PERIOD_S);
  if (status != CONTROL_OK) {
    throw plant.lines.error(fmt::format("design.{}.current_loop_bandwidth_hz", axis_name(axis)),
                            "is not possible with this motor and a PWM of 20 kHz", "give 10 to 2500");
  }
  return p;
}

}  // namespace

const std::vector<ControllerSpec>& controller_specs() {
  static const std::vector<ControllerSpec> specs = {
      {"pi", "PI", "PI speed loop with acceleration feedforward", false, FRICTION_NONE},
      {"pi_vob", "PI + VOB", "PI and velocity disturbance observer", true, FRICTION_NONE},
      {"pi_ftc", "PI + FTC", "PI and LuGre friction feedforward", false, FRICTION_LUGRE},
      {"pi_vob_ftc", "PI + VOB + FTC", "PI, observer and LuGre friction feedforward", true, FRICTION_LUGRE},
      {"pi_coulomb", "PI + Coulomb", "PI and the Coulomb and viscous feedforward that drives usually have", false,
       FRICTION_COULOMB},
      {"pi_best", "best PI", "PI tuned by an optimiser for this scenario within the same margins", false,
       FRICTION_NONE},
  };
  return specs;
}

const ControllerSpec& controller_spec(const std::string& name) {
  std::string choices;
  for (const ControllerSpec& spec : controller_specs()) {
    if (spec.name == name) {
      return spec;
    }
    choices += (choices.empty() ? "" : ", ") + spec.name;
  }
  throw std::invalid_argument(fmt::format("controller \"{}\" is not known; give one of {}", name, choices));
}

PiWish pi_wish(const PlantConfig& plant, int axis) {
  const DesignConfig& design = plant.design[static_cast<std::size_t>(axis)];
  if (design.speed_loop_natural_frequency_rad_s) {
    return {*design.speed_loop_natural_frequency_rad_s, design.speed_loop_damping, design.setpoint_weight};
  }
  const double bandwidth_hz = design.speed_loop_bandwidth_hz.value();
  servo_params params{};
  params.axis[axis].speed = design_speed_loop(plant, axis, controller_spec("pi"), {});
  const LinearMachine machine = linear_machine(plant, axis, false);
  PiWish wish{0.0, design.speed_loop_damping, design.setpoint_weight};
  double low = 0.01 * bandwidth_hz;
  double high = 2.0 * kPi * bandwidth_hz;
  for (int i = 0; i < 50; ++i) {
    wish.natural_frequency_rad_s = 0.5 * (low + high);
    set_pi(params, plant, axis, wish);
    const double gain = std::abs(closed_loop_gain(machine, params.axis[axis].speed, bandwidth_hz));
    (gain < M_SQRT1_2 ? low : high) = wish.natural_frequency_rad_s;
  }
  return wish;
}

void set_pi(servo_params& params, const PlantConfig& plant, int axis, const PiWish& wish) {
  const double inertia_kg_m2 = nominal_inertia_kg_m2(plant, axis);
  pi_controller_params& pi = params.axis[axis].speed.pi;
  pi.proportional_gain = to_float(2.0 * wish.damping * wish.natural_frequency_rad_s * inertia_kg_m2);
  pi.integral_gain = to_float(wish.natural_frequency_rad_s * wish.natural_frequency_rad_s * inertia_kg_m2);
  pi.setpoint_weight = to_float(wish.setpoint_weight);
  pi.tracking_rate_per_s = to_float(0.5 * wish.natural_frequency_rad_s / wish.damping);  // ki / kp
}

namespace {

// The firmware's own ranges, told as the wish that leads out of them.
void refuse_out_of_range(const PlantConfig& plant, int axis, const servo_axis_params& params) {
  if (servo_axis_check(&params, SERVO_TICK_S, SERVO_PWM_PERIOD_S) == CONTROL_OK) {
    return;
  }
  const DesignConfig& design = plant.design[static_cast<std::size_t>(axis)];
  const bool observer = disturbance_observer_check(&params.speed.observer, SERVO_TICK_S) != CONTROL_OK;
  const bool pi = pi_controller_check(&params.speed.pi, SERVO_TICK_S) != CONTROL_OK;
  const bool fusion = rate_fusion_check(&params.speed.rate_fusion) != CONTROL_OK;
  const char *pi_key =
      design.speed_loop_bandwidth_hz ? "speed_loop_bandwidth_hz" : "speed_loop_natural_frequency_rad_s";
  const std::string key = observer ? "observer_bandwidth_hz" : pi ? pi_key : fusion ? "fusion_crossover_hz" : "";
  if (key.empty()) {
    throw plant.lines.error(axis_name(axis), "has numbers that the firmware's ranges do not hold",
                            "check friction, motor and inertia against the ranges in firmware/control/*.h");
  }
  throw plant.lines.error(fmt::format("design.{}.{}", axis_name(axis), key), "is out of the firmware's range at 1 kHz",
                          observer ? "give at most 159" : "give a lower one");
}

}  // namespace

servo_params design_controller(const PlantConfig& plant, const ControllerSpec& spec, const DesignOptions& options) {
  servo_params params{};
  for (int axis = 0; axis < kAxes; ++axis) {
    params.axis[axis] = design_axis(plant, axis, spec, options);
    set_pi(params, plant, axis, pi_wish(plant, axis));
    refuse_out_of_range(plant, axis, params.axis[axis]);
  }
  refuse_unstable_loops(plant, params);
  return params;
}

}  // namespace trackservo::sim
