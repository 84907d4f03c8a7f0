// SPDX-License-Identifier: Apache-2.0
// A Cortex-M4F: Unicorn executes the instructions; this class adds the rest (ARMv7-M architecture manual, B1.5).
//
// Exception entry and return with stacking (FPU context included), priorities and tail-chaining, faults and their
// escalation, lock-up, WFI; time by the estimate of instruction_cost.hpp and flash_accelerator.hpp. An interrupt is
// taken at the end of a basic block.
// Not modelled: the process stack and unprivileged code (a violation). The FPU's registers are written to the stack at
// entry even when the architecture would do so lazily; only the cost is the lazy one.
#ifndef TRACKSERVO_SIM_EMULATOR_CORE_CORTEX_M4_HPP
#define TRACKSERVO_SIM_EMULATOR_CORE_CORTEX_M4_HPP

#include <array>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "core/bus.hpp"
#include "core/cost_account.hpp"
#include "core/exceptions.hpp"
#include "core/flash_accelerator.hpp"
#include "core/instruction_cost.hpp"
#include "core/timeline.hpp"
#include "core/violations.hpp"

struct uc_struct;

namespace trackservo::target {

// Bits of CFSR, HFSR as in the registers.
enum FaultBits : std::uint32_t {
  kDataAccessViolation = 1U << 1,
  kStackingAccessViolation = 1U << 4,
  kMemManageAddressValid = 1U << 7,
  kInstructionBusError = 1U << 8,
  kPreciseDataBusError = 1U << 9,
  kStackingBusError = 1U << 12,
  kBusFaultAddressValid = 1U << 15,
  kUndefinedInstruction = 1U << 16,
  kInvalidState = 1U << 17,
  kInvalidReturn = 1U << 18,
  kNoCoprocessor = 1U << 19,
  kVectorReadFault = 1U << 1,  // of HFSR
  kForcedHardFault = 1U << 30,
  kDebugEvent = 1U << 31,
};

// A region of the MPU without any access, the only kind that is modelled, and only where there is no memory: it turns a
// BusFault into a MemManage.
struct GuardRegion {
  std::uint32_t base = 0;
  std::uint32_t size = 0;
};

// State and settings of the System Control Block; its registers are in system_control.hpp.
struct CoreState {
  std::uint32_t vector_table = 0;
  std::uint32_t cfsr = 0;
  std::uint32_t hfsr = 0;
  std::uint32_t bfar = 0;
  std::uint32_t mmfar = 0;
  GuardRegion guard;                  // while the MPU is on
  std::uint32_t shcsr_enables = 0;    // bits 16 MemManage, 17 BusFault, 18 UsageFault
  bool fpu_enabled = false;           // CPACR
  bool fpu_context_automatic = true;  // FPCCR.ASPEN
  bool fpu_stacking_lazy = true;      // FPCCR.LSPEN
};

class CortexM4 {
 public:
  // A range of memory for code or data; `bytes` exists longer than the core.
  struct Memory {
    std::uint32_t base;
    std::uint8_t *bytes;
    std::uint32_t size;
    bool writable;
  };

  CortexM4(Timeline& timeline, Exceptions& exceptions, Violations& violations, Bus& bus);
  CortexM4(const CortexM4&) = delete;
  CortexM4& operator=(const CortexM4&) = delete;
  ~CortexM4();

  void map(const Memory& memory);

  // Lets the bus answer for `size` bytes from `base` on.
  void map_bus(std::uint32_t base, std::uint32_t size);

  // Resets the core: stack pointer and start address come from the vector table at 0.
  void reset();

  // Runs until `until`, a stop request, or a lock-up with nothing due; the peripherals' alarms run in between.
  void run(Instant until);

  // Ends run() at the next block; for resets and for tests.
  void request_stop() { stop_requested_ = true; }

  // Lets this handler (or kThread) make no progress from now until the next reset, as in an endless loop; more urgent
  // ones run.
  void hang(int exception) { hanging_ = exception; }

  void set_clock(std::uint32_t frequency_hz) { units_per_cycle_ = period_of(frequency_hz); }
  FlashAccelerator& accelerator() { return accelerator_; }
  std::uint64_t cycles() const { return cycles_; }
  std::uint64_t instructions() const { return instructions_; }
  CostAccount& costs() { return costs_; }
  CoreState& state() { return state_; }
  bool is_locked_up() const { return locked_up_; }
  bool is_asleep() const { return asleep_; }
  int current_exception();

