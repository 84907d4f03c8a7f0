/* What a check of parameters answers.
 *
 * Parameters are checked once, when they are set, never in the tick. A block that is given parameters
 * that its `*_check` accepts and finite inputs never returns a value that is not finite. */
#ifndef TRACKSERVO_CONTROL_STATUS_H
#define TRACKSERVO_CONTROL_STATUS_H

typedef enum {
  CONTROL_OK = 0,
  CONTROL_NOT_FINITE,   /* a value is NaN or infinite */
  CONTROL_OUT_OF_RANGE, /* a value is outside the range that the header states */
  CONTROL_INCONSISTENT  /* values are each in range but contradict each other, e.g. Ts < Tc */
} control_status;

#endif
