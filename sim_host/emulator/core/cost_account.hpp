// SPDX-License-Identifier: Apache-2.0
// Cost of each activation of an exception handler, without the handlers that preempt it.
#ifndef TRACKSERVO_SIM_EMULATOR_CORE_COST_ACCOUNT_HPP
#define TRACKSERVO_SIM_EMULATOR_CORE_COST_ACCOUNT_HPP

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <map>
#include <vector>

namespace trackservo::target {

struct Cost {
  std::uint64_t instructions = 0;
  std::uint64_t cycles = 0;  // with entry and return
};

class CostAccount {
 public:
  void charge(std::uint32_t instructions, std::uint32_t cycles) {
    Cost& cost = running_.empty() ? thread_ : running_.back();
    cost.instructions += instructions;
    cost.cycles += cycles;
  }

  void enter() { running_.emplace_back(); }

  void leave(int exception) {
    if (!running_.empty()) {
      finished_[exception].push_back(running_.back());
      running_.pop_back();
    }
  }

  // Clears the counts, not the running handlers.
  void clear() {
    finished_.clear();
    thread_ = {};
  }
  void drop_running() { running_.clear(); }

  const Cost& thread() const { return thread_; }
  const std::map<int, std::vector<Cost>>& finished() const { return finished_; }

 private:
  std::vector<Cost> running_;
  std::map<int, std::vector<Cost>> finished_;
  Cost thread_;
};

// Typical (median) and worst of many.
struct CostSummary {
  std::size_t count = 0;
  Cost typical;
  Cost worst;
  Cost sum;
};

inline CostSummary summary_of(const std::vector<Cost>& costs) {
  CostSummary summary;
  summary.count = costs.size();
  if (costs.empty()) {
    return summary;
  }
  std::vector<std::uint64_t> instructions;
  std::vector<std::uint64_t> cycles;
  for (const Cost& cost : costs) {
    instructions.push_back(cost.instructions);
    cycles.push_back(cost.cycles);
    summary.sum.instructions += cost.instructions;
    summary.sum.cycles += cost.cycles;
  }
  std::sort(instructions.begin(), instructions.end());
  std::sort(cycles.begin(), cycles.end());
  summary.typical = {instructions[costs.size() / 2], cycles[costs.size() / 2]};
  summary.worst = {instructions.back(), cycles.back()};
  return summary;
}

}  // namespace trackservo::target

#endif
