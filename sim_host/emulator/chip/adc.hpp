// SPDX-License-Identifier: Apache-2.0
// An analogue-digital converter of the pair ADC1 and ADC2 (RM0440, 21): the steps from power-down over calibration to
// ready, and injected sequences started by a timer or by software. Regular conversions are not modelled.
#ifndef TRACKSERVO_SIM_EMULATOR_CHIP_ADC_HPP
#define TRACKSERVO_SIM_EMULATOR_CHIP_ADC_HPP

#include <array>
#include <functional>

#include "core/peripheral.hpp"

namespace trackservo::target {

// Triggers of injected sequences of ADC1 and ADC2: the values of JEXTSEL (RM0440, table 166).
enum class AdcTrigger : unsigned { kTim1Trgo = 0, kTim1Trgo2 = 8, kTim8Trgo = 9, kTim8Trgo2 = 10 };

// 0x300 from the pair's base: the clock of both.
class AdcCommon : public Peripheral {
 public:
  AdcCommon(Services services, std::function<std::uint32_t()> core_hz);

  // Returns the frequency of the converters' clock; 0 for one that is not modelled.
  std::uint32_t clock_hz() const;
  void check() const;

 protected:
  void on_write(std::uint32_t offset, std::uint32_t written, unsigned width) override;

 private:
  std::function<std::uint32_t()> core_hz_;
};

class Adc : public Peripheral {
 public:
  Adc(Services services, const char *name, const AdcCommon& common);

  // Sets the source of a channel's counts, 0 .. 4095; it reports a violation when nothing is connected.
  void measures(std::function<std::uint32_t(unsigned channel)> source) { source_ = std::move(source); }

  void trigger(AdcTrigger trigger);

  bool wants_interrupt() const { return (reg(0x00) & reg(0x04)) != 0; }
  // Sets what is called when wants_interrupt() may have changed: both converters share a line.
  void monitor(std::function<void()> monitor) { monitor_ = std::move(monitor); }

 protected:
  void on_write(std::uint32_t offset, std::uint32_t written, unsigned width) override;
  void on_reset() override;

 private:
  bool is_ready() const;
  unsigned sequence_length() const { return (reg(0x4C) & 3U) + 1; }
  unsigned channel_of(unsigned rank) const;
  double adc_cycles(unsigned channel) const;
  void write_cr(std::uint32_t written);
  void start_sequence();
  void changed();

  const AdcCommon& common_;
  std::function<std::uint32_t(unsigned)> source_;
  std::function<void()> monitor_;
  Timeline::Alarm sequence_end_;
  Timeline::Alarm calibration_end_;
  Timeline::Alarm ready_;
  Instant regulator_ready_ = 0;
  Instant calibrated_at_ = 0;
  bool calibrated_ = false;
};

}  // namespace trackservo::target

#endif
