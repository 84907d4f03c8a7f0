/* SPDX-License-Identifier: Apache-2.0 */
/* Values that must not change by themselves: every bit that flips is found within one cycle. */
#include "base/guarded_copy.h"

#include <string.h>

#include "unity.h"

enum { FIRST_WORDS = 5, SECOND_WORDS = 3, SLICE = 2, CYCLE = 5 /* three slices and two */ };

static guarded_copy copy;
static float first[FIRST_WORDS];
static uint32_t second[SECOND_WORDS];
static int first_block;
static int second_block;

void setUp(void) {
  memset(&copy, 0, sizeof copy);
  for (int i = 0; i < FIRST_WORDS; ++i) {
    first[i] = 0.1f * (float)i;
  }
  for (uint32_t i = 0; i < SECOND_WORDS; ++i) {
    second[i] = i;
  }
  first_block = guarded_copy_add(&copy, first, sizeof first);
  second_block = guarded_copy_add(&copy, second, sizeof second);
}

void tearDown(void) {}

/* Calls until a block is found, at most two cycles; 0: none. */
static int calls_until(int block) {
  for (int i = 1; i <= 2 * CYCLE; ++i) {
    const int found = guarded_copy_step(&copy, SLICE);
    if (found != GUARDED_NONE) {
      TEST_ASSERT_EQUAL(block, found);
      return i;
    }
  }
  return 0;
}

static void test_what_stays_is_never_found(void) { TEST_ASSERT_EQUAL(0, calls_until(GUARDED_NONE)); }

static void test_every_bit_of_every_word_is_found_within_a_cycle_and_again_until_it_is_sealed(void) {
  for (uint32_t bit = 0; bit < 32u * (FIRST_WORDS + SECOND_WORDS); ++bit) {
    setUp();
    const bool in_first = bit < 32u * FIRST_WORDS;
    const int block = in_first ? first_block : second_block;
    uint8_t *bytes = in_first ? (uint8_t *)first : (uint8_t *)second;
    const uint32_t here = in_first ? bit : bit - 32u * FIRST_WORDS;
    bytes[here / 8u] ^= (uint8_t)(1u << here % 8u);
    const int calls = calls_until(block);
    TEST_ASSERT_TRUE(calls > 0 && calls <= CYCLE);
    TEST_ASSERT_TRUE(calls_until(block) > 0);
    guarded_copy_seal(&copy, block);
    TEST_ASSERT_EQUAL(0, calls_until(block));
  }
}

static void test_a_bit_of_the_copy_is_found_as_well(void) {
  copy.complement[6] ^= 4u;
  TEST_ASSERT_TRUE(calls_until(second_block) > 0);
}

static void test_a_change_on_purpose_is_sealed(void) {
  first[3] = 7.0f;
  guarded_copy_seal(&copy, first_block);
  TEST_ASSERT_EQUAL(0, calls_until(GUARDED_NONE));
}

static void test_what_has_no_room_is_refused(void) {
  static const uint32_t large[GUARDED_WORDS];
  TEST_ASSERT_EQUAL(GUARDED_NONE, guarded_copy_add(&copy, large, sizeof large));
  TEST_ASSERT_EQUAL(GUARDED_NONE, guarded_copy_add(&copy, large, 0));
  for (int i = 2; i < GUARDED_BLOCKS; ++i) {
    TEST_ASSERT_EQUAL(i, guarded_copy_add(&copy, large, 4));
  }
  TEST_ASSERT_EQUAL(GUARDED_NONE, guarded_copy_add(&copy, large, 4));
}

static void test_a_single_block_is_guarded_like_several(void) {
  memset(&copy, 0, sizeof copy);
  second_block = guarded_copy_add(&copy, second, sizeof second);
  TEST_ASSERT_EQUAL(0, calls_until(GUARDED_NONE));
  second[1] ^= 1u;
  TEST_ASSERT_TRUE(calls_until(second_block) > 0);
}

static void test_an_empty_copy_finds_nothing(void) {
  memset(&copy, 0, sizeof copy);
  TEST_ASSERT_EQUAL(GUARDED_NONE, guarded_copy_step(&copy, 10));
}

int main(void) {
  UNITY_BEGIN();
  RUN_TEST(test_what_stays_is_never_found);
  RUN_TEST(test_every_bit_of_every_word_is_found_within_a_cycle_and_again_until_it_is_sealed);
  RUN_TEST(test_a_bit_of_the_copy_is_found_as_well);
  RUN_TEST(test_a_change_on_purpose_is_sealed);
  RUN_TEST(test_what_has_no_room_is_refused);
  RUN_TEST(test_a_single_block_is_guarded_like_several);
  RUN_TEST(test_an_empty_copy_finds_nothing);
  return UNITY_END();
}
