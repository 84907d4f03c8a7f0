/* SPDX-License-Identifier: Apache-2.0 */
#include "hot_code.h"

#include "registers/rcc.h"
#include "registers/syscfg.h"

/* From the linker script; only their addresses are meaningful. */
extern volatile uint32_t hot_code_start[];
extern uint32_t hot_code_end[];
extern const uint32_t hot_code_image[];

#define ALL_PAGES UINT32_MAX

static uint32_t word_count(void) {
  return (uint32_t)((uintptr_t)hot_code_end - (uintptr_t)hot_code_start) / (uint32_t)sizeof(uint32_t);
}

void hot_code_load(void) {
  const uint32_t words = word_count();
  /* Bound: 8192, the words of the CCM SRAM; at the start. */
  for (uint32_t i = 0; i < words; ++i) {
    hot_code_start[i] = hot_code_image[i];
  }
  RCC->apb2enr |= RCC_APB2ENR_SYSCFGEN;
  (void)RCC->apb2enr;
  SYSCFG->swpr = ALL_PAGES;
  __asm volatile("dsb\n isb" ::: "memory");
}

bool hot_code_check_step(uint32_t *at, uint32_t words) {
  const uint32_t end = word_count();
  uint32_t wrong = 0;
  /* Bound: 8192, the words of the CCM SRAM, at the start; 8 in the background. */
  for (uint32_t i = 0; i < words && *at < end; ++i) {
    wrong |= hot_code_start[*at] ^ hot_code_image[*at];
    ++*at;
  }
  *at = *at < end ? *at : 0;
  return wrong == 0;
}

bool hot_code_is_whole(void) {
  uint32_t at = 0;
  return SYSCFG->swpr == ALL_PAGES && hot_code_check_step(&at, UINT32_MAX);
}
