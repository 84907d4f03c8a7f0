/* SPDX-License-Identifier: Apache-2.0 */
/* Values that must not change by themselves: gains, limits, motor data. Each block has a complement copy; a slice of
 * all blocks is compared per call, so that a bit that flips in either copy is found within one cycle.
 *
 * The blocks are those that the program adds at its start, at most GUARDED_BLOCKS of them. Whoever changes a block
 * seals it afterwards. Sizes are multiples of 4 bytes. */
#ifndef TRACKSERVO_BASE_GUARDED_COPY_H
#define TRACKSERVO_BASE_GUARDED_COPY_H

#include <stdbool.h>
#include <stdint.h>

enum { GUARDED_BLOCKS = 7, GUARDED_WORDS = 320, GUARDED_NONE = -1 };

typedef struct {
  const void *data;
  uint32_t first; /* of its words among all */
  uint32_t words;
} guarded_block;

typedef struct {
  guarded_block blocks[GUARDED_BLOCKS];
  uint32_t block_count;
  uint32_t word_count;
  uint32_t block; /* compared next */
  uint32_t word;  /* of this block */
  uint32_t complement[GUARDED_WORDS];
} guarded_copy;

/* Adds a block and takes its complement. Returns its number, or GUARDED_NONE when there is no room. */
int guarded_copy_add(guarded_copy *copy, const void *data, uint32_t bytes);

/* Renews the complement of a block. Call after every intended change of it. */
void guarded_copy_seal(guarded_copy *copy, int block);

/* Compares the next `words` words, at most to the end of their block. Returns the block if it differs from its
 * complement, else GUARDED_NONE. */
int guarded_copy_step(guarded_copy *copy, uint32_t words);

#endif
