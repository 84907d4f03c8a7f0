/* SPDX-License-Identifier: Apache-2.0 */
/* Controlwords that stop and wait for a tick of their own: their order, and what becomes of them when there is no room.
 */
#include "node/waiting_stops.h"

#include "unity.h"

enum { DISABLE = 0x07, QUICK_STOP = 0x02, OFF = 0x00, HALT = 0x100, HALTED = 0x10F };

static waiting_stops stops;

void setUp(void) { stops = (waiting_stops){0}; }
void tearDown(void) {}

static void test_each_word_is_given_back_in_its_order(void) {
  static const uint16_t words[WAITING_STOPS] = {0x07, 0x02, 0x00, 0x10F, 0x06, 0x03, 0x0B, 0x05};
  for (int i = 0; i < WAITING_STOPS; ++i) {
    waiting_stops_add(&stops, words[i]);
  }
  TEST_ASSERT_EQUAL(WAITING_STOPS, stops.count);
  for (int i = 0; i < WAITING_STOPS; ++i) {
    TEST_ASSERT_EQUAL_HEX16(words[i], waiting_stops_take(&stops));
  }
  TEST_ASSERT_EQUAL(0, stops.count);
}

static void test_the_last_word_again_is_no_other_one(void) {
  waiting_stops_add(&stops, DISABLE);
  waiting_stops_add(&stops, DISABLE);
  TEST_ASSERT_EQUAL(1, stops.count);
  waiting_stops_add(&stops, QUICK_STOP);
  waiting_stops_add(&stops, DISABLE);
  TEST_ASSERT_EQUAL(3, stops.count);
}

/* A word of 0 that waits is one, also as the first. */
static void test_switching_off_waits_as_any_other_word(void) {
  waiting_stops_add(&stops, OFF);
  TEST_ASSERT_EQUAL(1, stops.count);
  TEST_ASSERT_EQUAL_HEX16(OFF, waiting_stops_take(&stops));
}

/* The last place has each bit that stops: 0x07 and 0x02 are 0x02, halted. The words before it stay. */
static void test_without_room_the_last_word_stops_as_all_of_them(void) {
  for (int i = 0; i < WAITING_STOPS; ++i) {
    waiting_stops_add(&stops, i % 2 == 0 ? QUICK_STOP : DISABLE);
  }
  waiting_stops_add(&stops, HALT | QUICK_STOP);
  waiting_stops_add(&stops, HALTED);
  TEST_ASSERT_EQUAL(WAITING_STOPS, stops.count);
  for (int i = 0; i < WAITING_STOPS - 1; ++i) {
    TEST_ASSERT_EQUAL_HEX16(i % 2 == 0 ? QUICK_STOP : DISABLE, waiting_stops_take(&stops));
  }
  TEST_ASSERT_EQUAL_HEX16(HALT | QUICK_STOP, waiting_stops_take(&stops));
}

int main(void) {
  UNITY_BEGIN();
  RUN_TEST(test_each_word_is_given_back_in_its_order);
  RUN_TEST(test_the_last_word_again_is_no_other_one);
  RUN_TEST(test_switching_off_waits_as_any_other_word);
  RUN_TEST(test_without_room_the_last_word_stops_as_all_of_them);
  return UNITY_END();
}
