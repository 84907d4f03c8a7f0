/* SPDX-License-Identifier: Apache-2.0 */
/* The published vectors of SipHash-2-4 (appendix A of the paper, and the authors' list): key 00 .. 0F, messages 00, 01,
 * 02 ... of each length. */
#include "base/siphash.h"

#include "unity.h"

void setUp(void) {}
void tearDown(void) {}

static const siphash_key key = {UINT64_C(0x0706050403020100), UINT64_C(0x0F0E0D0C0B0A0908)};

static void test_it_gives_the_published_values(void) {
  static const struct {
    uint32_t length;
    uint64_t hash;
  } vectors[] = {
      {0, UINT64_C(0x726FDB47DD0E0E31)},  {1, UINT64_C(0x74F839C593DC67FD)},  {2, UINT64_C(0x0D6C8009D9A94F5A)},
      {3, UINT64_C(0x85676696D7FB7E2D)},  {4, UINT64_C(0xCF2794E0277187B7)},  {7, UINT64_C(0xAB0200F58B01D137)},
      {8, UINT64_C(0x93F5F5799A932462)},  {15, UINT64_C(0xA129CA6149BE45E5)}, {16, UINT64_C(0x3F2ACC7F57C29BDB)},
      {63, UINT64_C(0x958A324CEB064572)},
  };
  uint8_t message[63];
  for (uint8_t i = 0; i < sizeof message; ++i) {
    message[i] = i;
  }
  for (uint32_t i = 0; i < sizeof vectors / sizeof vectors[0]; ++i) {
    TEST_ASSERT_EQUAL_HEX64(vectors[i].hash, siphash(&key, message, vectors[i].length));
  }
}

static void test_each_bit_of_key_and_message_changes_it(void) {
  const uint8_t message[8] = {'s', 'e', 'c', 'r', 'e', 't', '!', 0};
  const uint64_t hash = siphash(&key, message, sizeof message);
  for (uint32_t bit = 0; bit < 64; ++bit) {
    uint8_t other[8];
    for (uint32_t i = 0; i < sizeof other; ++i) {
      other[i] = (uint8_t)(message[i] ^ (bit / 8 == i ? 1u << bit % 8 : 0u));
    }
    const siphash_key low = {key.low ^ UINT64_C(1) << bit, key.high};
    const siphash_key high = {key.low, key.high ^ UINT64_C(1) << bit};
    TEST_ASSERT_NOT_EQUAL_UINT64(hash, siphash(&key, other, sizeof other));
    TEST_ASSERT_NOT_EQUAL_UINT64(hash, siphash(&low, message, sizeof message));
    TEST_ASSERT_NOT_EQUAL_UINT64(hash, siphash(&high, message, sizeof message));
  }
}

int main(void) {
  UNITY_BEGIN();
  RUN_TEST(test_it_gives_the_published_values);
  RUN_TEST(test_each_bit_of_key_and_message_changes_it);
  return UNITY_END();
}
