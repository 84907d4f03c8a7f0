// SPDX-License-Identifier: Apache-2.0
#include "chip/flash_interface.hpp"

#include <algorithm>
#include <cstring>

namespace trackservo::target {
namespace {

constexpr std::uint32_t kAcr = 0x00;
constexpr std::uint32_t kKeyr = 0x08;
constexpr std::uint32_t kSr = 0x10;
constexpr std::uint32_t kCr = 0x14;
constexpr std::uint32_t kEccr = 0x18;

constexpr std::uint32_t kOptr = 0x20;
constexpr std::uint32_t kWrp1ar = 0x2C;

constexpr std::uint32_t kProgram = 1;
constexpr std::uint32_t kPageErase = 2;
constexpr std::uint32_t kStart = 1U << 16;
constexpr std::uint32_t kLock = 1U << 31;
constexpr std::uint32_t kBusy = 1U << 16;
constexpr std::uint32_t kEndOfOperation = 1;
constexpr std::uint32_t kProgramError = 1U << 3;
constexpr std::uint32_t kSizeError = 1U << 6;
constexpr std::uint32_t kSequenceError = 1U << 7;
constexpr std::uint32_t kErrors = 0xC3FA;
constexpr std::uint32_t kEccBank2 = 1U << 21;
constexpr std::uint32_t kEccCorrected = 1U << 30;
constexpr std::uint32_t kEccDetected = 1U << 31;

// Data sheet, typical.
constexpr Instant kProgramTime = 82 * kUnitsPerMicrosecond;
constexpr Instant kEraseTime = 22'000 * kUnitsPerMicrosecond;

}  // namespace

FlashInterface::FlashInterface(Services services, std::vector<std::uint8_t>& contents, std::uint32_t data_offset)
    : Peripheral("FLASH", services,
                 {{"ACR", kAcr, 0x600, 0x47F0F},
                  {"PDKEYR", 0x04, 0, 0xFFFFFFFF},
                  {"KEYR", kKeyr, 0, 0xFFFFFFFF},
                  {"OPTKEYR", 0x0C, 0, 0xFFFFFFFF},
                  {"SR", kSr, 0, 0xC3FB, kBusy},
                  {"CR", kCr, 0xC0000000, 0xFF078FFF},
                  {"ECCR", kEccr, 0, 0xF1000000, 0x0067FFFF},
                  {"OPTR", kOptr, kOptionsAtDelivery, 0, 0xFFFFFFFF},
                  {"WRP1AR", kWrp1ar, kNothingProtected, 0, 0xFFFFFFFF}}),
      contents_(contents),
      data_offset_(data_offset),
      done_(timeline().add([this] {
        if ((reg(kCr) & 1U << 24) != 0) {
          reg(kSr) |= kEndOfOperation;
        }
        reg(kCr) &= ~kStart;
      })) {}

void FlashInterface::on_reset() {
  timeline().cancel(done_);
  keys_given_ = 0;
  key_failed_ = false;
  first_address_ = UINT32_MAX;
  reg(kEccr) = program_is_corrected_ ? kEccCorrected : 0;
  if (access_changed_) {
    access_changed_();
  }
}

void FlashInterface::begin(Instant duration) { timeline().set(done_, timeline().now() + duration); }

// Address and bank are those of the first error since the flags were cleared.
bool FlashInterface::check(std::uint32_t offset) {
  const auto found = weak_.find(offset / 8);
  if (found == weak_.end()) {
    return true;
  }
  if ((reg(kEccr) & (kEccCorrected | kEccDetected)) == 0) {
    reg(kEccr) = (reg(kEccr) & 1U << 24) | (offset % kBankBytes) / 8 | (offset >= kBankBytes ? kEccBank2 : 0);
  }
  if (found->second == WrongBits::kOne) {
    reg(kEccr) |= kEccCorrected;
    return true;
  }
  reg(kEccr) |= kEccDetected;
  exceptions().pend(kNmi);
  return false;
}

bool FlashInterface::supply_fails() {
  if (operations_left_ < 0 || operations_left_-- > 0) {
    return false;
  }
  power_off_();
  return true;
}

void FlashInterface::program(std::uint32_t address, std::uint32_t value, unsigned width) {
  const std::uint32_t offset = address - kBase;
  if ((reg(kCr) & kLock) != 0 || (reg(kCr) & kProgram) == 0 || is_busy() || (reg(kSr) & kErrors) != 0) {
    report_violation("programmed while locked or busy, without PG, or with a pending error");
    reg(kSr) |= kSequenceError;
    return;
  }
  if (width != 4 || address % 4 != 0) {
    report_violation("programmed with a width other than words");
    reg(kSr) |= kSizeError;
    return;
  }
  if (address % 8 == 0) {
    first_address_ = address;
    first_word_ = value;
    return;
  }
  if (first_address_ != address - 4) {
    report_violation("second word of a double-word written without its first");
    reg(kSr) |= kSequenceError;
    return;
  }
  first_address_ = UINT32_MAX;
  std::uint8_t *target = contents_.data() + (offset - 4);
  const bool erased = std::all_of(target, target + 8, [](std::uint8_t byte) { return byte == 0xFF; });
  if (!erased && (first_word_ | value) != 0) {
    report_violation("programmed where the flash is not erased");
    reg(kSr) |= kProgramError;
    return;
  }
  begin(kProgramTime);
  weak_.erase((offset - 4) / 8);
  if (supply_fails()) {
    target[0] &= 0x5A;  // an intermediate value
    return;
  }
  std::memcpy(target, &first_word_, 4);
  std::memcpy(target + 4, &value, 4);
}

void FlashInterface::erase_page() {
  // In one bank the pages have twice the size, and BKER has no meaning.
  const bool two_banks = (options_ & kTwoBanks) != 0;
  const std::uint32_t page_bytes = two_banks ? kPageBytes : 2 * kPageBytes;
  const std::uint32_t first_page = two_banks && (reg(kCr) & 1U << 11) != 0 ? kBankBytes / kPageBytes : 0;
  const std::uint32_t page = (reg(kCr) >> 3 & 0x7FU) + first_page;
  const std::uint32_t offset = page * page_bytes;
  if (offset < data_offset_) {
    report_violation(fmt::format("page {} of the running program is erased", page));
    return;
  }
  begin(kEraseTime);
  weak_.erase(weak_.lower_bound(offset / 8), weak_.lower_bound((offset + page_bytes) / 8));
  const bool half = supply_fails();
  std::fill_n(contents_.begin() + offset, half ? page_bytes / 2 : page_bytes, std::uint8_t{0xFF});
}

void FlashInterface::write_key(std::uint32_t written) {
  const std::uint32_t expected = keys_given_ == 0 ? 0x45670123 : 0xCDEF89AB;
  if (key_failed_ || written != expected || (reg(kCr) & kLock) == 0) {
    report_violation("wrong key; the flash stays locked until the next reset");
    key_failed_ = true;
    return;
  }
  if (++keys_given_ == 2) {
    keys_given_ = 0;
    reg(kCr) &= ~kLock;
  }
}

void FlashInterface::write_control(std::uint32_t written) {
  if ((reg(kCr) & kLock) != 0) {
    require(written == reg(kCr), "CR is written while it is locked");
    return;
  }
  require(!is_busy(), "CR is written while it is busy");
  require((written & (1U << 2 | 1U << 15 | 1U << 18)) == 0, "mass erase and fast programming are not modelled");
  const bool starts = (written & kStart) != 0;
  reg(kCr) = (written & ~kLock) | (reg(kCr) & 1U << 30) | (written & kLock);
  if (starts) {
    if ((written & kPageErase) != 0 && (written & kProgram) == 0) {
      erase_page();
    } else {
      report_violation("started without page erase, or together with PG");
      reg(kSr) |= kSequenceError;
    }
  }
}

std::uint32_t FlashInterface::on_read(std::uint32_t offset, std::uint32_t stored, unsigned /*width*/) {
  if (offset == kOptr || offset == kWrp1ar) {
    return offset == kOptr ? options_ : write_protection_;
  }
  return offset == kSr && is_busy() ? stored | kBusy : stored;
}

void FlashInterface::on_write(std::uint32_t offset, std::uint32_t written, unsigned /*width*/) {
  switch (offset) {
    case kAcr:
      require((written & (1U << 11 | 1U << 9)) != (1U << 11 | 1U << 9),
              "the instruction cache is reset while it is on");
      require((written & (1U << 12 | 1U << 10)) != (1U << 12 | 1U << 10), "the data cache is reset while it is on");
      store(offset, written);
      if (access_changed_) {
        access_changed_();
      }
      break;
    case kKeyr:
      write_key(written);
      break;
    case kSr:
      reg(kSr) &= ~(written & 0xC3FBU);
      break;
    case kCr:
      write_control(written);
      break;
    case kEccr:
      reg(kEccr) = (reg(kEccr) & ~(1U << 24) & ~(written & (kEccCorrected | kEccDetected))) | (written & 1U << 24);
      break;
    default:
      report_violation("power-down, option bytes and their keys are not modelled");
      break;
  }
}

FlashData::FlashData(Services services, FlashInterface& flash, const std::vector<std::uint8_t>& contents,
                     std::uint32_t offset, std::uint32_t size)
    : Peripheral("flash", services,
                 [size] {
                   std::vector<Register> table;
                   for (std::uint32_t at = 0; at < size; at += 4) {
                     table.push_back({"parameter pages", at, 0, 0xFFFFFFFF, 0, true});
                   }
                   return table;
                 }()),
      flash_(flash),
      contents_(contents),
      offset_(offset) {}

std::uint32_t FlashData::on_read(std::uint32_t offset, std::uint32_t /*stored*/, unsigned /*width*/) {
  std::uint32_t word = 0;
  std::memcpy(&word, contents_.data() + offset_ + offset, 4);
  return flash_.check(offset_ + offset) ? word : word ^ 3U;
}

void FlashData::on_write(std::uint32_t offset, std::uint32_t written, unsigned width) {
  flash_.program(FlashInterface::kBase + offset_ + offset, written, width);
}

}  // namespace trackservo::target
