// SPDX-License-Identifier: Apache-2.0
// The STM32G474RE as far as the board uses it: core, memories, peripherals at their addresses, their clocks and
// interrupts. The chip's owner connects the outside (board/board_machine.hpp).
#ifndef TRACKSERVO_SIM_EMULATOR_CHIP_STM32G474_HPP
#define TRACKSERVO_SIM_EMULATOR_CHIP_STM32G474_HPP

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "chip/adc.hpp"
#include "chip/capture_timer.hpp"
#include "chip/clock_timer.hpp"
#include "chip/dma.hpp"
#include "chip/fdcan.hpp"
#include "chip/fixed_registers.hpp"
#include "chip/flash_interface.hpp"
#include "chip/gpio.hpp"
#include "chip/pwr.hpp"
#include "chip/rcc.hpp"
#include "chip/spi.hpp"
#include "chip/syscfg.hpp"
#include "chip/timer.hpp"
#include "chip/usart.hpp"
#include "chip/watchdog.hpp"
#include "core/bus.hpp"
#include "core/cortex_m4.hpp"
#include "core/system_control.hpp"

namespace trackservo::target {

// Interrupt numbers (RM0440, table 97) that the board uses.
enum Interrupt : int {
  kAdc12Interrupt = 18,
  kFdcan1Interrupt0 = 21,
  kFdcan1Interrupt1 = 22,
  kTim1BreakInterrupt = 24,
  kTim1UpdateInterrupt = 25,
  kSpi1Interrupt = 35,
  kUsart1Interrupt = 37,
  kUsart3Interrupt = 39,
  kTim8BreakInterrupt = 43,
  kTim8UpdateInterrupt = 44,
  kSpi3Interrupt = 51,
  kTim6Interrupt = 54,
  kTim7Interrupt = 55,
};

class Stm32g474 {
 public:
  static constexpr std::uint32_t kFlashBytes = 512 * 1024;
  static constexpr std::uint32_t kParameterOffset = 0x7B000;  // parameter pages, to the end of the flash

  // Writes `image` to the start of the flash as a programmer would, with the option bytes that tools/image/board sets.
  explicit Stm32g474(const std::vector<std::uint8_t>& image);

  void power_on();

  // Runs for this long, resets included. `reset_happened` returns the cause.
  void run(Instant duration);
  void request_reset(ResetCause cause);
  // Sets the flags of a power-on, but RAM keeps its contents.
  void request_brown_out();
  // Counts resets other than the first power-on.
  int resets() const { return resets_; }
  ResetCause last_reset() const { return last_reset_; }
  void on_reset(std::function<void()> listener) { reset_listener_ = std::move(listener); }

  // Inverts one bit of the RAM; `address` is that of its word. Where the RAM has parity, the next read finds it. `bit`
  // may be CortexM4::kParityBit.
  void flip_ram_bit(std::uint32_t address, unsigned bit);

  // Returns the parameter pages, as a programmer reads and writes them.
  std::uint8_t *parameter_bytes() { return flash_bytes_.data() + kParameterOffset; }

  Gpio& port(char name) { return *ports_[static_cast<std::size_t>(name - 'A')]; }

  Timeline timeline;
  Exceptions exceptions;
  Violations violations;

 private:
  Services services_{timeline, exceptions, violations};
  std::vector<std::uint8_t> flash_bytes_;
  std::vector<std::uint8_t> sram_bytes_;
  std::array<std::unique_ptr<Gpio>, 7> ports_;

 public:
  Bus bus{violations};
  CortexM4 core{timeline, exceptions, violations, bus};
  SystemControl control{services_, core, [this] { request_reset(ResetCause::kSoftware); }};
  CycleCounter cycle_counter{services_, core, control};
  Rcc rcc{services_};
  Pwr pwr{services_};
  FlashInterface flash;
  FlashData parameter_pages;
  Dma dma1, dma2;
  DmaMux dma_mux{services_, dma1, dma2};
  Timer tim1, tim8, tim6;
  CaptureTimer tim16{services_, [this] { return rcc.core_hz(); }, [this] { return rcc.mco_edge_s(); }};
  ClockTimer tim5{services_, dma_mux};
  AdcCommon adc_common;
  Adc adc1{services_, "ADC1", adc_common};
  Adc adc2{services_, "ADC2", adc_common};
  Spi spi1, spi3;
  Usart usart1, usart3;
  MessageRam message_ram{services_};
  Fdcan fdcan1{services_, "FDCAN1", {kFdcan1Interrupt0, kFdcan1Interrupt1}, message_ram};
  Watchdog watchdog{services_, [this] { request_reset(ResetCause::kWatchdog); }};
  Syscfg syscfg{services_};
  DebugUnit debug{services_};
  FactoryWords factory{services_};

  // Pattern that fills uninitialised memory after power-on.
  static constexpr std::uint8_t kPowerOnPattern = 0xC3;

 private:
  void map_memories();
  void attach_all();
  void attach(Peripheral& peripheral, std::uint32_t base, std::uint32_t size);
  void give_clocks();
  void give_pins();
  void wire_timers();
  void wire_memory_protection();
  void reset(ResetCause cause);

  std::vector<Peripheral *> all_;
  IrqLine adc_line_{exceptions, kAdc12Interrupt};
  std::optional<ResetCause> reset_request_;
  bool keeps_ram_ = false;  // in the reset that is requested
  std::function<void()> reset_listener_;
  int resets_ = 0;
  ResetCause last_reset_ = ResetCause::kPowerOn;
};

}  // namespace trackservo::target

#endif
