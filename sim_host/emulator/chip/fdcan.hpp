// SPDX-License-Identifier: Apache-2.0
// An FDCAN used as classic CAN (RM0440, 44): acceptance filters, two receive FIFOs and three transmit buffers in the
// message RAM, time stamps in bits, interrupts, bus-off.
#ifndef TRACKSERVO_SIM_EMULATOR_CHIP_FDCAN_HPP
#define TRACKSERVO_SIM_EMULATOR_CHIP_FDCAN_HPP

#include <array>
#include <cstdint>
#include <functional>
#include <optional>

#include "core/peripheral.hpp"

namespace trackservo::target {

// A frame as stored in the message RAM.
struct CanMessage {
  std::uint32_t header = 0;  // ESI, XTD, RTR and the identifier
  std::uint32_t length = 0;  // 0 .. 8
  std::array<std::uint32_t, 2> data{};
  std::uint32_t bits = 0;  // that it took on the bus
};

// 848 bytes of message RAM; by whole words only.
class MessageRam : public Peripheral {
 public:
  static constexpr std::uint32_t kBytes = 0x350;

  explicit MessageRam(Services services);
  std::uint32_t& word(std::uint32_t offset) { return reg(offset); }
};

class Fdcan : public Peripheral {
 public:
  static constexpr unsigned kBuffers = 3;

  Fdcan(Services services, const char *name, std::array<int, 2> interrupts, MessageRam& ram);

  // Sets the source of its kernel clock's frequency, and whether RX and TX are connected to it.
  void clocked_at(std::function<std::uint32_t()> frequency_hz) { frequency_hz_ = std::move(frequency_hz); }
  void wired_by(std::function<bool()> pins) { pins_ = std::move(pins); }

  // Returns its bit rate on the bus; nothing unless it is started, wired and not off.
  std::optional<double> bits_per_s() const;

  // Returns how often the program has started its configuration: waiting frames are lost each time.
  int restarts() const { return restarts_; }

  // Takes a frame from the bus.
  void receive(const CanMessage& message);

  // Returns the number of frames that the filters have passed.
  int accepted() const { return accepted_; }

  // Returns its next frame to send; call `sent` when the bus has accepted it.
  std::optional<CanMessage> next_to_send() const;
  void sent();

  // Takes the node off the bus, as after 256 failed transmissions, until the program ends its initialisation mode.
  void go_bus_off();

  // Ends the bus-off when time for 129 times eleven recessive bits has passed since the program requested to return.
  void bus_idle(Instant now);

 protected:
  std::uint32_t on_read(std::uint32_t offset, std::uint32_t stored, unsigned width) override;
  void on_write(std::uint32_t offset, std::uint32_t written, unsigned width) override;
  void on_reset() override;

 private:
  struct Fifo {
    std::uint32_t get = 0;
    std::uint32_t fill = 0;
  };
  struct Decision {
    bool accepted;
    unsigned fifo;
    std::uint32_t filter;  // 0x80: none matched
  };

  std::uint32_t timestamp() const;
  bool is_initialising() const { return (reg(0x18) & 1U) != 0; }
  void write_cccr(std::uint32_t written);
  void check_timing() const;
  void forget_frames();
  Decision filter(const CanMessage& message);
  Decision filter_standard(const CanMessage& message);
  Decision filter_extended(const CanMessage& message);
  static std::optional<Decision> element(std::uint32_t configuration, std::uint32_t index);
  void put(unsigned fifo, const CanMessage& message, std::uint32_t filter);
  void acknowledge(unsigned fifo, std::uint32_t index);
  std::uint32_t fifo_status(unsigned fifo) const;
  std::optional<unsigned> next_buffer() const;
  void flag(std::uint32_t bits);
  void refresh_interrupts();

  MessageRam& ram_;
  std::array<IrqLine, 2> lines_;
  std::function<std::uint32_t()> frequency_hz_;
  std::function<bool()> pins_;
  std::array<Fifo, 2> fifo_{};
  std::uint32_t order_ = 0;  // two bits each: buffers in the order of their requests, oldest lowest
  unsigned waiting_ = 0;
  unsigned put_index_ = 0;
  std::optional<Instant> recovery_;
  Instant stamped_from_ = 0;  // when the program last reset the time stamps
  int accepted_ = 0;
  int restarts_ = 0;
};

}  // namespace trackservo::target

#endif
