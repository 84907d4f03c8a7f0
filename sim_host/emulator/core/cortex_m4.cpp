// SPDX-License-Identifier: Apache-2.0
#include "core/cortex_m4.hpp"

#include <unicorn/unicorn.h>

#include <algorithm>
#include <cstring>
#include <stdexcept>

namespace trackservo::target {
namespace {

constexpr std::uint32_t kFlashBase = 0x08000000;
constexpr std::uint32_t kFlashSize = 512 * 1024;
constexpr std::uint32_t kCodeRamBase = 0x10000000;
constexpr std::uint32_t kCodeRamSize = 32 * 1024;

// Exceptions that Unicorn reports to its interrupt hook.
constexpr int kSupervisorCall = 2;
constexpr int kBreakpoint = 7;
constexpr int kExceptionReturn = 8;
constexpr int kCoprocessorOff = 17;
constexpr int kWrongState = 18;

constexpr std::uint32_t kThumbBit = 1U << 24;  // of xPSR
constexpr std::uint32_t kStackPadded = 1U << 9;
constexpr std::uint32_t kExceptionMask = 0x1FF;
constexpr std::uint32_t kProcessStack = 2;  // of CONTROL
constexpr std::uint32_t kFloatContext = 4;
constexpr std::uint32_t kFloatContextInUse = 0xC;  // Unicorn needs its secure twin set too, or starts a new context
constexpr std::uint32_t kNoFloatFrame = 0x10;      // of an EXC_RETURN
constexpr std::uint32_t kBasicFrame = 0x20;        // bytes
constexpr std::uint32_t kFloatFrame = 0x68;

// Technical reference manual: 12 cycles to enter, 17 more for FPU registers that are stacked; 10 to return; 6 from one
// handler to the next.
constexpr std::uint32_t kEntryCycles = 12;
constexpr std::uint32_t kFloatStackingCycles = 17;
constexpr std::uint32_t kReturnCycles = 10;
constexpr std::uint32_t kTailChainCycles = 6;

void check(uc_err error, const char *what) {
  if (error != UC_ERR_OK) {
    throw std::runtime_error(fmt::format("Unicorn: {}: {}", what, uc_strerror(error)));
  }
}

std::uint32_t word_at(const std::uint8_t *bytes) {
  std::uint32_t word = 0;
  std::memcpy(&word, bytes, 4);
  return word;
}

// The eight registers of a basic frame, in its order.
std::array<int, 8> frame_registers() {
  return {UC_ARM_REG_R0,  UC_ARM_REG_R1, UC_ARM_REG_R2, UC_ARM_REG_R3,
          UC_ARM_REG_R12, UC_ARM_REG_LR, UC_ARM_REG_PC, UC_ARM_REG_XPSR};
}

}  // namespace

// Unicorn's callbacks are C.
struct CortexM4::Hooks {
  static CortexM4& of(void *core) { return *static_cast<CortexM4 *>(core); }

  static void block(uc_engine * /*uc*/, std::uint64_t address, std::uint32_t size, void *core) {
    of(core).on_block(static_cast<std::uint32_t>(address), size);
  }

  static void interrupt(uc_engine *uc, std::uint32_t number, void *core) {
    of(core).intno_ = static_cast<int>(number);
    uc_emu_stop(uc);
  }

  static bool invalid(uc_engine * /*uc*/, uc_mem_type /*type*/, std::uint64_t address, int /*size*/,
                      std::int64_t /*value*/, void *core) {
    of(core).fault_address_ = static_cast<std::uint32_t>(address);
    return false;
  }

  // Before the load.
  static void hold_stuck_bit(uc_engine * /*uc*/, uc_mem_type /*type*/, std::uint64_t /*address*/, int /*size*/,
                             std::int64_t /*value*/, void *stuck_bit) {
    const auto *stuck = static_cast<StuckBit *>(stuck_bit);
    *stuck->byte = static_cast<std::uint8_t>(stuck->value ? *stuck->byte | stuck->mask : *stuck->byte & ~stuck->mask);
  }

