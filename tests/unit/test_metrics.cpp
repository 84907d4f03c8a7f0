// Figures of merit on traces whose figures everybody can work out, forwards and backwards.
#include "analysis/metrics.hpp"

#include <cmath>

#include "support/bench.hpp"
#include "support/check.h"

extern "C" void setUp(void) {}
extern "C" void tearDown(void) {}

namespace {

using namespace bench;

constexpr double kRest_s = 0.5;
constexpr double kEnd_s = 3.0;
constexpr double kNatural_rad_s = 20.0;
constexpr double kDamping = 0.5;

// A step of a second-order system with damping 0.5, both axes alike, 1 row per ms.
Trace step_trace(double step_rad_s) {
  Trace trace;
  const double damped = kNatural_rad_s * std::sqrt(1.0 - kDamping * kDamping);
  for (int tick = 0; tick < 3000; ++tick) {
    TraceRow row{};
    row.time_s = tick * kTick_s;
    const double t = row.time_s - kRest_s;
    for (AxisRow& axis : row.axis) {
      axis.reference_rad_s = t < 0.0 ? 0.0 : step_rad_s;
      axis.rate_rad_s =
          t < 0.0 ? 0.0
                  : step_rad_s *
                        (1.0 - std::exp(-kDamping * kNatural_rad_s * t) *
                                   (std::cos(damped * t) + kDamping * kNatural_rad_s / damped * std::sin(damped * t)));
    }
    trace.push_back(row);
  }
  return trace;
}

void test_steps_are_judged_the_same_in_both_directions() {
  const double overshoot = std::exp(-kPi * kDamping / std::sqrt(1.0 - kDamping * kDamping));
  for (const double step_rad_s : {0.1 * kDegree, -0.1 * kDegree, 2.0, -2.0}) {
    const Trace trace = step_trace(step_rad_s);
    const Window window{kRest_s, kEnd_s};
    CHECK_NEAR("overshoot", overshoot, overshoot_fraction(trace, kPitch, window, step_rad_s), 1e-4);
    CHECK_NEAR("time to 90 % in s", 2.125 / kNatural_rad_s, time_to_90_percent_s(trace, kPitch, window, step_rad_s),
               2e-3);
    CHECK_RELATIVE("peak error, the step itself", std::abs(step_rad_s), peak_rate_error_rad_s(trace, kPitch, window),
                   1e-6);
  }
}

void test_a_step_in_the_other_direction_never_arrives() {
  const Window window{kRest_s, kEnd_s};
  CHECK_NEAR("time in s", kEnd_s - kRest_s, time_to_90_percent_s(step_trace(-1.0), kAzimuth, window, 1.0), 1e-9);
  CHECK_SAME("overshoot", 0.0, overshoot_fraction(step_trace(-1.0), kAzimuth, window, 1.0));
}

void test_a_window_without_rows_has_no_value() {
  const Window nothing{10.0, 11.0};
  TEST_ASSERT_DOUBLE_IS_NAN(peak_rate_error_rad_s(step_trace(1.0), kAzimuth, nothing));
  TEST_ASSERT_DOUBLE_IS_NAN(overshoot_fraction(step_trace(1.0), kAzimuth, nothing, 1.0));
  TEST_ASSERT_DOUBLE_IS_NAN(time_to_90_percent_s(step_trace(1.0), kAzimuth, nothing, 1.0));
}

}  // namespace

int main() {
  UNITY_BEGIN();
  RUN_TEST(test_steps_are_judged_the_same_in_both_directions);
  RUN_TEST(test_a_step_in_the_other_direction_never_arrives);
  RUN_TEST(test_a_window_without_rows_has_no_value);
  return UNITY_END();
}
