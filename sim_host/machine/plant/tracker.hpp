// SPDX-License-Identifier: Apache-2.0
// The simulated machine: two motor-driven axes with seals, loads, a swaying base, and the sensors on them.
//
//   J_az(pitch) = J0 + J1 cos^2(pitch),  T = (J_az w_az^2 + J_p w_p^2) / 2,  U = gravity of the off-centre masses
//   d(J_az w_az)/dt        = motor - friction(joint rate) - load,
//   J_p dw_p/dt + J1 sin(2 pitch) w_az^2 / 2 = motor - friction(joint rate) - load,     w: inertial rates
//
// A base that turns (base_motion.hpp) adds its rates about the stage's axes x (ahead) and y (to the left). They come
// from the same Lagrangian with T = (J0 w_az^2 + J_p w_p^2 + J1 (cos(pitch) w_az - sin(pitch) w_x)^2) / 2: the stage
// and the line of sight are taken as symmetric about z.
//
// Each PWM period (50 us) solves the motor current exactly, and rate, friction memory and end stop by a linearly
// implicit second-order step (joint.hpp). Wind and base are updated at 1 kHz. Gravity, ripple and everything else that
// depends only on the angle are updated, with their slopes, as soon as the angle has moved.
//
// Use, in every 1 ms tick: sample_tick() once (or each sensor when it is read), then 20 times sample_pwm() of each axis
// and step_pwm(); measure errors on truth().
#ifndef TRACKSERVO_SIM_PLANT_TRACKER_HPP
#define TRACKSERVO_SIM_PLANT_TRACKER_HPP

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "machine/config/plant_config.hpp"
#include "machine/plant/base_motion.hpp"
#include "machine/plant/base_sway.hpp"
#include "machine/plant/dc_bus.hpp"
#include "machine/plant/gravity.hpp"
#include "machine/plant/holding_brake.hpp"
#include "machine/plant/joint.hpp"
#include "machine/plant/load.hpp"
#include "machine/plant/motor.hpp"
#include "machine/plant/structure.hpp"
#include "machine/plant/truth.hpp"
#include "machine/sensors/adc.hpp"
#include "machine/sensors/sensor_suite.hpp"

namespace trackservo::sim {

class Tracker {
 public:
  // Makes the machine. The configuration must come from load_plant() or satisfy the same ranges. Equal seeds give equal
  // runs, bit by bit.
  Tracker(const PlantConfig& plant, std::uint64_t seed);

  // Puts the machine at rest at these joint angles [rad], bristles relaxed. Only before the first step.
  void place(const std::array<double, kAxes>& joint_angle_rad);

  // Samples all sensors and the bus voltage of this tick. Draws noise: call it exactly once per tick, before its first
  // step.
  TickSamples sample_tick();

  // Returns the same sensors for electronics that read them one by one, at their own times. Each call draws noise.
  std::uint32_t read_encoder(int axis) { return axis_[static_cast<std::size_t>(axis)].sensors.encoder.read(); }
  Gyro::Reading read_gyro(int axis) { return axis_[static_cast<std::size_t>(axis)].sensors.gyro.sample(); }

  // Returns motor current and bus voltage as the ADC reads them at the start of this PWM period. Draws noise: call it
  // at most once per axis and period.
  PwmSample sample_pwm(int axis);

  // Sets whether the bridge of an axis leaves its motor's terminals open, from the next period on.
  void open_terminals(int axis, bool open) { motors_.open_terminals(open, static_cast<std::size_t>(axis)); }

  bool terminals_are_open(int axis) const { return motors_.is_open(static_cast<std::size_t>(axis)); }

  // Sets the share of the bus' capacitance that its capacitor has left.
  void age_capacitor(double share) { bus_.age_capacitor(share); }

  double bus_voltage_v() const { return bus_.voltage_v(); }

  // Adds the holding brakes of the plant; without this call there is none. Only before the first step.
  void fit_holding_brakes();

  // Sets whether the coil of an axis' brake has current, from the next period on.
  void power_brake(int axis, bool on);

  // Returns whether an axis' brake is open; an axis without a brake has an open one.
  bool brake_is_open(int axis) const;

  // Holds a joint where it is; pushes it with a torque [Nm] from outside.
  void hold_joint(int axis, bool held) { joints_.hold(held, static_cast<std::size_t>(axis)); }
  void push(int axis, double torque_nm) { push_nm_[static_cast<std::size_t>(axis)] = torque_nm; }

