// SPDX-License-Identifier: Apache-2.0
// The firmware's check of a gain set against another judge: the eigenvalues of the sampled closed loop in double
// precision, with the plant's exact transition matrices. Random sets and plants; no unstable one may pass.
#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <complex>
#include <cstdio>
#include <cstdlib>
#include <unsupported/Eigen/MatrixFunctions>
#include <utility>
#include <vector>

#include "machine/base/random.hpp"
#include "support/test_size.h"
#include "units.hpp"
#include "unity.h"

extern "C" {
#include "control/loop_stability.h"
}

extern "C" void setUp() {}
extern "C" void tearDown() {}

namespace {

using Row = Eigen::RowVectorXd;
using trackservo::kTick_s;
constexpr int kStates = 110;
constexpr int kCommands = 14;     // past torques
constexpr int kAngles = 15;       // past angles
constexpr int kCameraTicks = 36;  // as in the firmware

double d(float value) { return static_cast<double>(value); }

// Every signal is a linear function of the states; `next` collects the rows of the transition matrix.
class Loop {
 public:
  Loop(const loop_stability_input& in, double inertia, bool pre_sliding, loop_name loop)
      : in_(in), inertia_(inertia), pre_sliding_(pre_sliding), loop_(loop) {}

  double spectral_radius() {
    for (int i = 0; i < kCommands; ++i) {
      commands_.push_back(state());
    }
    const Plant encoder = plant(d(in_.plant.encoder_delay_s));
    const Plant gyro = plant(d(in_.plant.gyro_delay_s));
    std::vector<Row> angles = delayed(encoder.angle, kAngles);
    const Row unfiltered = fused(angles, gyro.rate);
    const Row feedback = filtered(in_.speed.lowpass, filtered(in_.speed.notch, unfiltered));
    const Row torque = controlled(reference(encoder.angle, unfiltered), feedback);
    commands_.insert(commands_.begin(), torque);
    move(encoder);
    move(gyro);
    for (int i = 0; i < kCommands; ++i) {
      next_.emplace_back(i, commands_[static_cast<std::size_t>(i)]);
    }
    return radius();
  }

 private:
  struct Plant {
    Row angle, rate;
    int first = 0;
    int whole = 0;
    Eigen::Matrix3d before, after;  // of (angle, rate, torque), until the new torque and from then on
  };

  Row state() {
    Row row = Row::Zero(kStates);
    row(used_++) = 1.0;
    return row;
  }

  Plant plant(double delay_s) {
    Plant p;
    p.first = used_;
    p.angle = state();
    p.rate = state();
    p.whole = static_cast<int>(delay_s / kTick_s);
    const double until_s = delay_s - p.whole * kTick_s;
    const double damping = d(in_.plant.viscous_nm_s_rad) + (pre_sliding_ ? d(in_.plant.damping_nm_s_rad) : 0.0);
    const double spring = pre_sliding_ ? d(in_.plant.stiffness_nm_rad) : 0.0;
    Eigen::Matrix3d motion = Eigen::Matrix3d::Zero();
    motion(0, 1) = 1.0;
    motion.row(1) << -spring / inertia_, -damping / inertia_, 1.0 / inertia_;
    p.before = (motion * until_s).exp();
    p.after = (motion * (kTick_s - until_s)).exp();
    return p;
  }

  void move(const Plant& p) {
    const auto at = [&](const Eigen::Matrix3d& m, int i, const Row& angle, const Row& rate, const Row& torque) {
      return Row(m(i, 0) * angle + m(i, 1) * rate + m(i, 2) * torque);
    };
    const Row& old = commands_[static_cast<std::size_t>(p.whole) + 1];
    const Row& now = commands_[static_cast<std::size_t>(p.whole)];
    const Row angle = at(p.before, 0, p.angle, p.rate, old);
    const Row rate = at(p.before, 1, p.angle, p.rate, old);
    next_.emplace_back(p.first, at(p.after, 0, angle, rate, now));
    next_.emplace_back(p.first + 1, at(p.after, 1, angle, rate, now));
  }

  // `signal` now and in the `count` ticks before.
  std::vector<Row> delayed(const Row& signal, int count) {
    std::vector<Row> all{signal};
    for (int i = 0; i < count; ++i) {
      const int place = used_;
      const Row past = state();
      next_.emplace_back(place, all.back());
      all.push_back(past);
    }
    return all;
  }

  Row fused(const std::vector<Row>& angles, const Row& gyro) {
    const int n = in_.speed.rate_estimator.window_ticks;
    Row slope = Row::Zero(kStates);
    for (int i = 0; i < n; ++i) {
      slope += 12.0 / (n * (n * n - 1.0) * kTick_s) * (0.5 * (n - 1) - i) * angles[static_cast<std::size_t>(i)];
    }
    const double step = d(in_.speed.rate_fusion.crossover_rad_s) * kTick_s;
    const int place = used_;
    const Row base = state();
    const Row base_now = base + step / (1.0 + step) * (gyro - slope - base);
    next_.emplace_back(place, base_now);
    switch (in_.speed.rate_fusion.source) {
      case RATE_FROM_ENCODER:
        return slope;
      case RATE_FROM_GYRO:
        return gyro;
      default:
        return slope + base_now;
    }
  }

