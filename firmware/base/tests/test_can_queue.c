/* SPDX-License-Identifier: Apache-2.0 */
#include <pthread.h>

#include "base/can_queue.h"
#include "unity.h"

void setUp(void) {}
void tearDown(void) {}

enum { CAPACITY = 8 };
static can_frame frames[64];
static can_queue queue;

static void test_queue_gives_frames_back_in_order(void) {
  can_frame out;
  TEST_ASSERT_TRUE(can_queue_init(&queue, frames, CAPACITY));
  TEST_ASSERT_FALSE(can_queue_pop(&queue, &out));
  for (uint32_t round = 0; round < 100; round++) {
    for (uint32_t i = 0; i < 5; i++) {
      TEST_ASSERT_TRUE(can_queue_push(&queue, &(can_frame){.id = round * 10 + i, .length = 1}));
    }
    for (uint32_t i = 0; i < 5; i++) {
      TEST_ASSERT_TRUE(can_queue_pop(&queue, &out));
      TEST_ASSERT_EQUAL(round * 10 + i, out.id);
    }
  }
  TEST_ASSERT_FALSE(can_queue_pop(&queue, &out));
}

static void test_full_queue_drops_the_newest_and_counts_it(void) {
  can_frame out;
  TEST_ASSERT_TRUE(can_queue_init(&queue, frames, CAPACITY));
  for (uint32_t i = 0; i < CAPACITY + 3; i++) {
    TEST_ASSERT_EQUAL(i < CAPACITY, can_queue_push(&queue, &(can_frame){.id = i}));
  }
  TEST_ASSERT_EQUAL(3, can_queue_overruns(&queue));
  for (uint32_t i = 0; i < CAPACITY; i++) {
    TEST_ASSERT_TRUE(can_queue_pop(&queue, &out));
    TEST_ASSERT_EQUAL(i, out.id);
  }
}

static void test_queue_refuses_a_capacity_that_is_no_power_of_two(void) {
  can_frame out;
  TEST_ASSERT_FALSE(can_queue_init(&queue, frames, 12));
  TEST_ASSERT_FALSE(can_queue_init(&queue, frames, 0));
  TEST_ASSERT_FALSE(can_queue_init(&queue, NULL, 8));
  TEST_ASSERT_FALSE(can_queue_push(&queue, &(can_frame){.id = 1}));
  TEST_ASSERT_FALSE(can_queue_pop(&queue, &out));
  TEST_ASSERT_EQUAL(1, can_queue_overruns(&queue));
}

static void test_queue_works_across_the_wrap_of_its_counters(void) {
  can_frame out;
  TEST_ASSERT_TRUE(can_queue_init(&queue, frames, CAPACITY));
  atomic_store(&queue.pushed, UINT32_MAX - 2);
  atomic_store(&queue.popped, UINT32_MAX - 2);
  for (uint32_t i = 0; i < CAPACITY; i++) {
    TEST_ASSERT_TRUE(can_queue_push(&queue, &(can_frame){.id = i}));
  }
  TEST_ASSERT_FALSE(can_queue_push(&queue, &(can_frame){.id = 99}));
  for (uint32_t i = 0; i < CAPACITY; i++) {
    TEST_ASSERT_TRUE(can_queue_pop(&queue, &out));
    TEST_ASSERT_EQUAL(i, out.id);
  }
}

enum { MANY = 2000000 };

static void *produce(void *context) {
  (void)context;
  uint32_t i = 0;
  while (i < MANY) {
    const uint8_t byte = (uint8_t)i;
    const can_frame frame = {.id = i, .length = 8, .data = {byte, byte, byte, byte, byte, byte, byte, byte}};
    i += can_queue_push(&queue, &frame) ? 1u : 0u;
  }
  return NULL;
}

/* Bound: all sequences of 16 pushes and pops (65,536), on queues of 1, 2, 4 and 8 frames, from counters at 0 and just
 * before their wrap, compared with a list of the expected frames. */
static void test_all_short_sequences_of_pushes_and_pops(void) {
  enum { STEPS = 16 };
  uint32_t wrong = 0;
  for (uint32_t n = 0; n < (1u << STEPS) * 8u; n++) {
    const uint32_t capacity = 1u << (n >> STEPS & 3u);
    const uint32_t start = (n >> STEPS & 4u) != 0 ? UINT32_MAX - 3 : 0;
    (void)can_queue_init(&queue, frames, capacity);
    atomic_store(&queue.pushed, start);
    atomic_store(&queue.popped, start);
    uint32_t next = 0, oldest = 0, lost = 0; /* numbers of accepted frames, and of those taken out */
    uint32_t waiting[STEPS];
    for (uint32_t step = 0; step < STEPS; step++) {
      can_frame frame = {.id = step};
      if ((n >> step & 1u) != 0) {
        const bool room = next - oldest < capacity;
        wrong += can_queue_push(&queue, &frame) == room ? 0u : 1u;
        lost += room ? 0u : 1u;
        if (room) {
          waiting[next++] = step;
        }
      } else {
        const bool there = oldest < next;
        wrong += can_queue_pop(&queue, &frame) == there ? 0u : 1u;
        wrong += frame.id == (there ? waiting[oldest] : step) ? 0u : 1u; /* unchanged when there is none */
        oldest += there ? 1u : 0u;
      }
    }
    wrong += can_queue_overruns(&queue) == lost ? 0u : 1u;
  }
  TEST_ASSERT_EQUAL(0, wrong);
}

static void test_two_threads_lose_and_tear_nothing(void) {
  pthread_t producer;
  TEST_ASSERT_TRUE(can_queue_init(&queue, frames, 64));
  TEST_ASSERT_EQUAL(0, pthread_create(&producer, NULL, produce, NULL));
  uint32_t good = 0;
  for (uint32_t wanted = 0; wanted < MANY;) {
    can_frame frame;
    if (can_queue_pop(&queue, &frame)) {
      const uint8_t byte = (uint8_t)wanted;
      good += frame.id == wanted && frame.data[0] == byte && frame.data[7] == byte ? 1u : 0u;
      wanted++;
    }
  }
  TEST_ASSERT_EQUAL(0, pthread_join(producer, NULL));
  TEST_ASSERT_EQUAL(MANY, good);
}

int main(void) {
  UNITY_BEGIN();
  RUN_TEST(test_queue_gives_frames_back_in_order);
  RUN_TEST(test_full_queue_drops_the_newest_and_counts_it);
  RUN_TEST(test_queue_refuses_a_capacity_that_is_no_power_of_two);
  RUN_TEST(test_queue_works_across_the_wrap_of_its_counters);
  RUN_TEST(test_all_short_sequences_of_pushes_and_pops);
  RUN_TEST(test_two_threads_lose_and_tear_nothing);
  return UNITY_END();
}
