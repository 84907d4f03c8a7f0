/* SPDX-License-Identifier: Apache-2.0 */
#include "commissioning/scope.h"

#include <math.h>
#include <stddef.h>
#include <string.h>

#define MAGIC UINT32_C(0x43535354) /* "TSSC" */

enum { VERSION = 1, FIXED_WORDS = SCOPE_HEADER_BYTES / 4, CHANNEL_WORDS = SCOPE_CHANNEL_BYTES / 4 };

uint32_t scope_capacity(uint8_t channels) { return (uint32_t)SCOPE_WORDS / channels; }

static bool looks_at_channel(scope_source source) { return source >= SCOPE_ABOVE && source <= SCOPE_FALLING; }

static scope_status check_trigger(const scope_config *config) {
  const scope_trigger *trigger = &config->trigger;
  if ((unsigned)trigger->source > (unsigned)SCOPE_FAULT) {
    return SCOPE_BAD_TRIGGER;
  }
  const bool channel_good = trigger->channel < config->channels && isfinite(trigger->level);
  return looks_at_channel(trigger->source) && !channel_good ? SCOPE_BAD_TRIGGER : SCOPE_OK;
}

scope_status scope_check(const scope_config *config) {
  if (config->channels == 0 || config->channels > SCOPE_CHANNELS) {
    return SCOPE_BAD_CHANNELS;
  }
  /* Bound: SCOPE_CHANNELS: checked just before. */
  for (int i = 0; i < config->channels; ++i) {
    const scope_channel *channel = &config->channel[i];
    if (channel->source == NULL || (unsigned)channel->kind > (unsigned)SCOPE_UINT32) {
      return SCOPE_BAD_CHANNELS;
    }
  }
  if (config->divider == 0) {
    return SCOPE_BAD_DIVIDER;
  }
  if (config->pretrigger >= scope_capacity(config->channels)) {
    return SCOPE_BAD_PRETRIGGER;
  }
  return check_trigger(config);
}

void scope_reset(scope *s) { memset(s, 0, sizeof *s); }

scope_status scope_arm(scope *s, const scope_config *config, float tick_s) {
  const scope_status status = scope_check(config);
  if (status != SCOPE_OK) {
    return status;
  }
  scope_reset(s);
  s->config = *config;
  s->tick_ns = (uint32_t)(tick_s * 1e9f + 0.5f);
  s->capacity_frames = scope_capacity(config->channels);
  s->phase = config->pretrigger == 0 ? SCOPE_WAITING : SCOPE_FILLING;
  return SCOPE_OK;
}

/* Frames from the trigger on are counted; the frames before it are the rest: fewer than requested after a forced
 * trigger. */
static uint32_t find_trigger(const scope *s) {
  return s->frames - (s->capacity_frames - s->config.pretrigger - s->after_left);
}

void scope_stop(scope *s) {
  if (s->phase == SCOPE_FILLING || s->phase == SCOPE_WAITING) {
    s->trigger_frame = s->frames;
  } else if (s->phase == SCOPE_TRIGGERED) {
    s->trigger_frame = find_trigger(s);
  }
  s->phase = s->phase == SCOPE_IDLE ? SCOPE_IDLE : SCOPE_DONE;
}

void scope_force(scope *s) {
  if (s->phase == SCOPE_FILLING || s->phase == SCOPE_WAITING) {
    s->forced = true;
    s->phase = SCOPE_WAITING;
  }
}

static float as_float(scope_kind kind, uint32_t word) {
  if (kind == SCOPE_FLOAT) {
    float value;
    memcpy(&value, &word, sizeof value);
    return value;
  }
  if (kind == SCOPE_INT32) {
    int32_t value;
    memcpy(&value, &word, sizeof value);
    return (float)value;
  }
  return (float)word;
}

static void take_frame(scope *s) {
  const uint32_t channels = s->config.channels;
  /* Bound: SCOPE_CHANNELS: scope_check asks for it. */
  for (uint32_t i = 0; i < channels; ++i) {
    memcpy(&s->words[s->next_frame * channels + i], s->config.channel[i].source, sizeof s->words[0]);
  }
  s->next_frame = s->next_frame + 1 == s->capacity_frames ? 0 : s->next_frame + 1;
  s->frames += s->frames < s->capacity_frames ? 1u : 0u;
}