  Row filtered(const biquad_params& p, const Row& input) {
    const int place = used_;
    const Row s1 = state();
    const Row s2 = state();
    const Row output = d(p.b0) * input + s1;
    next_.emplace_back(place, d(p.b1) * input - d(p.a1) * output + s2);
    next_.emplace_back(place + 1, d(p.b2) * input - d(p.a2) * output);
    return output;
  }

  // Integral of `input` times `gain`, before and after this tick.
  std::pair<Row, Row> integral(double gain, const Row& input) {
    const int place = used_;
    const Row before = state();
    const Row after = before + gain * kTick_s * input;
    next_.emplace_back(place, after);
    return {before, after};
  }

  Row reference(const Row& angle, const Row& rate) {
    if (loop_ == LOOP_SPEED) {
      return Row::Zero(kStates);
    }
    if (loop_ == LOOP_POSITION) {
      return -d(in_.position_per_s) * angle;
    }
    if (in_.tracker.kind == TRACKER_PREDICTIVE) {
      return d(in_.tracker.proportional_per_s) * integral(-1.0, rate).second;
    }
    const Row error = -delayed(angle, kCameraTicks).back();
    return d(in_.tracker.proportional_per_s) * error + integral(d(in_.tracker.integral_per_s2), error).second;
  }

  // Rate and acceleration.
  std::pair<Row, Row> shaped(const Row& reference) {
    const setpoint_model_params& model = in_.speed.setpoint_model;
    if (model.gain_per_s == 0.0F) {
      return {reference, Row::Zero(kStates)};
    }
    const int place = used_;
    const Row rate = state();
    const Row catch_up = d(model.decay) * state() - d(model.gain_per_s) * (reference - rate);
    next_.emplace_back(place, rate - kTick_s * catch_up);
    next_.emplace_back(place + 1, catch_up);
    return {rate, -catch_up};
  }

  Row controlled(const Row& wanted, const Row& feedback) {
    const pi_controller_params& pi = in_.speed.pi;
    const double share = in_.gains_follow ? inertia_ / d(in_.plant.inertia_kg_m2) : 1.0;
    const auto [reference, acceleration] = shaped(wanted);
    Row torque = share * d(in_.speed.acceleration_inertia_kg_m2) * acceleration +
                 share * d(pi.proportional_gain) * (d(pi.setpoint_weight) * reference - feedback) +
                 integral(share * d(pi.integral_gain), reference - feedback).first;
    if (in_.speed.observer_on) {
      const disturbance_observer_params& o = in_.speed.observer;
      const double blend = 1.0 - std::exp(-d(o.bandwidth_rad_s) * kTick_s);
      const double momentum = blend * share * d(o.inertia_kg_m2) / kTick_s;
      const int place = used_;
      const Row prediction = state();
      const Row auxiliary = prediction + blend * commands_.front();
      next_.emplace_back(place, (1.0 - blend) * auxiliary + blend * (momentum - d(o.viscous_nm_s_rad)) * feedback);
      torque += auxiliary - momentum * feedback;
    }
    return torque;
  }

  // Without the poles at 1 that no output shows: the angle of a speed loop, the integral against a spring.
  double radius() const {
    Eigen::MatrixXd transition = Eigen::MatrixXd::Zero(used_, used_);
    for (const auto& [place, row] : next_) {
      transition.row(place) = row.head(used_);
    }
    const Eigen::VectorXcd poles = transition.eigenvalues();
    double largest = 0.0;
    for (const std::complex<double>& pole : poles) {
      largest = std::abs(pole - 1.0) < 2e-6 ? largest : std::max(largest, std::abs(pole));
    }
    return largest;
  }

  const loop_stability_input& in_;
  double inertia_;
  bool pre_sliding_;
  loop_name loop_;
  int used_ = 0;
  std::vector<Row> commands_;
  std::vector<std::pair<int, Row>> next_;
};

double largest_radius(const loop_stability_input& in) {
  double largest = 0.0;
  for (const float inertia : {in.plant.inertia_kg_m2, in.plant.min_inertia_kg_m2}) {
    for (const bool pre_sliding : {false, true}) {
      for (const loop_name loop : {LOOP_SPEED, LOOP_POSITION, LOOP_TRACKING}) {
        largest = std::max(largest, Loop(in, d(inertia), pre_sliding, loop).spectral_radius());
      }
    }
  }
  return largest;
}

// A sound design for a random plant, of which some values are replaced by anything in range.
class Draw {
 public:
  explicit Draw(std::uint64_t seed) : random_(seed) {}

  loop_stability_input next() {
    loop_stability_input in{};
    in.dt_s = 1e-3F;
    plant(in.plant);
    speed_loop(in);
    filters(in.speed);
    in.position_per_s = rarely(0.3) ? any(0.01, 1000.0) : any(1.0, 30.0);
    in.tracker.kind = rarely(0.5) ? TRACKER_PREDICTIVE : TRACKER_PI;
    in.tracker.proportional_per_s = rarely(0.2) ? any(0.1, 100.0) : any(1.0, 12.0);
    const float critical = 0.25F * in.tracker.proportional_per_s * in.tracker.proportional_per_s;
    in.gains_follow = rarely(0.5);
    in.tracker.integral_per_s2 = in.tracker.kind == TRACKER_PI && rarely(0.5) ? critical : 0.0F;
    return in;
  }

