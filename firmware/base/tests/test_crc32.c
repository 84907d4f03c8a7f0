/* SPDX-License-Identifier: Apache-2.0 */
/* CRC-32 against the check value of its definition and against values of zlib. */
#include "base/crc32.h"

#include <string.h>

#include "unity.h"

void setUp(void) {}
void tearDown(void) {}

static uint32_t crc_of(const char *text) {
  return crc32_end(crc32_add(CRC32_START, (const uint8_t *)text, (uint32_t)strlen(text)));
}

/* The check value of the catalogue: the nine digits. Any other polynomial, start, direction or inversion differs. */
static void test_the_nine_digits_give_the_check_value(void) {
  TEST_ASSERT_EQUAL_HEX32(0xCBF43926, crc_of("123456789"));
}

static void test_texts_give_the_values_of_zlib(void) {
  TEST_ASSERT_EQUAL_HEX32(0x00000000, crc_of(""));
  TEST_ASSERT_EQUAL_HEX32(0xE8B7BE43, crc_of("a"));
  TEST_ASSERT_EQUAL_HEX32(0x414FA339, crc_of("The quick brown fox jumps over the lazy dog"));
}

static void test_bytes_that_come_in_pieces_give_the_same_sum(void) {
  const uint8_t *digits = (const uint8_t *)"123456789";
  for (uint32_t cut = 0; cut <= 9; ++cut) {
    const uint32_t first = crc32_add(CRC32_START, digits, cut);
    TEST_ASSERT_EQUAL_HEX32(0xCBF43926, crc32_end(crc32_add(first, digits + cut, 9 - cut)));
  }
}

int main(void) {
  UNITY_BEGIN();
  RUN_TEST(test_the_nine_digits_give_the_check_value);
  RUN_TEST(test_texts_give_the_values_of_zlib);
  RUN_TEST(test_bytes_that_come_in_pieces_give_the_same_sum);
  return UNITY_END();
}
