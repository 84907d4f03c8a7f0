// SPDX-License-Identifier: Apache-2.0
// Known attacks by legal writes, each on both axes and towards both ends of the travel.
#ifndef TRACKSERVO_SIM_ATTACK_NAMED_SEQUENCES_HPP
#define TRACKSERVO_SIM_ATTACK_NAMED_SEQUENCES_HPP

#include <functional>
#include <limits>
#include <string>
#include <vector>

#include "judge/attack/attack_run.hpp"

namespace trackservo::sim {

// Where the axis is and what it does when the writes come.
enum class Approach {
  kTowardsEnd,      // fast, at a distance from the hard limit
  kStandstill,      // at rest in the middle of the travel
  kBeyondHalfTurn,  // started where a single-turn encoder reports another turn; then it moves outwards
};

struct NamedSequence {
  std::string name;
  bool harmless = true;  // with the present firmware
  Approach approach = Approach::kTowardsEnd;
  std::int8_t mode = DRIVE_PROFILE_VELOCITY;
  double rate_rad_s = 1.4;
  double distance_rad = 0.3;                                        // to the hard limit: kTowardsEnd
  double angle_rad = 0;                                             // at the start: kBeyondHalfTurn
  double seconds = 4;                                               // from the writes to the end of the run
  double max_rate_rad_s = std::numeric_limits<double>::infinity();  // of the joint, after the writes
  bool rests_at_end = false;                                        // required
  bool silent = false;                                              // no frame from the master after the writes
  bool heartbeats = false;                                          // of a master, until the writes
  fault_id reports = FAULT_NONE;                                    // each run must, first; none: any or no fault
  bool wide = false;                                                // the travel of the plant file: kTowardsEnd
  bool frames_stop = false;  // mode -1: no frame from the camera after the writes
  bool early = false;        // the writes come before the axis is enabled
  double across_rad = 0;     // mode -1: the target is so far to the side in the picture
  // Writes of the axis, in this order; `direction` is 1 or -1.
  std::function<std::vector<SdoWrite>(const DrivenNode&, int axis, double direction)> writes;
};

const std::vector<NamedSequence>& named_sequences();

// The worst run of a sequence.
struct SequenceResult {
  const NamedSequence *sequence = nullptr;
  Harm harm;
  bool harmless = true;
  double max_contact_rad_s = 0;
  double max_torque_nm = 0;
  double max_rate_rad_s = 0;  // after the writes
  double max_travel_rad = 0;  // from the writes to the end of the run
  double last_fault_s = 0;    // from the writes to the fault, of the slowest run; 0: no run had one
  std::vector<int> faults;    // that the runs ended with, in rising order
  int runs = 0;
};

std::vector<SequenceResult> run_named_sequences(const AttackBench& bench, int threads);

// Returns a log of the run that does most harm.
std::string replay(const AttackBench& bench, const NamedSequence& sequence);

// Throws std::invalid_argument that lists the names.
const NamedSequence& named_sequence(const std::string& name);

std::string print(const std::vector<SequenceResult>& results);

}  // namespace trackservo::sim

#endif
