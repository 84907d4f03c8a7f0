/* SPDX-License-Identifier: Apache-2.0 */
/* Passes to the servo core what record_core has recorded on another machine, and compares the results bit for bit. */
#ifndef TRACKSERVO_TESTS_CORTEX_M4_CORE_REPLAY_H
#define TRACKSERVO_TESTS_CORTEX_M4_CORE_REPLAY_H

#include <stdbool.h>

/* Returns false when a word differs, or the trace cannot be read to its end; the difference is printed. `changed`, a
 * name of core_trace.c ("pi->proportional_gain"), changes the last bit of the first parameter of that name: it proves
 * that one unit of the last place is detected. NULL changes nothing. At most `max_ticks` are replayed. */
bool core_replay(const char *path, const char *changed, long max_ticks);

#endif
