/* SPDX-License-Identifier: Apache-2.0 */
/* A fault in the HardFault handler: the core locks up. */
#include "probe.h"

void hard_fault(void) {
  note(0xF0);
  __asm volatile("udf 2");
  note(0xF1);
}

void start(void) {
  probe_log.count = 0;
  __asm volatile("udf 1");
  end_of_probe();
}