 private:
  float any(double low, double high) {
    return static_cast<float>(low * std::exp(std::log(high / low) * random_.uniform()));
  }
  float within(double low, double high) { return static_cast<float>(low + (high - low) * random_.uniform()); }
  bool rarely(double share) { return random_.uniform() < share; }

  void plant(loop_plant& p) {
    p.inertia_kg_m2 = any(0.5, 20.0);
    p.min_inertia_kg_m2 = p.inertia_kg_m2 * (rarely(0.5) ? 1.0F : within(0.4, 1.0));
    p.viscous_nm_s_rad = any(0.1, 30.0);
    p.stiffness_nm_rad = any(1e3, 1e5);
    p.damping_nm_s_rad = any(10.0, 600.0);
    p.encoder_delay_s = within(2.8e-4, 7.8e-4);
    p.gyro_delay_s = within(5e-4, 1.3e-3);
  }

  void speed_loop(loop_stability_input& in) {
    const float natural_rad_s = any(5.0, 100.0);
    const float inertia = in.plant.inertia_kg_m2;
    speed_loop_params& p = in.speed;
    p.pi.proportional_gain = rarely(0.4) ? any(1.0, 1e6) : within(1.0, 3.0) * natural_rad_s * inertia;
    p.pi.integral_gain = rarely(0.4) ? any(1.0, 1e8) : natural_rad_s * natural_rad_s * inertia;
    p.pi.integral_gain = rarely(0.1) ? 0.0F : p.pi.integral_gain;
    p.pi.setpoint_weight = within(0.1, 1.0);
    p.acceleration_inertia_kg_m2 = rarely(0.3) ? any(0.1, 100.0) : inertia;
    if (rarely(0.4)) {
      (void)setpoint_model_design(&p.setpoint_model, within(100.0, 1000.0), 1e-3F);
    }
    p.observer_on = rarely(0.6);
    p.observer.inertia_kg_m2 = rarely(0.3) ? any(0.1, 1000.0) : inertia;
    p.observer.viscous_nm_s_rad = rarely(0.2) ? any(0.1, 100.0) : 0.0F;
    p.observer.bandwidth_rad_s = rarely(0.3) ? any(0.1, 1000.0) : any(10.0, 400.0);
  }

  void filters(speed_loop_params& p) {
    constexpr float kTurn = 6.2831853F;
    p.notch = biquad_pass();
    p.lowpass = biquad_pass();
    if (rarely(0.3)) {
      const float frequency = kTurn * any(2.0, 450.0);
      (void)biquad_design_notch(&p.notch, frequency, frequency * any(0.002, 1.5), within(0.0, 1.0), 1e-3F);
    }
    if (rarely(0.4)) {
      (void)biquad_design_lowpass(&p.lowpass, kTurn * any(1.0, 490.0), any(0.1, 2.0), 1e-3F);
    }
    p.rate_fusion.source = static_cast<rate_source>(random_() % 3);
    p.rate_fusion.crossover_rad_s = any(5.0, 300.0);
    p.rate_estimator.window_ticks = rarely(0.4) ? 2 + static_cast<int>(random_() % 15) : 2;
  }

  trackservo::sim::SplitMix64 random_;
};

void test_no_unstable_set_passes_the_check() {
  const int count = by_size(40, 150, 2000);
  Draw draw(1);
  int unstable = 0;
  int passed = 0;
  int refused = 0;
  int refused_far = 0;
  for (int i = 0; i < count; ++i) {
    const loop_stability_input in = draw.next();
    loop_stability state;
    loop_stability_start(&state);
    while (loop_stability_step(&state, &in, 100) == LOOP_RUNNING) {
    }
    const bool accepted = state.verdict == LOOP_STABLE;
    const double radius = largest_radius(in);
    if (radius > 1.0 + 1e-7) {
      ++unstable;
      passed += accepted ? 1 : 0;
    } else if (!accepted) {
      ++refused;
      refused_far += d(state.distance) > d(LOOP_LEAST_DISTANCE) && radius < 1.0 - 1e-5 ? 1 : 0;
    }
  }
  std::printf("%d sets: %d unstable, %d of them passed; %d stable, %d of them refused, %d at a distance above %.1f\n",
              count, unstable, passed, count - unstable, refused, refused_far, d(LOOP_LEAST_DISTANCE));
  TEST_ASSERT_EQUAL(0, passed);
  TEST_ASSERT_EQUAL(0, refused_far);
  TEST_ASSERT_GREATER_THAN(count / 4, unstable);
  TEST_ASSERT_LESS_THAN(count / 5, refused);
}

}  // namespace

int main() {
  UNITY_BEGIN();
  RUN_TEST(test_no_unstable_set_passes_the_check);
  return UNITY_END();
}
