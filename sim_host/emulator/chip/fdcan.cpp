// SPDX-License-Identifier: Apache-2.0
#include "chip/fdcan.hpp"

namespace trackservo::target {
namespace {

constexpr std::uint32_t kCccr = 0x18;
constexpr std::uint32_t kNbtp = 0x1C;
constexpr std::uint32_t kTscc = 0x20;
constexpr std::uint32_t kTscv = 0x24;
constexpr std::uint32_t kEcr = 0x40;
constexpr std::uint32_t kPsr = 0x44;
constexpr std::uint32_t kIr = 0x50;
constexpr std::uint32_t kIe = 0x54;
constexpr std::uint32_t kIls = 0x58;
constexpr std::uint32_t kIle = 0x5C;
constexpr std::uint32_t kRxgfc = 0x80;
constexpr std::uint32_t kXidam = 0x84;
constexpr std::uint32_t kRxf0s = 0x90;
constexpr std::uint32_t kRxf0a = 0x94;
constexpr std::uint32_t kRxf1s = 0x98;
constexpr std::uint32_t kRxf1a = 0x9C;
constexpr std::uint32_t kTxbc = 0xC0;
constexpr std::uint32_t kTxfqs = 0xC4;
constexpr std::uint32_t kTxbrp = 0xC8;
constexpr std::uint32_t kTxbar = 0xCC;
constexpr std::uint32_t kTxbcr = 0xD0;
constexpr std::uint32_t kTxbto = 0xD4;
constexpr std::uint32_t kTxbcf = 0xD8;
constexpr std::uint32_t kTxbtie = 0xDC;
constexpr std::uint32_t kCkdiv = 0x100;

// Offsets in the message RAM (RM0440, 44.3.3).
constexpr std::uint32_t kStandardFilters = 0x000;
constexpr std::uint32_t kExtendedFilters = 0x070;
constexpr std::uint32_t kFifos[] = {0x0B0, 0x188};
constexpr std::uint32_t kTransmitBuffers = 0x278;
constexpr std::uint32_t kElementBytes = 72;
constexpr std::uint32_t kFifoElements = 3;

constexpr std::uint32_t kInit = 1;
constexpr std::uint32_t kChangeEnable = 2;
constexpr std::uint32_t kExtended = 1U << 30;
constexpr std::uint32_t kRemote = 1U << 29;
constexpr std::uint32_t kNoFilter = 0x80;

constexpr std::uint32_t kTransmissionComplete = 1U << 7;
constexpr std::uint32_t kTransmitFifoEmpty = 1U << 9;
constexpr std::uint32_t kWarning = 1U << 18;
constexpr std::uint32_t kPassive = 1U << 17;
constexpr std::uint32_t kBusOff = 1U << 19;

std::vector<Peripheral::Register> ram_words() {
  std::vector<Peripheral::Register> table;
  for (std::uint32_t offset = 0; offset < MessageRam::kBytes; offset += 4) {
    table.push_back({"message RAM", offset, 0x5A5A5A5A, 0xFFFFFFFF});
  }
  return table;
}

}  // namespace

MessageRam::MessageRam(Services services) : Peripheral("SRAMCAN", services, ram_words()) {}

Fdcan::Fdcan(Services services, const char *name, std::array<int, 2> interrupts, MessageRam& ram)
    : Peripheral(name, services,
                 {
                     {"CREL", 0x00, 0x32141218, 0},
                     {"ENDN", 0x04, 0x87654321, 0},
                     {"DBTP", 0x0C, 0xA33, 0x009F1FFF},
                     {"TEST", 0x10, 0, 0x70, 0x80},
                     {"RWD", 0x14, 0, 0xFF, 0xFF00},
                     {"CCCR", kCccr, 1, 0xF3F7, 8},
                     {"NBTP", kNbtp, 0x06000A03, 0xFFFFFF7F},
                     {"TSCC", kTscc, 0, 0xF0003},
                     {"TSCV", kTscv, 0, 0xFFFF},
                     {"TOCC", 0x28, 0xFFFF0000, 0xFFFF0007},
                     {"ECR", kEcr, 0, 0, 0xFFFFFF},
                     {"PSR", kPsr, 0x707, 0, 0x7F7FFF},
                     {"TDCR", 0x48, 0, 0x7F7F},
                     {"IR", kIr, 0, 0xFFFFFF},
                     {"IE", kIe, 0, 0xFFFFFF},
                     {"ILS", kIls, 0, 0x7F},
                     {"ILE", kIle, 0, 3},
                     {"RXGFC", kRxgfc, 0, 0x0F1F033F},
                     {"XIDAM", kXidam, 0x1FFFFFFF, 0x1FFFFFFF},
                     {"HPMS", 0x88, 0, 0, 0x9FC7},
                     {"RXF0S", kRxf0s, 0, 0, 0x303030F},
                     {"RXF0A", kRxf0a, 0, 7},
                     {"RXF1S", kRxf1s, 0, 0, 0x303030F},
                     {"RXF1A", kRxf1a, 0, 7},
                     {"TXBC", kTxbc, 0, 1U << 24},
                     {"TXFQS", kTxfqs, 3, 0, 0x230307},
                     {"TXBRP", kTxbrp, 0, 0, 7},
                     {"TXBAR", kTxbar, 0, 7},
                     {"TXBCR", kTxbcr, 0, 7},
                     {"TXBTO", kTxbto, 0, 0, 7},
                     {"TXBCF", kTxbcf, 0, 0, 7},
                     {"TXBTIE", kTxbtie, 0, 7},
                     {"TXBCIE", 0xE0, 0, 7},
                     {"TXEFS", 0xE4, 0, 0, 0x3030307},
                     {"TXEFA", 0xE8, 0, 3},
                     {"CKDIV", kCkdiv, 0, 0xF},
                 }),
      ram_(ram),
      lines_{IrqLine(services.exceptions, interrupts[0]), IrqLine(services.exceptions, interrupts[1])} {}

void Fdcan::on_reset() {
  fifo_ = {};
  order_ = 0;
  waiting_ = 0;
  put_index_ = 0;
  accepted_ = 0;
  recovery_.reset();
  for (IrqLine& line : lines_) {
    line.forget();
  }
}

// --- joining the bus ---

std::optional<double> Fdcan::bits_per_s() const {
  if (is_initialising() || !pins_()) {
    return std::nullopt;
  }
  const std::uint32_t nbtp = reg(kNbtp);
  const double quanta = (nbtp & 0x7FU) + (nbtp >> 8 & 0xFFU) + 3;
  const std::uint32_t divider = reg(kCkdiv) == 0 ? 1 : 2 * reg(kCkdiv);
  return static_cast<double>(frequency_hz_()) / divider / ((nbtp >> 16 & 0x1FFU) + 1.0) / quanta;
}

// RM0440: setting CCE resets the status registers of the FIFOs and the buffers.
void Fdcan::forget_frames() {
  fifo_ = {};
  order_ = 0;
  waiting_ = 0;
  put_index_ = 0;
  reg(kTxbrp) = 0;
  reg(kTxbto) = 0;
  reg(kTxbcf) = 0;
  ++restarts_;
}

void Fdcan::check_timing() const {
  const std::uint32_t nbtp = reg(kNbtp);
  const std::uint32_t after = (nbtp & 0x7FU) + 1;
  const std::uint32_t before = (nbtp >> 8 & 0xFFU) + 2;
  const double sample_point = static_cast<double>(before) / static_cast<double>(before + after);
  require(sample_point >= 0.80 && sample_point <= 0.90, "sample point outside the 80 to 90 % that CiA 301 requires");
  require((nbtp >> 25) + 1 <= after, "synchronisation jump width longer than the segment after the sample point");
  require((reg(kCccr) & 0x3BCU & ~0x300U) == 0, "monitor, test, restricted or one-shot mode is on");
  require((reg(kCccr) & 0x300U) == 0, "CAN FD is on, but the bus is classic CAN");
}

void Fdcan::write_cccr(std::uint32_t written) {
  const std::uint32_t old = reg(kCccr);
  require((old & kChangeEnable) != 0 || ((written ^ old) & 0xF3E4U) == 0,
          "a protected bit of CCCR is written without CCE");
  if ((written & kInit) == 0) {
    written &= ~kChangeEnable;
  }
  require((written & kChangeEnable) == 0 || (old & kInit) != 0, "CCE is set without INIT");
  store(kCccr, written);
  if ((old & kChangeEnable) == 0 && (written & kChangeEnable) != 0) {
    forget_frames();
  }
  if ((old & kInit) != 0 && (written & kInit) == 0) {
    check_timing();
    if ((reg(kPsr) & 1U << 7) != 0) {
      recovery_ = timeline().now() + Instant{129} * 11 * kUnitsPerMicrosecond;
    }
  }
}

void Fdcan::go_bus_off() {
  reg(kPsr) |= 1U << 7 | 1U << 6 | 1U << 5;
  reg(kCccr) |= kInit;
  flag(kBusOff | kWarning | kPassive);
}

void Fdcan::bus_idle(Instant now) {
  if (recovery_ && now >= *recovery_) {
    recovery_.reset();
    reg(kPsr) &= ~(1U << 7 | 1U << 6 | 1U << 5);
    flag(kBusOff | kWarning | kPassive);
  }
}

// --- receiving ---

std::optional<Fdcan::Decision> Fdcan::element(std::uint32_t configuration, std::uint32_t index) {
  switch (configuration & 7U) {
    case 1:
    case 5:
      return Decision{true, 0, index};
    case 2:
    case 6:
      return Decision{true, 1, index};
    case 3:
      return Decision{false, 0, index};
    default:
      return std::nullopt;
  }
}

Fdcan::Decision Fdcan::filter_standard(const CanMessage& message) {
  const std::uint32_t identifier = message.header >> 18 & 0x7FFU;
  for (std::uint32_t i = 0; i < (reg(kRxgfc) >> 16 & 0x1FU); ++i) {
    const std::uint32_t entry = ram_.word(kStandardFilters + 4 * i);
    const std::uint32_t first = entry >> 16 & 0x7FFU;
    const std::uint32_t second = entry & 0x7FFU;
    const std::uint32_t type = entry >> 30;
    const bool matches = (type == 0 && identifier >= first && identifier <= second) ||
                         (type == 1 && (identifier == first || identifier == second)) ||
                         (type == 2 && ((identifier ^ first) & second) == 0);
    if (matches) {
      if (const std::optional<Decision> decision = element(entry >> 27, i)) {
        return *decision;
      }
    }
  }
  const std::uint32_t others = reg(kRxgfc) >> 4 & 3U;
  return {others < 2, others & 1U, kNoFilter};
}

Fdcan::Decision Fdcan::filter_extended(const CanMessage& message) {
  const std::uint32_t identifier = message.header & reg(kXidam);
  for (std::uint32_t i = 0; i < (reg(kRxgfc) >> 24 & 0xFU); ++i) {
    const std::uint32_t entry = ram_.word(kExtendedFilters + 8 * i);
    const std::uint32_t limit = ram_.word(kExtendedFilters + 8 * i + 4);
    const std::uint32_t first = entry & 0x1FFFFFFF;
    const std::uint32_t second = limit & 0x1FFFFFFF;
    const std::uint32_t type = limit >> 30;
    const bool matches = ((type == 0 || type == 3) && identifier >= first && identifier <= second) ||
                         (type == 1 && (identifier == first || identifier == second)) ||
                         (type == 2 && ((identifier ^ first) & second) == 0);
    if (matches) {
      if (const std::optional<Decision> decision = element(entry >> 29, i)) {
        return *decision;
      }
    }
  }
  const std::uint32_t others = reg(kRxgfc) >> 2 & 3U;
  return {others < 2, others & 1U, kNoFilter};
}

Fdcan::Decision Fdcan::filter(const CanMessage& message) {
  const bool extended = (message.header & kExtended) != 0;
  if ((message.header & kRemote) != 0 && (reg(kRxgfc) & (extended ? 1U : 2U)) != 0) {
    return {false, 0, kNoFilter};
  }
  return extended ? filter_extended(message) : filter_standard(message);
}

void Fdcan::receive(const CanMessage& message) {
  reg(kPsr) &= ~7U;  // no error
  const Decision decision = filter(message);
  if (decision.accepted) {
    ++accepted_;
    put(decision.fifo, message, decision.filter);
  }
}

// RM0440: TSS = 1 counts bits.
std::uint32_t Fdcan::timestamp() const {
  require((reg(kTscc) & 2U) == 0 && reg(kTscc) >> 16 == 0,
          "time stamps of another timer or with a prescaler are not modelled");
  const double bits = seconds_of(timeline().now() - stamped_from_) * bits_per_s().value_or(0.0);
  return (reg(kTscc) & 3U) == 1 ? static_cast<std::uint32_t>(static_cast<std::uint64_t>(bits)) : 0;
}

void Fdcan::put(unsigned fifo, const CanMessage& message, std::uint32_t filter) {
  Fifo& state = fifo_[fifo];
  const unsigned shift = fifo == 0 ? 0 : 3;
  if (state.fill == kFifoElements) {
    if ((reg(kRxgfc) & (fifo == 0 ? 1U << 9 : 1U << 8)) == 0) {  // blocking: the new one is lost
      flag(4U << shift);
      return;
    }
    state.get = (state.get + 1) % kFifoElements;
    --state.fill;
    flag(4U << shift);
  }
  const std::uint32_t at = kFifos[fifo] + kElementBytes * ((state.get + state.fill) % kFifoElements);
  ram_.word(at) = message.header;
  ram_.word(at + 4) =
      (filter & kNoFilter ? 1U << 31 : filter << 24) | message.length << 16 | ((timestamp() - message.bits) & 0xFFFFU);
  ram_.word(at + 8) = message.data[0];
  ram_.word(at + 12) = message.data[1];
  ++state.fill;
  flag((state.fill == kFifoElements ? 3U : 1U) << shift);
}

void Fdcan::acknowledge(unsigned fifo, std::uint32_t index) {
  Fifo& state = fifo_[fifo];
  if (index >= kFifoElements || state.fill == 0) {
    report_violation("a message that does not exist is acknowledged");
    return;
  }
  const std::uint32_t freed = (index + kFifoElements - state.get) % kFifoElements + 1;
  require(freed <= state.fill, "a message that does not exist is acknowledged");
  state.fill -= std::min(freed, state.fill);
  state.get = (index + 1) % kFifoElements;
}

std::uint32_t Fdcan::fifo_status(unsigned fifo) const {
  const Fifo& state = fifo_[fifo];
  const bool lost = (reg(kIr) & 4U << (fifo == 0 ? 0 : 3)) != 0;
  return state.fill | state.get << 8 | (state.get + state.fill) % kFifoElements << 16 |
         (state.fill == kFifoElements ? 1U << 24 : 0U) | (lost ? 1U << 25 : 0U);
}

// --- sending ---

std::optional<unsigned> Fdcan::next_buffer() const {
  if (waiting_ == 0) {
    return std::nullopt;
  }
  return order_ & 3U;
}

std::optional<CanMessage> Fdcan::next_to_send() const {
  const std::optional<unsigned> buffer = next_buffer();
  if (!buffer || is_initialising() || recovery_) {
    return std::nullopt;
  }
  const std::uint32_t at = kTransmitBuffers + kElementBytes * *buffer;
  CanMessage message;
  message.header = ram_.word(at);
  message.length = std::min<std::uint32_t>(ram_.word(at + 4) >> 16 & 0xFU, 8);
  message.data = {ram_.word(at + 8), ram_.word(at + 12)};
  if ((message.header & kExtended) == 0) {
    require((message.header & 0x3FFFFU) == 0, "a standard identifier with bits below bit 18");
  }
  require((ram_.word(at + 4) & 0x00300000U) == 0, "a frame in FD format is sent on a classic CAN bus");
  return message;
}

void Fdcan::sent() {
  const std::optional<unsigned> buffer = next_buffer();
  if (!buffer) {
    return;
  }
  order_ >>= 2;
  --waiting_;
  reg(kTxbrp) &= ~(1U << *buffer);
  reg(kTxbto) |= 1U << *buffer;
  reg(kPsr) &= ~7U;
  flag(((reg(kTxbtie) >> *buffer & 1U) != 0 ? kTransmissionComplete : 0U) | (waiting_ == 0 ? kTransmitFifoEmpty : 0U));
}

// --- registers ---

void Fdcan::flag(std::uint32_t bits) {
  reg(kIr) |= bits;
  refresh_interrupts();
}

void Fdcan::refresh_interrupts() {
  // Which interrupts each bit of ILS moves to line 1 (RM0440, FDCAN_ILS).
  constexpr std::uint32_t kGroups[] = {0x000007, 0x000038, 0x0001C0, 0x001E00, 0x00E000, 0x030000, 0xFC0000};
  std::uint32_t second = 0;
  for (unsigned group = 0; group < 7; ++group) {
    second |= (reg(kIls) >> group & 1U) != 0 ? kGroups[group] : 0U;
  }
  const std::uint32_t active = reg(kIr) & reg(kIe);
  lines_[0].set((active & ~second) != 0 && (reg(kIle) & 1U) != 0);
  lines_[1].set((active & second) != 0 && (reg(kIle) & 2U) != 0);
}

std::uint32_t Fdcan::on_read(std::uint32_t offset, std::uint32_t stored, unsigned /*width*/) {
  switch (offset) {
    case kRxf0s:
      return fifo_status(0);
    case kRxf1s:
      return fifo_status(1);
    case kTxfqs:
      return (kBuffers - waiting_) | (next_buffer().value_or(put_index_)) << 8 | put_index_ << 16 |
             (waiting_ == kBuffers ? 1U << 21 : 0U);
    case kTscv:
      return timestamp() & 0xFFFFU;
    case kPsr:
      reg(kPsr) |= 7U;  // reading sets "no change"
      return stored;
    default:
      return stored;
  }
}

void Fdcan::on_write(std::uint32_t offset, std::uint32_t written, unsigned /*width*/) {
  const bool is_protected = offset == kNbtp || offset == kRxgfc || offset == kXidam || offset == kTxbc ||
                            offset == kCkdiv || offset == kTscc || offset == 0x0C || offset == 0x48 || offset == 0x28;
  if (is_protected && (reg(kCccr) & 3U) != 3) {
    report_violation("a protected register is written outside of initialisation");
    return;
  }
  switch (offset) {
    case kCccr:
      write_cccr(written);
      break;
    case kTscv:
      stamped_from_ = timeline().now();
      break;
    case kIr:
      reg(kIr) &= ~written;
      break;
    case kRxf0a:
      acknowledge(0, written);
      break;
    case kRxf1a:
      acknowledge(1, written);
      break;
    case kTxbar:
      for (unsigned buffer = 0; buffer < kBuffers; ++buffer) {
        if ((written >> buffer & 1U) != 0) {
          require((reg(kTxbrp) >> buffer & 1U) == 0, "a buffer that is still pending is requested");
          require(buffer == put_index_, "a buffer other than the put index is requested");
          reg(kTxbrp) |= 1U << buffer;
          reg(kTxbto) &= ~(1U << buffer);
          order_ |= buffer << (2 * waiting_++);
          put_index_ = (buffer + 1) % kBuffers;
        }
      }
      break;
    case kTxbcr:
      if ((written & reg(kTxbrp)) != 0) {
        reg(kTxbcf) |= written & reg(kTxbrp);
        reg(kTxbrp) &= ~written;
        std::uint32_t order = 0;
        unsigned waiting = 0;
        for (unsigned i = 0; i < waiting_; ++i) {
          const std::uint32_t buffer = order_ >> (2 * i) & 3U;
          if ((written >> buffer & 1U) == 0) {
            order |= buffer << (2 * waiting++);
          }
        }
        order_ = order;
        waiting_ = waiting;
      }
      break;
    default:
      store(offset, written);
      break;
  }
  refresh_interrupts();
}

}  // namespace trackservo::target
