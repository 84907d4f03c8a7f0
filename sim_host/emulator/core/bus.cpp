// SPDX-License-Identifier: Apache-2.0
#include "core/bus.hpp"

namespace trackservo::target {

void Bus::attach(Peripheral& peripheral, std::uint32_t base, std::uint32_t size) {
  regions_.push_back({base, size, &peripheral});
  last_ = nullptr;
}

const Bus::Region *Bus::find(std::uint32_t address) const {
  for (const Region& region : regions_) {
    if (address - region.base < region.size) {
      return &region;
    }
  }
  return nullptr;
}

const Bus::Region *Bus::find(std::uint32_t address, const char *what) {
  if (last_ == nullptr || address - last_->base >= last_->size) {
    last_ = find(address);
  }
  if (last_ == nullptr) {
    violations_.add(fmt::format("{} at 0x{:08x}, where nothing is modelled", what, address));
  }
  return last_;
}

std::uint32_t Bus::read(std::uint32_t address, unsigned width) {
  const Region *region = find(address, "read");
  return region != nullptr ? region->peripheral->bus_read(address - region->base, width) : 0;
}

std::uint32_t Bus::peek(std::uint32_t address) const {
  const Region *region = find(address);
  return region != nullptr ? region->peripheral->peek(address - region->base) : 0;
}

std::uint32_t Bus::writable(std::uint32_t address) const {
  const Region *region = find(address);
  return region != nullptr ? region->peripheral->writable(address - region->base) : 0;
}

void Bus::write(std::uint32_t address, std::uint32_t value, unsigned width) {
  if (monitor_) {
    const unsigned shift = width == 4 ? 0 : 8 * (address & 3U);
    const std::uint32_t lanes = width == 4 ? 0xFFFFFFFFU : (1U << (8 * width)) - 1U;
    monitor_({address, value, (value ^ peek(address) >> shift) & writable(address) >> shift & lanes});
  }
  if (bend_ && bend_->address == address) {
    value = bend_->forced ? value | bend_->bit : value & ~bend_->bit;
  }
  const Region *region = find(address, "write");
  if (region != nullptr) {
    region->peripheral->bus_write(address - region->base, value, width);
  }
}

}  // namespace trackservo::target
