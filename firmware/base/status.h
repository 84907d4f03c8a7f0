/* SPDX-License-Identifier: Apache-2.0 */
/* Result of a parameter check.
 *
 * Parameters are checked once, when they are set, never in the tick. With parameters that its `*_check` accepts and
 * finite inputs, a block never returns a value that is not finite. */
#ifndef TRACKSERVO_BASE_STATUS_H
#define TRACKSERVO_BASE_STATUS_H

typedef enum {
  CONTROL_OK = 0,
  CONTROL_NOT_FINITE,   /* a value is NaN or infinite */
  CONTROL_OUT_OF_RANGE, /* a value is outside the range that the header states */
  CONTROL_INCONSISTENT, /* each value is in range, but some contradict each other, e.g. Ts < Tc */
  CONTROL_UNSTABLE /* the loops would be unstable on the identified plant, or close to it; or a feedforward is beyond
                      plant or motor */
} control_status;

#endif
