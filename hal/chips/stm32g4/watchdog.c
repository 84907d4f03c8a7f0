/* SPDX-License-Identifier: Apache-2.0 */
#include "watchdog.h"

#include "clock.h"
#include "registers/iwdg.h"

/* 32 kHz / 4: 8 counts a ms, downwards. */
enum { COUNTS_PER_MS = 8, TIME_OUT_MS = 20, CLOSED_MS = 5, MAX_WAIT_US = 2000 };

static bool wait_until_taken(void) {
  const uint32_t start = clock_cycles();
  /* Bound: MAX_WAIT_US, by the if in it. */
  while ((IWDG->sr & (IWDG_SR_PVU | IWDG_SR_RVU | IWDG_SR_WVU)) != 0) {
    if (clock_cycles() - start > MAX_WAIT_US * CLOCK_CYCLES_PER_US) {
      return false;
    }
  }
  return true;
}

/* RM0440: writing the window reloads the counter. */
bool watchdog_start(void) {
  IWDG->kr = IWDG_KEY_START;
  IWDG->kr = IWDG_KEY_ACCESS;
  IWDG->pr = FIELD_VALUE(IWDG_PR_PR, IWDG_PR_DIV_4);
  IWDG->rlr = FIELD_VALUE(IWDG_RLR_RL, TIME_OUT_MS * COUNTS_PER_MS - 1);
  const bool taken = wait_until_taken();
  IWDG->winr = FIELD_VALUE(IWDG_WINR_WIN, (TIME_OUT_MS - CLOSED_MS) * COUNTS_PER_MS - 1);
  return wait_until_taken() && taken;
}

void watchdog_refresh(void) { IWDG->kr = IWDG_KEY_RELOAD; }
