// SPDX-License-Identifier: Apache-2.0
// The core's own registers: NVIC, System Control Block, MPU, SysTick, FPU context control, DWT cycle counter
// (ARMv7-M architecture manual, B3.2 to B3.4, C1.8).
#ifndef TRACKSERVO_SIM_EMULATOR_CORE_SYSTEM_CONTROL_HPP
#define TRACKSERVO_SIM_EMULATOR_CORE_SYSTEM_CONTROL_HPP

#include <functional>

#include "core/cortex_m4.hpp"
#include "core/peripheral.hpp"

namespace trackservo::target {

// 0xE000E000, 4 KiB.
class SystemControl : public Peripheral {
 public:
  // Calls `reset_request` at SYSRESETREQ.
  SystemControl(Services services, CortexM4& core, std::function<void()> reset_request);

  bool is_trace_enabled() const { return (reg(0xDFC) & (1U << 24)) != 0; }

 protected:
  std::uint32_t on_read(std::uint32_t offset, std::uint32_t stored, unsigned width) override;
  void on_write(std::uint32_t offset, std::uint32_t written, unsigned width) override;
  void on_reset() override;

 private:
  static std::vector<Register> registers();
  std::uint32_t enable_bits(std::uint32_t offset) const;
  std::uint32_t pending_bits(std::uint32_t offset) const;
  std::uint32_t active_bits(std::uint32_t offset) const;
  std::uint32_t icsr() const;
  std::uint32_t shcsr() const;
  void write_bits(std::uint32_t offset, std::uint32_t written);
  void write_priorities(int first_exception, std::uint32_t offset, std::uint32_t written);
  void write_icsr(std::uint32_t written);
  void take_guard();
  void write_aircr(std::uint32_t written);
  std::uint32_t read_systick(std::uint32_t offset, std::uint32_t stored);
  void write_systick(std::uint32_t offset, std::uint32_t written);
  void start_systick();

  CortexM4& core_;
  std::function<void()> reset_request_;
  Timeline::Alarm systick_;
  std::uint64_t systick_zero_ = 0;  // core cycle in which it was or will be zero next
};

// 0xE0001000: the cycle counter of the Data Watchpoint and Trace unit.
class CycleCounter : public Peripheral {
 public:
  CycleCounter(Services services, CortexM4& core, const SystemControl& control);

 protected:
  std::uint32_t on_read(std::uint32_t offset, std::uint32_t stored, unsigned width) override;
  void on_write(std::uint32_t offset, std::uint32_t written, unsigned width) override;

 private:
  bool counts() const;

  CortexM4& core_;
  const SystemControl& control_;
  std::uint64_t zero_ = 0;  // core cycle of count 0
};

}  // namespace trackservo::target

#endif
