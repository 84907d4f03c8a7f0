/* SPDX-License-Identifier: Apache-2.0 */
/* Answers of a BiSS-C encoder, written bit by bit from its protocol, and the mean of the readings. */
#include "sensors/biss.h"

#include <string.h>

#include "sensors/angle_mean.h"
#include "support/check.h"
#include "support/random.h"

void setUp(void) {}
void tearDown(void) {}

enum { NO_FLAGS = 3, ERROR_ONLY = 1, WARNING_ONLY = 2 }; /* error and warning, low active */

typedef struct {
  uint8_t bytes[BISS_BYTES];
  int count;
} answer;

static void put(answer *a, uint32_t value, int bits) {
  for (int i = bits - 1; i >= 0; --i) {
    if (a->count < 8 * BISS_BYTES && (value >> i & 1u) != 0) {
      a->bytes[a->count / 8] |= (uint8_t)(0x80 >> (a->count % 8));
    }
    a->count++;
  }
}

/* Division by x^6 + x + 1, one bit at a time. */
static uint32_t crc_by_the_definition(uint32_t checked) {
  uint64_t rest = (uint64_t)checked << BISS_CRC_BITS;
  for (int bit = BISS_CHECKED_BITS + BISS_CRC_BITS - 1; bit >= BISS_CRC_BITS; --bit) {
    if ((rest >> bit & 1u) != 0) {
      rest ^= UINT64_C(0x43) << (bit - BISS_CRC_BITS);
    }
  }
  return (uint32_t)rest;
}

static answer answer_of(uint32_t position, uint32_t flags, int line_bits, int acknowledge_bits) {
  answer a = {.count = 0};
  const uint32_t checked = position << 2 | flags;
  put(&a, UINT32_MAX, line_bits);
  put(&a, 0, acknowledge_bits);
  put(&a, 2, 2); /* start bit, CDS */
  put(&a, checked, BISS_CHECKED_BITS);
  put(&a, ~crc_by_the_definition(checked), BISS_CRC_BITS);
  return a;
}

static void test_crc_is_the_remainder_of_the_division(void) {
  random_source source = {3};
  for (int i = 0; i < 2000; ++i) {
    const uint32_t checked = (uint32_t)(random_uniform(&source, 0.0, 1.0) * 268435455.0);
    TEST_ASSERT_EQUAL_HEX32(crc_by_the_definition(checked), biss_crc(checked));
  }
}

static void test_position_is_read_at_every_delay_of_the_line(void) {
  for (int delay = 2; delay <= BISS_MAX_DELAY_BITS; ++delay) {
    const answer a = answer_of(0x2ABCDEF, NO_FLAGS, delay - 1, 1);
    biss_reading reading = {0};
    TEST_ASSERT_EQUAL(BISS_OK, biss_decode(a.bytes, &reading));
    TEST_ASSERT_EQUAL_HEX32(0x2ABCDEFu << 6, reading.angle_turn32);
    TEST_ASSERT_FALSE(reading.warning);
  }
}

static void test_position_is_read_with_every_length_of_the_acknowledge(void) {
  for (int length = 1; length < BISS_MAX_DELAY_BITS; ++length) {
    const answer a = answer_of(0x3FFFFFF, NO_FLAGS, 1, length);
    biss_reading reading = {0};
    TEST_ASSERT_EQUAL(BISS_OK, biss_decode(a.bytes, &reading));
    TEST_ASSERT_EQUAL_HEX32(0xFFFFFFC0u, reading.angle_turn32);
  }
}

static void test_an_answer_that_comes_too_late_is_none(void) {
  const answer a = answer_of(1, NO_FLAGS, BISS_MAX_DELAY_BITS, 1);
  biss_reading reading;
  TEST_ASSERT_EQUAL(BISS_NO_ANSWER, biss_decode(a.bytes, &reading));
}

static void test_a_dead_line_is_no_answer(void) {
  uint8_t bytes[BISS_BYTES];
  biss_reading reading;
  memset(bytes, 0, sizeof bytes);
  TEST_ASSERT_EQUAL(BISS_NO_ANSWER, biss_decode(bytes, &reading));
  memset(bytes, 0xFF, sizeof bytes);
  TEST_ASSERT_EQUAL(BISS_NO_ANSWER, biss_decode(bytes, &reading));
}

static void test_error_bit_refuses_and_warning_bit_warns(void) {
  biss_reading reading = {.angle_turn32 = 7};
  TEST_ASSERT_EQUAL(BISS_ERROR, biss_decode(answer_of(5, ERROR_ONLY, 3, 4).bytes, &reading));
  TEST_ASSERT_EQUAL_HEX32(7, reading.angle_turn32);
  TEST_ASSERT_EQUAL(BISS_OK, biss_decode(answer_of(5, WARNING_ONLY, 3, 4).bytes, &reading));
  TEST_ASSERT_TRUE(reading.warning);
}

/* A CRC of six bits with this polynomial finds every single and double error within 63 bits. */
static void test_no_one_or_two_wrong_bits_give_a_position(void) {
  const answer good = answer_of(0x1234567, NO_FLAGS, 2, 3);
  const int first = 2 + 3 + 2;
  const int last = first + BISS_CHECKED_BITS + BISS_CRC_BITS - 1;
  for (int i = first; i <= last; ++i) {
    for (int j = i; j <= last; ++j) {
      answer bad = good;
      bad.bytes[i / 8] ^= (uint8_t)(0x80 >> (i % 8));
      if (j != i) {
        bad.bytes[j / 8] ^= (uint8_t)(0x80 >> (j % 8));
      }
      biss_reading reading;
      TEST_ASSERT_EQUAL(BISS_BAD_CRC, biss_decode(bad.bytes, &reading));
    }
  }
}

static void test_mean_of_angles_goes_around_the_wrap(void) {
  const uint32_t around[] = {0xFFFFFFF0u, 0x00000010u, 0xFFFFFFFCu, 0x00000008u};
  TEST_ASSERT_EQUAL_HEX32(1u, angle_mean(around, 4));
  const uint32_t half_turn[] = {0x7FFFFFF0u, 0x80000010u};
  TEST_ASSERT_EQUAL_HEX32(0x80000000u, angle_mean(half_turn, 2));
  const uint32_t one[] = {0x12345678u};
  TEST_ASSERT_EQUAL_HEX32(0x12345678u, angle_mean(one, 1));
}

int main(void) {
  UNITY_BEGIN();
  RUN_TEST(test_crc_is_the_remainder_of_the_division);
  RUN_TEST(test_position_is_read_at_every_delay_of_the_line);
  RUN_TEST(test_position_is_read_with_every_length_of_the_acknowledge);
  RUN_TEST(test_an_answer_that_comes_too_late_is_none);
  RUN_TEST(test_a_dead_line_is_no_answer);
  RUN_TEST(test_error_bit_refuses_and_warning_bit_warns);
  RUN_TEST(test_no_one_or_two_wrong_bits_give_a_position);
  RUN_TEST(test_mean_of_angles_goes_around_the_wrap);
  return UNITY_END();
}
