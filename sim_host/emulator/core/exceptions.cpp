// SPDX-License-Identifier: Apache-2.0
#include "core/exceptions.hpp"

#include <algorithm>

namespace trackservo::target {

void Exceptions::reset() {
  pending_.reset();
  active_.reset();
  enabled_.reset();
  for (int exception = 0; exception < kFirstInterrupt; ++exception) {
    enabled_[index(exception)] = true;
  }
  priority_.fill(0);
  line_.fill(0);
  nesting_.clear();
  prigroup_ = 0;
  decide();
}

void Exceptions::set(Bits& bits, int exception, bool value) {
  bits[index(exception)] = value;
  decide();
}

void Exceptions::set_priority(int exception, std::uint8_t priority) {
  priority_[index(exception)] = priority & 0xF0U;
  decide();
}

void Exceptions::set_priority_grouping(unsigned prigroup) {
  prigroup_ = prigroup & 7U;
  decide();
}

void Exceptions::raise_line(int interrupt) {
  const int exception = kFirstInterrupt + interrupt;
  if (line_[index(exception)]++ == 0) {
    pend(exception);
  }
}

void Exceptions::lower_line(int interrupt) { --line_[index(kFirstInterrupt + interrupt)]; }

int Exceptions::group_priority(int exception) const {
  switch (exception) {
    case kNmi:
      return -2;
    case kHardFault:
      return -1;
    default:
      return priority_[index(exception)] & ~((2 << prigroup_) - 1);
  }
}

int Exceptions::active_priority() const {
  int priority = kLowest;
  for (const int exception : nesting_) {
    priority = std::min(priority, group_priority(exception));
  }
  return priority;
}

int Exceptions::execution_priority(bool primask, bool faultmask, std::uint8_t basepri) const {
  int priority = active_priority();
  if (basepri != 0) {
    priority = std::min(priority, basepri & ~((2 << prigroup_) - 1));
  }
  if (primask) {
    priority = std::min(priority, 0);
  }
  if (faultmask) {
    priority = std::min(priority, -1);
  }
  return priority;
}

bool Exceptions::can_run(int exception, bool primask, bool faultmask, std::uint8_t basepri) const {
  return exception != kThread && group_priority(exception) < execution_priority(primask, faultmask, basepri);
}

// Of several waiting exceptions, the highest priority including its sub-priority, then the lowest number.
void Exceptions::decide() {
  const Bits waiting = pending_ & enabled_;
  next_ = kThread;
  attention_ = false;
  if (waiting.none()) {
    return;
  }
  int best = kLowest;
  for (int exception = kNmi; exception < kCount; ++exception) {
    if (waiting[index(exception)]) {
      const int priority = exception <= kHardFault ? exception - 4 : priority_[index(exception)];
      if (priority < best) {
        best = priority;
        next_ = exception;
      }
    }
  }
  attention_ = group_priority(next_) < active_priority();
}

void Exceptions::enter(int exception) {
  pending_[index(exception)] = false;
  active_[index(exception)] = true;
  nesting_.push_back(exception);
  decide();
}

void Exceptions::leave(int exception) {
  active_[index(exception)] = false;
  nesting_.erase(std::remove(nesting_.begin(), nesting_.end(), exception), nesting_.end());
  if (line_[index(exception)] > 0) {
    pending_[index(exception)] = true;
  }
  decide();
}

}  // namespace trackservo::target