  // Sets the share of torque and back-EMF that a motor's magnets still give.
  void weaken_motor(int axis, double share) { motors_.weaken(share, static_cast<std::size_t>(axis)); }

  // Applies the duty of both bridges, -1..1 (clipped; NaN counts as 0), for one PWM period of 50 us.
  void step_pwm(const std::array<double, kAxes>& duty);

  // Returns the true state, computed on request, not in every step.
  TruthState truth() const;

 private:
  struct Axis {
    Axis(const AxisConfig& config, const PlantConfig& plant, std::uint64_t seed, int index);

    ExternalLoad load;
    std::optional<HoldingBrake> brake;
    std::optional<Structure> structure;
    BaseSway base;
    SensorSuite sensors;
    CurrentAdc adc;
  };

  // A step of the joints: its times as fractions of the tick, and the values in its middle.
  struct Step {
    double middle;
    double end;
    Pair rate_rad_s;
    Pair travel_rad;  // since the last evaluation
    Pair inertia_kg_m2;
    Pair drag_nm_s_rad;  // d(J w) = J dw + dJ w
    Pair coupling_nm;
    Pair base_end_rad_s;  // the base's rate about each axis, at its end
  };

  void begin_tick();
  void predict_step();
  void add_base_motion(Step& step) const;
  double base_rate_rad_s(std::size_t axis, const BaseState& base, double azimuth_rad, double u) const;
  void advance_sensors(double u);
  double optics_angle_rad(std::size_t axis) const;
  double optics_rate_rad_s(std::size_t axis) const;
  std::array<double, kAxes> sensed_rates(double u) const;
  BaseState base_state(double u) const;
  void step_motors(const std::array<double, kAxes>& duty);
  void step_joints();
  bool has_left_the_shapes() const;
  void renew_shapes();
  double drawn_a() const;
  Pair gravity_nm(Pair travel_rad) const;
  double azimuth_inertia_kg_m2(double pitch_travel_rad) const;  // travel since the last evaluation

  int periods_;    // PWM periods per step of the joints
  double step_s_;  // its length
  double per_step_s_;
  double step_share_;  // of a tick
  std::array<Axis, kAxes> axis_;
  MotorPair motors_;
  JointPair joints_;
  std::array<std::optional<HoldingBrakeConfig>, kAxes> brake_config_;
  BaseMotion base_motion_;
  std::array<GyroMounting, kAxes> gyro_mounting_;
  Gravity gravity_;
  FrictionDrift drift_;
  bool drifts_;
  double inertia_base_kg_m2_;   // J0
  double inertia_swing_kg_m2_;  // J1
  double pitch_inertia_kg_m2_;
  DcBus bus_;
  double pwm_counts_;
  double pwm_count_;  // duty of one count
  Pair duty_{};
  Pair push_nm_{};  // from outside, held until set again

  // Of this step.
  Step step_{};
  Pair motor_sum_nm_{};  // of its PWM periods so far

  // Of this tick.
  LoadOfTick<Pair> load_;
  SwayRate<Pair> sway_;

  // Of the last step.
  Pair motor_nm_{};  // mean
  Pair load_nm_{};
  Pair base_rate_rad_s_{};                   // at its end
  std::array<SensedState, kAxes> sensed_{};  // likewise

  // Functions of the joint angles only, with their slopes at the angles of the last evaluation.
  Pair shape_angle_rad_{};
  bool shapes_known_ = false;
  std::array<double, kAxes> eccentricity_factor_{};
  Pair gravity_nm_{};
  Pair gravity_by_azimuth_nm_rad_{};
  Pair gravity_by_pitch_nm_rad_{};
  double azimuth_inertia_kg_m2_ = 0;
  double inertia_slope_kg_m2_rad_ = 0;   // by pitch angle
  double inertia_curve_kg_m2_rad2_ = 0;  // second derivative

  std::int64_t steps_ = 0;
  std::int64_t bus_sampled_at_ = -1;  // both axes share one conversion per period
  double bus_sample_v_ = 0;
  int step_in_tick_ = 0;
  double tick_fraction_ = 0;  // at the end of the last step
};

}  // namespace trackservo::sim

#endif
