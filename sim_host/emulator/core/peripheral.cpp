// SPDX-License-Identifier: Apache-2.0
#include "core/peripheral.hpp"

#include <algorithm>
#include <utility>

namespace trackservo::target {

Peripheral::Peripheral(std::string name, Services services, std::vector<Register> registers)
    : name_(std::move(name)), services_(services), table_(std::move(registers)) {
  for (const Register& entry : table_) {
    const std::size_t word = entry.offset / 4;
    index_.resize(std::max(index_.size(), word + 1), kNone);
    index_[word] = static_cast<std::uint16_t>(values_.size());
    values_.push_back(entry.reset);
  }
}

void Peripheral::reset() {
  for (std::size_t i = 0; i < table_.size(); ++i) {
    values_[i] = table_[i].reset;
  }
  on_reset();
}

std::uint16_t Peripheral::find(std::uint32_t offset) const {
  return offset / 4 < index_.size() ? index_[offset / 4] : kNone;
}

bool Peripheral::is_accessible(std::uint32_t offset, unsigned width, const char *what) const {
  if (clock_ && !clock_()) {
    report_violation(fmt::format("{} of +0x{:02x} while its clock is off", what, offset));
    return false;
  }
  const std::uint16_t found = find(offset);
  if (found == kNone) {
    report_violation(fmt::format("{} of +0x{:02x}, which is not modelled", what, offset));
    return false;
  }
  if (width != 4 && !table_[found].narrow) {
    report_violation(
        fmt::format("{} of {} by {} byte(s); only whole words are allowed", what, table_[found].name, width));
    return false;
  }
  return true;
}

std::uint32_t Peripheral::bus_read(std::uint32_t offset, unsigned width) {
  if (!is_accessible(offset, width, "read")) {
    return 0;
  }
  const std::uint32_t word = on_read(offset & ~3U, values_[find(offset)], width);
  return width == 4 ? word : (word >> (8 * (offset & 3U))) & ((1U << (8 * width)) - 1U);
}

void Peripheral::bus_write(std::uint32_t offset, std::uint32_t value, unsigned width) {
  if (!is_accessible(offset, width, "write")) {
    return;
  }
  const Register& entry = table_[find(offset)];
  const std::uint32_t lanes = width == 4 ? 0xFFFFFFFFU : ((1U << (8 * width)) - 1U) << (8 * (offset & 3U));
  const std::uint32_t reserved = ~(entry.writable | entry.read_only) & lanes;
  const std::uint32_t shifted = width == 4 ? value : (value << (8 * (offset & 3U))) & lanes;
  if ((shifted & reserved) != (entry.reset & reserved)) {
    report_violation(fmt::format("0x{:08x} written to {} changes reserved bits 0x{:08x}", value, entry.name,
                                 (shifted ^ entry.reset) & reserved));
  }
  on_write(offset & ~3U, width == 4 ? value : (values_[find(offset)] & ~lanes) | shifted, width);
}

void Peripheral::store(std::uint32_t offset, std::uint32_t written) {
  const std::uint16_t found = find(offset);
  const std::uint32_t writable = table_[found].writable;
  values_[found] = (values_[found] & ~writable) | (written & writable);
}

}  // namespace trackservo::target
