/* SPDX-License-Identifier: Apache-2.0 */
/* One classic CAN frame, and the function type that sends one.
 *
 * Standard: ISO 11898-1 classic frames with 11-bit or 29-bit identifiers and at most 8 data bytes. Everything that
 * receives or sends (queue, node, simulated buses, the platform's CAN driver) passes this one value. */
#ifndef TRACKSERVO_BASE_CAN_FRAME_H
#define TRACKSERVO_BASE_CAN_FRAME_H

#include <stdbool.h>
#include <stdint.h>

enum { CAN_FRAME_BYTES = 8 };

/* Flags. */
enum {
  CAN_FRAME_EXTENDED = 1, /* 29-bit identifier */
  CAN_FRAME_REMOTE = 2    /* remote request: length counts, data do not */
};

typedef struct {
  uint32_t id;                   /* 0 .. 0x7FF, or 0 .. 0x1FFFFFFF when extended */
  uint8_t flags;                 /* CAN_FRAME_* */
  uint8_t length;                /* DLC, 0 .. 8 */
  uint8_t data[CAN_FRAME_BYTES]; /* bytes from `length` on are undefined */
  uint16_t received_us;          /* hal_clock_us when it began, modulo 2^16; of a received frame only */
} can_frame;

/* Accepts a frame for sending. Returns false when there is no room: the caller keeps the frame and tries again
 * later. */
typedef struct {
  bool (*send)(void *context, const can_frame *frame);
  void *context;
} can_sender;

/* 11-bit identifiers; both ends belong to the range. */
typedef struct {
  uint16_t first;
  uint16_t last;
} can_id_range;

#endif
