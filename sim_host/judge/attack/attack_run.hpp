// SPDX-License-Identifier: Apache-2.0
// One attacked machine: a master moves both axes and writes legal values, and the run reports the harm that this did.
#ifndef TRACKSERVO_SIM_ATTACK_ATTACK_RUN_HPP
#define TRACKSERVO_SIM_ATTACK_ATTACK_RUN_HPP

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "judge/attack/motion_judge.hpp"
#include "judge/attack/random_master.hpp"

namespace trackservo::sim {

// The machines under attack, and what may be written to them. Expensive, so it is made once for many runs.
class AttackBench {
 public:
  explicit AttackBench(const PlantConfig& plant);

  // Returns the setup as the plant file says.
  const NodeSetup& shipped() const { return shipped_; }
  // Returns the setup with end stops of azimuth within half a turn, so that a start near them is within reach of its
  // single-turn encoder.
  const NodeSetup& narrow() const { return narrow_; }
  const WritableObjects& objects() const { return *objects_; }

 private:
  NodeSetup shipped_;
  NodeSetup narrow_;
  std::unique_ptr<WritableObjects> objects_;
};

struct AttackResult {
  std::uint64_t seed = 0;
  Theme theme = Theme::kEverything;
  bool narrow = false;
  Harm harm;
  bool answers = true;  // to a read of 1000 at the end, after NMT start
  int writes = 0;
  int refusals = 0;

  bool harmless() const { return !harm.hits_hard() && !harm.runs_away() && !harm.not_finite && answers; }
};

constexpr double kWrites_s = 5.0;  // random writes
constexpr double kAfter_s = 1.0;   // and then none, while their effects last

// Runs one attack. Equal seeds give equal runs, bit by bit. With a log, every frame and every event of the axes is in
// it.
AttackResult run_attack(const AttackBench& bench, std::uint64_t seed, EventLog *log = nullptr);

// Returns what an attack did, in one line: "azimuth reaches an end stop at 12.0 deg/s after 1.234 s".
std::string describe(const Harm& harm, bool answers);

// Says in a log what the axes do: power states, faults, contacts with end stops.
class EventReporter {
 public:
  explicit EventReporter(EventLog *log) : log_(log) {}
  void look(const DrivenNode& node, const Harm& harm, double time_s);

 private:
  EventLog *log_;
  std::array<int, kAxes> power_{};
  std::array<int, kAxes> fault_{};
  std::array<int, kAxes> contacts_{};
  std::array<int, kAxes> tracking_{};
};

}  // namespace trackservo::sim

#endif
