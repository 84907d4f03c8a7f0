/* SPDX-License-Identifier: Apache-2.0 */
/* A queue of CAN frames from one producer to one consumer, without locks.
 *
 * A ring with free-running counters (Lamport 1983, "Specifying concurrent program modules"), with C11 acquire and
 * release order on them. The receive interrupt pushes, the tick pops. A frame that finds the ring full is dropped and
 * counted. */
#ifndef TRACKSERVO_BASE_CAN_QUEUE_H
#define TRACKSERVO_BASE_CAN_QUEUE_H

#include "base/can_frame.h"
#include "base/shared.h"

typedef struct {
  can_frame *frames;
  uint32_t capacity;
  shared_word pushed;   /* written by the producer only */
  shared_word popped;   /* written by the consumer only */
  shared_word overruns; /* frames dropped since the start, written by the producer only */
} can_queue;

/* Uses `frames` (owned by the caller) as the ring. `capacity` is a power of two up to 2^31. Any other capacity is
 * refused, and the queue then drops every frame. Call it before either side runs. */
bool can_queue_init(can_queue *queue, can_frame *frames, uint32_t capacity);

/* Adds a frame; producer side. Returns false when the ring is full; the frame is dropped and counted. */
bool can_queue_push(can_queue *queue, const can_frame *frame);

/* Returns the oldest frame in place, or NULL; consumer side. It stays until `can_queue_drop`, which must only be called
 * when there is a frame. */
const can_frame *can_queue_front(const can_queue *queue);
void can_queue_drop(can_queue *queue);

/* Copies and drops the oldest frame; consumer side. Returns false when the queue is empty; `frame` is then
 * unchanged. */
bool can_queue_pop(can_queue *queue, can_frame *frame);

/* Returns how many frames wait; consumer side. */
uint32_t can_queue_count(const can_queue *queue);

/* Returns the number of frames dropped since the start. Either side may call it. */
uint32_t can_queue_overruns(const can_queue *queue);

#endif
