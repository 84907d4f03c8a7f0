// SPDX-License-Identifier: Apache-2.0
#include "core/instruction_cost.hpp"

namespace trackservo::target {
namespace {

struct Cost {
  std::uint32_t cycles;
  bool single_access;  // a load or store of one register, which overlaps with its neighbour
};

std::uint32_t ones(std::uint32_t bits) { return static_cast<std::uint32_t>(__builtin_popcount(bits)); }

Cost narrow_cost(std::uint32_t code) {
  if (code >= 0x4800 && code < 0xA000) {
    return {2, true};  // LDR literal, LDR and STR of all kinds
  }
  if (code >> 12 == 0xC) {
    return {1 + ones(code & 0xFF), false};  // LDM, STM
  }
  if ((code & 0xF600) == 0xB400) {
    return {1 + ones(code & 0x1FF), false};  // PUSH, POP
  }
  return {1, false};
}

Cost float_cost(std::uint32_t first, std::uint32_t second) {
  if ((first & 0xFE00) == 0xEC00) {  // loads, stores and 64-bit moves
    if ((first & 0x01E0) == 0x0040) {
      return {2, false};  // VMOV of two core registers
    }
    if ((first & 0x0120) == 0x0100) {
      return {2, true};  // VLDR, VSTR
    }
    return {1 + (second & 0xFF), false};  // VLDM, VSTM, VPUSH, VPOP
  }
  if ((first & 0xFF00) == 0xEE00 && (second & 0x0010) == 0) {  // data processing
    const std::uint32_t operation = (first >> 4) & 0xB;
    if (operation == 0x8) {
      return {14, false};  // VDIV
    }
    if (operation == 0xB) {
      return {(first & 0xF) == 1 && (second & 0xC0) == 0xC0 ? 14U : 1U, false};  // VSQRT among moves and compares
    }
    const bool accumulates = operation == 0x0 || operation == 0x1 || operation == 0x9 || operation == 0xA;
    return {accumulates ? 3U : 1U, false};
  }
  return {1, false};
}

Cost wide_cost(std::uint32_t first, std::uint32_t second) {
  if ((first & 0xEC00) == 0xEC00 && (second & 0x0E00) == 0x0A00) {
    return float_cost(first, second);
  }
  if ((first & 0xFE40) == 0xE800) {
    return {1 + ones(second), false};  // LDM, STM, PUSH, POP
  }
  if ((first & 0xFE40) == 0xE840) {
    return {3, false};  // LDRD, STRD, exclusives, table branch
  }
  if ((first & 0xFE00) == 0xF800) {
    return {2, true};  // LDR, STR
  }
  if ((first & 0xFF80) == 0xFB80) {  // long multiply and divide
    return {(first & 0x00D0) == 0x0090 ? 12U : 1U, false};
  }
  if ((first & 0xFFF0) == 0xFB00 && (second & 0xF000) != 0xF000) {
    return {2, false};  // MLA, MLS
  }
  return {1, false};
}

}  // namespace

BlockCost block_cost(const std::uint8_t *code, std::size_t size) {
  BlockCost sum;
  std::uint32_t in_it = 0;  // instructions left in an If-Then
  bool behind_access = false;
  for (std::size_t at = 0; at + 1 < size;) {
    const std::uint32_t first = code[at] | static_cast<std::uint32_t>(code[at + 1]) << 8;
    const bool wide = first >> 11 >= 0x1D && at + 3 < size;
    const std::uint32_t second = wide ? code[at + 2] | static_cast<std::uint32_t>(code[at + 3]) << 8 : 0U;
    const Cost cost = wide ? wide_cost(first, second) : narrow_cost(first);
    sum.cycles += cost.single_access && behind_access ? 1 : cost.cycles;
    behind_access = cost.single_access;
    ++sum.instructions;
    in_it = in_it > 0 ? in_it - 1 : 0;
    if (!wide && (first & 0xFF00) == 0xBF00 && (first & 0xF) != 0) {
      in_it = 4 - static_cast<std::uint32_t>(__builtin_ctz(first & 0xF));
    }
    at += wide ? 4 : 2;
  }
  sum.ends_within_it = in_it > 0;
  return sum;
}

}  // namespace trackservo::target
