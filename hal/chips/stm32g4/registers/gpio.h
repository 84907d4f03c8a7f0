/* SPDX-License-Identifier: Apache-2.0 */
/* General-purpose I/O: RM0440, the facts only. */
#ifndef TRACKSERVO_STM32G4_REGISTERS_GPIO_H
#define TRACKSERVO_STM32G4_REGISTERS_GPIO_H

#include "registers/field.h"

typedef struct {
  volatile uint32_t moder;
  volatile uint32_t otyper;
  volatile uint32_t ospeedr;
  volatile uint32_t pupdr;
  volatile uint32_t idr;
  volatile uint32_t odr;
  volatile uint32_t bsrr;
  volatile uint32_t lckr;
  volatile uint32_t afr[2]; /* AFRL: pins 0 .. 7, AFRH: 8 .. 15 */
  volatile uint32_t brr;
} gpio_registers;
REGISTER_AT(gpio_registers, brr, 0x28);

#define GPIOA ((gpio_registers *)0x48000000u)
#define GPIOB ((gpio_registers *)0x48000400u)
#define GPIOC ((gpio_registers *)0x48000800u)

/* JTAG is on PA13 .. PA15, PB3, PB4 after reset. */
#define GPIOA_MODER_RESET 0xABFFFFFFu
#define GPIOB_MODER_RESET 0xFFFFFEBFu
#define GPIOC_MODER_RESET 0xFFFFFFFFu
#define GPIOA_OSPEEDR_RESET 0x0C000000u
#define GPIOB_OSPEEDR_RESET 0x000000C0u
#define GPIOA_PUPDR_RESET 0x64000000u
#define GPIOB_PUPDR_RESET 0x00000100u

/* Of pin n: two bits of MODER, OSPEEDR and PUPDR, four of AFR, one of the others. */
#define GPIO_PIN_2BIT(pin) FIELD(2u * (pin), 2)
#define GPIO_PIN_4BIT(pin) FIELD(4u * ((pin) % 8u), 4)
#define GPIO_SET(pin) FIELD(pin, 1)
#define GPIO_CLEAR(pin) FIELD((pin) + 16u, 1)

#endif
