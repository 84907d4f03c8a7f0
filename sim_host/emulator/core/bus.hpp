// SPDX-License-Identifier: Apache-2.0
// Which peripheral answers at which address.
//
// One bit of one register may be inverted on purpose: whatever the program writes, the register gets the other value.
// The tests use it to show that a wrongly wired bit is detected.
#ifndef TRACKSERVO_SIM_EMULATOR_CORE_BUS_HPP
#define TRACKSERVO_SIM_EMULATOR_CORE_BUS_HPP

#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

#include "core/peripheral.hpp"

namespace trackservo::target {

class Bus {
 public:
  struct Write {
    std::uint32_t address;
    std::uint32_t value;
    std::uint32_t changed = 0;  // writable bits that differ from the former value
  };
  struct Bend {
    std::uint32_t address;
    std::uint32_t bit;
    bool forced;
  };

  explicit Bus(Violations& violations) : violations_(violations) {}

  // Adds a region of `size` bytes for a peripheral; regions do not overlap.
  void attach(Peripheral& peripheral, std::uint32_t base, std::uint32_t size);

  std::uint32_t read(std::uint32_t address, unsigned width);
  void write(std::uint32_t address, std::uint32_t value, unsigned width);

  // Returns the value without side effects, for tests.
  std::uint32_t peek(std::uint32_t address) const;
  std::uint32_t writable(std::uint32_t address) const;

  void bend(std::optional<Bend> bend) { bend_ = bend; }

  // Receives every write before it is executed.
  void monitor(std::function<void(const Write&)> monitor) { monitor_ = std::move(monitor); }

 private:
  struct Region {
    std::uint32_t base;
    std::uint32_t size;
    Peripheral *peripheral;
  };

  const Region *find(std::uint32_t address) const;
  const Region *find(std::uint32_t address, const char *what);

  Violations& violations_;
  std::vector<Region> regions_;
  const Region *last_ = nullptr;
  std::optional<Bend> bend_;
  std::function<void(const Write&)> monitor_;
};

}  // namespace trackservo::target

#endif
