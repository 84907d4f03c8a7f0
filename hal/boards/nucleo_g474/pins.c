/* SPDX-License-Identifier: Apache-2.0 */
#include "pins.h"

#include <stdint.h>

#include "outputs.h"
#include "registers/gpio.h"
#include "registers/rcc.h"
#include "registers/timer.h"

typedef enum { INPUT = 0, OUTPUT = 1, ALTERNATE = 2, ANALOG = 3 } pin_mode;
typedef enum { NO_PULL = 0, PULL_UP = 1, PULL_DOWN = 2 } pin_pull;
typedef enum { SLOW = 0, MEDIUM = 1, FAST = 2 } pin_speed;

typedef struct {
  gpio_registers *port;
  uint32_t pin;
  pin_mode mode;
  uint32_t function; /* alternate function number */
  pin_pull pull;
  pin_speed speed;
} pin_use;

enum { LED_PIN = 5 };                                      /* of port A */
enum { AZIMUTH_CONTACT_PIN = 5, PITCH_CONTACT_PIN = 7 };   /* of port B */
enum { STO_A_PIN = 2, STO_B_PIN = 3 };                     /* of port C */
enum { AZIMUTH_READBACK_PIN = 1, PITCH_READBACK_PIN = 2 }; /* of port B */
enum { BUTTON_PIN = 13 }; /* of port C: B1 of the NUCLEO board, high while it is held */

/* Gate signals are pulled low, so a bridge without a running processor is off. A driver's fault line is pulled to
 * fault, so a broken wire reads as a fault. Alternate functions: data sheet DS12288. */
static const pin_use pins[] = {
    /* azimuth bridge: TIM1 CH1, CH1N, CH2, CH2N, BKIN */
    {GPIOA, 8, ALTERNATE, 6, PULL_DOWN, MEDIUM},
    {GPIOB, 13, ALTERNATE, 6, PULL_DOWN, MEDIUM},
    {GPIOA, 9, ALTERNATE, 6, PULL_DOWN, MEDIUM},
    {GPIOB, 14, ALTERNATE, 6, PULL_DOWN, MEDIUM},
    {GPIOB, 12, ALTERNATE, 6, PULL_DOWN, SLOW},
    /* pitch bridge: TIM8 CH1, CH1N, CH2, CH2N, BKIN */
    {GPIOC, 6, ALTERNATE, 4, PULL_DOWN, MEDIUM},
    {GPIOA, 7, ALTERNATE, 4, PULL_DOWN, MEDIUM},
    {GPIOC, 7, ALTERNATE, 4, PULL_DOWN, MEDIUM},
    {GPIOB, 0, ALTERNATE, 4, PULL_DOWN, MEDIUM},
    {GPIOA, 6, ALTERNATE, 4, PULL_DOWN, SLOW},
    /* bridge enables */
    {GPIOC, AZIMUTH_ENABLE_PIN, OUTPUT, 0, NO_PULL, SLOW},
    {GPIOC, PITCH_ENABLE_PIN, OUTPUT, 0, NO_PULL, SLOW},
    /* azimuth current, bus voltage, pitch current, heat sink: ADC1_IN1, ADC1_IN6, ADC2_IN2, ADC2_IN7 */
    {GPIOA, 0, ANALOG, 0, NO_PULL, SLOW},
    {GPIOC, 0, ANALOG, 0, NO_PULL, SLOW},
    {GPIOA, 1, ANALOG, 0, NO_PULL, SLOW},
    {GPIOC, 1, ANALOG, 0, NO_PULL, SLOW},
    /* azimuth encoder: SPI1 SCK, MISO; a line without an encoder reads low, which is no valid answer */
    {GPIOB, 3, ALTERNATE, 5, NO_PULL, MEDIUM},
    {GPIOB, 4, ALTERNATE, 5, PULL_DOWN, SLOW},
    /* pitch encoder: SPI3 SCK, MISO */
    {GPIOC, 10, ALTERNATE, 6, NO_PULL, MEDIUM},
    {GPIOC, 11, ALTERNATE, 6, PULL_DOWN, SLOW},
    /* azimuth gyro: USART1 TX, RX; pitch gyro: USART3 TX, RX; a UART line idles high */
    {GPIOC, 4, ALTERNATE, 7, NO_PULL, SLOW},
    {GPIOC, 5, ALTERNATE, 7, PULL_UP, SLOW},
    {GPIOB, 10, ALTERNATE, 7, NO_PULL, SLOW},
    {GPIOB, 11, ALTERNATE, 7, PULL_UP, SLOW},
    /* CAN: FDCAN1 RX, TX */
    {GPIOA, 11, ALTERNATE, 9, PULL_UP, SLOW},
    {GPIOA, 12, ALTERNATE, 9, NO_PULL, MEDIUM},
    /* STO: channel A, channel B as second break input TIM1 BKIN2 and TIM8 BKIN2, the drivers' enables behind the gate
     * of channel A; a broken wire reads as torque off */
    {GPIOC, STO_A_PIN, INPUT, 0, PULL_DOWN, SLOW},
    {GPIOC, 3, ALTERNATE, 6, PULL_DOWN, SLOW},
    {GPIOB, 6, ALTERNATE, 10, PULL_DOWN, SLOW},
    {GPIOB, AZIMUTH_READBACK_PIN, INPUT, 0, PULL_DOWN, SLOW},
    {GPIOB, PITCH_READBACK_PIN, INPUT, 0, PULL_DOWN, SLOW},
    /* holding brakes: coils, contacts */
    {GPIOB, AZIMUTH_BRAKE_PIN, OUTPUT, 0, NO_PULL, SLOW},
    {GPIOB, PITCH_BRAKE_PIN, OUTPUT, 0, NO_PULL, SLOW},
    {GPIOB, AZIMUTH_CONTACT_PIN, INPUT, 0, PULL_DOWN, SLOW},
    {GPIOB, PITCH_CONTACT_PIN, INPUT, 0, PULL_DOWN, SLOW},
    /* strobe of the camera: TIM5 CH2 */
    {GPIOC, 12, ALTERNATE, 1, PULL_DOWN, SLOW},
    {GPIOA, LED_PIN, OUTPUT, 0, NO_PULL, SLOW},
    {GPIOC, BUTTON_PIN, INPUT, 0, PULL_DOWN, SLOW},
};

