// SPDX-License-Identifier: Apache-2.0
#include "chip/timer.hpp"

#include <algorithm>

namespace trackservo::target {
namespace {

constexpr std::uint32_t kCr1 = 0x00;
constexpr std::uint32_t kCr2 = 0x04;
constexpr std::uint32_t kSmcr = 0x08;
constexpr std::uint32_t kDier = 0x0C;
constexpr std::uint32_t kSr = 0x10;
constexpr std::uint32_t kEgr = 0x14;
constexpr std::uint32_t kCcmr1 = 0x18;
constexpr std::uint32_t kCcmr2 = 0x1C;
constexpr std::uint32_t kCcer = 0x20;
constexpr std::uint32_t kCnt = 0x24;
constexpr std::uint32_t kPsc = 0x28;
constexpr std::uint32_t kArr = 0x2C;
constexpr std::uint32_t kRcr = 0x30;
constexpr std::uint32_t kCcr1 = 0x34;
constexpr std::uint32_t kCcr4 = 0x40;
constexpr std::uint32_t kBdtr = 0x44;
constexpr std::uint32_t kCcr5 = 0x48;
constexpr std::uint32_t kCcr6 = 0x4C;
constexpr std::uint32_t kCcmr3 = 0x50;
constexpr std::uint32_t kAf1 = 0x60;
constexpr std::uint32_t kAf2 = 0x64;

constexpr std::uint32_t kEnable = 1;
constexpr std::uint32_t kMainOutput = 1U << 15;
constexpr std::uint32_t kBreakFlag = 1U << 7;
constexpr std::uint32_t kSecondBreakFlag = 1U << 8;
constexpr std::uint32_t kSystemBreakFlag = 1U << 13;
constexpr std::uint32_t kBreakEnable = 1U << 12;
constexpr std::uint32_t kBreakInterrupt = 1U << 7;  // of DIER, for all break flags

// Master modes of CR2.
constexpr unsigned kByEnable = 1;
constexpr unsigned kByUpdate = 2;

}  // namespace

std::vector<Peripheral::Register> Timer::registers(bool advanced) {
  std::vector<Register> table = {
      {"CR1", kCr1, 0, advanced ? 0xBFFU : 0x88FU},
      {"CR2", kCr2, 0, advanced ? 0x02F5FFFDU : 0x70U},
      {"DIER", kDier, 0, advanced ? 0x7FFFU : 0x101U},
      {"SR", kSr, 0, 0xFFFFFFFF},  // writing ones does nothing
      {"EGR", kEgr, 0, advanced ? 0x1FFU : 1U},
      {"CNT", kCnt, 0, 0xFFFF, 1U << 31},
      {"PSC", kPsc, 0, 0xFFFF},
      {"ARR", kArr, 0xFFFF, 0xFFFF},
  };
  if (advanced) {
    const std::vector<Register> more = {
        {"SMCR", kSmcr, 0, 0x0331FFFF},   {"CCMR1", kCcmr1, 0, 0x0101FFFF},
        {"CCMR2", kCcmr2, 0, 0x0101FFFF}, {"CCER", kCcer, 0, 0x33BBBB | 0x4444},
        {"RCR", kRcr, 0, 0xFFFF},         {"CCR1", kCcr1, 0, 0xFFFF},
        {"CCR2", 0x38, 0, 0xFFFF},        {"CCR3", 0x3C, 0, 0xFFFF},
        {"CCR4", kCcr4, 0, 0xFFFF},       {"BDTR", kBdtr, 0, 0x3FFFFFFF},
        {"CCR5", kCcr5, 0, 0xE000FFFF},   {"CCR6", kCcr6, 0, 0xFFFF},
        {"CCMR3", kCcmr3, 0, 0x0101FCFC}, {"DTR2", 0x54, 0, 0x000300FF},
        {"TISEL", 0x5C, 0, 0x0F0F0F0F},   {"AF1", kAf1, 1, 0x3FEFF},
        {"AF2", kAf2, 1, 0x73EFF},
    };
    table.insert(table.end(), more.begin(), more.end());
  }
  return table;
}

Timer::Timer(Services services, const char *name, Interrupts interrupts, bool advanced)
    : Peripheral(name, services, registers(advanced)),
      advanced_(advanced),
      update_line_(services.exceptions, interrupts.update),
      edge_(timeline().add([this] { edge(); })),
      compare_(timeline().add([this] { compare_pulse(); })) {
  if (interrupts.brake >= 0) {
    break_line_.emplace(services.exceptions, interrupts.brake);
  }
}

void Timer::on_reset() {
  timeline().cancel(edge_);
  timeline().cancel(compare_);
  update_line_.forget();
  if (break_line_) {
    break_line_->forget();
  }
  limit_ = 0xFFFF;
  prescale_ = 0;
  compare_value_.fill(0);
  repetitions_left_ = 0;
  down_ = false;
  stopped_at_ = 0;
  outputs_changed();
}

// --- counting ---

std::uint32_t Timer::counter() const {
  if (!is_running()) {
    return stopped_at_;
  }
  const auto counts = static_cast<std::uint32_t>((timeline().instant() - edge_at_) / count_);
  return down_ ? limit_ - std::min(counts, limit_) : std::min(counts, limit_);
}

void Timer::start() {
  count_ = period_of(frequency_hz_()) * (prescale_ + 1);
  if (limit_ == 0) {
    report_violation("started with an auto-reload value of 0");
    return;
  }
  require((reg(kCr1) & 1U << 4) == 0, "counting down is not modelled");
  down_ = false;
  edge_at_ = timeline().instant() - stopped_at_ * count_;
  timeline().set(edge_, edge_at_ + (is_centred() ? limit_ : limit_ + 1) * count_);
  schedule_compare();
  integrate();
  if (enabled_ && (reg(kCr2) >> 4 & 7U) == kByEnable) {
    enabled_();
  }
}

void Timer::stop() {
  integrate();
  stopped_at_ = counter();
  timeline().cancel(edge_);
  timeline().cancel(compare_);
}

void Timer::slip(Instant delay) {
  edge_at_ += delay;
  timeline().set(edge_, edge_at_ + (is_centred() ? limit_ : limit_ + 1) * count_);
}

// The counter is at its limit or, centre-aligned, back at 0.
void Timer::edge() {
  edge_at_ = timeline().instant();
  down_ = is_centred() && !down_;
  if (repetitions_left_ == 0) {
    update(false);
  } else {
    --repetitions_left_;
  }
  if (is_running()) {
    timeline().set(edge_, edge_at_ + (is_centred() ? limit_ : limit_ + 1) * count_);
    schedule_compare();
  }
}

// The update event: preloaded values take effect, then the flag, the interrupt and the triggers.
void Timer::update(bool by_software) {
  if ((reg(kCr1) & 2U) != 0 && !by_software) {
    return;  // UDIS
  }
  integrate();
  load_preload();
  const bool only_overflows = (reg(kCr1) & 4U) != 0;
  if (!(by_software && only_overflows)) {
    reg(kSr) |= 1;
    refresh_interrupts();
  }
  if ((reg(kCr1) & 8U) != 0 && !by_software) {
    stopped_at_ = 0;
    reg(kCr1) &= ~kEnable;
  }
  trigger(kByUpdate);
}

void Timer::load_preload() {
  prescale_ = reg(kPsc);
  limit_ = reg(kArr) & 0xFFFF;
  if (advanced_) {
    repetitions_left_ = reg(kRcr);
    for (std::uint32_t channel = 0; channel < 4; ++channel) {
      compare_value_[channel] = reg(kCcr1 + 4 * channel);
    }
    compare_value_[4] = reg(kCcr5) & 0xFFFF;
    compare_value_[5] = reg(kCcr6);
  }
}

void Timer::trigger(unsigned source) {
  if (!triggered_) {
    return;
  }
  if ((reg(kCr2) >> 4 & 7U) == source && (reg(kCr2) & 1U << 25) == 0) {
    triggered_(false);
  }
  if (advanced_ && (reg(kCr2) >> 20 & 0xFU) == source) {
    triggered_(true);
  }
}

// The second trigger output by the reference of channel 4, 5 or 6 (MMS2 7, 8, 9): a pulse at its rising edge.
void Timer::schedule_compare() {
  timeline().cancel(compare_);
  const unsigned source = advanced_ ? reg(kCr2) >> 20 & 0xFU : 0;
  if (source < 7 || !is_running()) {
    return;
  }
  if (source > 9 || !is_centred()) {
    report_violation("this source of the second trigger output is not modelled");
    return;
  }
  const unsigned channel = source - 4;  // 3, 4, 5 for channels 4, 5, 6
  const std::uint32_t modes = channel == 3 ? reg(kCcmr2) >> 8 : (channel == 4 ? reg(kCcmr3) : reg(kCcmr3) >> 8);
  const bool inverted = (modes >> 4 & 7U) == 7;  // PWM mode 2 rises while counting up, mode 1 while counting down
  require((modes >> 4 & 6U) == 6, "the trigger's channel is not in a PWM mode");
  const std::uint32_t value = compare_value_[channel];
  if (inverted != down_ && value <= limit_) {
    timeline().set(compare_, edge_at_ + (down_ ? limit_ - value : value) * count_);
  }
}

void Timer::compare_pulse() { trigger(reg(kCr2) >> 20 & 0xFU); }

// --- start by a master ---

void Timer::started_by_master() {
  const std::uint32_t mode = (reg(kSmcr) & 7U) | (reg(kSmcr) >> 13 & 8U);
  const std::uint32_t source = (reg(kSmcr) >> 4 & 7U) | (reg(kSmcr) >> 17 & 0x18U);
  if (mode == 6 && source == 0 && !is_running()) {
    reg(kCr1) |= kEnable;
    start();
  }
}

// --- outputs ---

bool Timer::is_leg_driven(std::size_t leg) const {
  const std::uint32_t enables = reg(kCcer) >> (4 * leg) & 0xFU;
  return is_main_output_enabled() && is_running() && (enables & 5U) == 5U;
}

void Timer::integrate() {
  if (!advanced_) {
    return;
  }
  // Less than 0 in an alarm that was due just before the access of a register to which it was integrated last.
  const auto elapsed = static_cast<double>(static_cast<std::int64_t>(timeline().instant() - integrated_to_));
  for (std::size_t leg = 0; leg < kLegs; ++leg) {
    driven_[leg] = driven_[leg] && is_leg_driven(leg);
    const double share = std::min(1.0, compare_value_[leg] / static_cast<double>(std::max(1U, limit_)));
    conducted_[leg] += share * elapsed;
  }
  integrated_to_ = timeline().instant();
}

std::array<std::optional<double>, Timer::kLegs> Timer::take_mean_legs() {
  integrate();
  std::array<std::optional<double>, kLegs> mean;
  const auto elapsed = static_cast<double>(integrated_to_ - integrated_from_);
  for (std::size_t leg = 0; leg < kLegs; ++leg) {
    if (driven_[leg] && elapsed > 0.0) {
      mean[leg] = conducted_[leg] / elapsed;
    }
    conducted_[leg] = 0.0;
    driven_[leg] = is_leg_driven(leg);
  }
  integrated_from_ = integrated_to_;
  return mean;
}

bool Timer::is_break_active() const {
  const std::uint32_t bdtr = reg(kBdtr);
  if ((bdtr & 1U << 12) == 0 || (reg(kAf1) & 1U) == 0) {
    return false;
  }
  const bool active_high = (bdtr & 1U << 13) != 0;
  const bool inverted = (reg(kAf1) & 1U << 9) != 0;
  return break_input_ == (active_high != inverted);
}

void Timer::set_break_input(bool level) {
  break_input_ = level;
  take_active_breaks();
}

bool Timer::is_second_break_active() const {
  const std::uint32_t bdtr = reg(kBdtr);
  const bool active_high = ((bdtr >> 25 ^ reg(kAf2) >> 9) & 1U) != 0;
  return (bdtr & 1U << 24) != 0 && (reg(kAf2) & 1U) != 0 && second_break_input_ == active_high;
}

void Timer::set_second_break_input(bool level) {
  second_break_input_ = level;
  take_active_breaks();
}

void Timer::set_system_break(bool active) {
  system_break_ = active;
  take_active_breaks();
}

void Timer::take_active_breaks() {
  if (is_break_active()) {
    take_break(kBreakFlag);
  }
  if (is_second_break_active()) {
    take_break(kSecondBreakFlag);
  }
  if (system_break_ && (reg(kBdtr) & kBreakEnable) != 0) {
    take_break(kSystemBreakFlag);
  }
}

void Timer::take_break(std::uint32_t flag) {
  integrate();
  reg(kBdtr) &= ~kMainOutput;
  reg(kSr) |= flag;
  refresh_interrupts();
  outputs_changed();
}

void Timer::refresh_interrupts() {
  update_line_.set((reg(kSr) & reg(kDier) & 1U) != 0);
  if (break_line_) {
    break_line_->set((reg(kDier) & kBreakInterrupt) != 0 &&
                     (reg(kSr) & (kBreakFlag | kSecondBreakFlag | kSystemBreakFlag)) != 0);
  }
}

void Timer::outputs_changed() {
  if (output_monitor_) {
    output_monitor_();
  }
}

// Settings that would let both switches of a leg conduct, or a bridge move while it should be off.
void Timer::check_legs() {
  if (!is_main_output_enabled()) {
    return;
  }
  const std::uint32_t dead_time = reg(kBdtr) & 0xFFU;
  const double dead_time_us = dead_time / 170.0;
  require((dead_time & 0x80U) == 0 && (reg(kCr1) >> 8 & 3U) == 0 && dead_time_us >= 0.4 && dead_time_us <= 0.7,
          "outputs enabled with a dead time outside 0.4 to 0.7 us");
  require((reg(kBdtr) & 1U << 12) != 0, "outputs enabled without the driver's fault input");
  require((reg(kBdtr) & 1U << 24) != 0, "outputs enabled without channel B of STO");
  require((reg(kBdtr) & 0xC00U) == 0xC00U, "the second break input needs OSSI and OSSR");
  for (unsigned leg = 0; leg < kLegs; ++leg) {
    const std::uint32_t bits = reg(kCcer) >> (4 * leg) & 0xFU;
    require((bits & 2U) == 0, "a leg's high side is inverted: both switches would conduct");
    require((bits & 8U) == 0, "a leg's low side is inverted: both switches would conduct");
    require((bits & 5U) == 5U, "outputs enabled with only one switch of a leg");
    const std::uint32_t mode = reg(kCcmr1) >> (8 * leg);
    require((mode & 3U) == 0 && (mode >> 4 & 7U) == 6 && (mode & 8U) != 0 && (reg(kCcmr1) >> (16 + 8 * leg) & 1U) == 0,
            "outputs enabled on a channel that is not in preloaded PWM mode 1");
  }
  require((reg(kCr2) & 0x3F00U) == 0, "an idle state would switch a bridge on");
  require(is_centred(), "outputs enabled and not centre-aligned");
}

// --- registers ---

std::uint32_t Timer::on_read(std::uint32_t offset, std::uint32_t stored, unsigned /*width*/) {
  if (offset == kCnt) {
    return counter();
  }
  return offset == kCr1 && down_ && is_running() ? stored | 1U << 4 : stored;
}

void Timer::write_cr1(std::uint32_t written) {
  const bool was_running = is_running();
  if (was_running) {
    require(((written ^ reg(kCr1)) & 0x360U) == 0, "alignment or clock division changed while the counter runs");
  }
  if (was_running && (written & kEnable) == 0) {
    stop();
  }
  store(kCr1, is_centred() && was_running ? written & ~(1U << 4) : written);
  if (!was_running && is_running()) {
    start();
  }
}

// RM0440, LOCK of BDTR: bits that can no longer change.
void Timer::check_lock(std::uint32_t offset, std::uint32_t written) const {
  const std::uint32_t level = reg(kBdtr) >> 8 & 3U;
  const std::uint32_t change = written ^ reg(offset);
  const bool locked =
      (level >= 1 && ((offset == kBdtr && (change & 0x3FFF7000U) != 0) || (offset == kCr2 && (change & 0x3F00U) != 0) ||
                      (offset == kAf1 && change != 0))) ||
      (level >= 1 && offset == kBdtr && (change & 0xFFU) != 0) ||
      (level >= 2 && ((offset == kCcer && (change & 0xAAAAU) != 0) || (offset == kBdtr && (change & 0xC00U) != 0))) ||
      (level >= 3 && (offset == kCcmr1 || offset == kCcmr2) && change != 0);
  require(!locked, "a locked bit is written");
}

void Timer::write_bdtr(std::uint32_t written) {
  check_lock(kBdtr, written);
  integrate();
  store(kBdtr, written);
  require((written & 0x3C000000U) == 0, "bidirectional break inputs are not modelled");
  take_active_breaks();
  check_legs();
  outputs_changed();
}

void Timer::write_compare(std::uint32_t offset, std::uint32_t written) {
  store(offset, written);
  const std::uint32_t channel = offset >= kCcr5 ? 4 + (offset - kCcr5) / 4 : (offset - kCcr1) / 4;
  const std::uint32_t modes = channel < 2 ? reg(kCcmr1) : (channel < 4 ? reg(kCcmr2) : reg(kCcmr3));
  const bool preloaded = (modes >> (8 * (channel % 2)) & 8U) != 0;
  if (channel < kLegs && is_main_output_enabled()) {
    require(reg(offset) <= limit_, "a compare value above the period");
  }
  if (!preloaded) {
    integrate();
    compare_value_[channel] = reg(offset) & 0xFFFF;
  }
}

void Timer::on_write(std::uint32_t offset, std::uint32_t written, unsigned /*width*/) {
  if (offset == kCr1) {
    write_cr1(written);
    check_legs();
  } else if (offset == kSr) {
    reg(kSr) &= written;
    refresh_interrupts();
  } else if (offset == kEgr) {
    require((written & ~0x81U) == 0, "this event by software is not modelled");
    if ((written & 0x80U) != 0) {
      take_break(kBreakFlag);
    }
    if ((written & 1U) != 0) {
      update(true);
      stopped_at_ = 0;
      down_ = false;
      edge_at_ = timeline().instant();
      if (is_running()) {
        timeline().set(edge_, edge_at_ + (is_centred() ? limit_ : limit_ + 1) * count_);
        schedule_compare();
      }
    }
  } else if (offset == kBdtr) {
    write_bdtr(written);
  } else if ((offset >= kCcr1 && offset <= kCcr4) || offset == kCcr5 || offset == kCcr6) {
    write_compare(offset, written);
  } else if (offset == kCnt) {
    require(!is_running(), "the running counter is written");
    stopped_at_ = written & 0xFFFF;
  } else {
    if (advanced_) {
      check_lock(offset, written);
    }
    integrate();
    store(offset, written);
    if (offset == kArr && (reg(kCr1) & 1U << 7) == 0) {
      limit_ = written & 0xFFFF;
    }
    if (offset == kDier) {
      require((written & ~0x81U) == 0, "compare, trigger and DMA requests are not modelled");
      refresh_interrupts();
    }
    if (advanced_) {
      check_legs();
    }
  }
}

}  // namespace trackservo::target
