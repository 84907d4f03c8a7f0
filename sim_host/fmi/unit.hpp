// SPDX-License-Identifier: Apache-2.0
// A simulated machine as a unit for co-simulation: its variables, and what it does in a step.
//
// Use: set parameters through variables(), start(), then set inputs, step() and read outputs again and again.
#ifndef TRACKSERVO_FMI_UNIT_HPP
#define TRACKSERVO_FMI_UNIT_HPP

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <variant>
#include <vector>

#include "machine/base/axis.hpp"

namespace trackservo::fmi {

enum class Causality { kParameter, kInput, kOutput };

// One variable of a unit. `value` is where the unit keeps it; what is there before start() is the start value.
struct Variable {
  std::string name;  // structured: azimuth.joint_angle_rad
  Causality causality;
  std::string unit;  // one of unit_description.cpp; empty for a number without unit, a truth value or a text
  std::string description;
  std::variant<double *, std::uint64_t *, bool *, std::string *> value;
  double bound = 0;  // of an input: its largest size; 0: none but a finite number
};

class Unit {
 public:
  Unit() = default;
  Unit(const Unit&) = delete;
  Unit& operator=(const Unit&) = delete;
  virtual ~Unit() = default;

  // Returns the variables, the same in every unit of one kind. The index of a variable is its value reference minus 1;
  // 0 is the time.
  const std::vector<Variable>& variables() const { return variables_; }

  // Builds the machine from the parameters, at rest. May be called again. Throws std::exception with a sentence for
  // people if a parameter is wrong.
  virtual void start() = 0;

  // Runs one PWM period: inputs count from its beginning on, outputs are those at its end.
  virtual void step() = 0;

 protected:
  std::vector<Variable> variables_;
};

struct UnitKind {
  const char *name;  // modelName and modelIdentifier
  const char *description;
};

// Returns the kind of the unit that this library is.
UnitKind unit_kind();

// Makes that unit. `resources`: the folder of the shipped plant files' folder `plants`.
std::unique_ptr<Unit> make_unit(const std::filesystem::path& resources);

}  // namespace trackservo::fmi

#endif
