// SPDX-License-Identifier: Apache-2.0
// The cost of bandwidth: every controller keeps 6 dB and 40 degrees, and the machine confirms the calculation.
#include <cmath>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "bench.hpp"
#include "design/frequency_measurement.hpp"
#include "studies/margins/margin_study.hpp"
#include "unity.h"

namespace sim = trackservo::sim;

extern "C" void setUp() {}
extern "C" void tearDown() {}

namespace {

sim::PlantConfig plant_named(const char *name) {
  return sim::load_plant(std::string("sim_host/plants/") + name + ".toml");
}

void test_every_controller_keeps_its_margins_sliding_and_at_rest() {
  for (const char *name : {"paper_simulation", "tracker"}) {
    const sim::PlantConfig plant = plant_named(name);
    for (const sim::ControllerSpec& spec : sim::controller_specs()) {
      const servo_params params = sim::design_controller(plant, spec, {});
      for (int axis = 0; axis < sim::kAxes; ++axis) {
        const sim::Margins margins = sim::worst_margins(plant, axis, params.axis[axis].speed);
        TEST_ASSERT_TRUE_MESSAGE(margins.gain_margin_db >= sim::kMinMargins.gain_margin_db, spec.name.c_str());
        TEST_ASSERT_TRUE_MESSAGE(margins.phase_margin_deg >= sim::kMinMargins.phase_margin_deg, spec.name.c_str());
      }
    }
  }
}

void test_speed_loop_of_the_tracker_has_the_30_hz_that_it_claims() {
  const sim::PlantConfig plant = plant_named("tracker");
  const servo_params params = sim::design_controller(plant, sim::controller_spec("pi"), {});
  for (int axis = 0; axis < sim::kAxes; ++axis) {
    const sim::LinearMachine machine = sim::linear_machine(plant, axis, false);
    TEST_ASSERT_DOUBLE_WITHIN(0.3, 30.0, sim::closed_loop_bandwidth_hz(machine, params.axis[axis].speed));
  }
}

// Multisine torque on the sliding azimuth axis, all noise on; computed and measured loop gain side by side.
void test_measured_loop_gain_agrees_with_the_computed_one() {
  const sim::PlantConfig plant = plant_named("tracker");
  sim::MeasurementRequest request;
  request.plant = &plant;
  request.params = sim::design_controller(plant, sim::controller_spec("pi_vob_ftc"), {});
  request.bias_rate_rad_s = 2.0 * bench::kRadPerDeg;
  request.torque_rms_nm = 6.0;
  request.first_hz = 12.0;
  request.last_hz = 300.0;
  const sim::FrequencyResponse measured = sim::measured_loop_gain(request);
  const sim::LinearMachine machine = sim::linear_machine(plant, sim::kAzimuth, false);
  const sim::FrequencyResponse computed =
      sim::computed_loop_gain(machine, request.params.axis[sim::kAzimuth].speed, measured.frequency_hz);
  for (std::size_t i = 0; i < measured.frequency_hz.size(); ++i) {
    const std::complex<double> ratio = measured.loop_gain[i] / computed.loop_gain[i];
    TEST_ASSERT_DOUBLE_WITHIN(1.5, 0.0, 20.0 * std::log10(std::abs(ratio)));
    TEST_ASSERT_DOUBLE_WITHIN(10.0, 0.0, std::arg(ratio) * sim::kDegPerRad);
  }
  const sim::Margins by_machine = sim::margins_of(measured);
  const sim::Margins by_equations = sim::margins_of(computed);
  TEST_ASSERT_DOUBLE_WITHIN(1.0, by_equations.gain_margin_db, by_machine.gain_margin_db);
  TEST_ASSERT_DOUBLE_WITHIN(4.0, by_equations.phase_margin_deg, by_machine.phase_margin_deg);
}

// The slow loop of the paper's simulation crosses -180 deg at a hundred times its crossover: the band must extend to
// it.
void test_measured_band_reaches_the_gain_margin_of_the_slow_loop() {
  const std::vector<sim::PlantConfig> plants{plant_named("paper_simulation")};
  const std::filesystem::path folder = std::filesystem::temp_directory_path() / "trackservo_test_margins";
  std::filesystem::create_directories(folder / "margins");
  for (const sim::MarginJob& job : sim::margin_jobs_of(plants, {}, {})) {
    if (job.axis == sim::kAzimuth && !job.pre_sliding && (job.controller == "pi" || job.controller == "pi_vob_ftc")) {
      const sim::MarginRecord record = sim::run_margin_job(job, folder);
      TEST_ASSERT_DOUBLE_WITHIN(1.5, record.computed.gain_margin_db, record.measured.gain_margin_db);
      TEST_ASSERT_DOUBLE_WITHIN(2.0, record.computed.phase_margin_deg, record.measured.phase_margin_deg);
    }
  }
  std::filesystem::remove_all(folder);
}

void test_every_study_has_its_best_pi_among_the_margins() {
  const std::vector<sim::PlantConfig> plants{plant_named("tracker")};
  const std::vector<sim::Study> studies = {bench::study("tracking", "tracker"),
                                           bench::study("steady_speed", "tracker")};
  const std::map<std::string, sim::PiRequirement> best_pi{{sim::study_name(studies[0]), {100.0, 1.0, 1.0}},
                                                          {sim::study_name(studies[1]), {200.0, 0.9, 1.0}}};
  int found = 0;
  for (const sim::MarginJob& job : sim::margin_jobs_of(plants, studies, best_pi)) {
    if (job.controller == "pi_best") {
      TEST_ASSERT_DOUBLE_WITHIN(0.0, best_pi.at(job.study).natural_frequency_rad_s,
                                job.pi.value().natural_frequency_rad_s);
      ++found;
    }
  }
  TEST_ASSERT_EQUAL_INT(2 * sim::kAxes * 2, found);  // studies, axes, sliding and pre-sliding
}

// A pure integrator under proportional control with a dead time has simple analytic margins: crossover w = k, phase
// margin 90 deg - w T, gain margin pi / (2 k T).
void test_margins_of_an_integrator_with_dead_time_are_the_textbook_ones() {
  const double gain_rad_s = 100.0;
  const double dead_time_s = 4e-3;
  sim::FrequencyResponse response;
  response.frequency_hz = sim::log_space(0.5, 400.0, 4000);
  for (const double f_hz : response.frequency_hz) {
    const std::complex<double> s(0.0, 2.0 * sim::kPi * f_hz);
    response.loop_gain.push_back(gain_rad_s / s * std::exp(-s * dead_time_s));
  }
  const sim::Margins margins = sim::margins_of(response);
  TEST_ASSERT_DOUBLE_WITHIN(0.05, gain_rad_s / (2.0 * sim::kPi), margins.crossover_hz);
  TEST_ASSERT_DOUBLE_WITHIN(0.1, 90.0 - gain_rad_s * dead_time_s * sim::kDegPerRad, margins.phase_margin_deg);
  TEST_ASSERT_DOUBLE_WITHIN(0.05, 20.0 * std::log10(sim::kPi / (2.0 * gain_rad_s * dead_time_s)),
                            margins.gain_margin_db);
  TEST_ASSERT_DOUBLE_WITHIN(0.1, 1.0 / (4.0 * dead_time_s), margins.phase_crossover_hz);
}

}  // namespace

int main() {
  UNITY_BEGIN();
  RUN_TEST(test_every_controller_keeps_its_margins_sliding_and_at_rest);
  RUN_TEST(test_speed_loop_of_the_tracker_has_the_30_hz_that_it_claims);
  RUN_TEST(test_measured_loop_gain_agrees_with_the_computed_one);
  RUN_TEST(test_measured_band_reaches_the_gain_margin_of_the_slow_loop);
  RUN_TEST(test_every_study_has_its_best_pi_among_the_margins);
  RUN_TEST(test_margins_of_an_integrator_with_dead_time_are_the_textbook_ones);
  return UNITY_END();
}
