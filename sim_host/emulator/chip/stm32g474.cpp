// SPDX-License-Identifier: Apache-2.0
#include "chip/stm32g474.hpp"

#include <algorithm>
#include <stdexcept>
#include <utility>

namespace trackservo::target {
namespace {

constexpr std::uint32_t kSramBytes = 128 * 1024;
constexpr std::uint32_t kSramBase = 0x20000000;
constexpr std::uint32_t kParityBytes = 32 * 1024;  // of SRAM1
constexpr std::uint32_t kCcmBase = 0x10000000;
constexpr std::uint32_t kCcmOffset = 96 * 1024;  // of the RAM; the CCM SRAM is there, too
constexpr std::uint32_t kCcmPageBytes = 1024;

constexpr std::array<int, Dma::kChannels> kDma1Interrupts = {11, 12, 13, 14, 15, 16, 17, 96};
constexpr std::array<int, Dma::kChannels> kDma2Interrupts = {56, 57, 58, 59, 60, 97, 98, 99};

}  // namespace

Stm32g474::Stm32g474(const std::vector<std::uint8_t>& image)
    : flash_bytes_(kFlashBytes, 0xFF),
      sram_bytes_(kSramBytes, kPowerOnPattern),
      flash(services_, flash_bytes_, kParameterOffset),
      parameter_pages(services_, flash, flash_bytes_, kParameterOffset, kFlashBytes - kParameterOffset),
      dma1(services_, "DMA1", kDma1Interrupts, bus,
           [this](std::uint32_t at, std::uint32_t n) { return core.memory_at(at, n); }),
      dma2(services_, "DMA2", kDma2Interrupts, bus,
           [this](std::uint32_t at, std::uint32_t n) { return core.memory_at(at, n); }),
      tim1(services_, "TIM1", {kTim1UpdateInterrupt, kTim1BreakInterrupt}, true),
      tim8(services_, "TIM8", {kTim8UpdateInterrupt, kTim8BreakInterrupt}, true),
      tim6(services_, "TIM6", {kTim6Interrupt, -1}, false),
      adc_common(services_, [this] { return rcc.core_hz(); }),
      spi1(services_, "SPI1", {kSpi1Interrupt, DmaRequest::kSpi1Rx, DmaRequest::kSpi1Tx}, dma_mux),
      spi3(services_, "SPI3", {kSpi3Interrupt, DmaRequest::kSpi3Rx, DmaRequest::kSpi3Tx}, dma_mux),
      usart1(services_, "USART1", {kUsart1Interrupt, DmaRequest::kUsart1Rx}, dma_mux),
      usart3(services_, "USART3", {kUsart3Interrupt, DmaRequest::kUsart3Rx}, dma_mux) {
  if (image.size() < 8 || image.size() > kParameterOffset) {
    throw std::invalid_argument("the image is empty or extends into the parameter pages");
  }
  std::copy(image.begin(), image.end(), flash_bytes_.begin());
  flash.set_options(FlashInterface::kOptionsAtDelivery & ~FlashInterface::kNoRamParity,
                    FlashInterface::protect_image(image.size()));
  for (std::size_t i = 0; i < ports_.size(); ++i) {
    ports_[i] = std::make_unique<Gpio>(services_, static_cast<char>('A' + i));
  }
  map_memories();
  attach_all();
  give_clocks();
  give_pins();
  wire_timers();
  wire_memory_protection();
}

void Stm32g474::map_memories() {
  core.map({0, flash_bytes_.data(), kParameterOffset, false});
  core.map({0x08000000, flash_bytes_.data(), kParameterOffset, false});
  core.map({kSramBase, sram_bytes_.data(), kCcmOffset, true});
  core.map({kSramBase + kCcmOffset, sram_bytes_.data() + kCcmOffset, kSramBytes - kCcmOffset, true});
  core.map({kCcmBase, sram_bytes_.data() + kCcmOffset, kSramBytes - kCcmOffset, true});
  core.map_bus(0x08000000 + kParameterOffset, kFlashBytes - kParameterOffset);
  core.map_bus(0x1FFF7000, 0x1000);
  core.map_bus(0x40000000, 0x20000000);
  core.map_bus(0xE0000000, 0x100000);
}

void Stm32g474::attach(Peripheral& peripheral, std::uint32_t base, std::uint32_t size) {
  bus.attach(peripheral, base, size);
  all_.push_back(&peripheral);
}

void Stm32g474::attach_all() {
  attach(tim5, 0x40000C00, 0x400);
  attach(tim6, 0x40001000, 0x400);
  attach(watchdog, 0x40003000, 0x400);
  attach(spi3, 0x40003C00, 0x400);
  attach(usart3, 0x40004800, 0x400);
  attach(fdcan1, 0x40006400, 0x400);
  attach(pwr, 0x40007000, 0x400);
  attach(message_ram, 0x4000A400, MessageRam::kBytes);
  attach(syscfg, 0x40010000, 0x400);
  attach(tim1, 0x40012C00, 0x400);
  attach(spi1, 0x40013000, 0x400);
  attach(tim8, 0x40013400, 0x400);
  attach(usart1, 0x40013800, 0x400);
  attach(tim16, 0x40014400, 0x400);
  attach(dma1, 0x40020000, 0x400);
  attach(dma2, 0x40020400, 0x400);
  attach(dma_mux, 0x40020800, 0x400);
  attach(rcc, 0x40021000, 0x400);
  attach(flash, 0x40022000, 0x400);
  for (std::uint32_t i = 0; i < ports_.size(); ++i) {
    attach(*ports_[i], 0x48000000 + 0x400 * i, 0x400);
  }
  attach(adc1, 0x50000000, 0x100);
  attach(adc2, 0x50000100, 0x100);
  attach(adc_common, 0x50000300, 0x100);
  attach(control, 0xE000E000, 0x1000);
  attach(cycle_counter, 0xE0001000, 0x1000);
  attach(debug, 0xE0042000, 0x400);
  attach(factory, 0x1FFF7000, 0x1000);
  attach(parameter_pages, 0x08000000 + kParameterOffset, kFlashBytes - kParameterOffset);
}

void Stm32g474::give_clocks() {
  struct Gate {
    Peripheral& peripheral;
    std::uint32_t enable_register;
    unsigned bit;
  };
  const Gate gates[] = {
      {dma1, 0x48, 0},    {dma2, 0x48, 1},        {dma_mux, 0x48, 2},      {flash, 0x48, 8},   {adc1, 0x4C, 13},
      {adc2, 0x4C, 13},   {adc_common, 0x4C, 13}, {tim6, 0x58, 4},         {tim5, 0x58, 3},    {spi3, 0x58, 15},
      {usart3, 0x58, 18}, {fdcan1, 0x58, 25},     {message_ram, 0x58, 25}, {pwr, 0x58, 28},    {syscfg, 0x60, 0},
      {tim1, 0x60, 11},   {spi1, 0x60, 12},       {tim8, 0x60, 13},        {usart1, 0x60, 14}, {tim16, 0x60, 17},
  };
  for (const Gate& gate : gates) {
    gate.peripheral.clocked_by(rcc.clock(gate.enable_register, gate.bit));
  }
  for (unsigned i = 0; i < ports_.size(); ++i) {
    ports_[i]->clocked_by(rcc.clock(0x4C, i));
  }
  // A timer's clock is twice its bus's when that is divided.
  const auto timer_clock = [](std::uint32_t bus_hz, std::uint32_t core_hz) {
    return bus_hz == core_hz ? bus_hz : 2 * bus_hz;
  };
  const auto apb1_timer = [this, timer_clock] { return timer_clock(rcc.pclk1_hz(), rcc.core_hz()); };
  const auto apb2_timer = [this, timer_clock] { return timer_clock(rcc.pclk2_hz(), rcc.core_hz()); };
  tim1.clocked_at(apb2_timer);
  tim8.clocked_at(apb2_timer);
  tim6.clocked_at(apb1_timer);
  tim5.clocked_at(apb1_timer);
  spi1.clocked_at([this] { return rcc.pclk2_hz(); });
  spi3.clocked_at([this] { return rcc.pclk1_hz(); });
  const auto usart_clock = [this](unsigned selection, std::uint32_t bus_hz) {
    return selection == 2 ? 16'000'000 : (selection == 1 ? rcc.core_hz() : bus_hz);
  };
  usart1.clocked_at([this, usart_clock] { return usart_clock(rcc.selection(0), rcc.pclk2_hz()); });
  usart3.clocked_at([this, usart_clock] { return usart_clock(rcc.selection(4), rcc.pclk1_hz()); });
  fdcan1.clocked_at(
      [this] { return rcc.selection(24) == 0 ? Rcc::kCrystalHz : (rcc.selection(24) == 2 ? rcc.pclk1_hz() : 1); });
  const auto configure_flash = [this] {
    core.accelerator().configure(flash.wait_states(), flash.is_cached(), flash.is_prefetching());
  };
  flash.on_access_control(configure_flash);
  rcc.supplied_by({[this] { return flash.wait_states(); }, [this] { return pwr.is_range_1(); },
                   [this] { return pwr.is_boosted(); }, [this](std::uint32_t hz) { core.set_clock(hz); }});
}

void Stm32g474::give_pins() {
  const auto pin = [this](char port_name, unsigned number, unsigned function) {
    return [this, port_name, number, function] { return port(port_name).has_function(number, function); };
  };
  spi1.wired_by(pin('B', 3, 5), pin('B', 4, 5));
  spi3.wired_by(pin('C', 10, 6), pin('C', 11, 6));
  tim5.wired_by(pin('C', 12, 1));
  usart1.wired_by(pin('C', 5, 7));
  usart3.wired_by(pin('B', 11, 7));
  fdcan1.wired_by([receive = pin('A', 11, 9), transmit = pin('A', 12, 9)] { return receive() && transmit(); });
}

void Stm32g474::wire_timers() {
  tim1.on_enable([this] { tim8.started_by_master(); });
  const auto adcs = [this](AdcTrigger trigger) {
    adc1.trigger(trigger);
    adc2.trigger(trigger);
  };
  tim1.on_trigger([adcs](bool second) { adcs(second ? AdcTrigger::kTim1Trgo2 : AdcTrigger::kTim1Trgo); });
  tim8.on_trigger([adcs](bool second) { adcs(second ? AdcTrigger::kTim8Trgo2 : AdcTrigger::kTim8Trgo); });
  const auto adc_interrupt = [this] { adc_line_.set(adc1.wants_interrupt() || adc2.wants_interrupt()); };
  adc1.monitor(adc_interrupt);
  adc2.monitor(adc_interrupt);
  const auto serve = [this] {
    spi1.serve_dma();
    spi3.serve_dma();
  };
  dma1.on_enable(serve);
  dma2.on_enable(serve);
}

void Stm32g474::wire_memory_protection() {
  syscfg.on_break([this] {
    tim1.set_system_break(syscfg.breaks_timers());
    tim8.set_system_break(syscfg.breaks_timers());
  });
  syscfg.on_protection([this] {
    for (std::uint32_t page = 0; page < 32; ++page) {
      const bool writable = (syscfg.protected_pages() >> page & 1U) == 0;
      core.allow_writes(kCcmBase + page * kCcmPageBytes, kCcmPageBytes, writable);
      core.allow_writes(kSramBase + kCcmOffset + page * kCcmPageBytes, kCcmPageBytes, writable);
    }
  });
  core.on_lock_up([this] { syscfg.find_lock_up(); });
}

void Stm32g474::flip_ram_bit(std::uint32_t address, unsigned bit) {
  const bool has_parity = address - kSramBase < kParityBytes || address - kCcmBase < kSramBytes - kCcmOffset;
  core.flip(address, bit,
            has_parity && flash.has_ram_parity() ? [this] { syscfg.find_parity_error(); } : std::function<void()>());
}

// --- resets ---

void Stm32g474::power_on() {
  std::fill(sram_bytes_.begin(), sram_bytes_.end(), kPowerOnPattern);
  reset(ResetCause::kPowerOn);
}

void Stm32g474::reset(ResetCause cause) {
  last_reset_ = cause;
  exceptions.reset();
  adc_line_.forget();
  for (Peripheral *peripheral : all_) {
    peripheral->reset();
  }
  rcc.report_cause(cause);
  core.reset();
  if (reset_listener_) {
    reset_listener_();
  }
}

void Stm32g474::request_reset(ResetCause cause) {
  reset_request_ = cause;
  keeps_ram_ = cause != ResetCause::kPowerOn;
  core.request_stop();
}

void Stm32g474::request_brown_out() {
  request_reset(ResetCause::kPowerOn);
  keeps_ram_ = true;
}

void Stm32g474::run(Instant duration) {
  const Instant until = timeline.now() + duration;
  while (timeline.now() < until) {
    core.run(until);
    if (reset_request_) {
      const ResetCause cause = *std::exchange(reset_request_, std::nullopt);
      ++resets_;
      if (keeps_ram_) {
        reset(cause);
      } else {
        power_on();
      }
    }
  }
}

}  // namespace trackservo::target
