// Every breakage in every motion at random moments on both axes, and whether the firmware keeps what it promises.
#ifndef TRACKSERVO_SIM_FAULT_INJECTION_FAULT_MATRIX_HPP
#define TRACKSERVO_SIM_FAULT_INJECTION_FAULT_MATRIX_HPP

#include <map>
#include <string>
#include <vector>

#include "base/job_pool.hpp"
#include "fault_injection/trial.hpp"

namespace trackservo::sim {

struct MatrixOptions {
  int moments = 20;  // random ones, of each breakage in each motion on each axis; every other one in calm air
  std::uint64_t seed = 1;
  int threads = usable_threads();
};

// All trials of one breakage.
struct MatrixRow {
  const Breakage *breakage = nullptr;
  int trials = 0;
  int showed = 0;
  int seen = 0;
  std::map<fault_id, int> taken_for;
  std::map<Motion, int> hidden;  // trials in which there was nothing to be seen
  int worst_latency_ms = 0;
  double worst_overshoot_rad_s = 0;
  double worst_travel_rad = 0;  // in calm air
  double worst_travel_in_wind_rad = 0;
  double worst_travel_share = 0;        // of what is promised
  std::vector<std::string> complaints;  // one per trial that broke a promise
};

std::vector<MatrixRow> run_fault_matrix(const PlantConfig& plant, const MatrixOptions& options);

// A table for people, and the complaints below it.
std::string print_fault_matrix(const std::vector<MatrixRow>& rows);

bool all_promises_kept(const std::vector<MatrixRow>& rows);

}  // namespace trackservo::sim

#endif
