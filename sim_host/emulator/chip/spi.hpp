// SPDX-License-Identifier: Apache-2.0
// A serial peripheral interface as master (RM0440, 39): frames of 4 to 16 bits, with DMA.
#ifndef TRACKSERVO_SIM_EMULATOR_CHIP_SPI_HPP
#define TRACKSERVO_SIM_EMULATOR_CHIP_SPI_HPP

#include <deque>
#include <functional>

#include "chip/dma.hpp"
#include "core/peripheral.hpp"

namespace trackservo::target {

// The device on clock and data: gives one bit for each clock period.
class SpiDevice {
 public:
  SpiDevice() = default;
  SpiDevice(const SpiDevice&) = delete;
  SpiDevice& operator=(const SpiDevice&) = delete;
  virtual ~SpiDevice() = default;

  // Returns the data line as the master samples it in `bits` clock periods from `at` on, `period` each, first bit
  // highest. `on_leading_edge`: it samples half a period earlier than at the trailing edge.
  virtual std::uint32_t clock(unsigned bits, Instant at, Instant period, bool on_leading_edge) = 0;
};

class Spi : public Peripheral {
 public:
  struct Wiring {
    int interrupt;
    DmaRequest receive;
    DmaRequest transmit;
  };

  Spi(Services services, const char *name, Wiring wiring, DmaMux& dma);

  void clocked_at(std::function<std::uint32_t()> frequency_hz) { frequency_hz_ = std::move(frequency_hz); }
  void connect(SpiDevice *device) { device_ = device; }
  // Sets whether clock and data pins are connected to this peripheral.
  void wired_by(std::function<bool()> clock, std::function<bool()> data) {
    clock_pin_ = std::move(clock);
    data_pin_ = std::move(data);
  }

  // Repeats the requests that wait, which a DMA channel may now serve.
  void serve_dma();

 protected:
  std::uint32_t on_read(std::uint32_t offset, std::uint32_t stored, unsigned width) override;
  void on_write(std::uint32_t offset, std::uint32_t written, unsigned width) override;
  void on_reset() override;

 private:
  unsigned frame_bits() const { return (reg(0x04) >> 8 & 0xFU) + 1; }
  Instant bit_period() const;
  bool is_enabled() const { return (reg(0x00) & 1U << 6) != 0; }
  void begin_frame();
  void end_frame();
  void check();
  std::uint32_t status() const;
  void refresh_interrupt();

  Wiring wiring_;
  DmaMux& dma_;
  IrqLine line_;
  std::function<std::uint32_t()> frequency_hz_;
  std::function<bool()> clock_pin_;
  std::function<bool()> data_pin_;
  SpiDevice *device_ = nullptr;
  Timeline::Alarm frame_end_;
  std::deque<std::uint32_t> transmit_;
  std::deque<std::uint32_t> receive_;
  std::uint32_t shifting_ = 0;
  bool busy_ = false;
  bool overrun_ = false;
  bool serving_ = false;
};

}  // namespace trackservo::target

#endif
