/* SPDX-License-Identifier: Apache-2.0 */
/* Which turn an axis is in, as far as an encoder of one turn and the travel of the machine determine it.
 *
 *     candidates    all whole k with   minimum - margin <= lowest count + 2 pi k,   highest count + 2 pi k <= maximum +
 * margin
 *
 * The drive counts turns from the start, and anew after a jump of the encoder; "count" is the angle counted since
 * then, from within half a turn of the encoder's zero. Lowest and highest are of the whole time since the start, so
 * motion excludes candidates. With exactly one candidate the position is known: count + 2 pi k. With several it is not
 * known until motion has excluded the others or the operator has confirmed the turn. Without a candidate nothing
 * changes: a known position stays known when the travel is made smaller than what the axis has visited. The margin
 * covers the distance from the hard travel to the end stops, and an axis that was pushed beyond the hard travel. */
#ifndef TRACKSERVO_PROTECTION_START_POSITION_H
#define TRACKSERVO_PROTECTION_START_POSITION_H

#include <stdbool.h>
#include <stdint.h>

#define START_POSITION_MARGIN_RAD 0.1f

/* Beyond 34 turns no position fits into object 6064. */
enum { START_POSITION_MAX_TURN = 34 };

typedef struct {
  bool counted;      /* the counts are valid */
  float lowest_rad;  /* count */
  float highest_rad; /* count */
  bool confirmed;    /* by the operator: `turn` */
  bool seen;         /* by the operator: `seen_turn`, which homing has yet to confirm */
  int8_t seen_turn;
  bool settled; /* there was exactly one candidate, and have never been several since */
  int8_t turn;  /* in force: position = count + 2 pi turn */
} start_position;

typedef struct {
  int8_t lowest;
  int8_t highest; /* below `lowest`: no candidate */
  bool known;     /* `turn` in force is certain */
} start_candidates;

/* Restarts the count. Call at the start, and when the encoder was lost for so long that the axis may have turned. */
void start_position_forget(start_position *start);

/* Returns the candidates for the present count. With an unlimited travel (minimum not below maximum) no turn is needed
 * and it counts as known. */
start_candidates start_position_step(start_position *start, float count_rad, float minimum_rad, float maximum_rad);

/* Confirms the turn. The next step uses it. */
void start_position_confirm(start_position *start, int8_t turn);

/* Finds the turn in which the present count is within a quarter turn of a position. Returns false when there is none.
 * */
bool start_position_turn_at(float count_rad, float position_rad, int8_t *turn);

/* Notes the turn that the operator has seen. It counts only from `start_position_take_seen` on. */
void start_position_see(start_position *start, int8_t turn);

void start_position_take_seen(start_position *start);

#endif
