// SPDX-License-Identifier: Apache-2.0
// Speed of the simulator, and cost of a firmware tick on this host. Prints a measurement; it is not a test.
#ifndef TRACKSERVO_SIM_ANALYSIS_BENCHMARK_HPP
#define TRACKSERVO_SIM_ANALYSIS_BENCHMARK_HPP

#include "machine/config/plant_config.hpp"
#include "machine/config/scenario_config.hpp"

namespace trackservo::sim {

struct BenchmarkFigures {
  double real_time_factor;  // simulated seconds per second of processor time: both axes, full plant, firmware
  double tick_ns;           // servo_app_tick, both axes, everything on
  double pwm_ns;            // motor_stage_step, one axis
  double plant_pwm_ns;      // Tracker::step_pwm with its ADC samples, both axes
};

// Measures processor time, best of `repeats` passes, which reduces the effect of other load, scheduling and cache.
BenchmarkFigures run_benchmark(const PlantConfig& plant, const ScenarioConfig& scenario, int repeats);

}  // namespace trackservo::sim

#endif
