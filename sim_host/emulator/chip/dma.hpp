// SPDX-License-Identifier: Apache-2.0
// Two DMA controllers of eight channels and their request multiplexer (RM0440, 12 and 13).
#ifndef TRACKSERVO_SIM_EMULATOR_CHIP_DMA_HPP
#define TRACKSERVO_SIM_EMULATOR_CHIP_DMA_HPP

#include <array>
#include <functional>
#include <vector>

#include "core/bus.hpp"
#include "core/peripheral.hpp"

namespace trackservo::target {

// Request numbers of the multiplexer (RM0440, table 91).
enum class DmaRequest : std::uint32_t {
  kSpi1Rx = 10,
  kSpi1Tx = 11,
  kSpi3Rx = 14,
  kSpi3Tx = 15,
  kUsart1Rx = 24,
  kUsart1Tx = 25,
  kUsart3Rx = 28,
  kUsart3Tx = 29,
  kTim5Ch2 = 73,
};

class Dma : public Peripheral {
 public:
  static constexpr unsigned kChannels = 8;

  // The memory end of a transfer; nullptr for an address that is no RAM or flash.
  using MemoryAt = std::function<std::uint8_t *(std::uint32_t address, std::uint32_t size)>;

  Dma(Services services, const char *name, const std::array<int, kChannels>& interrupts, Bus& bus, MemoryAt memory);

  bool is_enabled(unsigned channel) const { return (control(channel) & 1U) != 0 && left(channel) > 0; }

  // Moves one item of the channel.
  void transfer(unsigned channel);

  // Sets what is called when a channel is switched on.
  void on_enable(std::function<void()> listener) { enabled_ = std::move(listener); }

 protected:
  void on_write(std::uint32_t offset, std::uint32_t written, unsigned width) override;
  void on_reset() override;

 private:
  struct Channel {
    std::uint32_t memory = 0;  // next address
    std::uint32_t reload = 0;
  };

  std::uint32_t control(unsigned channel) const { return reg(0x08 + 0x14 * channel); }
  std::uint32_t left(unsigned channel) const { return reg(0x0C + 0x14 * channel); }
  void write_control(unsigned channel, std::uint32_t written);
  void flag(unsigned channel, std::uint32_t bits);
  void refresh_interrupts();

  Bus& bus_;
  MemoryAt memory_;
  std::array<Channel, kChannels> channel_{};
  std::vector<IrqLine> lines_;
  std::function<void()> enabled_;
};

class DmaMux : public Peripheral {
 public:
  DmaMux(Services services, Dma& dma1, Dma& dma2);

  // Takes a peripheral's request for one item; returns false when no enabled channel serves it.
  bool request(DmaRequest request);

 protected:
  void on_write(std::uint32_t offset, std::uint32_t written, unsigned width) override;

 private:
  Dma& dma1_;
  Dma& dma2_;
};

}  // namespace trackservo::target

#endif
