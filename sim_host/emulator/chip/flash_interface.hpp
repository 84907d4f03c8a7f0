// SPDX-License-Identifier: Apache-2.0
// The flash's registers and the parameter pages behind them (RM0440, 5): unlocking, page erase, programming of
// double-words, errors, timing.
#ifndef TRACKSERVO_SIM_EMULATOR_CHIP_FLASH_INTERFACE_HPP
#define TRACKSERVO_SIM_EMULATOR_CHIP_FLASH_INTERFACE_HPP

#include <cstdint>
#include <functional>
#include <map>
#include <vector>

#include "core/peripheral.hpp"

namespace trackservo::target {

class FlashInterface : public Peripheral {
 public:
  static constexpr std::uint32_t kBase = 0x08000000;
  static constexpr std::uint32_t kBankBytes = 256 * 1024;
  static constexpr std::uint32_t kPageBytes = 2048;

  // Keeps a reference to `contents`, the whole flash; only the part from `data_offset` on may be changed.
  FlashInterface(Services services, std::vector<std::uint8_t>& contents, std::uint32_t data_offset);

  std::uint32_t wait_states() const { return reg(0x00) & 0xFU; }
  bool is_cached() const { return (reg(0x00) & 1U << 9) != 0; }
  bool is_prefetching() const { return (reg(0x00) & 1U << 8) != 0; }
  void on_access_control(std::function<void()> listener) { access_changed_ = std::move(listener); }

  // Option bytes, as a programmer writes them; they outlast every reset.
  static constexpr std::uint32_t kOptionsAtDelivery = 0xFFEFF8AA;
  static constexpr std::uint32_t kNoRamParity = 1U << 24;
  static constexpr std::uint32_t kTwoBanks = 1U << 22;
  static constexpr std::uint32_t kNothingProtected = 0x7F;
  // Returns WRP1AR for the pages of an image of this size.
  static constexpr std::uint32_t protect_image(std::size_t bytes) {
    return static_cast<std::uint32_t>((bytes - 1) / kPageBytes) << 16;
  }
  void set_options(std::uint32_t options, std::uint32_t write_protection) {
    options_ = options;
    write_protection_ = write_protection;
  }
  bool has_ram_parity() const { return (options_ & kNoRamParity) == 0; }

  // Takes what the program stores to an address of the flash.
  void program(std::uint32_t address, std::uint32_t value, unsigned width);

  // Until it is programmed or erased, the double word at this offset of the flash has one wrong bit, which the ECC
  // corrects, or two, which it detects: NMI, and wrong data.
  enum class WrongBits { kOne, kTwo };
  void weaken(std::uint32_t offset, WrongBits bits) { weak_[offset / 8] = bits; }

  // Sets whether ECCR shows a corrected bit in bank 1 after each reset, as a weak cell of the program leaves it.
  void correct_program_at_reset(bool corrected) { program_is_corrected_ = corrected; }

  // Checks what the program reads from the parameter pages; sets the flags and the NMI. Returns whether the data are
  // right.
  bool check(std::uint32_t offset);

  // Ends the next erase or program operations halfway: the supply fails. Counts down to 0; negative: never.
  void fail_supply_in(int operations, std::function<void()> power_off) {
    operations_left_ = operations;
    power_off_ = std::move(power_off);
  }

 protected:
  std::uint32_t on_read(std::uint32_t offset, std::uint32_t stored, unsigned width) override;
  void on_write(std::uint32_t offset, std::uint32_t written, unsigned width) override;
  void on_reset() override;

 private:
  bool is_busy() const { return timeline().due(done_) != Timeline::kNever; }
  void begin(Instant duration);
  void write_key(std::uint32_t written);
  void write_control(std::uint32_t written);
  void erase_page();
  bool supply_fails();

  std::vector<std::uint8_t>& contents_;
  std::uint32_t data_offset_;
  std::function<void()> access_changed_;
  std::function<void()> power_off_;
  Timeline::Alarm done_;
  int keys_given_ = 0;
  bool key_failed_ = false;
  std::uint32_t first_word_ = 0;
  std::uint32_t first_address_ = UINT32_MAX;
  int operations_left_ = -1;
  std::uint32_t options_ = kOptionsAtDelivery;
  std::uint32_t write_protection_ = kNothingProtected;
  std::map<std::uint32_t, WrongBits> weak_;
  bool program_is_corrected_ = false;
};

// The parameter pages on the bus: reads, and stores that program.
class FlashData : public Peripheral {
 public:
  FlashData(Services services, FlashInterface& flash, const std::vector<std::uint8_t>& contents, std::uint32_t offset,
            std::uint32_t size);

 protected:
  std::uint32_t on_read(std::uint32_t offset, std::uint32_t stored, unsigned width) override;
  void on_write(std::uint32_t offset, std::uint32_t written, unsigned width) override;

 private:
  FlashInterface& flash_;
  const std::vector<std::uint8_t>& contents_;
  std::uint32_t offset_;
};

}  // namespace trackservo::target

#endif
