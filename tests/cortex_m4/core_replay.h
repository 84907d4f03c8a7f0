/* Gives the servo core what record_core has recorded on another machine, and compares what comes out bit for bit. */
#ifndef TRACKSERVO_TESTS_CORTEX_M4_CORE_REPLAY_H
#define TRACKSERVO_TESTS_CORTEX_M4_CORE_REPLAY_H

#include <stdbool.h>

/* False when a word came out different, or the trace cannot be read to its end; what it was is printed. `changed`, as
 * core_trace.c names the words ("pi->proportional_gain"), changes the last bit of the first parameter of that name:
 * proof that one unit of the last place is seen. NULL changes nothing. At most `most_ticks` are replayed. */
bool core_replay(const char *path, const char *changed, long most_ticks);

#endif
