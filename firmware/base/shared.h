/* SPDX-License-Identifier: Apache-2.0 */
/* Variables that two contexts share, of which one interrupts the other: in C and C++17 alike, with one representation.
 *
 * C reads and writes them with atomic_load_explicit and atomic_store_explicit, C++ with load and store. On the board
 * each is a plain load or store of a word, half-word or byte. */
#ifndef TRACKSERVO_BASE_SHARED_H
#define TRACKSERVO_BASE_SHARED_H

#include <stdbool.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C++" {
#include <atomic>
}
typedef std::atomic<uint32_t> shared_word; /* C++17 has no stdatomic.h */
typedef std::atomic<float> shared_float;
typedef std::atomic<bool> shared_flag;
#else
#include <stdatomic.h>
typedef _Atomic uint32_t shared_word;
typedef _Atomic float shared_float;
typedef _Atomic bool shared_flag;
#endif

#endif
