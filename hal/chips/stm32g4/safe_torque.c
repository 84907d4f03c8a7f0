/* SPDX-License-Identifier: Apache-2.0 */
#include "safe_torque.h"

#include "connections.h"

enum { OFF_TICKS = 2, MAX_DIFFER_TICKS = 100, WRONG_TICKS = 3 };

static uint32_t count(uint32_t ticks, bool seen, uint32_t most) {
  if (!seen) {
    return 0;
  }
  return ticks < most ? ticks + 1 : most;
}

safe_torque_state safe_torque_step(safe_torque *torque, const safe_torque_inputs *in) {
  bool wrong = false;
  for (int axis = 0; axis < BOARD_AXES; ++axis) {
    wrong = wrong || in->enable[axis] != (in->commanded[axis] && in->channel_a);
  }
  torque->off_ticks = count(torque->off_ticks, !in->channel_a || !in->channel_b, OFF_TICKS);
  torque->differ_ticks = count(torque->differ_ticks, in->channel_a != in->channel_b, MAX_DIFFER_TICKS + 1);
  torque->wrong_ticks = count(torque->wrong_ticks, wrong, WRONG_TICKS);
  if (torque->differ_ticks > MAX_DIFFER_TICKS || torque->wrong_ticks >= WRONG_TICKS) {
    torque->faulty = true;
    torque->both_were_low = false;
  } else if (torque->faulty && !in->channel_a && !in->channel_b) {
    torque->both_were_low = true;
  } else if (torque->both_were_low && in->channel_a && in->channel_b) {
    torque->faulty = false;
    torque->both_were_low = false;
  }
  if (torque->faulty) {
    return SAFE_TORQUE_FAULT;
  }
  return torque->off_ticks >= OFF_TICKS ? SAFE_TORQUE_OFF : SAFE_TORQUE_ON;
}
