#include "core/bus.hpp"

namespace trackservo::target {

void Bus::attach(Peripheral& peripheral, std::uint32_t base, std::uint32_t size) {
  regions_.push_back({base, size, &peripheral});
}

const Bus::Region *Bus::find(std::uint32_t address, const char *what) {
  const auto holds = [address](const Region& region) { return address - region.base < region.size; };
  if (last_ < regions_.size() && holds(regions_[last_])) {
    return &regions_[last_];
  }
  for (std::size_t i = 0; i < regions_.size(); ++i) {
    if (holds(regions_[i])) {
      last_ = i;
      return &regions_[i];
    }
  }
  complaints_.add(fmt::format("{} at 0x{:08x}, where nothing is modelled", what, address));
  return nullptr;
}

std::uint32_t Bus::read(std::uint32_t address, unsigned width) {
  const Region *region = find(address, "read");
  return region != nullptr ? region->peripheral->bus_read(address - region->base, width) : 0;
}

std::uint32_t Bus::peek(std::uint32_t address) const {
  for (const Region& region : regions_) {
    if (address - region.base < region.size) {
      return region.peripheral->peek(address - region.base);
    }
  }
  return 0;
}

void Bus::write(std::uint32_t address, std::uint32_t value, unsigned width) {
  if (watcher_) {
    watcher_({address, value, value ^ peek(address)});
  }
  if (bend_ && bend_->write.address == address && bend_->write.value == value) {
    value ^= bend_->flip;
  }
  const Region *region = find(address, "write");
  if (region != nullptr) {
    region->peripheral->bus_write(address - region->base, value, width);
  }
}

}  // namespace trackservo::target