  // Sets what is called at the start of every exception and after every return (then with kThread or the resumed
  // exception).
  void monitor_exceptions(std::function<void(int exception)> monitor) { exception_monitor_ = std::move(monitor); }

  std::uint32_t register_value(int unicorn_register) const;

  // Lets the program read one bit of RAM as `value`, whatever it wrote. Call it before anything has run; DMA bypasses
  // it.
  void stick(std::uint32_t address, unsigned bit, bool value);

  // Sets whether the program may write there; a store that may not is a bus error.
  void allow_writes(std::uint32_t address, std::uint32_t size, bool allowed);

  // One bit of a word changes; kParityBit leaves the word as it is. If `found` is given, each later read of the word,
  // also as code, calls it; a write repairs the word.
  static constexpr unsigned kParityBit = 32;
  void flip(std::uint32_t address, unsigned bit, std::function<void()> found);

  // Reports once, from now on, each word between these addresses that the program reads before it is written.
  void report_unwritten_reads(std::uint32_t begin, std::uint32_t end);

  // Sets what is called when the core locks up.
  void on_lock_up(std::function<void()> listener) { lock_up_listener_ = std::move(listener); }

  // Sets the stack pointer from the next time on in which no handler runs, as if calls had nested so deep; running
  // code has its variables there.
  void sink_stack_to(std::uint32_t address) { sunken_stack_ = address; }

  // Returns memory as the program reads it; nullptr outside RAM and flash.
  std::uint8_t *memory_at(std::uint32_t address, std::uint32_t size);

 private:
  struct Block {
    BlockCost cost;
    std::uint32_t size = 0;
    bool in_flash = false;
  };
  struct Hooks;
  friend struct Hooks;

  void on_block(std::uint32_t address, std::uint32_t size);
  Block& block_at(std::uint32_t address, std::uint32_t size);
  void charge_cycles(std::uint32_t cycles);
  bool is_masked(int exception) const;
  void execute();
  void sleep(Instant until);
  void handle_stop(int error);
  void enter(int exception);
  void sink_stack();
  void begin_handler(int exception, std::uint32_t return_code);
  void leave();
  void unstack(std::uint32_t return_code);
  bool is_guarded(std::uint32_t address);
  int exception_of_failed_stacking(std::uint32_t bottom);
  void fault_at_missing_memory();
  void fault(int exception, std::uint32_t cfsr_bits, std::optional<std::uint32_t> address = std::nullopt);
  void hard_fault(std::uint32_t hfsr_bits);
  void lock_up();
  void note_written(std::uint32_t address, std::uint32_t size);
  void check_code(std::uint32_t address, std::uint32_t size);
  void set_register(int unicorn_register, std::uint32_t value);

  Timeline& timeline_;
  Exceptions& exceptions_;
  Violations& violations_;
  Bus& bus_;
  uc_struct *uc_ = nullptr;
  std::vector<Memory> memories_;
  struct BusWindow {
    CortexM4 *core;
    std::uint32_t base;
  };
  std::vector<std::unique_ptr<BusWindow>> windows_;

  struct StuckBit {
    std::uint8_t *byte;
    std::uint8_t mask;
    bool value;
  };
  std::vector<std::unique_ptr<StuckBit>> stuck_bits_;

  struct BadWord {
    std::uint32_t address;
    std::function<void()> found;  // none: repaired
  };
  std::vector<std::unique_ptr<BadWord>> bad_words_;
  std::function<void()> lock_up_listener_;

  std::uint32_t tracked_begin_ = 0;  // of report_unwritten_reads
  std::vector<bool> written_;        // by bytes

  std::vector<Block> blocks_;              // of the flash, by half-word
  std::vector<Block> ram_blocks_;          // of the RAM for code, by half-word
  std::map<std::uint32_t, Block> others_;  // elsewhere
  std::uint32_t next_address_ = 0;         // end of the last block
  bool within_it_ = false;

  CoreState state_;
  CostAccount costs_;
  FlashAccelerator accelerator_;
  std::function<void(int)> exception_monitor_;
  Instant units_per_cycle_ = period_of(16'000'000);
  std::uint64_t cycles_ = 0;
  std::uint64_t instructions_ = 0;
  Instant until_ = 0;
  std::uint32_t pc_ = 0;
  int intno_ = -1;  // last report of Unicorn
  std::uint32_t fault_address_ = 0;
  bool stop_requested_ = false;
  bool asleep_ = false;
  bool locked_up_ = false;
  std::optional<int> hanging_;
  std::optional<std::uint32_t> sunken_stack_;
};

}  // namespace trackservo::target

#endif
