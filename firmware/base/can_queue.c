/* SPDX-License-Identifier: Apache-2.0 */
#include "base/can_queue.h"

#include <stddef.h>

bool can_queue_init(can_queue *queue, can_frame *frames, uint32_t capacity) {
  const bool good = frames != NULL && capacity != 0 && (capacity & (capacity - 1)) == 0;
  queue->frames = frames;
  queue->capacity = good ? capacity : 0;
  atomic_init(&queue->pushed, 0);
  atomic_init(&queue->popped, 0);
  atomic_init(&queue->overruns, 0);
  return good;
}

bool can_queue_push(can_queue *queue, const can_frame *frame) {
  const uint32_t pushed = atomic_load_explicit(&queue->pushed, memory_order_relaxed);
  const uint32_t popped = atomic_load_explicit(&queue->popped, memory_order_acquire);
  if (pushed - popped >= queue->capacity) {
    const uint32_t overruns = atomic_load_explicit(&queue->overruns, memory_order_relaxed);
    atomic_store_explicit(&queue->overruns, overruns + 1, memory_order_relaxed);
    return false;
  }
  queue->frames[pushed & (queue->capacity - 1)] = *frame;
  atomic_store_explicit(&queue->pushed, pushed + 1, memory_order_release);
  return true;
}

const can_frame *can_queue_front(const can_queue *queue) {
  const uint32_t popped = atomic_load_explicit(&queue->popped, memory_order_relaxed);
  const bool empty = atomic_load_explicit(&queue->pushed, memory_order_acquire) == popped;
  return empty ? NULL : &queue->frames[popped & (queue->capacity - 1)];
}

void can_queue_drop(can_queue *queue) {
  const uint32_t popped = atomic_load_explicit(&queue->popped, memory_order_relaxed);
  atomic_store_explicit(&queue->popped, popped + 1, memory_order_release);
}

bool can_queue_pop(can_queue *queue, can_frame *frame) {
  const can_frame *front = can_queue_front(queue);
  if (front == NULL) {
    return false;
  }
  *frame = *front;
  can_queue_drop(queue);
  return true;
}

uint32_t can_queue_count(const can_queue *queue) {
  return atomic_load_explicit(&queue->pushed, memory_order_acquire) -
         atomic_load_explicit(&queue->popped, memory_order_relaxed);
}

uint32_t can_queue_overruns(const can_queue *queue) {
  return atomic_load_explicit(&queue->overruns, memory_order_relaxed);
}
