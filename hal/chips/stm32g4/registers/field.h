/* SPDX-License-Identifier: Apache-2.0 */
/* A field of a register is its mask. Source of all of registers/: RM0440 rev 8, the facts only; every offset, field and
 * reset value is compared with the SVD-derived crate `stm32g4` by tools/registers/check_registers.py.
 *
 * Registers are members of volatile structs, named as in the manual in lower case; fields are REGISTER_FIELD macros.
 * *_RESET is a register's value after reset, where it is not 0. Only what this firmware uses is described. */
#ifndef TRACKSERVO_STM32G4_REGISTERS_FIELD_H
#define TRACKSERVO_STM32G4_REGISTERS_FIELD_H

#include <stddef.h>
#include <stdint.h>

/* width 1 .. 31 */
#define FIELD(position, width) (((1u << (width)) - 1u) << (position))

/* `value` shifted to the field; a constant when both are. */
#define FIELD_VALUE(mask, value) ((uint32_t)(value) * ((mask) & (0u - (mask))))

static inline uint32_t field_get(uint32_t word, uint32_t mask) { return (word & mask) / (mask & (0u - mask)); }

/* Reads, changes one field, writes. */
static inline void field_set(volatile uint32_t *word, uint32_t mask, uint32_t value) {
  *word = (*word & ~mask) | FIELD_VALUE(mask, value);
}

#define REGISTER_AT(type, member, offset) _Static_assert(offsetof(type, member) == (offset), "RM0440: " #member)

#endif
