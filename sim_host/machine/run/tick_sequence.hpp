// SPDX-License-Identifier: Apache-2.0
// The order of one tick, the same on board and simulator: PWM period 0, the tick, PWM periods 1 to 19.
#ifndef TRACKSERVO_SIM_RUN_TICK_SEQUENCE_HPP
#define TRACKSERVO_SIM_RUN_TICK_SEQUENCE_HPP

#include <cstdint>

#include "machine/base/firmware.hpp"

namespace trackservo::sim {

// One PWM period of the sequence. `begin_period(period)` provides what the motor stages of this PWM period read,
// `tick()` is the firmware's 1 ms tick, `end_period(period)` does with the duties whatever the machine does.
template <typename BeginPeriod, typename Tick, typename EndPeriod>
void run_pwm_period(servo_board& board, std::uint32_t period, const BeginPeriod& begin_period, const Tick& tick,
                    const EndPeriod& end_period) {
  begin_period(period);
  servo_board_pwm_period(&board, period);
  if (period == 0) {
    tick();
  }
  end_period(period);
}

// The whole sequence.
template <typename BeginPeriod, typename Tick, typename EndPeriod>
void run_tick_sequence(servo_board& board, const BeginPeriod& begin_period, const Tick& tick,
                       const EndPeriod& end_period) {
  for (std::uint32_t period = 0; period < SERVO_PWM_PER_TICK; ++period) {
    run_pwm_period(board, period, begin_period, tick, end_period);
  }
}

}  // namespace trackservo::sim

#endif