static void start(const pin_use *use) {
  const uint32_t pin = use->pin;
  if (use->mode == OUTPUT) {
    use->port->bsrr = GPIO_CLEAR(pin);
  }
  field_set(&use->port->pupdr, GPIO_PIN_2BIT(pin), use->pull);
  field_set(&use->port->ospeedr, GPIO_PIN_2BIT(pin), use->speed);
  field_set(&use->port->afr[pin / 8u], GPIO_PIN_4BIT(pin), use->function);
  field_set(&use->port->moder, GPIO_PIN_2BIT(pin), use->mode);
}

void pins_start(void) {
  for (unsigned i = 0; i < sizeof pins / sizeof pins[0]; ++i) {
    start(&pins[i]);
  }
}

void safe_outputs(void) {
  RCC->ahb2enr |= RCC_AHB2ENR_GPIOBEN | RCC_AHB2ENR_GPIOCEN;
  RCC->apb2enr |= RCC_APB2ENR_TIM1EN | RCC_APB2ENR_TIM8EN;
  (void)RCC->apb2enr; /* a clock needs two cycles before the first access; reading back takes that long */
  TIM1->bdtr &= ~TIM1_BDTR_MOE;
  TIM8->bdtr &= ~TIM1_BDTR_MOE;
  GPIOC->bsrr = GPIO_CLEAR(AZIMUTH_ENABLE_PIN) | GPIO_CLEAR(PITCH_ENABLE_PIN);
  GPIOB->bsrr = GPIO_CLEAR(AZIMUTH_BRAKE_PIN) | GPIO_CLEAR(PITCH_BRAKE_PIN);
  field_set(&GPIOB->moder, GPIO_PIN_2BIT(AZIMUTH_BRAKE_PIN), OUTPUT);
  field_set(&GPIOB->moder, GPIO_PIN_2BIT(PITCH_BRAKE_PIN), OUTPUT);
  field_set(&GPIOC->moder, GPIO_PIN_2BIT(AZIMUTH_ENABLE_PIN), OUTPUT);
  field_set(&GPIOC->moder, GPIO_PIN_2BIT(PITCH_ENABLE_PIN), OUTPUT);
}

void pins_release_brake(int axis, bool release) {
  const uint32_t pin = axis == 0 ? AZIMUTH_BRAKE_PIN : PITCH_BRAKE_PIN;
  GPIOB->bsrr = release ? GPIO_SET(pin) : GPIO_CLEAR(pin);
}

static bool is_high(const gpio_registers *port, uint32_t pin) { return (port->idr & GPIO_SET(pin)) != 0; }

static bool is_set(const gpio_registers *port, uint32_t pin) { return (port->odr & GPIO_SET(pin)) != 0; }

bool pins_brake_is_released(int axis) { return is_high(GPIOB, axis == 0 ? AZIMUTH_CONTACT_PIN : PITCH_CONTACT_PIN); }

safe_torque_inputs pins_read_safe_torque(void) {
  return (safe_torque_inputs){
      .channel_a = is_high(GPIOC, STO_A_PIN),
      .channel_b = is_high(GPIOC, STO_B_PIN),
      .enable = {is_high(GPIOB, AZIMUTH_READBACK_PIN), is_high(GPIOB, PITCH_READBACK_PIN)},
      .commanded = {is_set(GPIOC, AZIMUTH_ENABLE_PIN), is_set(GPIOC, PITCH_ENABLE_PIN)},
  };
}

void pins_light_led(bool on) { GPIOA->bsrr = on ? GPIO_SET(LED_PIN) : GPIO_CLEAR(LED_PIN); }

bool pins_button_is_held(void) { return is_high(GPIOC, BUTTON_PIN); }