  static void read_bad_word(uc_engine * /*uc*/, uc_mem_type /*type*/, std::uint64_t /*address*/, int /*size*/,
                            std::int64_t /*value*/, void *bad_word) {
    const auto *bad = static_cast<BadWord *>(bad_word);
    if (bad->found) {
      bad->found();
    }
  }

  static void repair_bad_word(uc_engine * /*uc*/, uc_mem_type /*type*/, std::uint64_t /*address*/, int /*size*/,
                              std::int64_t /*value*/, void *bad_word) {
    static_cast<BadWord *>(bad_word)->found = nullptr;
  }

  static void note_write(uc_engine * /*uc*/, uc_mem_type /*type*/, std::uint64_t address, int size,
                         std::int64_t /*value*/, void *core) {
    of(core).note_written(static_cast<std::uint32_t>(address), static_cast<std::uint32_t>(size));
  }

  static void check_read(uc_engine * /*uc*/, uc_mem_type /*type*/, std::uint64_t address, int size,
                         std::int64_t /*value*/, void *core) {
    CortexM4& self = of(core);
    const std::uint32_t word = (static_cast<std::uint32_t>(address) & ~3U) - self.tracked_begin_;
    for (std::uint32_t byte = word; byte < word + 4 && byte < self.written_.size(); ++byte) {
      if (!self.written_[byte]) {
        self.violations_.add(fmt::format("0x{:08x} is read before it was written ({} bytes)", address, size));
        self.note_written(self.tracked_begin_ + word, 4);
      }
    }
  }

  static std::uint64_t read(uc_engine * /*uc*/, std::uint64_t offset, unsigned width, void *window) {
    const auto *w = static_cast<BusWindow *>(window);
    return w->core->bus_.read(w->base + static_cast<std::uint32_t>(offset), width);
  }

