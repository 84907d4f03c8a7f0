// SPDX-License-Identifier: Apache-2.0
// Requirements that make the machine unstable are refused, those close to it give a warning, and the advice works.
#include "design/design_check.hpp"

#include <array>
#include <cmath>
#include <cstdlib>
#include <functional>

#include "design/control_design.hpp"
#include "machine/run/scenario_run.hpp"
#include "support/bench.hpp"
#include "support/check.h"

extern "C" void setUp(void) {}
extern "C" void tearDown(void) {}

namespace {

using namespace bench;

FrequencyResponse response_of(const std::function<std::complex<double>(std::complex<double>)>& loop_gain) {
  FrequencyResponse response;
  response.frequency_hz = log_space(1e-4, 499.0, 1000);
  for (const double f_hz : response.frequency_hz) {
    response.loop_gain.push_back(loop_gain({0.0, 2.0 * kPi * f_hz}));
  }
  return response;
}

// k/s exp(-sT) closes stably for k T < pi/2; (2ws + w^2)/s^2 exp(-sT), two integrators, for w T < 0.549 (crossover at
// w sqrt(2 + sqrt 5), phase atan(2 sqrt(2 + sqrt 5)) of lead).
void test_stability_is_judged_as_in_the_textbook() {
  const double dead_time_s = 0.02;
  for (const double share : {0.01, 0.5, 0.97}) {
    TEST_ASSERT_TRUE(is_stable_in_closed_loop(
        response_of([&](auto s) { return share * 0.5 * kPi / dead_time_s / s * std::exp(-s * dead_time_s); })));
  }
  for (const double share : {1.03, 1.5, 4.0}) {
    TEST_ASSERT_FALSE(is_stable_in_closed_loop(
        response_of([&](auto s) { return share * 0.5 * kPi / dead_time_s / s * std::exp(-s * dead_time_s); })));
  }
  const double crossover = std::sqrt(2.0 + std::sqrt(5.0));
  const double limit_rad_s = std::atan(2.0 * crossover) / crossover / dead_time_s;
  const auto pi_loop = [&](double share) {
    const double w = share * limit_rad_s;
    return response_of([&, w](auto s) { return (2.0 * w * s + w * w) / (s * s) * std::exp(-s * dead_time_s); });
  };
  TEST_ASSERT_TRUE(is_stable_in_closed_loop(pi_loop(0.97)));
  TEST_ASSERT_FALSE(is_stable_in_closed_loop(pi_loop(1.03)));
  // Three integrators and a double lead are stable only with enough gain: (s + 1)^2 k / s^3 for k > 1/2.
  const auto three = [](double k) {
    return response_of([k](auto s) { return k * (s + 1.0) * (s + 1.0) / (s * s * s); });
  };
  TEST_ASSERT_TRUE(is_stable_in_closed_loop(three(0.52)));
  TEST_ASSERT_FALSE(is_stable_in_closed_loop(three(0.48)));
}

std::string refusal(const PlantConfig& plant, const char *controller) {
  try {
    design_controller(plant, controller_spec(controller), {});
  } catch (const ConfigError& error) {
    return error.what();
  }
  return "";
}

void check_says(const std::string& text, const std::string& part) {
  TEST_ASSERT_TRUE_MESSAGE(text.find(part) != std::string::npos, (part + " in: " + text).c_str());
}

// The number after "give at most".
double advised(const std::string& text) {
  const std::string mark = "give at most ";
  const std::size_t place = text.find(mark);
  TEST_ASSERT_TRUE_MESSAGE(place != std::string::npos, text.c_str());
  return std::atof(text.c_str() + place + mark.size());
}

void test_shipped_plants_are_designed_without_warning() {
  for (const char *name : {"tracker", "paper_simulation"}) {
    const PlantConfig plant = shipped_plant(name);
    for (const ControllerSpec& spec : controller_specs()) {
      TEST_ASSERT_EQUAL_MESSAGE(0, margin_warnings(plant, design_controller(plant, spec, {})).size(), name);
    }
  }
}

void test_a_long_window_with_a_fast_observer_is_refused_and_the_advice_works() {
  PlantConfig plant = shipped_plant("tracker");
  for (DesignConfig& design : plant.design) {
    design.rate_window_ticks = 12;
  }
  TEST_ASSERT_EQUAL_STRING("", refusal(plant, "pi").c_str());
  const std::string text = refusal(plant, "pi_vob_ftc");
  check_says(text, "tracker.toml:");
  check_says(text, ": design.azimuth.observer_bandwidth_hz: 35 makes the speed loop with PI and observer unstable");
  check_says(text, "at an inertia of 3 or 6 kg m2 (inertia_kg_m2 = 3, inertia_swing_kg_m2 = 3)");
  check_says(text, "or fewer rate_window_ticks: 12 of them delay the encoder's rate by 5.5 ms");
  const double max_hz = advised(text);
  for (DesignConfig& design : plant.design) {
    design.observer_bandwidth_hz = max_hz;
  }
  TEST_ASSERT_EQUAL_STRING("", refusal(plant, "pi_vob_ftc").c_str());
  TEST_ASSERT_EQUAL(0, margin_warnings(plant, design_controller(plant, controller_spec("pi_vob_ftc"), {})).size());
}

void test_a_bandwidth_beyond_the_delays_is_named_and_the_advice_works() {
  PlantConfig plant = shipped_plant("tracker");
  plant.design[kPitch].speed_loop_bandwidth_hz = 200.0;  // stable, with little margin
  const std::vector<std::string> warnings = margin_warnings(plant, design_controller(plant, controller_spec("pi"), {}));
  TEST_ASSERT_EQUAL(1, warnings.size());
  check_says(warnings[0], ": design.pitch.speed_loop_bandwidth_hz: leaves the speed loop with PI ");
  check_says(warnings[0], "but 6 dB and 40 deg are required");
  plant.design[kPitch].speed_loop_bandwidth_hz = advised(warnings[0]);
  TEST_ASSERT_EQUAL(0, margin_warnings(plant, design_controller(plant, controller_spec("pi"), {})).size());

  plant.design[kAzimuth].speed_loop_bandwidth_hz = 200.0;  // also at the zenith, where the inertia is half
  TEST_ASSERT_EQUAL_STRING("", refusal(plant, "pi").c_str());
  plant.design[kAzimuth].speed_loop_bandwidth_hz = 300.0;
  check_says(refusal(plant, "pi"), ": design.azimuth.speed_loop_bandwidth_hz: makes the speed loop with PI unstable");
}

void test_a_requirement_as_natural_frequency_is_advised_in_that_key() {
  PlantConfig plant = shipped_plant("paper_simulation");
  plant.design[kAzimuth].speed_loop_natural_frequency_rad_s = 900.0;
  const std::string text = refusal(plant, "pi");
  check_says(text, ": design.azimuth.speed_loop_natural_frequency_rad_s: makes the speed loop with PI unstable");
  plant.design[kAzimuth].speed_loop_natural_frequency_rad_s = advised(text);
  TEST_ASSERT_EQUAL(0, margin_warnings(plant, design_controller(plant, controller_spec("pi"), {})).size());
}

void test_requirements_out_of_the_firmwares_range_name_their_line() {
  PlantConfig plant = shipped_plant("tracker");
  plant.design[kAzimuth].observer_bandwidth_hz = 200.0;
  check_says(refusal(plant, "pi"), ": design.azimuth.observer_bandwidth_hz: is outside the firmware's range at 1 kHz");
  plant = shipped_plant("tracker");
  plant.design[kPitch].current_loop_bandwidth_hz = 3000.0;
  check_says(refusal(plant, "pi"), ": design.pitch.current_loop_bandwidth_hz: is not possible with this motor");
}

// The first two numbers after "give ".
std::array<double, 2> advised_range(const std::string& text) {
  const std::size_t place = text.find("give ");
  TEST_ASSERT_TRUE_MESSAGE(place != std::string::npos, text.c_str());
  char *end = nullptr;
  const double low = std::strtod(text.c_str() + place + 5, &end);
  TEST_ASSERT_EQUAL_STRING_LEN_MESSAGE(" to ", end, 4, text.c_str());
  return {low, std::strtod(end + 4, nullptr)};
}

// Its gains follow the inertia, down to a thousandth.
void test_an_azimuth_without_inertia_at_the_zenith_is_designed() {
  PlantConfig plant = shipped_plant("tracker");
  for (const double inertia_kg_m2 : {1e-2, 1e-3, 1e-5}) {  // with a swing of 3 kg m2
    plant.axis[kAzimuth].inertia_kg_m2 = inertia_kg_m2;
    TEST_ASSERT_EQUAL_STRING("", refusal(plant, "pi_vob_ftc").c_str());
  }
}

void test_an_inertia_that_no_controller_can_turn_is_named_with_the_range_that_works() {
  PlantConfig plant = shipped_plant("tracker");
  plant.axis[kPitch].inertia_kg_m2 = 1e5;
  const std::string text = refusal(plant, "pi_vob_ftc");
  check_says(text, ": pitch.inertia_kg_m2: 1e+05 leads to gains that the firmware refuses (");
  check_says(text, "or design.pitch.speed_loop_bandwidth_hz (now 30) ");
  for (const double inertia_kg_m2 : advised_range(text)) {
    plant.axis[kPitch].inertia_kg_m2 = inertia_kg_m2;
    TEST_ASSERT_EQUAL_STRING("", refusal(plant, "pi_vob_ftc").c_str());
  }
}

void test_two_numbers_that_do_not_go_together_are_both_named() {
  PlantConfig plant = shipped_plant("tracker");
  plant.axis[kAzimuth].motor.torque_constant_nm_a = 1000.0;
  check_says(refusal(plant, "pi"),
             ": azimuth.motor.torque_constant_nm_a: 1000 leads to gains that the firmware refuses (2020:5 Observer "
             "limit is 16000 N m, not within 0 .. 10000)");
  check_says(refusal(plant, "pi"), "azimuth.motor.current_limit_a (now 16) ");
}

void test_the_min_inertia_is_that_of_the_pitch_travel() {
  PlantConfig plant = shipped_plant("tracker");
  CHECK_NEAR("over the zenith", 3.0, min_inertia_kg_m2(plant, kAzimuth), 1e-9);
  CHECK_NEAR("pitch", 2.5, min_inertia_kg_m2(plant, kPitch), 1e-9);
  plant.axis[kPitch].end_stops->upper_rad = 60.0 * kRadPerDeg;
  CHECK_NEAR("up to 60 deg", 3.0 + 3.0 * 0.25, min_inertia_kg_m2(plant, kAzimuth), 1e-9);
  plant.axis[kPitch].end_stops.reset();
  CHECK_NEAR("without stops", 3.0, min_inertia_kg_m2(plant, kAzimuth), 1e-9);
}

// Peak rate error of the sliding axis, twice: early and late. A machine without noise or loads, so that any growth is
// its own.
struct Growth {
  double early_rad_s;
  double late_rad_s;
};

Growth growth_with_observer_of(double bandwidth_hz) {
  PlantConfig plant = bare_plant();
  plant.axis[kAzimuth].encoder.resolution_bits = 32;
  servo_params params = design_controller(plant, controller_spec("pi_vob"), {});
  params.axis[kAzimuth].speed.rate_estimator.window_ticks = 8;
  params.axis[kAzimuth].speed.observer.bandwidth_rad_s = static_cast<float>(2.0 * kPi * bandwidth_hz);
  ScenarioConfig scenario = shipped_scenario("steady_speed");
  scenario.axes = {true, false};
  scenario.duration_s = 4.0;
  const Trace trace = run_scenario({&plant, &scenario, 0.1 * kRadPerDeg, params, 1});
  Growth growth{0.0, 0.0};
  for (const TraceRow& row : trace) {
    const double error = std::abs(row.axis[kAzimuth].rate_rad_s - row.axis[kAzimuth].reference_rad_s);
    double& peak = row.time_s > 3.5 ? growth.late_rad_s : growth.early_rad_s;
    peak = row.time_s > 0.5 ? std::max(peak, error) : peak;
  }
  return growth;
}

// Calculation and machine agree on the stability of a loop.
void test_the_machine_shakes_where_the_calculation_says_so() {
  PlantConfig plant = bare_plant();
  for (AxisConfig& axis : plant.axis) {
    axis.friction.positive.viscous_nm_s_rad = 0.0;  // bare_plant has no friction; the calculation has to know that
    axis.inertia_kg_m2 += axis.inertia_swing_kg_m2;
    axis.inertia_swing_kg_m2 = 0.0;
  }
  speed_loop_params loop = design_controller(plant, controller_spec("pi_vob"), {}).axis[kAzimuth].speed;
  loop.rate_estimator.window_ticks = 8;
  const LinearMachine machine = linear_machine(plant, kAzimuth, false);
  double border_hz = 5.0;
  const auto stable_at = [&](double bandwidth_hz) {
    loop.observer.bandwidth_rad_s = static_cast<float>(2.0 * kPi * bandwidth_hz);
    return is_stable_in_closed_loop(computed_loop_gain(machine, loop, log_space(1e-4, 499.0, 1000)));
  };
  while (stable_at(border_hz)) {
    border_hz *= 1.02;
  }
  LOG_VALUE("border of the observer's bandwidth in Hz", border_hz);
  const Growth below = growth_with_observer_of(border_hz / 1.15);
  const Growth above = growth_with_observer_of(border_hz * 1.15);
  LOG_VALUE("late over early peak below the border", below.late_rad_s / below.early_rad_s);
  LOG_VALUE("late over early peak above the border", above.late_rad_s / above.early_rad_s);
  CHECK_AT_MOST("dies away below", 0.1, below.late_rad_s / below.early_rad_s);
  CHECK_AT_LEAST("lives on above, in deg/s", 0.1, above.late_rad_s / kRadPerDeg);
}

}  // namespace

int main() {
  UNITY_BEGIN();
  RUN_TEST(test_stability_is_judged_as_in_the_textbook);
  RUN_TEST(test_shipped_plants_are_designed_without_warning);
  RUN_TEST(test_a_long_window_with_a_fast_observer_is_refused_and_the_advice_works);
  RUN_TEST(test_a_bandwidth_beyond_the_delays_is_named_and_the_advice_works);
  RUN_TEST(test_a_requirement_as_natural_frequency_is_advised_in_that_key);
  RUN_TEST(test_requirements_out_of_the_firmwares_range_name_their_line);
  RUN_TEST(test_an_azimuth_without_inertia_at_the_zenith_is_designed);
  RUN_TEST(test_an_inertia_that_no_controller_can_turn_is_named_with_the_range_that_works);
  RUN_TEST(test_two_numbers_that_do_not_go_together_are_both_named);
  RUN_TEST(test_the_min_inertia_is_that_of_the_pitch_travel);
  RUN_TEST(test_the_machine_shakes_where_the_calculation_says_so);
  return UNITY_END();
}
