/* SPDX-License-Identifier: Apache-2.0 */
/* Which value of a set of parameters is wrong, and what would be right.
 *
 * A check of a whole set answers with it, so that no caller has to look for the value in the blocks:
 * axis_parameters_check and protection_refusal fill it, object 2070:6 to 9 shows it, tools print it as a sentence. */
#ifndef TRACKSERVO_BASE_REFUSAL_H
#define TRACKSERVO_BASE_REFUSAL_H

#include <stdint.h>

#include "base/status.h"

typedef struct {
  control_status status; /* CONTROL_OK: nothing is wrong, and the rest is 0 */
  uint32_t object;       /* PARAMETER_OBJECT of the wrong value, in azimuth's indices */
  uint32_t bound_by;     /* likewise, of the value that sets the limit which is missed; 0: the limit is fixed */
  float low;             /* smallest and largest value that would be right, all others being as they are */
  float high;
} parameter_refusal;

#define PARAMETER_OBJECT(index, sub) ((uint32_t)(index) << 16 | (uint32_t)(sub) << 8)

#endif
