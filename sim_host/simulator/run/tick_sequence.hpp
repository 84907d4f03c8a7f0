// SPDX-License-Identifier: Apache-2.0
// The order of one tick, the same on board and simulator: PWM period 0, the tick, PWM periods 1 to 19.
#ifndef TRACKSERVO_SIM_RUN_TICK_SEQUENCE_HPP
#define TRACKSERVO_SIM_RUN_TICK_SEQUENCE_HPP

#include <cstdint>

#include "base/firmware.hpp"

namespace trackservo::sim {

// `begin_period(period)` provides what the motor stages of this PWM period read, `tick()` is the firmware's 1 ms tick,
// `end_period(period)` does with the duties whatever the machine does.
template <typename BeginPeriod, typename Tick, typename EndPeriod>
void run_tick_sequence(servo_board& board, BeginPeriod begin_period, Tick tick, EndPeriod end_period) {
  for (std::uint32_t period = 0; period < SERVO_PWM_PER_TICK; ++period) {
    begin_period(period);
    servo_board_pwm_period(&board, period);
    if (period == 0) {
      tick();
    }
    end_period(period);
  }
}

}  // namespace trackservo::sim

#endif
