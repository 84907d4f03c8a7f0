/* SPDX-License-Identifier: Apache-2.0 */
/* The base's rates, as an inertial sensor of the vehicle or ship sends them, and what they add to the inertial rate of
 * an axis whose own sensors do not see all that moves the line of sight.
 *
 * With the rates x (about the axis ahead), y (to the left) and z (up) of the base, azimuth psi and pitch theta, the
 * base turns the azimuth stage about its own axes by
 *
 *     ahead = cos(psi) x + sin(psi) y,   left = cos(psi) y - sin(psi) x,   z
 *
 * What an axis lacks, by the sensors whose rate it feeds back:
 *
 *                no gyro                  gyro on the stage or below it    gyro on the line of sight
 *     azimuth    z - tan(theta) ahead     -tan(theta) ahead                0
 *     pitch      -left                    0                                0
 *
 * The azimuth must turn by tan(theta) ahead to keep the picture where it is. Near the zenith no azimuth can, and the
 * tangent fades out as the gain of a gyro on the line of sight does (control/speed_loop.h).
 *
 * Between messages each rate follows a straight line, found by an alpha-beta filter with two equal poles:
 *
 *     e = measured - (rate + slope T),   k = 1 / (1 + w T),   rate += slope T + (1 - k^2) e,   slope += (1 - k)^2 e / T
 *
 * A sine of frequency v comes out with an error of (v / w)^2. */
#ifndef TRACKSERVO_SERVO_BASE_RATES_H
#define TRACKSERVO_SERVO_BASE_RATES_H

#include <stdbool.h>
#include <stdint.h>

#include "base/rotation.h"
#include "servo/servo_axis.h"

/* In the base's frame: ahead, to the left, up. */
typedef struct {
  float x;
  float y;
  float z;
} base_vector;

/* From the bus (0x3076). */
typedef struct {
  int16_t x;
  int16_t y;
  int16_t z;
  uint8_t counter; /* one more with each message */
} base_rates_message;

enum { BASE_RATE_NOT_MEASURED = INT16_MIN, BASE_TIMES_PER_TICK = 100 };

/* Of a message that does not count (0x3078:4). */
typedef enum {
  BASE_RATES_TAKEN = 0,
  BASE_RATES_REPEATED,     /* the counter of the last message */
  BASE_RATES_IMPOSSIBLE,   /* a rate above 3077:4 */
  BASE_RATES_NOT_MEASURED, /* a rate is BASE_RATE_NOT_MEASURED */
  BASE_RATES_REPLACED      /* another one came before it was taken */
} base_rates_drop;

/* 0x3077; ranges: node/objects/base_objects.c. */
typedef struct {
  uint8_t use;           /* 0 or 1 */
  float scale_rad_s;     /* of one count */
  uint16_t delay;        /* from the measurement to the arrival of its message, 10 us */
  float largest_rad_s;   /* of a message that counts */
  float bandwidth_rad_s; /* w */
  uint16_t timeout_ms;   /* after the last message */
} base_rates_params;

typedef struct {
  bool known;             /* a message has counted since the reset */
  bool ended;             /* the last message is older than 3077:6 */
  bool heard;             /* `counter` is that of a message */
  uint8_t counter;        /* of the last message */
  uint32_t arrived_tick;  /* of the last message that counted */
  base_vector rate_rad_s; /* at the time of its measurement */
  base_vector slope_rad_s2;
} base_rates;

/* Forgets all messages. */
void base_rates_reset(base_rates *self);

/* Takes a message that has arrived before tick `tick`. Returns whether it counts; if it does not, nothing but its
 * counter is kept. */
base_rates_drop base_rates_take(base_rates *self, const base_rates_params *params, const base_rates_message *message,
                                uint32_t tick);

/* Notices that the messages have ended: until another one counts they stay so, also when the ticks begin anew. Call at
 * least once in 2^31 ticks. */
void base_rates_age(base_rates *self, const base_rates_params *params, uint32_t tick);

/* Returns whether a message that counts has arrived within 3077:6. */
bool base_rates_are_fresh(const base_rates *self, const base_rates_params *params, uint32_t tick);

/* Returns the rates in a tick. The straight line ends BASE_RATES_AHEAD_S after the measurement of the last message,
 * and no rate is above 3077:4. */
base_vector base_rates_at(const base_rates *self, const base_rates_params *params, uint32_t tick);

#define BASE_RATES_AHEAD_S 0.05f

/* Return what these rates add to the inertial rate of the axis. */
float base_rates_of_azimuth(const servo_axis_params *azimuth, base_vector rate_rad_s, rotation psi, rotation theta);
float base_rates_of_pitch(const servo_axis_params *pitch, base_vector rate_rad_s, rotation psi);

#endif
