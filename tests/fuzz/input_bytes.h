/* SPDX-License-Identifier: Apache-2.0 */
/* A fuzzer's input, taken byte by byte; zeros follow its end. */
#ifndef TRACKSERVO_TESTS_FUZZ_INPUT_BYTES_H
#define TRACKSERVO_TESTS_FUZZ_INPUT_BYTES_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

typedef struct {
  const uint8_t *bytes;
  size_t left;
} input_bytes;

static inline bool input_is_empty(const input_bytes *input) { return input->left == 0; }

static inline uint8_t input_u8(input_bytes *input) {
  if (input->left == 0) {
    return 0;
  }
  input->left--;
  return *input->bytes++;
}

static inline uint16_t input_u16(input_bytes *input) {
  const uint8_t low = input_u8(input);
  return (uint16_t)(low | input_u8(input) << 8);
}

#endif
