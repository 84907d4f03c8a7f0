// SPDX-License-Identifier: Apache-2.0
// LuGre block against the continuous model, solved by Boost.Odeint's rosenbrock4 at 1e-10 Nm.
//
// With the speed held over each tick the block claims to be exact, so only rounding to float may remain: the bands are
// a few units of 2^-24 of Ts (8e-7 Nm), times the ticks over which a float z remembers its rounding.
#include <algorithm>
#include <cmath>
#include <vector>

#include "support/check.h"
#include "support/lugre_ode.hpp"
#include "support/seals.h"

extern "C" void setUp(void) {}
extern "C" void tearDown(void) {}

namespace {

constexpr double kPi = 3.14159265358979323846;
constexpr float kTick = 1e-3f;

struct Comparison {
  double torque_nm;   // largest difference of the mean torque of a tick
  double bristle_nm;  // largest difference of s0 z after a tick
  double largest_nm;  // largest torque, as a reference for the two
};

// Runs both with one speed per tick.
Comparison compare(const lugre_params& seal, const std::vector<float>& speeds, float dt_s = kTick) {
  lugre_ode::Driven reference{lugre_ode::Friction(seal)};
  lugre_state state;
  lugre_reset(&state);
  Comparison result{0.0, 0.0, 0.0};
  for (const float speed : speeds) {
    const double torque = static_cast<double>(lugre_step(&state, &seal, speed, dt_s));
    const double v = static_cast<double>(speed);
    const double expected = reference.advance([v](double) { return v; }, 0.0, static_cast<double>(dt_s));
    const double force = static_cast<double>(seal.stiffness_nm_rad) * static_cast<double>(state.deflection_rad);
    result.torque_nm = std::max(result.torque_nm, std::abs(torque - expected));
    result.bristle_nm = std::max(result.bristle_nm, std::abs(force - reference.force()));
    result.largest_nm = std::max(result.largest_nm, std::abs(expected));
  }
  return result;
}

std::vector<float> profile(int ticks, double (*speed)(double time)) {
  std::vector<float> speeds;
  speeds.reserve(static_cast<std::size_t>(ticks));
  for (int tick = 0; tick < ticks; ++tick) {
    speeds.push_back(static_cast<float>(speed((tick + 0.5) * 1e-3)));
  }
  return speeds;
}

double degrees(double angle) { return angle * kPi / 180.0; }

void test_steady_sliding_agrees_at_every_speed_of_the_stribeck_curve() {
  const double speeds_deg_s[] = {0.01, 0.1, 0.3, 1.0, 2.0, 10.0, -0.1, -0.3, -1.0, -10.0};
  double worst = 0.0;
  for (const double speed : speeds_deg_s) {
    const std::vector<float> held(400, static_cast<float>(degrees(speed)));
    worst = std::max(worst, compare(stiff_seal(), held).torque_nm);
  }
  LOG_VALUE("steady sliding, largest torque error in Nm of 14", worst);
  CHECK_AT_MOST("torque error", 4e-5, worst);
}

void test_presliding_hysteresis_loops_agree() {
  // 0.1 mrad amplitude is half of the break-away deflection; an inner loop at a third of it is added to the outer one.
  const auto loops = profile(2000, [](double t) {
    return 1e-4 * 2.0 * kPi * std::cos(2.0 * kPi * t) + 3e-5 * 10.0 * kPi * std::cos(10.0 * kPi * t);
  });
  const Comparison seen = compare(stiff_seal(), loops);
  LOG_VALUE("pre-sliding loops, largest torque error in Nm", seen.torque_nm);
  CHECK_AT_LEAST("loop reaches into pre-sliding", 4.0, seen.largest_nm);
  CHECK_AT_MOST("torque error", 2e-5, seen.torque_nm);
  CHECK_AT_MOST("bristle error", 2e-5, seen.bristle_nm);
}

void test_breakaway_from_rest_agrees() {
  const auto ramp = profile(1500, [](double t) { return t < 0.2 ? 0.0 : 2e-3 * (t - 0.2); });
  const Comparison seen = compare(stiff_seal(), ramp);
  LOG_VALUE("break-away, largest torque error in Nm", seen.torque_nm);
  CHECK_AT_LEAST("the contact broke away", 12.0, seen.largest_nm);
  CHECK_AT_MOST("torque error", 3e-5, seen.torque_nm);
}

void test_sudden_and_smooth_reversals_agree() {
  const auto reversals = profile(2000, [](double t) {
    return t < 0.8 ? (std::fmod(t, 0.4) < 0.2 ? degrees(1.0) : degrees(-1.0)) : degrees(1.0) * std::sin(4.0 * kPi * t);
  });
  const Comparison stiff = compare(stiff_seal(), reversals);
  const Comparison soft = compare(seal_of_the_paper(), reversals);
  LOG_VALUE("reversals, stiff seal, largest torque error in Nm", stiff.torque_nm);
  LOG_VALUE("reversals, paper's seal, largest torque error in Nm", soft.torque_nm);
  CHECK_AT_MOST("torque error, stiff", 2e-5, stiff.torque_nm);
  CHECK_AT_MOST("torque error, paper", 5e-6, soft.torque_nm);
}

void test_the_papers_slow_sine_agrees_over_one_period() {
  const auto sine = profile(10000, [](double t) { return degrees(1.0) * std::sin(0.2 * kPi * t); });
  const Comparison seen = compare(seal_of_the_paper(), sine);
  LOG_VALUE("1 deg/s, 0.1 Hz sine, largest torque error in Nm", seen.torque_nm);
  CHECK_AT_LEAST("the sine loads the bristles", 5.0, seen.largest_nm);
  CHECK_AT_MOST("torque error", 1e-4, seen.torque_nm);
}

void test_fast_speeds_at_which_explicit_euler_would_explode_agree() {
  // s0 |v| dt / g is 7 at 1 rad/s and 350 at 50 rad/s; Euler is unstable above 2.
  const auto fast = profile(300, [](double t) { return (t < 0.15 ? 1.0 : -50.0) * std::sin(200.0 * t); });
  const Comparison seen = compare(stiff_seal(), fast);
  LOG_VALUE("fast, largest torque error in Nm", seen.torque_nm);
  CHECK_AT_MOST("torque error relative to the torque", 1e-6, seen.torque_nm / seen.largest_nm);
}

// The root mean square over 0.4 s of the difference between the block, given the speed in the middle of each tick, and
// the continuous model under the continuous speed.
template <class Speed>
double hold_error(Speed speed, float dt_s) {
  const lugre_params seal = stiff_even_seal();
  lugre_ode::Driven reference{lugre_ode::Friction(seal)};
  lugre_state state;
  lugre_reset(&state);
  const double dt = static_cast<double>(dt_s);
  const int ticks = static_cast<int>(std::lround(0.4 / dt));
  double sum = 0.0;
  for (int tick = 0; tick < ticks; ++tick) {
    const double start = tick * dt;
    const float middle = static_cast<float>(speed(start + dt / 2));
    const double torque = static_cast<double>(lugre_step(&state, &seal, middle, dt_s));
    const double expected = reference.advance(speed, start, start + dt);
    sum += (torque - expected) * (torque - expected);
  }
  return std::sqrt(sum / ticks);
}

void test_under_a_continuous_speed_the_error_falls_with_the_square_of_the_tick() {
  const auto speed = [](double t) { return 2e-3 * (1.5 - std::cos(6.0 * kPi * t)); };
  const double coarse = hold_error(speed, 4e-3f);
  const double middle = hold_error(speed, 2e-3f);
  const double fine = hold_error(speed, 1e-3f);
  LOG_VALUE("rms torque error at 1 ms under a continuous speed, Nm", fine);
  LOG_VALUE("order from 4 to 2 ms", std::log2(coarse / middle));
  LOG_VALUE("order from 2 to 1 ms", std::log2(middle / fine));
  CHECK_AT_LEAST("order from 4 to 2 ms", 1.9, std::log2(coarse / middle));
  CHECK_AT_LEAST("order from 2 to 1 ms", 1.9, std::log2(middle / fine));
}

void test_a_reversal_within_a_tick_costs_at_most_half_an_order() {
  // The one tick in which v changes sign has a kink in |v|; elsewhere the order stays 2.
  const auto speed = [](double t) { return 4e-3 * std::sin(6.0 * kPi * t); };
  const double middle = hold_error(speed, 2e-3f);
  const double fine = hold_error(speed, 1e-3f);
  LOG_VALUE("rms torque error at 1 ms with reversals, Nm", fine);
  CHECK_AT_LEAST("order from 2 to 1 ms", 1.5, std::log2(middle / fine));
  CHECK_AT_MOST("rms torque error at 1 ms", 1e-3, fine);
}

}  // namespace

int main() {
  UNITY_BEGIN();
  RUN_TEST(test_steady_sliding_agrees_at_every_speed_of_the_stribeck_curve);
  RUN_TEST(test_presliding_hysteresis_loops_agree);
  RUN_TEST(test_breakaway_from_rest_agrees);
  RUN_TEST(test_sudden_and_smooth_reversals_agree);
  RUN_TEST(test_the_papers_slow_sine_agrees_over_one_period);
  RUN_TEST(test_fast_speeds_at_which_explicit_euler_would_explode_agree);
  RUN_TEST(test_under_a_continuous_speed_the_error_falls_with_the_square_of_the_tick);
  RUN_TEST(test_a_reversal_within_a_tick_costs_at_most_half_an_order);
  return UNITY_END();
}
