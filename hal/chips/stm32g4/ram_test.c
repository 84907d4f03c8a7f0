/* SPDX-License-Identifier: Apache-2.0 */
#include "ram_test.h"

#include <stdint.h>

/* From the linker script; only their addresses are meaningful. */
extern volatile uint32_t stack_limit[];
extern uint32_t stack_top[];
extern volatile uint32_t data_start[];
extern uint32_t retained_start[];
extern volatile uint32_t ccm_start[];
extern uint32_t ccm_end[];

#define ZEROS 0u
#define ONES UINT32_MAX

/* The result may lie in damaged memory too: it is valid only as a word and its complement. */
#define PASSED 0x4D415243u

__attribute__((section(".noinit"))) static volatile struct {
  uint32_t passed;
  uint32_t complement;
} verdict;

/* Both return the bits in which any word was wrong. */
static uint32_t upwards(volatile uint32_t *first, uint32_t words, uint32_t expected, uint32_t written) {
  uint32_t wrong = 0;
  /* Bound: 24576, the words of the RAM; at the start. */
  for (uint32_t i = 0; i < words; ++i) {
    wrong |= first[i] ^ expected;
    first[i] = written;
  }
  return wrong;
}

static uint32_t downwards(volatile uint32_t *first, uint32_t words, uint32_t expected, uint32_t written) {
  uint32_t wrong = 0;
  /* Bound: 24576, the words of the RAM; at the start. */
  for (uint32_t i = words; i > 0; --i) {
    wrong |= first[i - 1] ^ expected;
    first[i - 1] = written;
  }
  return wrong;
}

/* Without reading: with parity, reading a word that was never written is an error. */
static void fill(volatile uint32_t *first, uint32_t words, uint32_t written) {
  /* Bound: 24576, the words of the RAM; at the start. */
  for (uint32_t i = 0; i < words; ++i) {
    first[i] = written;
  }
}

static uint32_t march(volatile uint32_t *first, uintptr_t end) {
  const uint32_t words = (uint32_t)(end - (uintptr_t)first) / sizeof(uint32_t);
  fill(first, words, ZEROS);
  uint32_t wrong = upwards(first, words, ZEROS, ONES);
  wrong |= upwards(first, words, ONES, ZEROS);
  wrong |= downwards(first, words, ZEROS, ONES);
  wrong |= downwards(first, words, ONES, ZEROS);
  return wrong | upwards(first, words, ZEROS, ZEROS);
}

void ram_test_run(void) {
  const uint32_t wrong = march(stack_limit, (uintptr_t)stack_top - RAM_TEST_STACK_BYTES) |
                         march(data_start, (uintptr_t)retained_start) | march(ccm_start, (uintptr_t)ccm_end);
  verdict.passed = wrong == 0 ? PASSED : 0;
  verdict.complement = wrong == 0 ? ~PASSED : 0;
}

bool ram_test_passed(void) { return verdict.passed == PASSED && verdict.complement == ~PASSED; }
