/* SPDX-License-Identifier: Apache-2.0 */
/* The words of a proof harness: any value of a range, and what must hold. ESBMC explores every value bit by bit;
 * Frama-C (Eva) computes with intervals. Both also check each memory access, index, shift and signed sum of the code.
 */
#ifndef TRACKSERVO_TESTS_PROOFS_PROOF_H
#define TRACKSERVO_TESTS_PROOFS_PROOF_H

#include <stdbool.h>
#include <stdint.h>

#ifdef __FRAMAC__

#include <__fc_builtin.h>
#include <assert.h>

#define REQUIRE(condition, what) assert((condition) && (what))
static inline float any_float(float low, float high) { return Frama_C_float_interval(low, high); }
static inline bool any_bool(void) { return Frama_C_interval(0, 1) == 1; }
static inline uint32_t any_u32(void) { return Frama_C_unsigned_int_interval(0, UINT32_MAX); }
static inline uint16_t any_u16(void) { return (uint16_t)Frama_C_interval(0, UINT16_MAX); }
static inline uint8_t any_u8(void) { return (uint8_t)Frama_C_interval(0, UINT8_MAX); }

#else

bool nondet_bool(void);
uint8_t nondet_uchar(void);
uint16_t nondet_ushort(void);
uint32_t nondet_uint(void);
float nondet_float(void);
void __ESBMC_assume(_Bool condition);
void __ESBMC_assert(_Bool condition, const char *what);

#define ASSUME(condition) __ESBMC_assume(condition)
#define REQUIRE(condition, what) __ESBMC_assert((condition), what)
static inline float any_float(float low, float high) {
  const float value = nondet_float();
  ASSUME(value >= low && value <= high);
  return value;
}
static inline bool any_bool(void) { return nondet_bool(); }
static inline uint32_t any_u32(void) { return nondet_uint(); }
static inline uint16_t any_u16(void) { return nondet_ushort(); }
static inline uint8_t any_u8(void) { return nondet_uchar(); }

#endif

#endif
