/* SPDX-License-Identifier: Apache-2.0 */
#include "protection/access_lock.h"

#include "unity.h"

enum { A = 0, B = 1, NOBODY = ACCESS_LOCK_CLIENTS };

static uint32_t caller;
static access_lock lock;

#define OWNERS_WORD UINT64_C(0x0064726F77737361)

void setUp(void) {
  caller = A;
  lock = (access_lock){.caller = &caller, .salt = 4711};
}

void tearDown(void) {}

static void wait_ticks(uint32_t ticks) {
  for (uint32_t i = 0; i < ticks; ++i) {
    access_lock_tick(&lock);
  }
}

static void test_it_opens_by_the_known_word_for_a_minute_and_closes_by_command(void) {
  TEST_ASSERT_FALSE(access_lock_is_open(&lock));
  TEST_ASSERT_EQUAL(ACCESS_OPENED, access_lock_open(&lock, ACCESS_LOCK_WORD));
  TEST_ASSERT_EQUAL(ACCESS_LOCK_TICKS, access_lock_ticks_left(&lock));
  wait_ticks(59999);
  TEST_ASSERT_TRUE(access_lock_is_open(&lock));
  wait_ticks(1);
  TEST_ASSERT_FALSE(access_lock_is_open(&lock));
  (void)access_lock_open(&lock, ACCESS_LOCK_WORD);
  access_lock_close(&lock);
  TEST_ASSERT_FALSE(access_lock_is_open(&lock));
}

static void test_it_is_open_only_for_the_channel_that_opened_it(void) {
  (void)access_lock_open(&lock, ACCESS_LOCK_WORD);
  caller = B;
  TEST_ASSERT_FALSE(access_lock_is_open(&lock));
  TEST_ASSERT_EQUAL(0, access_lock_ticks_left(&lock));
  access_lock_close(&lock); /* its own */
  caller = A;
  TEST_ASSERT_TRUE(access_lock_is_open(&lock));
  caller = NOBODY;
  TEST_ASSERT_FALSE(access_lock_is_open(&lock));
  TEST_ASSERT_EQUAL(0, access_lock_delay_ticks(&lock));
  TEST_ASSERT_EQUAL(ACCESS_NO_CLIENT, access_lock_open(&lock, ACCESS_LOCK_WORD));
  access_lock_close(&lock);
  caller = B;
  (void)access_lock_open(&lock, ACCESS_LOCK_WORD);
  access_lock_close_all(&lock);
  TEST_ASSERT_FALSE(access_lock_is_open(&lock));
  caller = A;
  TEST_ASSERT_FALSE(access_lock_is_open(&lock));
}

static void test_the_owners_word_replaces_the_known_one(void) {
  lock.hash = access_lock_hash(&lock, OWNERS_WORD);
  TEST_ASSERT_EQUAL(ACCESS_WRONG_WORD, access_lock_open(&lock, ACCESS_LOCK_WORD));
  wait_ticks(1000);
  TEST_ASSERT_EQUAL(ACCESS_WRONG_WORD, access_lock_open(&lock, lock.hash)); /* the hash does not open it */
  wait_ticks(2000);
  TEST_ASSERT_EQUAL(ACCESS_OPENED, access_lock_open(&lock, OWNERS_WORD));
}

static void test_the_hash_of_a_word_differs_from_device_to_device(void) {
  access_lock other = lock;
  other.salt = 4712;
  TEST_ASSERT_NOT_EQUAL_UINT64(access_lock_hash(&lock, OWNERS_WORD), access_lock_hash(&other, OWNERS_WORD));
}

/* Set by one firmware, compared by the next: SipHash-2-4 of the word with the key "trstlock" and the serial number. */
static void test_a_stored_hash_stays_right_with_another_firmware(void) {
  TEST_ASSERT_EQUAL_HEX64(UINT64_C(0x0823CAE14173BDC3), access_lock_hash(&lock, UINT64_C(0x1122334455667788)));
}

static void test_each_wrong_word_delays_its_channel_twice_as_long(void) {
  uint32_t expected = ACCESS_LOCK_FIRST_DELAY;
  for (int i = 0; i < 10; ++i) {
    TEST_ASSERT_EQUAL(ACCESS_WRONG_WORD, access_lock_open(&lock, 1));
    TEST_ASSERT_EQUAL(expected, access_lock_delay_ticks(&lock));
    wait_ticks(expected - 1);
    TEST_ASSERT_EQUAL(ACCESS_DELAYED, access_lock_open(&lock, ACCESS_LOCK_WORD));
    wait_ticks(1);
    expected = expected < ACCESS_LOCK_LAST_DELAY ? 2 * expected : expected;
  }
  TEST_ASSERT_EQUAL(ACCESS_LOCK_LAST_DELAY, expected);
  caller = B;
  TEST_ASSERT_EQUAL(ACCESS_OPENED, access_lock_open(&lock, ACCESS_LOCK_WORD));
  caller = A;
  TEST_ASSERT_EQUAL(ACCESS_OPENED, access_lock_open(&lock, ACCESS_LOCK_WORD));
  TEST_ASSERT_EQUAL(ACCESS_WRONG_WORD, access_lock_open(&lock, 1)); /* the right word has ended the growth */
  TEST_ASSERT_EQUAL(ACCESS_LOCK_FIRST_DELAY, access_lock_delay_ticks(&lock));
  TEST_ASSERT_FALSE(access_lock_is_open(&lock)); /* and a wrong one locks */
}

static void test_2000_wrong_words_as_fast_as_possible_are_2_that_are_compared(void) {
  int compared = 0;
  for (int i = 0; i < 2000; ++i) {
    compared += access_lock_open(&lock, (uint64_t)i) == ACCESS_WRONG_WORD ? 1 : 0;
    wait_ticks(1);
  }
  TEST_ASSERT_EQUAL(2, compared);
}

int main(void) {
  UNITY_BEGIN();
  RUN_TEST(test_it_opens_by_the_known_word_for_a_minute_and_closes_by_command);
  RUN_TEST(test_it_is_open_only_for_the_channel_that_opened_it);
  RUN_TEST(test_the_owners_word_replaces_the_known_one);
  RUN_TEST(test_the_hash_of_a_word_differs_from_device_to_device);
  RUN_TEST(test_a_stored_hash_stays_right_with_another_firmware);
  RUN_TEST(test_each_wrong_word_delays_its_channel_twice_as_long);
  RUN_TEST(test_2000_wrong_words_as_fast_as_possible_are_2_that_are_compared);
  return UNITY_END();
}
