/* SPDX-License-Identifier: Apache-2.0 */
/* The scope: up to 8 signals sampled at the tick into 32 KiB, around a trigger, read out as bytes.
 *
 * A frame is one sample of each channel, bit for bit the 32-bit word of its source. Frames go into a ring until the
 * trigger has come and the frames after it are complete. The capture is read as one byte stream (object 0x3000 as
 * DOMAIN, CiA 301 clause 7.2.4): a header that describes it, then the frames, oldest first, little endian.
 *
 * Header, all UNSIGNED32 unless said otherwise:
 *     0  "TSSC"                    16  frames               32  one record of 8 bytes for each channel:
 *     4  version 1                 20  frame of the trigger        0  id as given
 *     8  bytes of this header      24  ticks between frames        4  kind (scope_kind)
 *    12  channels                  28  tick, ns                  then the frames */
#ifndef TRACKSERVO_COMMISSIONING_SCOPE_H
#define TRACKSERVO_COMMISSIONING_SCOPE_H

#include <stdbool.h>
#include <stdint.h>

enum { SCOPE_CHANNELS = 8, SCOPE_WORDS = 8192, SCOPE_HEADER_BYTES = 32, SCOPE_CHANNEL_BYTES = 8 };

typedef enum {
  SCOPE_OK = 0,
  SCOPE_BAD_CHANNELS, /* none, more than 8, one without a source, or one of unknown kind */
  SCOPE_BAD_DIVIDER,  /* 0 */
  SCOPE_BAD_PRETRIGGER,
  SCOPE_BAD_TRIGGER, /* unknown source, a channel that is not captured, or a level that is not finite */
  SCOPE_NO_DATA,     /* no finished capture */
  SCOPE_OUT_OF_RANGE /* beyond the end of the stream */
} scope_status;

typedef enum { SCOPE_FLOAT = 0, SCOPE_INT32, SCOPE_UINT32 } scope_kind;

typedef struct {
  uint32_t id; /* identifies the signal for readers of the stream */
  scope_kind kind;
  const void *source; /* an aligned 32-bit value that exists longer than the capture */
} scope_channel;

typedef enum {
  SCOPE_IMMEDIATELY = 0,
  SCOPE_ABOVE,        /* channel > level */
  SCOPE_BELOW,        /* channel < level */
  SCOPE_RISING,       /* channel > level, after a frame in which it was not */
  SCOPE_FALLING,      /* channel < level, after a frame in which it was not */
  SCOPE_STATE_CHANGE, /* the drive's state differs from the previous tick */
  SCOPE_FAULT         /* a fault begins */
} scope_source;

typedef struct {
  scope_source source;
  uint8_t channel; /* 0 .. channels - 1, of ABOVE .. FALLING */
  float level;     /* in the channel's unit; integers are compared as floats */
} scope_trigger;

typedef struct {
  uint8_t channels;
  scope_channel channel[SCOPE_CHANNELS];
  uint16_t divider;    /* ticks per frame, >= 1 */
  uint16_t pretrigger; /* frames before that of the trigger, less than scope_capacity() */
  scope_trigger trigger;
} scope_config;

typedef enum {
  SCOPE_IDLE = 0,
  SCOPE_FILLING, /* armed; the frames before the trigger are not complete yet, triggers are ignored */
  SCOPE_WAITING, /* waits for the trigger */
  SCOPE_TRIGGERED,
  SCOPE_DONE
} scope_phase;

typedef struct {
  scope_config config;
  scope_phase phase;
  uint32_t tick_ns;
  uint32_t capacity_frames;
  uint32_t next_frame; /* slot of the ring for the next frame */
  uint32_t frames;     /* in the ring, up to the capacity */
  uint32_t after_left; /* frames left after the trigger */
  uint32_t ticks_to_frame;
  uint32_t trigger_frame; /* counted from the oldest one, once done */
  bool pending;           /* a state change or fault since the last frame */
  bool forced;
  bool level_known;
  bool level_met; /* in the last frame */
  bool seen;      /* last_state and last_faults are valid */
  uint32_t last_state;
  uint32_t last_faults;
  uint32_t words[SCOPE_WORDS];
} scope;

/* Returns how many frames fit with this number of channels, 1 .. 8. */
uint32_t scope_capacity(uint8_t channels);

/* Returns SCOPE_OK, or the error. */
scope_status scope_check(const scope_config *config);

void scope_reset(scope *s);

/* Starts a capture; the previous one is lost. On an error nothing is changed. */
scope_status scope_arm(scope *s, const scope_config *config, float tick_s);

/* Ends a capture early, or stops waiting: the captured frames can be read (trigger_frame = frames when no trigger
 * came). */
void scope_stop(scope *s);

/* Makes the next frame that of the trigger, whatever the trigger condition. Has no effect unless the scope is armed and
 * waits for its trigger. The frames captured until then stay, even if fewer than the pre-trigger. */
void scope_force(scope *s);

/* Captures one tick. Call after the control has run. `state` is any number that changes with the drive's state,
 * `faults` has a bit for each axis in fault. Cost: copies up to 8 words every `divider` ticks, otherwise almost
 * nothing. */
void scope_step(scope *s, uint32_t state, uint32_t faults);

/* Returns the length of the stream in bytes; 0 unless done. */
uint32_t scope_bytes(const scope *s);

/* Copies bytes [offset, offset + length) of the stream; any offset, any order, until the scope is armed again. */
scope_status scope_read(const scope *s, uint32_t offset, uint8_t *bytes, uint32_t length);

#endif
