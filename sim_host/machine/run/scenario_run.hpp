// SPDX-License-Identifier: Apache-2.0
// Runs one case of a scenario that commands speeds, on a machine with the firmware's servo alone. A target is tracked
// by the whole node: device/tracking_run.hpp.
#ifndef TRACKSERVO_SIM_RUN_SCENARIO_RUN_HPP
#define TRACKSERVO_SIM_RUN_SCENARIO_RUN_HPP

#include <cstdint>
#include <string>
#include <vector>

#include "machine/config/plant_config.hpp"
#include "machine/config/scenario_config.hpp"
#include "machine/run/machine.hpp"
#include "machine/run/trace.hpp"

namespace trackservo::sim {

// Returns the commanded speed of a moving axis at a time of the run; `speed_rad_s` is the case.
speed_reference speed_set_point(const ScenarioConfig& scenario, double speed_rad_s, double time_s);

// Returns the scenario's disturbing torque. A disturbance given as a speed is the torque that alone would move the bare
// inertia with that speed: J d(speed)/dt. It is added behind the controller, which does not know it, and passes the
// motor's current loop.
double disturbance_nm(const PlantConfig& plant, const ScenarioConfig& scenario, int axis, double time_s);

// Returns the scenario as it is run: once, or once for each axis that moves if they move one at a time.
std::vector<ScenarioConfig> runs_of(const ScenarioConfig& scenario);

// Puts the trace of one of these runs beside those before it: `trace` is empty, or gets the axes that move in `run`.
void add_run(Trace& trace, const ScenarioConfig& run, Trace of_run);

// Returns the row of a tick: `truth` is the machine's state at the time of its set-points, before the tick.
TraceRow trace_row(double time_s, const TruthState& truth, const Machine& machine,
                   const std::array<double, kAxes>& tracking_error_rad = {});

struct RunRequest {
  const PlantConfig *plant = nullptr;
  const ScenarioConfig *scenario = nullptr;
  double speed_rad_s = 0;  // the case: sine amplitude or step
  servo_params params{};
  std::uint64_t seed = 1;
};

// Runs the whole scenario, 1 row per ms. Throws std::invalid_argument when the firmware refuses the parameters.
Trace run_scenario(const RunRequest& request);

}  // namespace trackservo::sim

#endif
