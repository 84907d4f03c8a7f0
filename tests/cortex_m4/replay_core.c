/* SPDX-License-Identifier: Apache-2.0 */
/* replay_core TRACE [NAME]: see core_replay.h. Ends with 1 unless all bits are the same. */
#include <limits.h>
#include <stdio.h>

#include "cortex_m4/core_replay.h"

int main(int argc, char **argv) {
  if (argc < 2) {
    printf("no trace is given\n");
    return 2;
  }
  return core_replay(argv[1], argc > 2 ? argv[2] : NULL, LONG_MAX) ? 0 : 1;
}
