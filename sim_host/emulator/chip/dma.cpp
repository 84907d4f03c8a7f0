// SPDX-License-Identifier: Apache-2.0
#include "chip/dma.hpp"

#include <cstring>
#include <utility>

namespace trackservo::target {
namespace {

constexpr std::uint32_t kIsr = 0x00;
constexpr std::uint32_t kIfcr = 0x04;
constexpr std::uint32_t kFirst = 0x08;  // CCR, CNDTR, CPAR, CMAR of channel 1
constexpr std::uint32_t kStep = 0x14;

constexpr std::uint32_t kEnable = 1;
constexpr std::uint32_t kCircular = 1U << 5;
constexpr std::uint32_t kFromMemory = 1U << 4;
constexpr std::uint32_t kCompleteFlag = 2;
constexpr std::uint32_t kHalfFlag = 4;

std::vector<Peripheral::Register> registers() {
  std::vector<Peripheral::Register> table = {{"ISR", kIsr, 0, 0, 0xFFFFFFFF}, {"IFCR", kIfcr, 0, 0xFFFFFFFF}};
  for (std::uint32_t channel = 0; channel < Dma::kChannels; ++channel) {
    const std::uint32_t base = kFirst + kStep * channel;
    table.push_back({"CCR", base, 0, 0x7FFF});
    table.push_back({"CNDTR", base + 4, 0, 0xFFFF});
    table.push_back({"CPAR", base + 8, 0, 0xFFFFFFFF});
    table.push_back({"CMAR", base + 12, 0, 0xFFFFFFFF});
  }
  return table;
}

}  // namespace

Dma::Dma(Services services, const char *name, const std::array<int, kChannels>& interrupts, Bus& bus, MemoryAt memory)
    : Peripheral(name, services, registers()), bus_(bus), memory_(std::move(memory)) {
  for (const int interrupt : interrupts) {
    lines_.emplace_back(services.exceptions, interrupt);
  }
}

void Dma::on_reset() {
  for (IrqLine& line : lines_) {
    line.forget();
  }
}

void Dma::refresh_interrupts() {
  for (unsigned channel = 0; channel < kChannels; ++channel) {
    const std::uint32_t flags = reg(kIsr) >> (4 * channel) & 0xEU;
    lines_[channel].set((flags & control(channel) & 0xEU) != 0);
  }
}

void Dma::flag(unsigned channel, std::uint32_t bits) {
  reg(kIsr) |= (bits | 1U) << (4 * channel);
  refresh_interrupts();
}

void Dma::transfer(unsigned channel) {
  const std::uint32_t base = kFirst + kStep * channel;
  const std::uint32_t control = reg(base);
  const std::uint32_t width = 1U << (control >> 10 & 3U);
  const std::uint32_t peripheral_width = 1U << (control >> 8 & 3U);
  Channel& state = channel_[channel];
  std::uint8_t *memory = memory_(state.memory, width);
  if (memory == nullptr || state.memory % width != 0) {
    report_violation(fmt::format("channel {}: no memory at 0x{:08x}", channel + 1, state.memory));
    return;
  }
  std::uint32_t item = 0;
  if ((control & kFromMemory) != 0) {
    std::memcpy(&item, memory, width);
    bus_.write(reg(base + 8), item, peripheral_width);
  } else {
    item = bus_.read(reg(base + 8), peripheral_width);
    std::memcpy(memory, &item, width);
  }
  state.memory += (control & 1U << 7) != 0 ? width : 0;
  --reg(base + 4);
  if (reg(base + 4) == state.reload / 2) {
    flag(channel, kHalfFlag);
  }
  if (reg(base + 4) == 0) {
    flag(channel, kCompleteFlag);
    if ((control & kCircular) != 0) {
      reg(base + 4) = state.reload;
      state.memory = reg(base + 12);
    }
  }
}

void Dma::write_control(unsigned channel, std::uint32_t written) {
  const std::uint32_t base = kFirst + kStep * channel;
  const bool was_enabled = (reg(base) & kEnable) != 0;
  if (was_enabled) {  // everything else is read-only until it is off
    require((written & kEnable) == 0 || ((written ^ reg(base)) & 0x7FF0U) == 0, "a running channel is reconfigured");
    written = (reg(base) & ~0xFU) | (written & 0xFU);
  }
  store(base, written);
  if (!was_enabled && (written & kEnable) != 0) {
    require((written & 1U << 14) == 0 && (written & 1U << 6) == 0, "memory to memory is not modelled");
    require((written >> 8 & 3U) == (written >> 10 & 3U), "different widths at both ends are not modelled");
    require(reg(base + 4) != 0, "a channel is started with a transfer count of 0");
    channel_[channel] = {reg(base + 12), reg(base + 4)};
    if (enabled_) {
      enabled_();
    }
  }
  refresh_interrupts();
}

void Dma::on_write(std::uint32_t offset, std::uint32_t written, unsigned /*width*/) {
  if (offset == kIfcr) {
    std::uint32_t clear = written;
    for (unsigned channel = 0; channel < kChannels; ++channel) {
      if ((written >> (4 * channel) & 1U) != 0) {
        clear |= 0xFU << (4 * channel);
      }
    }
    reg(kIsr) &= ~clear;
    refresh_interrupts();
    return;
  }
  const unsigned channel = (offset - kFirst) / kStep;
  if ((offset - kFirst) % kStep == 0) {
    write_control(channel, written);
    return;
  }
  require((control(channel) & kEnable) == 0, "transfer count or address of a running channel is written");
  store(offset, written);
}

DmaMux::DmaMux(Services services, Dma& dma1, Dma& dma2)
    : Peripheral("DMAMUX1", services,
                 [] {
                   std::vector<Register> table;
                   for (std::uint32_t channel = 0; channel < 2 * Dma::kChannels; ++channel) {
                     table.push_back({"CCR", 4 * channel, 0, 0x1FFF037F});
                   }
                   table.push_back({"CSR", 0x80, 0, 0, 0xFFFF});
                   table.push_back({"CFR", 0x84, 0, 0xFFFF});
                   return table;
                 }()),
      dma1_(dma1),
      dma2_(dma2) {}

bool DmaMux::request(DmaRequest request) {
  for (unsigned channel = 0; channel < 2 * Dma::kChannels; ++channel) {
    if ((reg(4 * channel) & 0x7FU) != static_cast<std::uint32_t>(request)) {
      continue;
    }
    Dma& dma = channel < Dma::kChannels ? dma1_ : dma2_;
    if (dma.is_enabled(channel % Dma::kChannels)) {
      dma.transfer(channel % Dma::kChannels);
      return true;
    }
  }
  return false;
}

void DmaMux::on_write(std::uint32_t offset, std::uint32_t written, unsigned /*width*/) {
  require((written & 0x1FFF0300U) == 0 || offset >= 0x80, "synchronised requests are not modelled");
  store(offset, written);
}

}  // namespace trackservo::target