  static void write(uc_engine * /*uc*/, std::uint64_t offset, unsigned width, std::uint64_t value, void *window) {
    const auto *w = static_cast<BusWindow *>(window);
    w->core->bus_.write(w->base + static_cast<std::uint32_t>(offset), static_cast<std::uint32_t>(value), width);
  }
};

CortexM4::CortexM4(Timeline& timeline, Exceptions& exceptions, Violations& violations, Bus& bus)
    : timeline_(timeline),
      exceptions_(exceptions),
      violations_(violations),
      bus_(bus),
      blocks_(kFlashSize / 2),
      ram_blocks_(kCodeRamSize / 2) {
  check(uc_open(UC_ARCH_ARM, static_cast<uc_mode>(UC_MODE_THUMB | UC_MODE_MCLASS), &uc_), "open");
  check(uc_ctl_set_cpu_model(uc_, UC_CPU_ARM_CORTEX_M4), "Cortex-M4");
  uc_hook hook = 0;
  check(uc_hook_add(uc_, &hook, UC_HOOK_BLOCK, reinterpret_cast<void *>(Hooks::block), this, 1, 0), "hook");
  check(uc_hook_add(uc_, &hook, UC_HOOK_INTR, reinterpret_cast<void *>(Hooks::interrupt), this, 1, 0), "hook");
  check(uc_hook_add(uc_, &hook, UC_HOOK_MEM_INVALID, reinterpret_cast<void *>(Hooks::invalid), this, 1, 0), "hook");
}

CortexM4::~CortexM4() { uc_close(uc_); }

void CortexM4::map(const Memory& memory) {
  memories_.push_back(memory);
  const bool code = !memory.writable || memory.base == kCodeRamBase;
  const auto rights =
      static_cast<std::uint32_t>(UC_PROT_READ | (memory.writable ? UC_PROT_WRITE : 0) | (code ? UC_PROT_EXEC : 0));
  check(uc_mem_map_ptr(uc_, memory.base, memory.size, rights, memory.bytes), "memory");
}

void CortexM4::map_bus(std::uint32_t base, std::uint32_t size) {
  windows_.push_back(std::make_unique<BusWindow>(BusWindow{this, base}));
  BusWindow *window = windows_.back().get();
  check(uc_mmio_map(uc_, base, size, Hooks::read, window, Hooks::write, window), "bus");
}

std::uint8_t *CortexM4::memory_at(std::uint32_t address, std::uint32_t size) {
  for (const Memory& memory : memories_) {
    const std::uint32_t offset = address - memory.base;
    if (offset < memory.size && size <= memory.size - offset) {
      return memory.bytes + offset;
    }
  }
  return nullptr;
}

void CortexM4::stick(std::uint32_t address, unsigned bit, bool value) {
  std::uint8_t *byte = memory_at(address + bit / 8, 1);
  if (byte == nullptr) {
    throw std::invalid_argument("no memory there for a stuck bit");
  }
  stuck_bits_.push_back(std::make_unique<StuckBit>(StuckBit{byte, static_cast<std::uint8_t>(1U << bit % 8), value}));
  uc_hook hook = 0;
  check(uc_hook_add(uc_, &hook, UC_HOOK_MEM_READ, reinterpret_cast<void *>(Hooks::hold_stuck_bit),
                    stuck_bits_.back().get(), address, address + 3),
        "stuck bit");
}

void CortexM4::allow_writes(std::uint32_t address, std::uint32_t size, bool allowed) {
  const bool code = address - kCodeRamBase < kCodeRamSize;
  const auto rights =
      static_cast<std::uint32_t>(UC_PROT_READ | (allowed ? UC_PROT_WRITE : 0) | (code ? UC_PROT_EXEC : 0));
  check(uc_mem_protect(uc_, address, size, rights), "write protection");
}

void CortexM4::flip(std::uint32_t address, unsigned bit, std::function<void()> found) {
  std::uint8_t *word = memory_at(address, 4);
  if (word == nullptr) {
    throw std::invalid_argument("no memory there for a flipped bit");
  }
  if (bit < kParityBit) {
    word[bit / 8] ^= static_cast<std::uint8_t>(1U << bit % 8);
  }
  check(uc_ctl_flush_tb(uc_), "code that has changed");  // also: translated code calls no new hooks
  if (!found) {
    return;
  }
  bad_words_.push_back(std::make_unique<BadWord>(BadWord{address, std::move(found)}));
  BadWord *bad = bad_words_.back().get();
  uc_hook hook = 0;
  check(uc_hook_add(uc_, &hook, UC_HOOK_MEM_READ, reinterpret_cast<void *>(Hooks::read_bad_word), bad, address,
                    address + 3),
        "flipped bit");
  check(uc_hook_add(uc_, &hook, UC_HOOK_MEM_WRITE, reinterpret_cast<void *>(Hooks::repair_bad_word), bad, address,
                    address + 3),
        "flipped bit");
}

void CortexM4::check_code(std::uint32_t address, std::uint32_t size) {
  for (const auto& bad : bad_words_) {
    if (bad->found && bad->address + 4 > address && bad->address < address + size) {
      bad->found();
    }
  }
}

void CortexM4::report_unwritten_reads(std::uint32_t begin, std::uint32_t end) {
  tracked_begin_ = begin;
  written_.assign(end - begin, false);
  uc_hook hook = 0;
  check(uc_hook_add(uc_, &hook, UC_HOOK_MEM_WRITE, reinterpret_cast<void *>(Hooks::note_write), this, begin, end - 1),
        "unwritten reads");
  check(uc_hook_add(uc_, &hook, UC_HOOK_MEM_READ, reinterpret_cast<void *>(Hooks::check_read), this, begin, end - 1),
        "unwritten reads");
}

void CortexM4::note_written(std::uint32_t address, std::uint32_t size) {
  for (std::uint32_t byte = address - tracked_begin_; size > 0 && byte < written_.size(); ++byte, --size) {
    written_[byte] = true;
  }
}

// With the existing frames: otherwise the program would use the memory there for its variables.
void CortexM4::sink_stack() {
  constexpr std::uint32_t kFrames = 512;  // more than the background and its calls use
  std::uint8_t *to = memory_at(*sunken_stack_, kFrames);
  const std::uint8_t *from = memory_at(register_value(UC_ARM_REG_SP), kFrames);
  if (to == nullptr || from == nullptr) {
    throw std::invalid_argument("no stack at this address");
  }
  std::memmove(to, from, kFrames);
  set_register(UC_ARM_REG_SP, *sunken_stack_);
  sunken_stack_.reset();
}

std::uint32_t CortexM4::register_value(int unicorn_register) const {
  std::uint32_t value = 0;
  uc_reg_read(uc_, unicorn_register, &value);
  return value;
}

void CortexM4::set_register(int unicorn_register, std::uint32_t value) { uc_reg_write(uc_, unicorn_register, &value); }

int CortexM4::current_exception() { return static_cast<int>(register_value(UC_ARM_REG_XPSR) & kExceptionMask); }

void CortexM4::reset() {
  state_ = {};
  costs_.drop_running();
  asleep_ = false;
  locked_up_ = false;
  hanging_.reset();
  sunken_stack_.reset();
  within_it_ = false;
  for (const int name :
       {UC_ARM_REG_R0, UC_ARM_REG_R1, UC_ARM_REG_R2, UC_ARM_REG_R3, UC_ARM_REG_R4, UC_ARM_REG_R5, UC_ARM_REG_R6,
        UC_ARM_REG_R7, UC_ARM_REG_R8, UC_ARM_REG_R9, UC_ARM_REG_R10, UC_ARM_REG_R11, UC_ARM_REG_R12, UC_ARM_REG_PRIMASK,
        UC_ARM_REG_BASEPRI, UC_ARM_REG_FAULTMASK, UC_ARM_REG_FPSCR}) {
    set_register(name, 0);
  }
  set_register(UC_ARM_REG_XPSR, kThumbBit);
  set_register(UC_ARM_REG_CONTROL, 0);
  set_register(UC_ARM_REG_LR, 0xFFFFFFFF);
  const std::uint8_t *vectors = memory_at(state_.vector_table, 8);
  set_register(UC_ARM_REG_SP, vectors != nullptr ? word_at(vectors) & ~3U : 0);
  pc_ = vectors != nullptr ? word_at(vectors + 4) : 0;
}

// --- time ---

void CortexM4::charge_cycles(std::uint32_t cycles) {
  cycles_ += cycles;
  timeline_.advance(cycles * units_per_cycle_);
  costs_.charge(0, cycles);
}

CortexM4::Block& CortexM4::block_at(std::uint32_t address, std::uint32_t size) {
  const std::uint32_t offset = address >= kFlashBase ? address - kFlashBase : address;  // flash is at 0, too
  const bool in_flash = offset < kFlashSize;
  const std::uint32_t ram_offset = address - kCodeRamBase;
  Block& block = in_flash                    ? blocks_[offset / 2]
                 : ram_offset < kCodeRamSize ? ram_blocks_[ram_offset / 2]
                                             : others_[address];
  if (block.size != size) {
    const std::uint8_t *code = memory_at(address, size);
    block.cost = code != nullptr ? block_cost(code, size) : BlockCost{1, 1, false};
    block.size = size;
    block.in_flash = in_flash;
  }
  return block;
}

// Called before the block runs: first everything that is due, then its own time.
void CortexM4::on_block(std::uint32_t address, std::uint32_t size) {
  if (!within_it_) {
    violations_.at_block(address);
    if (timeline_.next_due() <= timeline_.now()) {
      timeline_.run_due();
    }
    const bool interrupted = exceptions_.wants_attention() && !is_masked(exceptions_.next());
    if (interrupted || stop_requested_ || timeline_.now() >= until_) {
      uc_emu_stop(uc_);
      return;
    }
  }
  if (!bad_words_.empty()) {
    check_code(address, size);
  }
  const Block& block = block_at(address, size);
  const bool follows_on = address == next_address_;
  std::uint32_t cycles = block.cost.cycles;
  if (block.in_flash) {
    cycles += accelerator_.fetch(address & (kFlashSize - 1), size, cycles, follows_on);
  }
  if (!follows_on) {
    cycles += kTakenBranchCycles;
  }
  next_address_ = address + size;
  within_it_ = block.cost.ends_within_it;
  cycles_ += cycles;
  instructions_ += block.cost.instructions;
  timeline_.advance(cycles * units_per_cycle_);
  costs_.charge(block.cost.instructions, cycles);
}

// --- running ---

bool CortexM4::is_masked(int exception) const {
  return !exceptions_.can_run(exception, (register_value(UC_ARM_REG_PRIMASK) & 1) != 0,
                              (register_value(UC_ARM_REG_FAULTMASK) & 1) != 0,
                              static_cast<std::uint8_t>(register_value(UC_ARM_REG_BASEPRI)));
}

void CortexM4::run(Instant until) {
  until_ = until;
  stop_requested_ = false;
  while (timeline_.now() < until && !stop_requested_) {
    if (timeline_.next_due() <= timeline_.now()) {
      timeline_.run_due();
    }
    if (sunken_stack_ && exceptions_.nesting() == 0) {
      sink_stack();
    }
    if (asleep_ || locked_up_ || hanging_ == exceptions_.running()) {
      sleep(until);
    } else if (exceptions_.wants_attention() && !is_masked(exceptions_.next())) {
      enter(exceptions_.next());
    } else {
      execute();
    }
  }
}

// PRIMASK does not prevent a wake-up.
void CortexM4::sleep(Instant until) {
  const std::uint8_t basepri = static_cast<std::uint8_t>(register_value(UC_ARM_REG_BASEPRI));
  if (!locked_up_ && exceptions_.can_run(exceptions_.next(), false, false, basepri)) {
    asleep_ = false;
    if (!is_masked(exceptions_.next())) {
      enter(exceptions_.next());
    }
    return;
  }
  const Instant wake = std::min(timeline_.next_due(), until);
  if (wake > timeline_.now()) {
    const Instant idle = (wake - timeline_.now() + units_per_cycle_ - 1) / units_per_cycle_;
    cycles_ += idle;
    timeline_.advance(idle * units_per_cycle_);
  }
}

void CortexM4::execute() {
  intno_ = -1;
  const uc_err error = uc_emu_start(uc_, pc_ | 1U, 0xFFFFFFFE, 0, 0);
  pc_ = register_value(UC_ARM_REG_PC);
  handle_stop(error);
}

void CortexM4::handle_stop(int error) {
  if (intno_ == kExceptionReturn) {
    leave();
  } else if (intno_ == kSupervisorCall) {
    fault(kSvcall, 0);
  } else if (intno_ == kBreakpoint) {
    hard_fault(kDebugEvent);
  } else if (intno_ == kCoprocessorOff) {
    fault(kUsageFault, kNoCoprocessor);
  } else if (intno_ == kWrongState || error == UC_ERR_EXCEPTION) {
    fault(kUsageFault, kInvalidState);
  } else if (error == UC_ERR_INSN_INVALID) {
    fault(kUsageFault, kUndefinedInstruction);
  } else if (error == UC_ERR_FETCH_UNMAPPED || error == UC_ERR_FETCH_PROT) {
    fault(kBusFault, kInstructionBusError);
  } else if (error == UC_ERR_WRITE_PROT) {
    if (fault_address_ - kFlashBase < kFlashSize) {
      violations_.add(fmt::format("store to 0x{:08x} in the flash of the running program", fault_address_));
    }
    fault(kBusFault, kPreciseDataBusError, fault_address_);
  } else if (error == UC_ERR_READ_UNMAPPED || error == UC_ERR_WRITE_UNMAPPED) {
    fault_at_missing_memory();
  } else if (error != UC_ERR_OK || intno_ >= 0) {
    throw std::runtime_error(fmt::format("Unicorn stopped at 0x{:08x}: {} (interrupt {})", pc_,
                                         uc_strerror(static_cast<uc_err>(error)), intno_));
  } else if (!stop_requested_ && timeline_.now() < until_ &&
             !(exceptions_.wants_attention() && !is_masked(exceptions_.next()))) {
    asleep_ = true;  // no stop was requested: a WFI
  }
}

// --- exceptions ---

void CortexM4::enter(int exception) {
  const std::array<int, 8> names = frame_registers();
  std::array<std::uint32_t, 8> values{};
  std::array<void *, 8> places{};
  for (std::size_t i = 0; i < names.size(); ++i) {
    places[i] = &values[i];
  }
  uc_reg_read_batch(uc_, const_cast<int *>(names.data()), places.data(), static_cast<int>(names.size()));
  values[6] = pc_;
  const std::uint32_t control = register_value(UC_ARM_REG_CONTROL);
  if ((control & kProcessStack) != 0) {
    violations_.add("the process stack is used, which is not modelled");
  }
  if ((control & kFloatContext) != 0 && !state_.fpu_enabled) {
    violations_.add("the FPU is used while CPACR disables it");
  }
  const bool has_floats = (control & kFloatContext) != 0 && state_.fpu_context_automatic;
  const std::uint32_t size = has_floats ? kFloatFrame : kBasicFrame;
  const std::uint32_t top = register_value(UC_ARM_REG_SP);
  const std::uint32_t bottom = (top - size) & ~7U;
  values[7] = (values[7] & ~kStackPadded) | ((top & 4U) != 0 ? kStackPadded : 0U);
  std::uint8_t *frame = memory_at(bottom, size);
  if (frame == nullptr || bottom < 0x10000000) {
    locked_up_ = exception == kHardFault || exception == kNmi;
    if (locked_up_) {
      lock_up();
      return;
    }
    set_register(UC_ARM_REG_SP, bottom);  // the contents of the frame are lost
    exception = exception_of_failed_stacking(bottom);
  } else {
    std::memcpy(frame, values.data(), kBasicFrame);
    note_written(bottom, size);
    if (has_floats) {
      for (std::ptrdiff_t i = 0; i < 8; ++i) {
        uc_reg_read(uc_, UC_ARM_REG_D0 + static_cast<int>(i), frame + kBasicFrame + 8 * i);
      }
      uc_reg_read(uc_, UC_ARM_REG_FPSCR, frame + kBasicFrame + 64);
    }
    set_register(UC_ARM_REG_SP, bottom);
  }
  charge_cycles(kEntryCycles + (has_floats && !state_.fpu_stacking_lazy ? kFloatStackingCycles : 0));
  const std::uint32_t from_thread = (values[7] & kExceptionMask) == 0 ? 0xFFFFFFF9U : 0xFFFFFFF1U;
  begin_handler(exception, has_floats ? from_thread & ~kNoFloatFrame : from_thread);
}

void CortexM4::begin_handler(int exception, std::uint32_t return_code) {
  exceptions_.enter(exception);
  costs_.enter();
  const std::uint8_t *vector = memory_at(state_.vector_table + 4 * static_cast<std::uint32_t>(exception), 4);
  pc_ = vector != nullptr ? word_at(vector) : 0;
  set_register(UC_ARM_REG_LR, return_code);
  const std::uint32_t flags = register_value(UC_ARM_REG_XPSR) & 0xF80F0000;
  set_register(UC_ARM_REG_XPSR, flags | kThumbBit | static_cast<std::uint32_t>(exception));
  set_register(UC_ARM_REG_CONTROL, 0);
  next_address_ = 0;
  within_it_ = false;
  if ((pc_ & 1U) == 0) {
    if (exception == kHardFault) {
      lock_up();
    } else {
      fault(kUsageFault, kInvalidState);
    }
    return;
  }
  if (exception_monitor_) {
    exception_monitor_(exception);
  }
}

// An exception returns: directly to the next waiting one, or to the interrupted code.
void CortexM4::leave() {
  const int exception = current_exception();
  const std::uint32_t return_code = pc_ | 1U;
  const bool to_thread = (return_code & 8U) != 0;
  charge_cycles(kReturnCycles);
  exceptions_.leave(exception);
  costs_.leave(exception);
  if (exception != kNmi) {
    set_register(UC_ARM_REG_FAULTMASK, 0);
  }
  if (to_thread != (exceptions_.nesting() == 0)) {
    violations_.add(
        fmt::format("exception return 0x{:08x} does not match {} active handlers", return_code, exceptions_.nesting()));
  }
  if (exceptions_.wants_attention() && !is_masked(exceptions_.next())) {
    charge_cycles(kTailChainCycles);
    begin_handler(exceptions_.next(), return_code);
    return;
  }
  unstack(return_code);
}

void CortexM4::unstack(std::uint32_t return_code) {
  const bool has_floats = (return_code & kNoFloatFrame) == 0;
  const std::uint32_t size = has_floats ? kFloatFrame : kBasicFrame;
  const std::uint32_t bottom = register_value(UC_ARM_REG_SP);
  const std::uint8_t *frame = memory_at(bottom, size);
  if (frame == nullptr) {
    fault(kBusFault, kStackingBusError);
    return;
  }
  const std::array<int, 8> names = frame_registers();
  for (std::size_t i = 0; i < 6; ++i) {
    set_register(names[i], word_at(frame + 4 * i));
  }
  pc_ = word_at(frame + 24);
  const std::uint32_t flags = word_at(frame + 28);
  if (has_floats) {
    for (std::ptrdiff_t i = 0; i < 8; ++i) {
      uc_reg_write(uc_, UC_ARM_REG_D0 + static_cast<int>(i), frame + kBasicFrame + 8 * i);
    }
    uc_reg_write(uc_, UC_ARM_REG_FPSCR, frame + kBasicFrame + 64);
  }
  set_register(UC_ARM_REG_SP, bottom + size + ((flags & kStackPadded) != 0 ? 4 : 0));
  set_register(UC_ARM_REG_XPSR, (flags & ~kStackPadded) | kThumbBit);
  set_register(UC_ARM_REG_CONTROL, has_floats ? kFloatContextInUse : 0);
  next_address_ = 0;
  if (exception_monitor_) {
    exception_monitor_(static_cast<int>(flags & kExceptionMask));
  }
}

// --- faults ---

// The MPU is off in HardFault and NMI: HFNMIENA is not modelled.
bool CortexM4::is_guarded(std::uint32_t address) {
  return address - state_.guard.base < state_.guard.size && current_exception() != kHardFault &&
         current_exception() != kNmi;
}

int CortexM4::exception_of_failed_stacking(std::uint32_t bottom) {
  const bool guarded = is_guarded(bottom);
  state_.cfsr |= guarded ? kStackingAccessViolation : kStackingBusError;
  if (guarded && (state_.shcsr_enables & 1U << 16) != 0 && !is_masked(kMemManage)) {
    return kMemManage;
  }
  exceptions_.pend(kHardFault);
  state_.hfsr |= kForcedHardFault;
  return kHardFault;
}

void CortexM4::fault_at_missing_memory() {
  if (!is_guarded(fault_address_)) {
    fault(kBusFault, kPreciseDataBusError, fault_address_);
    return;
  }
  state_.mmfar = fault_address_;
  fault(kMemManage, kDataAccessViolation | kMemManageAddressValid);
}

// SVC and faults are taken at once or, if they cannot be, become a HardFault.
void CortexM4::fault(int exception, std::uint32_t cfsr_bits, std::optional<std::uint32_t> address) {
  state_.cfsr |= cfsr_bits;
  if (address) {
    state_.cfsr |= kBusFaultAddressValid;
    state_.bfar = *address;
  }
  const bool configured = exception == kSvcall || (state_.shcsr_enables & (1U << (16 + exception - kMemManage))) != 0;
  if (configured && !is_masked(exception)) {
    enter(exception);
  } else {
    hard_fault(kForcedHardFault);
  }
}

void CortexM4::hard_fault(std::uint32_t hfsr_bits) {
  state_.hfsr |= hfsr_bits;
  if (is_masked(kHardFault)) {
    lock_up();
  } else {
    enter(kHardFault);
  }
}

void CortexM4::lock_up() {
  locked_up_ = true;
  if (lock_up_listener_) {
    lock_up_listener_();
  }
}

}  // namespace trackservo::target
