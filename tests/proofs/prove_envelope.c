/* Envelope, one tick from any state within `ANY_STATE`, for any angle, position, phase and limits that its header
 * allows, at 1 kHz: the state stays within these bounds, so by induction it does for ever; the braking current is a
 * share of -1 .. 1; the fastest allowed rate is finite and not negative; no division by zero, no sum out of range, no
 * value that is not finite. */
#include "protection/envelope.h"

#include "proof.h"

#define FASTEST_RAD_S 4000.0f /* |difference of two angles| / two ticks, moved ahead: below pi * 4.5 / 2 ms * 1.2 */
#define LONGEST_S 1e9f

static envelope_state any_state(void) {
  envelope_state state = {.known = Frama_C_interval(0, ENVELOPE_ANGLES),
                          .rate_rad_s = any_float(-FASTEST_RAD_S, FASTEST_RAD_S),
                          .turns = any_bool(),
                          .stopping = any_bool(),
                          .stop_s = any_float(0.0f, LONGEST_S),
                          .stop_limit_rad_s = any_float(0.0f, 2.0f * FASTEST_RAD_S),
                          .braking = any_bool(),
                          .braking_limit_rad_s = any_float(0.0f, 2.0f * FASTEST_RAD_S),
                          .holds = any_bool(),
                          .held = any_u32(),
                          .rest_ticks = Frama_C_interval(0, 100)};
  for (int i = 0; i < ENVELOPE_ANGLES; ++i) {
    state.angle[i] = any_u32();
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
  const envelope_inputs in = {.angle_valid = any_bool(),
                              .angle = any_u32(),
                              .position_rad = any_float(-1e6f, 1e6f),
                              .phase = (envelope_phase)Frama_C_interval(ENVELOPE_POWERLESS, ENVELOPE_UNTRUSTED),
                              .powered = any_bool()};
  const envelope_output out = envelope_step(&state, &params, &in, 0.001f);
  REQUIRE(out.brake >= -1.0f && out.brake <= 1.0f, "at most the full current");
  REQUIRE(state.known >= 0 && state.known <= ENVELOPE_ANGLES, "known");
  REQUIRE(state.rate_rad_s >= -FASTEST_RAD_S && state.rate_rad_s <= FASTEST_RAD_S, "rate");
  REQUIRE(state.stop_s >= 0.0f && state.stop_s <= LONGEST_S, "time of a stop");
  REQUIRE(state.stop_limit_rad_s >= 0.0f && state.stop_limit_rad_s <= 2.0f * FASTEST_RAD_S, "limit of a stop");
  REQUIRE(state.braking_limit_rad_s >= 0.0f && state.braking_limit_rad_s <= 2.0f * FASTEST_RAD_S,
          "limit of the braking");
  REQUIRE(state.rest_ticks >= 0 && state.rest_ticks <= 100, "ticks at rest");
  const float fastest_rad_s = envelope_fastest_rad_s(&params, any_float(-1e6f, 1e6f));
  REQUIRE(fastest_rad_s <= 1e6f, "fastest rate");
  return 0;
}
