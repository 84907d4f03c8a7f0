// SPDX-License-Identifier: Apache-2.0
// One source of an interrupt: a level that a peripheral holds until the cause is cleared.
#ifndef TRACKSERVO_SIM_EMULATOR_CORE_IRQ_LINE_HPP
#define TRACKSERVO_SIM_EMULATOR_CORE_IRQ_LINE_HPP

#include "core/exceptions.hpp"

namespace trackservo::target {

class IrqLine {
 public:
  IrqLine(Exceptions& exceptions, int interrupt) : exceptions_(exceptions), interrupt_(interrupt) {}

  void set(bool level) {
    if (level != level_) {
      level_ = level;
      if (level) {
        exceptions_.raise_line(interrupt_);
      } else {
        exceptions_.lower_line(interrupt_);
      }
    }
  }

  // Forgets the level. Call after Exceptions::reset(), which has dropped all lines.
  void forget() { level_ = false; }

 private:
  Exceptions& exceptions_;
  int interrupt_;
  bool level_ = false;
};

}  // namespace trackservo::target

#endif
