// SPDX-License-Identifier: Apache-2.0
#include "chip/adc.hpp"

#include <utility>

namespace trackservo::target {
namespace {

constexpr std::uint32_t kIsr = 0x00;
constexpr std::uint32_t kCr = 0x08;
constexpr std::uint32_t kCfgr = 0x0C;
constexpr std::uint32_t kCfgr2 = 0x10;
constexpr std::uint32_t kSmpr1 = 0x14;
constexpr std::uint32_t kSmpr2 = 0x18;
constexpr std::uint32_t kJsqr = 0x4C;
constexpr std::uint32_t kJdr1 = 0x80;

constexpr std::uint32_t kReadyFlag = 1;
constexpr std::uint32_t kInjectedFlags = 1U << 5 | 1U << 6 | 1U << 1;  // end of conversion, of sequence, of sampling
constexpr std::uint32_t kEnable = 1;
constexpr std::uint32_t kDisable = 1U << 1;
constexpr std::uint32_t kStart = 1U << 2;
constexpr std::uint32_t kStartInjected = 1U << 3;
constexpr std::uint32_t kStopInjected = 1U << 5;
constexpr std::uint32_t kRegulator = 1U << 28;
constexpr std::uint32_t kDeepPowerDown = 1U << 29;
constexpr std::uint32_t kCalibrate = 1U << 31;

constexpr std::uint32_t kHighestClockHz = 60'000'000;
constexpr Instant kRegulatorStartup = 20 * kUnitsPerMicrosecond;
constexpr double kShortestSampling_s = 0.1e-6;  // for sources of a kilo-ohm
constexpr double kCalibrationCycles = 116;
constexpr Instant kEnableTime = 1 * kUnitsPerMicrosecond;

}  // namespace

AdcCommon::AdcCommon(Services services, std::function<std::uint32_t()> core_hz)
    : Peripheral("ADC12", services,
                 {{"CSR", 0x00, 0, 0, 0x07FF07FF}, {"CCR", 0x08, 0, 0x01FFEF1F}, {"CDR", 0x0C, 0, 0, 0xFFFFFFFF}}),
      core_hz_(std::move(core_hz)) {}

std::uint32_t AdcCommon::clock_hz() const {
  switch (reg(0x08) >> 16 & 3U) {
    case 1:
      return core_hz_();
    case 2:
      return core_hz_() / 2;
    case 3:
      return core_hz_() / 4;
    default:
      return 0;
  }
}

void AdcCommon::check() const {
  require(clock_hz() != 0, "the converters' asynchronous clock is not modelled");
  require(clock_hz() <= kHighestClockHz, "the converters' clock is faster than 60 MHz");
  require((reg(0x08) & 0xEF1FU) == 0, "dual mode and its DMA are not modelled");
}

void AdcCommon::on_write(std::uint32_t offset, std::uint32_t written, unsigned /*width*/) { store(offset, written); }

Adc::Adc(Services services, const char *name, const AdcCommon& common)
    : Peripheral(name, services,
                 {
                     {"ISR", kIsr, 0, 0x7FF},
                     {"IER", 0x04, 0, 0x7FF},
                     {"CR", kCr, 0x20000000, 0xF000003F},
                     {"CFGR", kCfgr, 0x80000000, 0xFFFFFFFF},
                     {"CFGR2", kCfgr2, 0, 0x0E0107FF},
                     {"SMPR1", kSmpr1, 0, 0xBFFFFFFF},
                     {"SMPR2", kSmpr2, 0, 0x07FFFFFF},
                     {"SQR1", 0x30, 0, 0x1F7DF7CF},
                     {"JSQR", kJsqr, 0, 0xFBEFBFFF},
                     {"JDR1", kJdr1, 0, 0, 0xFFFF},
                     {"JDR2", 0x84, 0, 0, 0xFFFF},
                     {"JDR3", 0x88, 0, 0, 0xFFFF},
                     {"JDR4", 0x8C, 0, 0, 0xFFFF},
                     {"DIFSEL", 0xB0, 0, 0x7FFFF},
                     {"CALFACT", 0xB4, 0, 0x7F007F},
                 }),
      common_(common),
      sequence_end_(timeline().add([this] {
        reg(kIsr) |= kInjectedFlags;
        if ((reg(kJsqr) >> 7 & 3U) == 0) {
          reg(kCr) &= ~kStartInjected;
        }
        changed();
      })),
      calibration_end_(timeline().add([this] {
        reg(kCr) &= ~kCalibrate;
        calibrated_ = true;
        calibrated_at_ = timeline().instant();
      })),
      ready_(timeline().add([this] {
        reg(kIsr) |= kReadyFlag;
        changed();
      })) {}

void Adc::on_reset() {
  timeline().cancel(sequence_end_);
  timeline().cancel(calibration_end_);
  timeline().cancel(ready_);
  calibrated_ = false;
  changed();
}

void Adc::changed() {
  if (monitor_) {
    monitor_();
  }
}

bool Adc::is_ready() const { return (reg(kCr) & kEnable) != 0 && timeline().due(ready_) == Timeline::kNever; }

unsigned Adc::channel_of(unsigned rank) const {
  constexpr unsigned kShift[] = {9, 15, 21, 27};
  return reg(kJsqr) >> kShift[rank] & 0x1FU;
}

double Adc::adc_cycles(unsigned channel) const {
  constexpr double kSampling[] = {2.5, 6.5, 12.5, 24.5, 47.5, 92.5, 247.5, 640.5};
  const std::uint32_t times = channel < 10 ? reg(kSmpr1) >> (3 * channel) : reg(kSmpr2) >> (3 * (channel - 10));
  return kSampling[times & 7U] + 12.5;
}

void Adc::trigger(AdcTrigger trigger) {
  const std::uint32_t jsqr = reg(kJsqr);
  const bool rising = (jsqr >> 7 & 1U) != 0;
  if ((reg(kCr) & kStartInjected) == 0 || !rising || (jsqr >> 2 & 0x1FU) != static_cast<unsigned>(trigger)) {
    return;
  }
  if (timeline().due(sequence_end_) != Timeline::kNever) {
    report_violation("triggered while the last sequence is still running");
    return;
  }
  start_sequence();
}

void Adc::start_sequence() {
  double cycles = 0.0;
  for (unsigned rank = 0; rank < sequence_length(); ++rank) {
    const unsigned channel = channel_of(rank);
    reg(kJdr1 + 4 * rank) = source_(channel);
    cycles += adc_cycles(channel);
    require((adc_cycles(channel) - 12.5) / common_.clock_hz() >= kShortestSampling_s, "sampled for less than 0.1 us");
  }
  const double seconds = cycles / common_.clock_hz();
  timeline().set(sequence_end_, timeline().instant() + duration_of(seconds));
}

void Adc::write_cr(std::uint32_t written) {
  const std::uint32_t old = reg(kCr);
  const Instant now = timeline().instant();
  if ((written & ~old & kRegulator) != 0) {
    require(((written | old) & kDeepPowerDown) == 0, "regulator switched on in deep power-down");
    regulator_ready_ = now + kRegulatorStartup;
  }
  const bool powered = (written & kRegulator) != 0 && (written & kDeepPowerDown) == 0;
  if ((written & kCalibrate) != 0 && (old & kCalibrate) == 0) {
    require(powered && now >= regulator_ready_, "calibrated before its regulator is ready");
    require((old & kEnable) == 0, "calibrated while it is enabled");
    common_.check();
    timeline().set(calibration_end_, now + duration_of(kCalibrationCycles / common_.clock_hz()));
  }
  if ((written & ~old & kEnable) != 0) {
    require(powered && calibrated_ && (old & kCalibrate) == 0, "enabled before it is calibrated");
    require(now >= calibrated_at_ + duration_of(4.0 / common_.clock_hz()), "enabled within 4 clocks of calibration");
    timeline().set(ready_, now + kEnableTime);
  }
  require((written & kStart) == 0, "regular conversions are not modelled");
  reg(kCr) = (old & (kEnable | kStartInjected | kCalibrate)) | (written & ~(kDisable | kStopInjected));
  if ((written & kDisable) != 0) {
    require((old & kStartInjected) == 0, "disabled while it converts");
    reg(kCr) &= ~(kEnable | kDisable);
  }
  if ((written & kStopInjected) != 0) {
    timeline().cancel(sequence_end_);
    reg(kCr) &= ~(kStartInjected | kStopInjected);
  }
  if ((written & ~old & kStartInjected) != 0) {
    require(is_ready(), "started before it is ready");
    require((reg(kCfgr) & 0x7FFFFFFFU & ~0x1000U) == 0 && reg(kCfgr2) == 0 && reg(0xB0) == 0,
            "resolution, alignment, oversampling, watchdogs or differential inputs differ from their reset values, "
            "which is not modelled");
    if ((reg(kJsqr) >> 7 & 3U) == 0) {
      start_sequence();
    }
  }
}

void Adc::on_write(std::uint32_t offset, std::uint32_t written, unsigned /*width*/) {
  if (offset == kIsr) {
    reg(kIsr) &= ~written;
  } else if (offset == kCr) {
    write_cr(written);
  } else {
    if (offset == kSmpr1 || offset == kSmpr2 || offset == 0xB0) {
      require((reg(kCr) & (kStart | kStartInjected)) == 0, "configured while it converts");
    }
    if (offset == kJsqr) {
      require((reg(kCr) & kStartInjected) == 0 || (reg(kCfgr) >> 31) == 0, "sequence written while it runs");
    }
    store(offset, written);
  }
  changed();
}

}  // namespace trackservo::target
