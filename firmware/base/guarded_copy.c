/* SPDX-License-Identifier: Apache-2.0 */
#include "base/guarded_copy.h"

#include <string.h>

static uint32_t word_of(const guarded_block *block, uint32_t i) {
  uint32_t word;
  memcpy(&word, (const uint8_t *)block->data + sizeof word * i, sizeof word);
  return word;
}

int guarded_copy_add(guarded_copy *copy, const void *data, uint32_t bytes) {
  const uint32_t words = bytes / (uint32_t)sizeof(uint32_t);
  if (copy->block_count >= GUARDED_BLOCKS || words == 0 || words > GUARDED_WORDS - copy->word_count) {
    return GUARDED_NONE;
  }
  const int number = (int)copy->block_count++;
  copy->blocks[number] = (guarded_block){.data = data, .first = copy->word_count, .words = words};
  copy->word_count += words;
  guarded_copy_seal(copy, number);
  return number;
}

void guarded_copy_seal(guarded_copy *copy, int block) {
  const guarded_block *sealed = &copy->blocks[block];
  /* Bound: GUARDED_WORDS: guarded_copy_add refuses more. */
  for (uint32_t i = 0; i < sealed->words; ++i) {
    copy->complement[sealed->first + i] = ~word_of(sealed, i);
  }
}

/* Whether one of these words differs from its copy. */
static bool differ(const guarded_block *block, const uint32_t *complement, uint32_t from, uint32_t end) {
  uint32_t equal_bits = UINT32_MAX;
  /* Bound: GUARDED_SETS_WORDS_PER_MS: what its caller gives. */
  for (uint32_t i = from; i < end; ++i) {
    equal_bits &= word_of(block, i) ^ complement[i];
  }
  return equal_bits != UINT32_MAX;
}

int guarded_copy_step(guarded_copy *copy, uint32_t words) {
  if (copy->block_count == 0) {
    return GUARDED_NONE;
  }
  const uint32_t number = copy->block;
  const guarded_block *block = &copy->blocks[number];
  const uint32_t from = copy->word;
  const uint32_t left = block->words - from;
  const uint32_t end = from + (words < left ? words : left);
  copy->word = end;
  if (end == block->words) {
    copy->word = 0;
    copy->block = number + 1u < copy->block_count ? number + 1u : 0;
  }
  return differ(block, &copy->complement[block->first], from, end) ? (int)number : GUARDED_NONE;
}
