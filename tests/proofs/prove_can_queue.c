/* SPDX-License-Identifier: Apache-2.0 */
/* CAN queue. From any state that the queue can have (capacity 1, 2, 4 or 8, any counters with at most `capacity`
 * frames between them, wrap included), one operation keeps the queue's contract:
 * - a push is refused exactly when `capacity` frames are inside, and then only counts; else the frame becomes the
 * newest;
 * - a pop returns the oldest frame and removes it, or finds nothing exactly when no frame is inside;
 * - all other frames inside stay as they are and in their order;
 * - no access outside the ring.
 * can_queue_init begins in such a state, so by induction the contract holds after any number of operations. */
#include "base/can_queue.h"

#include "proof.h"

enum { MOST = 8 };

static uint32_t inside(const can_queue *queue) {
  return atomic_load_explicit(&queue->pushed, memory_order_relaxed) -
         atomic_load_explicit(&queue->popped, memory_order_relaxed);
}

/* Identifier of the frame with `ahead` older ones in front of it. */
static uint32_t id_of(const can_queue *queue, uint32_t ahead) {
  const uint32_t at = atomic_load_explicit(&queue->popped, memory_order_relaxed) + ahead;
  return queue->frames[at & (queue->capacity - 1)].id;
}

static void prove_init(void) {
  can_frame ring[1];
  can_queue queue;
  const uint32_t capacity = any_u32();
  const bool power = capacity != 0 && (capacity & (capacity - 1)) == 0;
  REQUIRE(can_queue_init(&queue, ring, capacity) == power, "a capacity is accepted exactly when it is a power of two");
  REQUIRE(inside(&queue) == 0 && queue.capacity == (power ? capacity : 0), "a new queue is empty");
  REQUIRE(!can_queue_init(&queue, NULL, capacity), "no ring is refused");
}

int main(void) {
  prove_init();
  can_frame ring[MOST]; /* any contents; exactly MOST, so that a larger index is an error */
  can_queue queue;
  const uint32_t capacity = 1u << (any_u8() % 4u);
  (void)can_queue_init(&queue, ring, capacity);
  const uint32_t popped = any_u32();
  const uint32_t count = any_u32();
  const uint32_t overruns = any_u32();
  ASSUME(count <= capacity);
  atomic_init(&queue.popped, popped);
  atomic_init(&queue.pushed, popped + count);
  atomic_init(&queue.overruns, overruns);

  const uint32_t which = any_u32(); /* any frame inside */
  ASSUME(count == 0 || which < count);
  const uint32_t id = id_of(&queue, which);

  if (any_bool()) {
    const can_frame frame = {.id = any_u32()};
    const bool fits = count < capacity;
    REQUIRE(can_queue_push(&queue, &frame) == fits, "a push is refused exactly when the ring is full");
    REQUIRE(inside(&queue) == count + (fits ? 1u : 0u), "an accepted frame is inside, a refused one is not");
    REQUIRE(!fits || id_of(&queue, count) == frame.id, "it is the newest");
    REQUIRE(count == 0 || id_of(&queue, which) == id, "the others stay");
    REQUIRE(can_queue_overruns(&queue) == overruns + (fits ? 0u : 1u), "a refused frame is counted");
  } else {
    can_frame frame = {.id = 0};
    const uint32_t oldest = id_of(&queue, 0);
    REQUIRE((can_queue_front(&queue) != NULL) == (count != 0), "there is a front exactly when a frame is inside");
    REQUIRE(can_queue_pop(&queue, &frame) == (count != 0), "a pop finds a frame exactly when one is inside");
    REQUIRE(count == 0 || frame.id == oldest, "it is the oldest");
    REQUIRE(inside(&queue) == (count == 0 ? 0 : count - 1), "it is removed");
    REQUIRE(count == 0 || which == 0 || id_of(&queue, which - 1) == id, "the others stay");
    REQUIRE(can_queue_overruns(&queue) == overruns, "nothing is counted");
  }
  return 0;
}
