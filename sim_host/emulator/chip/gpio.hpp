// SPDX-License-Identifier: Apache-2.0
// A port of 16 pins (RM0440, 9).
#ifndef TRACKSERVO_SIM_EMULATOR_CHIP_GPIO_HPP
#define TRACKSERVO_SIM_EMULATOR_CHIP_GPIO_HPP

#include <functional>

#include "core/peripheral.hpp"

namespace trackservo::target {

class Gpio : public Peripheral {
 public:
  enum class Mode : std::uint32_t { kInput = 0, kOutput = 1, kAlternate = 2, kAnalog = 3 };

  Gpio(Services services, char port);

  Mode mode(unsigned pin) const { return static_cast<Mode>(reg(0x00) >> (2 * pin) & 3U); }
  bool has_function(unsigned pin, unsigned function) const {
    return mode(pin) == Mode::kAlternate && (reg(pin < 8 ? 0x20U : 0x24U) >> (4 * (pin % 8)) & 0xFU) == function;
  }

  // Returns whether the pin is an output that drives high.
  bool drives_high(unsigned pin) const { return mode(pin) == Mode::kOutput && (reg(0x14) >> pin & 1U) != 0; }
  bool drives_low(unsigned pin) const { return mode(pin) == Mode::kOutput && (reg(0x14) >> pin & 1U) == 0; }

  // Sets the external level of a pin.
  void set_input(unsigned pin, bool level) {
    inputs_ = (inputs_ & ~(1U << pin)) | (level ? 1U << pin : 0U);
    changed();
  }
  bool input(unsigned pin) const { return (inputs_ >> pin & 1U) != 0; }

  // Sets what is called after any change of a mode, function, output or input.
  void monitor(std::function<void()> monitor) { monitor_ = std::move(monitor); }

 protected:
  std::uint32_t on_read(std::uint32_t offset, std::uint32_t stored, unsigned width) override;
  void on_write(std::uint32_t offset, std::uint32_t written, unsigned width) override;
  void on_reset() override { changed(); }

 private:
  void changed() {
    if (monitor_) {
      monitor_();
    }
  }

  std::uint32_t inputs_ = 0;
  std::function<void()> monitor_;
};

}  // namespace trackservo::target

#endif