/* Evaluates the frame just taken. A NaN crosses no level. */
static bool level_triggers(scope *s) {
  const scope_trigger *trigger = &s->config.trigger;
  const uint32_t frame = s->next_frame == 0 ? s->capacity_frames - 1 : s->next_frame - 1;
  const uint32_t word = s->words[frame * s->config.channels + trigger->channel];
  const float value = as_float(s->config.channel[trigger->channel].kind, word);
  const bool upwards = trigger->source == SCOPE_ABOVE || trigger->source == SCOPE_RISING;
  const bool met = upwards ? value > trigger->level : value < trigger->level;
  const bool was_not_met = s->level_known && !s->level_met;
  s->level_known = true;
  s->level_met = met;
  const bool edge = trigger->source == SCOPE_RISING || trigger->source == SCOPE_FALLING;
  return met && (!edge || was_not_met);
}

static void monitor_events(scope *s, uint32_t state, uint32_t faults) {
  const bool changed = s->seen && state != s->last_state;
  const bool fault_begins = s->seen && (faults & ~s->last_faults) != 0;
  s->seen = true;
  s->last_state = state;
  s->last_faults = faults;
  const scope_source source = s->config.trigger.source;
  s->pending = s->pending || (source == SCOPE_STATE_CHANGE && changed) || (source == SCOPE_FAULT && fault_begins);
}

static bool triggers(scope *s) {
  const scope_source source = s->config.trigger.source;
  const bool event = s->pending;
  s->pending = false;
  if (looks_at_channel(source)) {
    return level_triggers(s) || s->forced;
  }
  return event || s->forced || source == SCOPE_IMMEDIATELY;
}

/* Advances after a frame. The phase of this frame decides whether its trigger counts. */
static void advance(scope *s) {
  const bool triggered = triggers(s);
  if (s->phase == SCOPE_FILLING) {
    s->phase = s->frames >= s->config.pretrigger ? SCOPE_WAITING : SCOPE_FILLING;
  } else if (s->phase == SCOPE_WAITING && triggered) {
    s->phase = SCOPE_TRIGGERED;
    s->after_left = s->capacity_frames - s->config.pretrigger - 1;
  } else if (s->phase == SCOPE_TRIGGERED) {
    --s->after_left;
  }
  if (s->phase == SCOPE_TRIGGERED && s->after_left == 0) {
    s->phase = SCOPE_DONE;
    s->trigger_frame = find_trigger(s);
  }
}

void scope_step(scope *s, uint32_t state, uint32_t faults) {
  if (s->phase == SCOPE_IDLE || s->phase == SCOPE_DONE) {
    return;
  }
  monitor_events(s, state, faults);
  if (s->ticks_to_frame > 0) {
    --s->ticks_to_frame;
    return;
  }
  s->ticks_to_frame = s->config.divider - 1u;
  take_frame(s);
  advance(s);
}

static uint32_t header_words(const scope *s) { return FIXED_WORDS + (uint32_t)CHANNEL_WORDS * s->config.channels; }

uint32_t scope_bytes(const scope *s) {
  return s->phase == SCOPE_DONE ? 4u * (header_words(s) + s->frames * s->config.channels) : 0;
}

static uint32_t header_word(const scope *s, uint32_t index) {
  const uint32_t fixed[FIXED_WORDS] = {MAGIC,     VERSION,          4u * header_words(s), s->config.channels,
                                       s->frames, s->trigger_frame, s->config.divider,    s->tick_ns};
  if (index < FIXED_WORDS) {
    return fixed[index];
  }
  const scope_channel *channel = &s->config.channel[(index - FIXED_WORDS) / CHANNEL_WORDS];
  return (index - FIXED_WORDS) % CHANNEL_WORDS == 0 ? channel->id : (uint32_t)channel->kind;
}

/* Word `index` of the frames, oldest first: when the ring is full, it begins at the place of the next frame. */
static uint32_t frame_word(const scope *s, uint32_t index) {
  const uint32_t used = s->capacity_frames * s->config.channels;
  const uint32_t oldest = s->frames == s->capacity_frames ? s->next_frame * s->config.channels : 0;
  const uint32_t place = oldest + index;
  return s->words[place >= used ? place - used : place];
}

scope_status scope_read(const scope *s, uint32_t offset, uint8_t *bytes, uint32_t length) {
  const uint32_t total = scope_bytes(s);
  if (total == 0) {
    return SCOPE_NO_DATA;
  }
  if (offset > total || length > total - offset) {
    return SCOPE_OUT_OF_RANGE;
  }
  const uint32_t header = header_words(s);
  /* Bound: 7 bytes of an SDO segment. */
  for (uint32_t i = 0; i < length; ++i) {
    const uint32_t index = (offset + i) / 4;
    const uint32_t word = index < header ? header_word(s, index) : frame_word(s, index - header);
    bytes[i] = (uint8_t)(word >> (8 * ((offset + i) % 4)));
  }
  return SCOPE_OK;
}
