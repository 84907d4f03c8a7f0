/* SPDX-License-Identifier: Apache-2.0 */
/* The envelope of one axis: how fast it may be towards each end of its hard travel, and the braking that keeps it so.
 *
 *     allowed    T v + (1.03 v)^2 / (2 a) <= distance to the end of the hard travel in the direction of v
 *     braking    current = -full current * clamp(v / (a Ts) + (x - x0) / (a Ts Th), -1, 1)
 *
 * a (2060:19) is the deceleration that the full motor current gives in every case. v is the joint rate from the encoder
 * alone, over two ticks, moved 3.5 ms ahead by its last change when that makes it faster. T = 4 ms covers sampling, the
 * tick, the hand-over of the set-point and the reversal of the current. x0 is the position at which the current first
 * leaves its limit; from there the braking holds the axis. Nothing here depends on a gain, a filter, a ramp, a torque
 * limit or the mode: only on 2060 and on the current limit (2055), which are guarded.
 *
 * Why the axis stops in time. In the tick before the first one that is not allowed, the stop from there still ended
 * before the end. Until the braking has its full current at most T passes. The motion in this time is T v; the gain in
 * rate is in v, because it was extrapolated, or is below 3 %. While |v| > a Ts the current is full, so by the meaning
 * of a the rate falls by at least a: the distance is at most v^2 / (2 a). Below a Ts the deceleration falls with v.
 * With a disturbance of the share d of the motor's torque, the axis then moves by at most a Ts^2 and creeps at d a Ts
 * until the hold has taken the disturbance: d a Ts Th. firmware/protection/tests/test_envelope.c integrates all of that
 * on a grid.
 *
 * Also: the axis must follow each stop that a fault or a stop command ordered, and must follow this braking. A machine
 * whose position is not known, or which has no valid travel, is limited to ENVELOPE_SLOW_RAD_S everywhere. Below
 * 0.03 rad/s nothing is too fast: FAULT_BEYOND_TRAVEL limits how far such an axis goes outwards.
 *
 * The envelope brakes an axis that has power, and one that still turns since it had power. Never one that came to rest
 * without power, whoever moves it. Cost: about 90 instructions per tick. */
#ifndef TRACKSERVO_PROTECTION_ENVELOPE_H
#define TRACKSERVO_PROTECTION_ENVELOPE_H

#include <stdbool.h>
#include <stdint.h>

#include "base/angle.h"

/* 5 degrees per second: an end stop bears a contact at this speed. */
#define ENVELOPE_SLOW_RAD_S 0.0872664626f

enum { ENVELOPE_ANGLES = 5 }; /* consecutive ones are needed for a judgement */

typedef struct {
  float minimum_rad;              /* 2060:9; not limited unless minimum < maximum */
  float maximum_rad;              /* 2060:10 */
  float deceleration_rad_s2;      /* 2060:19, 0.01 .. 1e4 */
  float stop_deceleration_rad_s2; /* of ordered stops, at least 2060:20 or half of 2060:19 */
  bool slow;                      /* ENVELOPE_SLOW_RAD_S everywhere, and no end of the travel */
} envelope_params;

/* The same, as a tick needs it. */
typedef struct {
  float rad_s_per_step;     /* of two ticks in 2^-32 turn */
  float fastest_rad_s;      /* wherever the axis is */
  float minimum_rad;        /* far away where the travel is not limited */
  float maximum_rad;        /* the same */
  float twice_rad_s2;       /* 2 a / 1.03^2 */
  float soft_rad_s;         /* a Ts */
  float braking_fall_rad_s; /* a braking slows the axis down by this in a tick */
  float stop_fall_rad_s;    /* the same of an ordered stop */
} envelope_limits;

/* What the drive did in the last tick. */
typedef enum {
  ENVELOPE_POWERLESS,
  ENVELOPE_RUNNING,  /* the mode of operation decides; the axis has power */
  ENVELOPE_STOPPING, /* a fault or a stop command has ordered a stop; also without power, after a fault */
  ENVELOPE_BRAKING,  /* as this block says */
  ENVELOPE_UNTRUSTED /* braked or off because neither sensors nor bridge can be trusted: nothing can be judged */
} envelope_phase;

/* What a tick has found: a sum of these bits. */
enum {
  ENVELOPE_TOO_FAST = 1,     /* towards an end of the travel, or for slow motion */
  ENVELOPE_STOP_IGNORED = 2, /* an ordered stop does not slow the axis down as guarded */
  ENVELOPE_BRAKING_FAILS = 4 /* the axis does not follow the braking */
};

typedef struct {
  angle_turn32 angle[2]; /* of the last two ticks, newest first */
  int32_t step[2];       /* that of the last tick and that before it, each over two ticks, in 2^-32 turn */
  int known;             /* angles, consecutive */
  bool turns;            /* has power, or has turned ever since it had */
  bool stopping;         /* an ordered stop has not ended */
  bool braking;          /* the braking has begun */
  bool holds;            /* the braking holds `held` */
  int ticks;             /* of the stop or of the braking; limited */
  float limit_rad_s;     /* fastest rate that the stop, or the braking, may still leave */
  angle_turn32 held;
  int rest_ticks;
} envelope_state;

/* Computes the limits. Call between two ticks, when a parameter may have changed. */
envelope_limits envelope_prepare(const envelope_params *params, float dt_s);

/* Forgets what was ordered, not the motion: an axis that still turns since it had power is kept within the travel. */
void envelope_release(envelope_state *state);

/* Computes one tick, with the angle of this tick and the position, which counts turns. `powered`: the bridge was on in
 * the last tick. `reference_rad_s`: the set-point of the speed loop in the last tick; in the first half second of an
 * ordered stop the axis may catch up with it. */
unsigned envelope_step(envelope_state *state, const envelope_limits *limits, envelope_phase phase, bool powered,
                       angle_turn32 angle, float position_rad, float reference_rad_s);

/* Call instead in a tick without an angle: checks nothing until ENVELOPE_ANGLES are known again. */
void envelope_lose(envelope_state *state, envelope_phase phase);

/* Returns the share of the full current with which to brake now, -1 .. 1; 0 while the angle is not known. Call after
 * the step, only in a tick in which the axis is braked, or may begin to be. */
float envelope_brake(envelope_state *state, const envelope_limits *limits);

/* Returns whether the braking has ended and the axis is at rest. */
bool envelope_at_rest(const envelope_state *state);

/* Returns the fastest rate that is allowed at this distance from the end of the travel; 0 at the end and beyond. */
float envelope_fastest_rad_s(const envelope_limits *limits, float room_rad);

#endif
