/* SPDX-License-Identifier: Apache-2.0 */
#include "protection/start_position.h"

#include <math.h>

#include "base/scalar.h"

#define TURNS_PER_RAD 0.159154943f

void start_position_forget(start_position *start) {
  start->counted = false;
  start->confirmed = false;
  start->seen = false;
  start->settled = false;
}

static int8_t whole_turn(float turns, int lowest, int highest) {
  return (int8_t)scalar_clamp(turns, (float)lowest, (float)highest);
}

start_candidates start_position_step(start_position *start, float count_rad, float minimum_rad, float maximum_rad) {
  start->lowest_rad = start->counted ? scalar_min(start->lowest_rad, count_rad) : count_rad;
  start->highest_rad = start->counted ? scalar_max(start->highest_rad, count_rad) : count_rad;
  start->counted = true;
  if (!(minimum_rad < maximum_rad)) {
    return (start_candidates){.lowest = start->turn, .highest = start->turn, .known = true};
  }
  /* Where both would be beyond the last turn there is no candidate. */
  enum { LAST = START_POSITION_MAX_TURN };
  start_candidates found = {
      .lowest = whole_turn(ceilf((minimum_rad - START_POSITION_MARGIN_RAD - start->lowest_rad) * TURNS_PER_RAD), -LAST,
                           LAST + 1),
      .highest = whole_turn(floorf((maximum_rad + START_POSITION_MARGIN_RAD - start->highest_rad) * TURNS_PER_RAD),
                            -LAST - 1, LAST),
  };
  if (!start->confirmed && found.lowest == found.highest) {
    start->turn = found.lowest;
  }
  /* Without a candidate, the travel was made smaller than what the axis has visited: that does not change its turn. */
  start->settled = found.lowest == found.highest || (start->settled && found.lowest > found.highest);
  found.known = start->confirmed || start->settled;
  return found;
}

void start_position_confirm(start_position *start, int8_t turn) {
  start->confirmed = true;
  start->turn = turn;
}

bool start_position_turn_at(float count_rad, float position_rad, int8_t *turn) {
  const float quarter_turn = 0.25f;
  const float turns = (position_rad - count_rad) * TURNS_PER_RAD;
  const float nearest = scalar_round(turns);
  *turn = whole_turn(nearest, -START_POSITION_MAX_TURN, START_POSITION_MAX_TURN);
  return scalar_within(turns - nearest, quarter_turn) && scalar_within(nearest, (float)START_POSITION_MAX_TURN);
}

void start_position_see(start_position *start, int8_t turn) {
  start->seen = true;
  start->seen_turn = turn;
}

void start_position_take_seen(start_position *start) {
  if (start->seen) {
    start->seen = false;
    start_position_confirm(start, start->seen_turn);
  }
}
