// SPDX-License-Identifier: Apache-2.0
// Cost of the instructions of a basic block on a Cortex-M4F, without flash waits.
//
// From the core's technical reference manual (instruction set summary, floating-point timings): one cycle, except load
// or store 2, after another one 1; n registers 1 + n; multiply-accumulate 2; divide 12 (its worst case); VDIV and VSQRT
// 14; VMLA and its variants 3; a 64-bit VMOV 2; a taken branch 2 more, which CortexM4 adds when the next block does not
// follow on. It is an estimate: stalls by results that are not ready yet are not counted.
#ifndef TRACKSERVO_SIM_EMULATOR_CORE_INSTRUCTION_COST_HPP
#define TRACKSERVO_SIM_EMULATOR_CORE_INSTRUCTION_COST_HPP

#include <cstddef>
#include <cstdint>

namespace trackservo::target {

constexpr std::uint32_t kTakenBranchCycles = 2;

struct BlockCost {
  std::uint32_t instructions = 0;
  std::uint32_t cycles = 0;
  bool ends_within_it = false;  // an If-Then sequence continues in the next block
};

// Returns the cost of `code`, `size` bytes of Thumb-2.
BlockCost block_cost(const std::uint8_t *code, std::size_t size);

}  // namespace trackservo::target

#endif
