#include "safe_torque.h"

#include "registers/gpio.h"
#include "safe_outputs.h"

enum { STO_A_PIN = 2, STO_B_PIN = 3, AZIMUTH_READBACK_PIN = 1, PITCH_READBACK_PIN = 2 }; /* ports C, C, B, B */

enum { OFF_TICKS = 2, MAX_DIFFER_TICKS = 100, WRONG_TICKS = 3 };

static bool is_high(const gpio_registers *port, uint32_t pin) { return (port->idr & GPIO_SET(pin)) != 0; }

static bool is_set(const gpio_registers *port, uint32_t pin) { return (port->odr & GPIO_SET(pin)) != 0; }

safe_torque_inputs safe_torque_read(void) {
  return (safe_torque_inputs){
      .channel_a = is_high(GPIOC, STO_A_PIN),
      .channel_b = is_high(GPIOC, STO_B_PIN),
      .enable = {is_high(GPIOB, AZIMUTH_READBACK_PIN), is_high(GPIOB, PITCH_READBACK_PIN)},
      .commanded = {is_set(GPIOC, AZIMUTH_ENABLE_PIN), is_set(GPIOC, PITCH_ENABLE_PIN)},
  };
}

static uint32_t count(uint32_t ticks, bool seen, uint32_t most) {
  if (!seen) {
    return 0;
  }
  return ticks < most ? ticks + 1 : most;
}

safe_torque_state safe_torque_step(safe_torque *torque, const safe_torque_inputs *in) {
  bool wrong = false;
  for (int axis = 0; axis < 2; ++axis) {
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
