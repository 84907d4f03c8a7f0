/* SPDX-License-Identifier: Apache-2.0 */
/* Envelope, one tick from any state within `any_state`, for any angle, position, phase and parameters that its header
 * allows, at 1 kHz: the state stays within these bounds, so by induction it does for ever; the braking current is a
 * share of -1 .. 1; the fastest allowed rate is finite and not negative; no division by zero, no sum out of range, no
 * value that is not finite. */
#include "protection/envelope.h"

#include "proof.h"

#define FASTEST_RAD_S 1600.0f /* half a turn in two ticks */

static envelope_state any_state(void) {
  envelope_state state = {.known = Frama_C_interval(0, ENVELOPE_ANGLES),
                          .turns = any_bool(),
                          .stopping = any_bool(),
                          .braking = any_bool(),
                          .holds = any_bool(),
                          .ticks = Frama_C_interval(0, 500),
                          .limit_rad_s = any_float(0.0f, 200.0f * FASTEST_RAD_S),
                          .held = any_u32(),
                          .rest_ticks = Frama_C_interval(0, 100)};
  for (int i = 0; i < 2; ++i) {
    state.angle[i] = any_u32();
    state.step[i] = (int32_t)any_u32();
  }
  return state;
}

int main(void) {
  envelope_state state = any_state();
  const envelope_params params = {.minimum_rad = any_float(-1e6f, 1e6f),
                                  .maximum_rad = any_float(-1e6f, 1e6f),
                                  .deceleration_rad_s2 = any_float(0.01f, 1e4f),
                                  .stop_deceleration_rad_s2 = any_float(0.0f, 1e4f),
                                  .slow = any_bool()};
  const envelope_limits limits = envelope_prepare(&params, 0.001f);
  const envelope_phase phase = (envelope_phase)Frama_C_interval(ENVELOPE_POWERLESS, ENVELOPE_UNTRUSTED);
  if (any_bool()) {
    (void)envelope_step(&state, &limits, phase, any_bool(), any_u32(), any_float(-1e6f, 1e6f),
                        any_float(-FASTEST_RAD_S, FASTEST_RAD_S));
  } else {
    envelope_lose(&state, phase);
  }
  const float brake = envelope_brake(&state, &limits);
  REQUIRE(brake >= -1.0f && brake <= 1.0f, "at most the full current");
  REQUIRE(state.known >= 0 && state.known <= ENVELOPE_ANGLES, "known");
  REQUIRE(state.ticks >= 0 && state.ticks <= 500, "ticks of a stop or a braking");
  REQUIRE(state.limit_rad_s >= 0.0f && state.limit_rad_s <= 200.0f * FASTEST_RAD_S, "limit of a stop or a braking");
  REQUIRE(state.rest_ticks >= 0 && state.rest_ticks <= 100, "ticks at rest");
  const float fastest_rad_s = envelope_fastest_rad_s(&limits, any_float(-1e6f, 1e6f));
  REQUIRE(fastest_rad_s >= 0.0f && fastest_rad_s <= 1e9f, "fastest rate");
  return 0;
}
