// SPDX-License-Identifier: Apache-2.0
// An asynchronous serial port (RM0440, 37): characters of eight bits, received by program or DMA; sent characters are
// dropped.
#ifndef TRACKSERVO_SIM_EMULATOR_CHIP_USART_HPP
#define TRACKSERVO_SIM_EMULATOR_CHIP_USART_HPP

#include <functional>
#include <vector>

#include "chip/dma.hpp"
#include "core/peripheral.hpp"

namespace trackservo::target {

class Usart : public Peripheral {
 public:
  struct Wiring {
    int interrupt;
    DmaRequest receive;
  };

  Usart(Services services, const char *name, Wiring wiring, DmaMux& dma);

  void clocked_at(std::function<std::uint32_t()> frequency_hz) { frequency_hz_ = std::move(frequency_hz); }
  void wired_by(std::function<bool()> receive_pin) { receive_pin_ = std::move(receive_pin); }

  // Takes a character from the line, sent at this rate without parity. Too different a rate breaks it.
  void receive(std::uint8_t character, double bits_per_s);

  // Returns the characters that the program has sent since the last call.
  std::vector<std::uint8_t> take_sent() { return std::move(sent_); }

 protected:
  std::uint32_t on_read(std::uint32_t offset, std::uint32_t stored, unsigned width) override;
  void on_write(std::uint32_t offset, std::uint32_t written, unsigned width) override;
  void on_reset() override;

 private:
  bool is_on() const { return (reg(0x00) & 1U) != 0; }
  double bits_per_s() const;
  Instant character_time() const { return duration_of(10.0 / bits_per_s()); }
  void check();
  void refresh_interrupt();

  Wiring wiring_;
  DmaMux& dma_;
  IrqLine line_;
  std::function<std::uint32_t()> frequency_hz_;
  std::function<bool()> receive_pin_;
  Timeline::Alarm idle_;
  std::vector<std::uint8_t> sent_;
};

}  // namespace trackservo::target

#endif
