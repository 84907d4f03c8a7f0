// SPDX-License-Identifier: Apache-2.0
// A peripheral as its manual's register table: offset, reset value, which bits may be written.
//
// Violations are: writing a reserved bit other than its reset value, access to a register that is not in the table,
// access of a wrong width, and access while the peripheral's clock is off. A peripheral adds the function of its
// registers in on_read and on_write.
#ifndef TRACKSERVO_SIM_EMULATOR_CORE_PERIPHERAL_HPP
#define TRACKSERVO_SIM_EMULATOR_CORE_PERIPHERAL_HPP

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "core/exceptions.hpp"
#include "core/irq_line.hpp"
#include "core/timeline.hpp"
#include "core/violations.hpp"

namespace trackservo::target {

// Services for every peripheral.
struct Services {
  Timeline& timeline;
  Exceptions& exceptions;
  Violations& violations;
};

class Peripheral {
 public:
  struct Register {
    const char *name;
    std::uint32_t offset;
    std::uint32_t reset;
    std::uint32_t writable;       // stores the written value, or acts on it
    std::uint32_t read_only = 0;  // set by the peripheral; writing either value is no fault
    bool narrow = false;          // may be accessed as byte or half-word
  };

  Peripheral(std::string name, Services services, std::vector<Register> registers);
  Peripheral(const Peripheral&) = delete;
  Peripheral& operator=(const Peripheral&) = delete;
  virtual ~Peripheral() = default;

  const std::string& name() const { return name_; }

  // Reads or writes for the bus; `width` in bytes.
  std::uint32_t bus_read(std::uint32_t offset, unsigned width);
  void bus_write(std::uint32_t offset, std::uint32_t value, unsigned width);

  // Returns the stored value, for tests: without side effects, 0 where there is no register.
  std::uint32_t peek(std::uint32_t offset) const {
    const std::uint16_t found = find(offset);
    return found == kNone ? 0 : values_[found];
  }

  // Returns which bits of a register the program may write.
  std::uint32_t writable(std::uint32_t offset) const {
    const std::uint16_t found = find(offset);
    return found == kNone ? 0 : table_[found].writable;
  }

  // Sets all registers to their reset values, then calls on_reset().
  void reset();

  // Sets what tells whether its clock runs; without it, it always does.
  void clocked_by(std::function<bool()> clock) { clock_ = std::move(clock); }

 protected:
  // Returns a value for the bus, with the side effects of reading. `stored` is the register's value.
  virtual std::uint32_t on_read(std::uint32_t /*offset*/, std::uint32_t stored, unsigned /*width*/) { return stored; }

  // Takes `written`, the value from the bus, a byte or half-word combined with the stored rest; reg(offset) still has
  // the old value. The default stores it.
  virtual void on_write(std::uint32_t offset, std::uint32_t written, unsigned /*width*/) { store(offset, written); }

  virtual void on_reset() {}

  // Returns the register's value, for the peripheral itself.
  std::uint32_t& reg(std::uint32_t offset) { return values_[index_[offset / 4]]; }
  std::uint32_t reg(std::uint32_t offset) const { return values_[index_[offset / 4]]; }

  // Stores the writable bits of `written`.
  void store(std::uint32_t offset, std::uint32_t written);

  void report_violation(const std::string& sentence) const { services_.violations.add(name_ + ": " + sentence); }
  void require(bool kept, const char *rule) const {
    if (!kept) {
      report_violation(rule);
    }
  }

  Timeline& timeline() const { return services_.timeline; }
  Exceptions& exceptions() const { return services_.exceptions; }
  Services services() const { return services_; }

 private:
  static constexpr std::uint16_t kNone = 0xFFFF;

  std::uint16_t find(std::uint32_t offset) const;
  bool is_accessible(std::uint32_t offset, unsigned width, const char *what) const;

  std::string name_;
  Services services_;
  std::vector<Register> table_;
  std::vector<std::uint16_t> index_;  // by word offset
  std::vector<std::uint32_t> values_;
  std::function<bool()> clock_;
};

}  // namespace trackservo::target

#endif
