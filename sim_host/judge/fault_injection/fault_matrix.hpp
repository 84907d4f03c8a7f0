// SPDX-License-Identifier: Apache-2.0
// Every fault injection in every motion at random instants on both axes, and whether the firmware meets its
// requirements.
#ifndef TRACKSERVO_SIM_FAULT_INJECTION_FAULT_MATRIX_HPP
#define TRACKSERVO_SIM_FAULT_INJECTION_FAULT_MATRIX_HPP

#include <map>
#include <string>
#include <vector>

#include "judge/fault_injection/injection_run.hpp"
#include "machine/base/job_pool.hpp"

namespace trackservo::sim {

struct MatrixOptions {
  int moments = 20;  // random ones, of each injection in each motion on each axis; every other one in calm air
  std::uint64_t seed = 1;
  int threads = usable_threads();
  std::vector<std::string> only;  // names of injections; empty: all
};

// All runs of one injection.
struct MatrixRow {
  const FaultInjection *fault_injection = nullptr;
  int injection_runs = 0;
  int showed = 0;
  int seen = 0;
  int later_faults = 0;  // second and third faults that met every requirement
  std::map<fault_id, int> taken_for;
  std::map<Motion, int> hidden;  // runs in which the fault could not be detected
  int worst_latency_ms = 0;
  double worst_overshoot_rad_s = 0;
  double worst_travel_rad = 0;  // in calm air
  double worst_travel_in_wind_rad = 0;
  double worst_travel_share = 0;   // of the allowed value
  double worst_deviation_rad = 0;  // from where the set-point led, until the detection or the end of the run
  double worst_speed_rad_s = 0;
  std::vector<std::string> errors;  // one per run that violated a requirement
};

std::vector<MatrixRow> run_fault_matrix(const PlantConfig& plant, const MatrixOptions& options);

// Returns a table for people, and the violations below it.
std::string print_fault_matrix(const std::vector<MatrixRow>& rows);

// Returns false for an injection that meets its requirements, although its row says otherwise, or the other way round.
bool is_as_stated(const MatrixRow& row);

bool all_promises_kept(const std::vector<MatrixRow>& rows);

}  // namespace trackservo::sim

#endif
