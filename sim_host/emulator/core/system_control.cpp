// SPDX-License-Identifier: Apache-2.0
#include "core/system_control.hpp"

#include <utility>

namespace trackservo::target {
namespace {

constexpr std::uint32_t kSystickControl = 0x010;
constexpr std::uint32_t kSystickReload = 0x014;
constexpr std::uint32_t kSystickValue = 0x018;
constexpr std::uint32_t kEnableSet = 0x100;
constexpr std::uint32_t kEnableClear = 0x180;
constexpr std::uint32_t kPendSet = 0x200;
constexpr std::uint32_t kPendClear = 0x280;
constexpr std::uint32_t kActive = 0x300;
constexpr std::uint32_t kPriority = 0x400;
constexpr std::uint32_t kPriorityEnd = 0x468;
constexpr std::uint32_t kIcsr = 0xD04;
constexpr std::uint32_t kVtor = 0xD08;
constexpr std::uint32_t kAircr = 0xD0C;
constexpr std::uint32_t kCcr = 0xD14;
constexpr std::uint32_t kSystemPriority = 0xD18;
constexpr std::uint32_t kShcsr = 0xD24;
constexpr std::uint32_t kCfsr = 0xD28;
constexpr std::uint32_t kHfsr = 0xD2C;
constexpr std::uint32_t kMmfar = 0xD34;
constexpr std::uint32_t kBfar = 0xD38;
constexpr std::uint32_t kCpacr = 0xD88;
constexpr std::uint32_t kMpuControl = 0xD94;
constexpr std::uint32_t kMpuRegion = 0xD98;
constexpr std::uint32_t kMpuBase = 0xD9C;
constexpr std::uint32_t kMpuAttributes = 0xDA0;
constexpr std::uint32_t kFpccr = 0xF34;

constexpr std::uint32_t kEveryBit = 0xFFFFFFFF;

bool is_in(std::uint32_t offset, std::uint32_t first, std::uint32_t end) { return offset >= first && offset < end; }

}  // namespace

std::vector<Peripheral::Register> SystemControl::registers() {
  std::vector<Register> table = {
      {"ACTLR", 0x008, 0, 0x307},
      {"SYST_CSR", kSystickControl, 4, 7, 1U << 16},
      {"SYST_RVR", kSystickReload, 0, 0xFFFFFF},
      {"SYST_CVR", kSystickValue, 0, kEveryBit},
      {"SYST_CALIB", 0x01C, 0, 0},
      {"CPUID", 0xD00, 0x410FC241, 0},
      {"ICSR", kIcsr, 0, 0x9E000000, 0x007FF9FF},
      {"VTOR", kVtor, 0, 0xFFFFFF80},
      {"AIRCR", kAircr, 0xFA050000, kEveryBit},
      {"SCR", 0xD10, 0, 0x16},
      {"CCR", kCcr, 0x200, 0x31B},
      {"SHCSR", kShcsr, 0, 0x70000, 0xFD8B},
      {"CFSR", kCfsr, 0, kEveryBit, 0, true},
      {"HFSR", kHfsr, 0, kEveryBit},
      {"MMFAR", kMmfar, 0, 0, kEveryBit},
      {"BFAR", kBfar, 0, 0, kEveryBit},
      {"CPACR", kCpacr, 0, 0xF00000},
      {"MPU_TYPE", 0xD90, 0x800, 0},
      {"MPU_CTRL", kMpuControl, 0, 7},
      {"MPU_RNR", kMpuRegion, 0, 0xFF},
      {"MPU_RBAR", kMpuBase, 0, 0xFFFFFFFF},
      {"MPU_RASR", kMpuAttributes, 0, 0x173FFF3F},
      {"DEMCR", 0xDFC, 0, 0x010F07F1},
      {"STIR", 0xF00, 0, 0x1FF},
      {"FPCCR", kFpccr, 0xC0000000, 0xC0000000, 0x17B},
      {"FPCAR", 0xF38, 0, 0xFFFFFFF8},
      {"FPDSCR", 0xF3C, 0, 0x07C00000},
  };
  for (std::uint32_t word = 0; word < 4; ++word) {
    table.push_back({"NVIC_ISER", kEnableSet + 4 * word, 0, kEveryBit});
    table.push_back({"NVIC_ICER", kEnableClear + 4 * word, 0, kEveryBit});
    table.push_back({"NVIC_ISPR", kPendSet + 4 * word, 0, kEveryBit});
    table.push_back({"NVIC_ICPR", kPendClear + 4 * word, 0, kEveryBit});
    table.push_back({"NVIC_IABR", kActive + 4 * word, 0, 0});
  }
  for (std::uint32_t offset = kPriority; offset < kPriorityEnd; offset += 4) {
    table.push_back({"NVIC_IPR", offset, 0, kEveryBit, 0, true});
  }
  for (std::uint32_t offset = kSystemPriority; offset < kShcsr; offset += 4) {
    table.push_back({"SHPR", offset, 0, kEveryBit, 0, true});
  }
  return table;
}

SystemControl::SystemControl(Services services, CortexM4& core, std::function<void()> reset_request)
    : Peripheral("SCS", services, registers()),
      core_(core),
      reset_request_(std::move(reset_request)),
      systick_(timeline().add([this] {
        systick_zero_ += reg(kSystickReload) + 1;
        if ((reg(kSystickControl) & 2U) != 0) {
          exceptions().pend(kSysTick);
        }
        reg(kSystickControl) |= 1U << 16;
        start_systick();
      })) {}

void SystemControl::on_reset() { timeline().cancel(systick_); }

// --- NVIC ---

std::uint32_t SystemControl::enable_bits(std::uint32_t offset) const {
  std::uint32_t bits = 0;
  for (int bit = 0; bit < 32; ++bit) {
    const int exception = kFirstInterrupt + static_cast<int>(offset & 0x7F) * 8 + bit;
    bits |= exception < Exceptions::kCount && exceptions().is_enabled(exception) ? 1U << bit : 0U;
  }
  return bits;
}

std::uint32_t SystemControl::pending_bits(std::uint32_t offset) const {
  std::uint32_t bits = 0;
  for (int bit = 0; bit < 32; ++bit) {
    const int exception = kFirstInterrupt + static_cast<int>(offset & 0x7F) * 8 + bit;
    bits |= exception < Exceptions::kCount && exceptions().is_pending(exception) ? 1U << bit : 0U;
  }
  return bits;
}

std::uint32_t SystemControl::active_bits(std::uint32_t offset) const {
  std::uint32_t bits = 0;
  for (int bit = 0; bit < 32; ++bit) {
    const int exception = kFirstInterrupt + static_cast<int>(offset & 0x7F) * 8 + bit;
    bits |= exception < Exceptions::kCount && exceptions().is_active(exception) ? 1U << bit : 0U;
  }
  return bits;
}

// The set and clear registers of enable and pending bits.
void SystemControl::write_bits(std::uint32_t offset, std::uint32_t written) {
  for (int bit = 0; bit < 32; ++bit) {
    if ((written >> bit & 1U) == 0) {
      continue;
    }
    const int exception = kFirstInterrupt + static_cast<int>(offset & 0x7F) * 8 + bit;
    if (exception >= Exceptions::kCount) {
      report_violation(fmt::format("interrupt {} does not exist", exception - kFirstInterrupt));
    } else if (offset < kPendSet) {
      exceptions().enable(exception, offset < kEnableClear);
    } else if (offset < kPendClear) {
      exceptions().pend(exception);
    } else {
      exceptions().unpend(exception);
    }
  }
}

void SystemControl::write_priorities(int first_exception, std::uint32_t offset, std::uint32_t written) {
  for (unsigned lane = 0; lane < 4; ++lane) {
    const auto priority = static_cast<std::uint8_t>(written >> (8 * lane));
    const int exception = first_exception + static_cast<int>(lane);
    if (exception < Exceptions::kCount) {
      require((priority & 0xFU) == 0, "a priority uses bits that this chip does not implement");
      exceptions().set_priority(exception, priority);
    }
  }
  reg(offset) = written;
}

// --- System Control Block ---

std::uint32_t SystemControl::icsr() const {
  const int next = exceptions().next();
  return static_cast<std::uint32_t>(core_.current_exception()) | static_cast<std::uint32_t>(next) << 12 |
         (exceptions().is_pending(kSysTick) ? 1U << 26 : 0U) | (exceptions().is_pending(kPendSv) ? 1U << 28 : 0U) |
         (exceptions().is_pending(kNmi) ? 1U << 31 : 0U) | (next >= kFirstInterrupt ? 1U << 22 : 0U);
}

std::uint32_t SystemControl::shcsr() const {
  return core_.state().shcsr_enables | (exceptions().is_active(kMemManage) ? 1U : 0U) |
         (exceptions().is_active(kBusFault) ? 2U : 0U) | (exceptions().is_active(kUsageFault) ? 8U : 0U) |
         (exceptions().is_active(kSvcall) ? 1U << 7 : 0U) | (exceptions().is_active(kPendSv) ? 1U << 10 : 0U) |
         (exceptions().is_active(kSysTick) ? 1U << 11 : 0U);
}

void SystemControl::write_icsr(std::uint32_t written) {
  if ((written & 1U << 31) != 0) {
    exceptions().pend(kNmi);
  }
  if ((written & 1U << 28) != 0) {
    exceptions().pend(kPendSv);
  }
  if ((written & 1U << 27) != 0) {
    exceptions().unpend(kPendSv);
  }
  if ((written & 1U << 26) != 0) {
    exceptions().pend(kSysTick);
  }
  if ((written & 1U << 25) != 0) {
    exceptions().unpend(kSysTick);
  }
}

void SystemControl::write_aircr(std::uint32_t written) {
  if (written >> 16 != 0x05FA) {
    report_violation("AIRCR written without its key");
    return;
  }
  reg(kAircr) = 0xFA050000 | (written & 0x700U);
  exceptions().set_priority_grouping(written >> 8 & 7U);
  if ((written & 4U) != 0) {
    reset_request_();
  }
}

// --- MPU ---

// One region, without access; elsewhere the map of the architecture.
void SystemControl::take_guard() {
  const std::uint32_t attributes = reg(kMpuAttributes);
  core_.state().guard = {};
  if ((reg(kMpuControl) & 1U) == 0 || (attributes & 1U) == 0) {
    return;
  }
  const std::uint32_t size = 2U << (attributes >> 1 & 0x1FU);
  const std::uint32_t base = reg(kMpuBase) & ~0x1FU;
  require(reg(kMpuControl) == 5 && reg(kMpuRegion) == 0, "this use of the MPU is not modelled");
  require((attributes & 0x0700FF00) == 0, "a region of the MPU with rights or parts is not modelled");
  require((base & (size - 1)) == 0, "a region of the MPU does not begin at a multiple of its size");
  require(core_.memory_at(base, 1) == nullptr && core_.memory_at(base + size - 1, 1) == nullptr,
          "a region of the MPU over memory is not modelled");
  core_.state().guard = {base, size};
}

// --- SysTick ---

void SystemControl::start_systick() {
  const std::uint64_t cycle_units = kUnitsPerSecond / 170'000'000;  // it is used at full speed or not at all
  const std::uint64_t left = systick_zero_ - core_.cycles();
  timeline().set(systick_, timeline().now() + left * cycle_units);
}

std::uint32_t SystemControl::read_systick(std::uint32_t offset, std::uint32_t stored) {
  if (offset == kSystickControl) {
    reg(kSystickControl) &= ~(1U << 16);
    return stored;
  }
  const bool runs = (reg(kSystickControl) & 1U) != 0;
  return offset == kSystickValue ? (runs ? static_cast<std::uint32_t>(systick_zero_ - core_.cycles()) & 0xFFFFFF : 0)
                                 : stored;
}

void SystemControl::write_systick(std::uint32_t offset, std::uint32_t written) {
  if (offset == kSystickValue) {
    written = 0;
  }
  store(offset, written);
  const bool runs = (reg(kSystickControl) & 1U) != 0;
  if (offset != kSystickReload && runs) {
    require((reg(kSystickControl) & 4U) != 0, "SysTick from the reference clock is not modelled");
    systick_zero_ = core_.cycles() + reg(kSystickReload) + 1;
    start_systick();
  } else if (!runs) {
    timeline().cancel(systick_);
  }
}

// --- registers ---

std::uint32_t SystemControl::on_read(std::uint32_t offset, std::uint32_t stored, unsigned /*width*/) {
  if (is_in(offset, kEnableSet, kPendSet)) {
    return enable_bits(offset);
  }
  if (is_in(offset, kPendSet, kActive)) {
    return pending_bits(offset);
  }
  if (is_in(offset, kActive, kPriority)) {
    return active_bits(offset);
  }
  if (is_in(offset, kSystickControl, 0x020)) {
    return read_systick(offset, stored);
  }
  switch (offset) {
    case kIcsr:
      return icsr();
    case kShcsr:
      return shcsr();
    case kCfsr:
      return core_.state().cfsr;
    case kHfsr:
      return core_.state().hfsr;
    case kMmfar:
      return core_.state().mmfar;
    case kBfar:
      return core_.state().bfar;
    default:
      return stored;
  }
}

void SystemControl::on_write(std::uint32_t offset, std::uint32_t written, unsigned /*width*/) {
  if (is_in(offset, kEnableSet, kActive)) {
    write_bits(offset, written);
  } else if (is_in(offset, kPriority, kPriorityEnd)) {
    write_priorities(kFirstInterrupt + static_cast<int>(offset - kPriority), offset, written);
  } else if (is_in(offset, kSystemPriority, kShcsr)) {
    write_priorities(4 + static_cast<int>(offset - kSystemPriority), offset, written);
  } else if (is_in(offset, kSystickControl, 0x020)) {
    write_systick(offset, written);
  } else if (offset == kIcsr) {
    write_icsr(written);
  } else if (offset == kAircr) {
    write_aircr(written);
  } else if (offset == kCfsr) {
    core_.state().cfsr &= ~written;
  } else if (offset == kHfsr) {
    core_.state().hfsr &= ~written;
  } else if (offset == 0xF00) {
    exceptions().pend(kFirstInterrupt + static_cast<int>(written & 0x1FF));
  } else {
    store(offset, written);
    take_guard();
    core_.state().vector_table = reg(kVtor);
    core_.state().shcsr_enables = reg(kShcsr) & 0x70000;
    core_.state().fpu_enabled = reg(kCpacr) == 0xF00000;
    core_.state().fpu_context_automatic = (reg(kFpccr) & 1U << 31) != 0;
    core_.state().fpu_stacking_lazy = (reg(kFpccr) & 1U << 30) != 0;
    require((reg(kCcr) & 0x200) != 0, "stack alignment of 8 bytes is switched off, which is not modelled");
  }
}

// --- cycle counter ---

CycleCounter::CycleCounter(Services services, CortexM4& core, const SystemControl& control)
    : Peripheral("DWT", services, {{"CTRL", 0, 0x40000000, 1}, {"CYCCNT", 4, 0, 0xFFFFFFFF}}),
      core_(core),
      control_(control) {}

bool CycleCounter::counts() const { return (reg(0) & 1U) != 0; }

std::uint32_t CycleCounter::on_read(std::uint32_t offset, std::uint32_t stored, unsigned /*width*/) {
  require(control_.is_trace_enabled(), "used without DEMCR.TRCENA");
  return offset == 4 && counts() ? static_cast<std::uint32_t>(core_.cycles() - zero_) : stored;
}

void CycleCounter::on_write(std::uint32_t offset, std::uint32_t written, unsigned /*width*/) {
  require(control_.is_trace_enabled(), "used without DEMCR.TRCENA");
  const std::uint32_t count = counts() ? static_cast<std::uint32_t>(core_.cycles() - zero_) : reg(4);
  store(offset, written);
  if (offset == 0) {
    reg(4) = count;
  }
  zero_ = core_.cycles() - reg(4);
}

}  // namespace trackservo::target
