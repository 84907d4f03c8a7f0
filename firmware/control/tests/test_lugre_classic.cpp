// SPDX-License-Identifier: Apache-2.0
// The cases of Canudas de Wit, Olsson, Astrom, Lischinsky 1995, section III: a mass of 1 kg on the classic contact.
//
// Each case is simulated with the block (speed held over steps of 10 us, the mass by a symplectic Euler step) and with
// rosenbrock4 on the continuous model of 1995 (s1 never reduced: the block's passivity measure must have no effect).
// The step is the finest that float still resolves well: a step's share of the bristle motion must stay above 2^-24 of
// it. The mass adds a first-order error of about half a step, and the contact's own time is sigma1/sigma0 = 3 ms, so
// bands are stated in per cent, or as 1e-5 s times the slope.
#include <algorithm>
#include <cmath>
#include <vector>

#include "support/check.h"
#include "support/lugre_ode.hpp"
#include "support/seals.h"

extern "C" void setUp(void) {}
extern "C" void tearDown(void) {}

namespace {

using lugre_ode::Damping;
using lugre_ode::Friction;
using lugre_ode::Vector;

constexpr double kPi = 3.14159265358979323846;
constexpr double kStep = 1e-5;

enum { kPosition, kSpeed, kBristleForce, kIntegral, kStates };  // the states of a case in the solver

// State of a moving mass at one time.
struct Moment {
  double time_s;
  double position_m;
  double speed_m_s;
  double friction_n;
};

// `push(time, position, speed, integral)` is the force on the mass, `rate(time, position)` the integrand of the
// integral.

// The block in the loop; every `every` steps one state is recorded.
template <class Push, class Rate>
std::vector<Moment> with_block(Push push, Rate rate, double duration, int every) {
  const lugre_params contact = classic_contact();
  lugre_state state;
  lugre_reset(&state);
  std::vector<Moment> seen;
  double x = 0.0;
  double v = 0.0;
  double integral = 0.0;
  const long steps = std::lround(duration / kStep);
  for (long step = 0; step < steps; ++step) {
    const double time = static_cast<double>(step) * kStep;
    const double friction =
        static_cast<double>(lugre_step(&state, &contact, static_cast<float>(v), static_cast<float>(kStep)));
    const double force = push(time, x, v, integral) - friction;
    integral += rate(time, x) * kStep;
    x += v * kStep;
    v += force * kStep;
    if ((step + 1) % every == 0) {
      seen.push_back({time + kStep, x, v, friction});
    }
  }
  return seen;
}

template <class Push, class Rate>
std::vector<Moment> with_solver(Push push, Rate rate, double duration, int every) {
  const Friction friction(classic_contact(), Damping::kOriginal);
  const auto rhs = [&](const Vector& s, Vector& slope, double time) {
    const double v = s(kSpeed);
    slope(kPosition) = v;
    slope(kSpeed) = push(time, s(kPosition), v, s(kIntegral)) - friction.torque(v, s(kBristleForce));
    slope(kBristleForce) = friction.force_rate(v, s(kBristleForce));
    slope(kIntegral) = rate(time, s(kPosition));
  };
  std::vector<Moment> seen;
  Vector state(kStates, 0.0);
  const double span = kStep * every;
  const long count = std::lround(duration / span);
  for (long i = 0; i < count; ++i) {
    const double start = static_cast<double>(i) * span;
    lugre_ode::solve(rhs, state, start, start + span, span * 0.1, 1e-9);
    seen.push_back(
        {start + span, state(kPosition), state(kSpeed), friction.torque(state(kSpeed), state(kBristleForce))});
  }
  return seen;
}

double no_integral(double /*time*/, double /*position*/) { return 0.0; }

template <class Pick>
double largest_difference(const std::vector<Moment>& a, const std::vector<Moment>& b, Pick pick) {
  double largest = 0.0;
  for (std::size_t i = 0; i < std::min(a.size(), b.size()); ++i) {
    largest = std::max(largest, std::abs(pick(a[i]) - pick(b[i])));
  }
  return largest;
}

double position_of(const Moment& m) { return m.position_m; }

// Section III.A: a force swept slowly to 1.425 N (95 % of Fs), back to its opposite and up again.
double presliding_push(double time, double /*position*/, double /*speed*/, double /*integral*/) {
  const double phase = std::fmod(time, 4.0);
  const double triangle = phase < 1.0 ? phase : (phase < 3.0 ? 2.0 - phase : phase - 4.0);
  return 1.425 * triangle;
}

void test_presliding_displacement_has_hysteresis() {
  const auto block = with_block(presliding_push, no_integral, 9.0, 1000);
  const auto reference = with_solver(presliding_push, no_integral, 9.0, 1000);
  double highest = 0.0;
  double lowest = 0.0;
  for (const Moment& m : block) {
    highest = std::max(highest, m.position_m);
    lowest = std::min(lowest, m.position_m);
  }
  const double error = largest_difference(block, reference, position_of);
  LOG_VALUE("pre-sliding travel, um", 1e6 * (highest - lowest));
  LOG_VALUE("largest position error, um", 1e6 * error);
  // An elastic contact would move by 2 * 14.25 um; the rest is slip, and the return path differs from the outward path.
  CHECK_AT_LEAST("travel in um", 40.0, 1e6 * (highest - lowest));
  CHECK_AT_MOST("travel in um", 200.0, 1e6 * (highest - lowest));
  const double going_up = block[449].position_m;  // push 0.7125 N, rising, second cycle
  const double coming_down = block[549].position_m;
  CHECK_NEAR("same push on both ways", presliding_push(4.5, 0, 0, 0), presliding_push(5.5, 0, 0, 0), 1e-12);
  CHECK_AT_LEAST("opening of the loop in um", 5.0, 1e6 * (coming_down - going_up));
  CHECK_AT_MOST("position error relative to the travel", 0.005, error / (highest - lowest));
}

// Section III.B: a speed that rises and falls without changing sign; friction is higher while it rises.
struct Loop {
  double opening;  // mean friction rising less falling, N
  double error;    // largest difference to the solver, N
};

Loop frictional_lag(double frequency_rad_s) {
  const auto speed = [frequency_rad_s](double t) { return 1.25e-3 * (1.1 - std::cos(frequency_rad_s * t)); };
  const lugre_params contact = classic_contact();
  lugre_ode::Driven reference{Friction(contact, Damping::kOriginal)};
  lugre_state state;
  lugre_reset(&state);
  const double period = 2.0 * kPi / frequency_rad_s;
  const int half = 500;  // steps of half a period
  const int steps = 2 * half;
  const double dt = period / steps;
  Loop loop{0.0, 0.0};
  for (int step = 0; step < 2 * steps; ++step) {  // the first period loads the bristles
    const double start = step * dt;
    const float held = static_cast<float>(speed(start + dt / 2));
    const double friction = static_cast<double>(lugre_step(&state, &contact, held, static_cast<float>(dt)));
    if (step < steps) {
      reference.advance(speed, start, start + dt);
      continue;
    }
    loop.error = std::max(loop.error, std::abs(friction - reference.advance(speed, start, start + dt)));
    loop.opening += (step < steps + half ? friction : -friction) / half;
  }
  return loop;
}

void test_friction_lags_the_speed_the_more_the_faster_it_changes() {
  const Loop slow = frictional_lag(1.0);
  const Loop middle = frictional_lag(10.0);
  const Loop fast = frictional_lag(25.0);
  LOG_VALUE("opening of the loop at 1 rad/s, N", slow.opening);
  LOG_VALUE("opening of the loop at 10 rad/s, N", middle.opening);
  LOG_VALUE("opening of the loop at 25 rad/s, N", fast.opening);
  LOG_VALUE("largest friction error, N", std::max(slow.error, std::max(middle.error, fast.error)));
  CHECK_AT_LEAST("slow loop", 1e-4, slow.opening);
  CHECK_AT_LEAST("middle over slow", 2.0, middle.opening / slow.opening);
  CHECK_AT_LEAST("fast over middle", 1.2, fast.opening / middle.opening);
  CHECK_AT_MOST("friction error", 2e-5, std::max(slow.error, std::max(middle.error, fast.error)));
}

// Section III.C: a force ramp; break-away is the highest friction before the mass slides off.
struct Breakaway {
  double block_n;
  double solver_n;
};

Breakaway breakaway(double force_rate_n_s) {
  const auto push = [force_rate_n_s](double time, double, double, double) { return force_rate_n_s * time; };
  const double duration = 2.0 / force_rate_n_s;
  const int every = std::max(1, static_cast<int>(duration / kStep / 500.0));
  const auto highest = [](const std::vector<Moment>& seen) {
    double highest_n = 0.0;
    for (const Moment& m : seen) {
      if (m.speed_m_s > 0.02) {
        break;  // far past the Stribeck speed: it slides
      }
      highest_n = std::max(highest_n, m.friction_n);
    }
    return highest_n;
  };
  return {highest(with_block(push, no_integral, duration, every)),
          highest(with_solver(push, no_integral, duration, every))};
}

void test_breakaway_force_falls_with_the_force_rate() {
  const double rates_n_s[] = {1.0, 2.0, 5.0, 10.0, 20.0, 50.0};
  double previous_n = 1.5;
  for (const double rate : rates_n_s) {
    const Breakaway seen = breakaway(rate);
    LOG_VALUE("break-away force, N", seen.block_n);
    LOG_VALUE("difference to the solver, N", seen.block_n - seen.solver_n);
    CHECK_AT_MOST("break-away force, falling with the rate", previous_n, seen.block_n);
    CHECK_AT_LEAST("break-away force stays above Coulomb", 1.0, seen.block_n);
    CHECK_RELATIVE("break-away force of the solver", seen.solver_n, seen.block_n, 2e-4);
    previous_n = seen.block_n - 1e-3;
  }
}

// The times at which a sticking mass slides off, i.e. its speed rises through `threshold`.
std::vector<double> starts_of_slip(const std::vector<Moment>& seen, double threshold) {
  std::vector<double> starts;
  bool sliding = false;
  for (const Moment& m : seen) {
    if (!sliding && std::abs(m.speed_m_s) > threshold) {
      starts.push_back(m.time_s);
      sliding = true;
    } else if (sliding && std::abs(m.speed_m_s) < 0.1 * threshold) {
      sliding = false;
    }
  }
  return starts;
}

// Section IV.A: a spring of 2 N/m, drawn at 0.1 m/s, pulls the mass.
double spring_push(double time, double position, double /*speed*/, double /*integral*/) {
  return 2.0 * (0.1 * time - position);
}

void test_a_mass_pulled_by_a_spring_sticks_and_slips() {
  const auto block = with_block(spring_push, no_integral, 35.0, 500);
  const auto reference = with_solver(spring_push, no_integral, 35.0, 500);
  const auto slips = starts_of_slip(block, 0.05);
  const auto expected = starts_of_slip(reference, 0.05);
  TEST_ASSERT_EQUAL_UINT(expected.size(), slips.size());
  TEST_ASSERT_TRUE_MESSAGE(slips.size() >= 4, "the mass does not stick and slip");
  LOG_VALUE("slips in 35 s", static_cast<double>(slips.size()));
  LOG_VALUE("first slip, s", slips.front());
  LOG_VALUE("largest position error, mm", 1e3 * largest_difference(block, reference, position_of));
  // The spring needs (1 .. 1.5 N)/(0.2 N/s) to break the mass away.
  CHECK_AT_LEAST("first slip", 7.0, slips.front());
  CHECK_AT_MOST("first slip", 8.0, slips.front());
  for (std::size_t i = 0; i < slips.size(); ++i) {
    CHECK_NEAR("moment of slip", expected[i], slips[i], 0.01);  // 1e-3 of the cycle
  }
  CHECK_AT_MOST("position error", 2e-3, largest_difference(block, reference, position_of));  // of 1.2 m steps
}

// Section IV.B: position control of the mass by a PID to x = 1 m; friction and integral action cause hunting.
double pid_push(double /*time*/, double position, double speed, double integral) {
  return -6.0 * speed - 3.0 * (position - 1.0) - 4.0 * integral;
}
double pid_error(double /*time*/, double position) { return position - 1.0; }

void test_pid_position_control_hunts() {
  const auto block = with_block(pid_push, pid_error, 60.0, 1000);
  const auto reference = with_solver(pid_push, pid_error, 60.0, 1000);
  const double error = largest_difference(block, reference, position_of);
  double highest = -1.0;
  double lowest = 3.0;
  for (const Moment& m : block) {
    if (m.time_s > 30.0) {
      highest = std::max(highest, m.position_m);
      lowest = std::min(lowest, m.position_m);
    }
  }
  LOG_VALUE("hunting from peak to peak after 30 s, m", highest - lowest);
  LOG_VALUE("largest position error, mm", 1e3 * error);
  CHECK_AT_LEAST("hunting from peak to peak", 0.05, highest - lowest);
  CHECK_AT_LEAST("target within the hunting", lowest, 1.0);
  CHECK_AT_MOST("target within the hunting", highest, 1.0);
  CHECK_AT_MOST("position error relative to the hunting", 0.01, error / (highest - lowest));
}

}  // namespace

int main() {
  UNITY_BEGIN();
  RUN_TEST(test_presliding_displacement_has_hysteresis);
  RUN_TEST(test_friction_lags_the_speed_the_more_the_faster_it_changes);
  RUN_TEST(test_breakaway_force_falls_with_the_force_rate);
  RUN_TEST(test_a_mass_pulled_by_a_spring_sticks_and_slips);
  RUN_TEST(test_pid_position_control_hunts);
  return UNITY_END();
}
