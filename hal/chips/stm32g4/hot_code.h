/* SPDX-License-Identifier: Apache-2.0 */
/* The hot code: what the frequent interrupts run, in the 32 KiB of CCM SRAM, from which the processor fetches without
 * waiting. tools/image/hot_code.py selects it; the image in flash has the original.
 *
 *     start-up: copy -> write protection of all pages (SYSCFG_SWPR) -> compare; in operation: compare, piece by piece
 *
 * The copy is compared with the original word by word, and the original has a CRC-32 (image_check.h). Together they
 * find every damage of the copy. The handlers of faults are not part of it. */
#ifndef TRACKSERVO_STM32G4_HOT_CODE_H
#define TRACKSERVO_STM32G4_HOT_CODE_H

#include <stdbool.h>
#include <stdint.h>

/* Copies the hot code into RAM. Call by the start-up, before anything else runs that could be hot: needs no variables.
 * Until the next reset nothing can write this RAM again. */
void hot_code_load(void);

/* Returns whether the whole copy is right and its pages are protected. Takes about 1 ms. */
bool hot_code_is_whole(void);

/* Compares the words from offset `*at` on, at most `words` of them, and moves it on; after the last word it begins
 * again. Returns false for damage. */
bool hot_code_check_step(uint32_t *at, uint32_t words);

#endif
