// SPDX-License-Identifier: Apache-2.0
// The independent watchdog with its window (RM0440, 42), on the 32 kHz oscillator.
#ifndef TRACKSERVO_SIM_EMULATOR_CHIP_WATCHDOG_HPP
#define TRACKSERVO_SIM_EMULATOR_CHIP_WATCHDOG_HPP

#include <functional>
#include <utility>

#include "core/peripheral.hpp"

namespace trackservo::target {

class Watchdog : public Peripheral {
 public:
  static constexpr std::uint32_t kLsiHz = 32'000;

  Watchdog(Services services, std::function<void()> reset_request)
      : Peripheral("IWDG", services,
                   {{"KR", 0x00, 0, 0xFFFF},
                    {"PR", 0x04, 0, 7},
                    {"RLR", 0x08, 0xFFF, 0xFFF},
                    {"SR", 0x0C, 0, 0, 7},
                    {"WINR", 0x10, 0xFFF, 0xFFF}}),
        reset_request_(std::move(reset_request)),
        expiry_(timeline().add([this] { reset_request_(); })) {}

  bool is_running() const { return running_; }
  double timeout_s() const { return (reg(0x08) + 1.0) * (4 << reg(0x04)) / kLsiHz; }

 protected:
  // Returns the register's value; a changed value takes some periods of the slow clock to arrive.
  std::uint32_t on_read(std::uint32_t offset, std::uint32_t stored, unsigned /*width*/) override {
    if (offset != 0x0C) {
      return stored;
    }
    if (timeline().now() >= arrived_) {
      updating_ = 0;
    }
    return updating_;
  }

  void on_write(std::uint32_t offset, std::uint32_t written, unsigned /*width*/) override {
    if (offset == 0x00) {
      write_key(written & 0xFFFF);
      return;
    }
    require(unlocked_, "written without its key");
    require(timeline().now() >= arrived_ || (updating_ & flag_of(offset)) == 0,
            "written while the last value is in transfer");
    store(offset, written);
    updating_ |= flag_of(offset);
    arrived_ = timeline().now() + kArrivalPeriods * period_of(kLsiHz);
    if (offset == 0x10 && running_) {
      reload();  // writing the window refreshes
    }
  }

  void on_reset() override {
    timeline().cancel(expiry_);
    running_ = unlocked_ = false;
    updating_ = 0;
    arrived_ = 0;
  }

 private:
  static constexpr Instant kArrivalPeriods = Instant{6} * 4;

  static std::uint32_t flag_of(std::uint32_t offset) { return offset == 0x04 ? 1U : (offset == 0x08 ? 2U : 4U); }

  void write_key(std::uint32_t key) {
    unlocked_ = key == 0x5555;
    if (key == 0xCCCC) {
      running_ = true;
      reload();
    } else if (key == 0xAAAA) {
      const double count = static_cast<double>(timeline().due(expiry_) - timeline().now()) /
                           static_cast<double>((Instant{4} << reg(0x04)) * period_of(kLsiHz));
      if (running_ && count > reg(0x10)) {
        reset_request_();
      } else if (running_) {
        reload();
      }
    } else {
      require(key == 0x5555, "unknown key");
    }
  }

  void reload() { timeline().set(expiry_, timeline().now() + duration_of(timeout_s())); }

  std::function<void()> reset_request_;
  Timeline::Alarm expiry_;
  bool running_ = false;
  bool unlocked_ = false;
  std::uint32_t updating_ = 0;
  Instant arrived_ = 0;
};

}  // namespace trackservo::target

#endif
