#include <pthread.h>

#include "canopen/can_queue.h"
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
  RUN_TEST(test_two_threads_lose_and_tear_nothing);
  return UNITY_END();
}
