// SPDX-License-Identifier: Apache-2.0
// The functions of FMI 3.0 (https://fmi-standard.org, version 3.0.2) for co-simulation, around one Unit.
//
// A unit has no global state: a program may make many instances. It takes communication steps of whole PWM periods. A
// call that is wrong gets fmi3Error and one sentence through the importer's logger, whatever loggingOn says; nothing of
// it is applied.
#include <fmi3Functions.h>
#include <fmt/format.h>

#include <cmath>
#include <exception>
#include <limits>
#include <stdexcept>
#include <utility>

#include "unit.hpp"
#include "unit_description.hpp"

namespace trackservo::fmi {
namespace {

enum class Phase { kInstantiated, kInitialising, kStepping, kTerminated };

struct Instance {
  std::filesystem::path resources;
  fmi3InstanceEnvironment environment = nullptr;
  fmi3LogMessageCallback log = nullptr;
  std::unique_ptr<Unit> unit;
  Phase phase = Phase::kInstantiated;
  bool started = false;  // since parameters were set
  double time_s = 0;     // the end of the last communication step, as the importer counts it

  void start_if_needed() {
    if (!started) {
      unit->start();
      started = true;
    }
  }
};

Instance& of(fmi3Instance instance) { return *static_cast<Instance *>(instance); }

// Runs `action`; what it throws is logged.
template <class Action>
fmi3Status guarded(fmi3Instance instance, const Action& action) {
  if (instance == nullptr) {
    return fmi3Error;
  }
  Instance& self = of(instance);
  try {
    action(self);
    return fmi3OK;
  } catch (const std::exception& error) {
    if (self.log != nullptr) {
      self.log(self.environment, fmi3Error, "logStatusError", error.what());
    }
    return fmi3Error;
  }
}

fmi3Status not_provided(fmi3Instance instance, const char *function) {
  return guarded(instance, [function](Instance&) {
    throw std::logic_error(fmt::format("{}: this unit does not provide it (see modelDescription.xml).", function));
  });
}

void require(bool allowed, const char *function, const char *when) {
  if (!allowed) {
    throw std::logic_error(fmt::format("{}: is allowed {} only.", function, when));
  }
}

const Variable& variable_of(const Instance& self, fmi3ValueReference reference) {
  const std::vector<Variable>& variables = self.unit->variables();
  if (reference < kFirstReference || reference - kFirstReference >= variables.size()) {
    throw std::invalid_argument(fmt::format("value reference {}: expected 0 to {}.", reference, variables.size()));
  }
  return variables[reference - kFirstReference];
}

// Where a variable of this type has its value.
template <class Value>
Value *place_of(const Variable& variable, const char *type) {
  Value *const *place = std::get_if<Value *>(&variable.value);
  if (place == nullptr) {
    throw std::invalid_argument(fmt::format("{}: is no {}.", variable.name, type));
  }
  return *place;
}

void require_settable(const Instance& self, const Variable& variable) {
  const bool before = self.phase == Phase::kInstantiated || self.phase == Phase::kInitialising;
  if (variable.causality == Causality::kOutput) {
    throw std::invalid_argument(fmt::format("{}: is an output; it cannot be set.", variable.name));
  }
  if (variable.causality == Causality::kParameter && !before) {
    throw std::logic_error(
        fmt::format("{}: is a parameter; set it before the simulation (fmi3Reset begins anew).", variable.name));
  }
  require(before || self.phase == Phase::kStepping, "setting a variable", "before and during the simulation");
}

void require_counts(std::size_t references, std::size_t values) {
  if (references != values) {
    throw std::invalid_argument(
        fmt::format("{} values for {} variables: expected as many, each is a scalar.", values, references));
  }
}

void require_valid(const Variable& variable, double value) {
  if (!std::isfinite(value)) {
    throw std::invalid_argument(fmt::format("{}: {}; expected a finite number.", variable.name, value));
  }
  if (variable.bound > 0.0 && std::abs(value) > variable.bound) {
    throw std::invalid_argument(fmt::format("{}: {:g}; expected -{:g} to {:g} {}.", variable.name, value,
                                            variable.bound, variable.bound, variable.unit));
  }
}
void require_valid(const Variable& variable, const char *value) {
  if (value == nullptr) {
    throw std::invalid_argument(fmt::format("{}: no text; expected one, which may be empty.", variable.name));
  }
}
void require_valid(const Variable&, std::uint64_t) {}
void require_valid(const Variable&, bool) {}

// All of the values are set, or none.
template <class Value, class Given>
fmi3Status set(fmi3Instance instance, const char *type, const fmi3ValueReference references[], std::size_t count,
               const Given values[], std::size_t values_count) {
  return guarded(instance, [&](Instance& self) {
    require_counts(count, values_count);
    for (std::size_t i = 0; i < count; ++i) {
      const Variable& variable = variable_of(self, references[i]);
      place_of<Value>(variable, type);
      require_settable(self, variable);
      require_valid(variable, values[i]);
    }
    for (std::size_t i = 0; i < count; ++i) {
      const Variable& variable = variable_of(self, references[i]);
      *place_of<Value>(variable, type) = values[i];
      self.started = self.started && variable.causality != Causality::kParameter;
    }
  });
}

double given(double value) { return value; }
std::uint64_t given(std::uint64_t value) { return value; }
bool given(bool value) { return value; }
const char *given(const std::string& value) { return value.c_str(); }

template <class Value, class Taken>
void get_one(const Instance& self, const char *type, fmi3ValueReference reference, Taken& value) {
  if constexpr (std::is_same_v<Value, double>) {
    if (reference == kTimeReference) {
      value = self.time_s;
      return;
    }
  }
  value = given(*place_of<Value>(variable_of(self, reference), type));
}

template <class Value, class Taken>
fmi3Status get(fmi3Instance instance, const char *type, const fmi3ValueReference references[], std::size_t count,
               Taken values[], std::size_t values_count) {
  return guarded(instance, [&](Instance& self) {
    require_counts(count, values_count);
    for (std::size_t i = 0; i < count; ++i) {
      const bool is_output =
          references[i] != kTimeReference && variable_of(self, references[i]).causality == Causality::kOutput;
      if (self.phase == Phase::kInitialising && is_output) {
        self.start_if_needed();  // outputs follow from the parameters
      }
      get_one<Value>(self, type, references[i], values[i]);
    }
  });
}

// The number of PWM periods in a communication step from `point_s` on. The importer adds up the time, so its rounding
// must not count: a point is compared with the end of the last step, a step with whole periods to a hundredth of one.
std::int64_t periods_of(const Instance& self, double point_s, double size_s) {
  constexpr double kMostPeriods = 1e9;  // 14 hours
  const double tolerance_s =
      0.01 * sim::kPwmPeriod_s + 4.0 * std::numeric_limits<double>::epsilon() * std::abs(point_s);
  const double periods = std::round(size_s / sim::kPwmPeriod_s);
  if (!(periods >= 1.0 && periods <= kMostPeriods && std::abs(size_s - periods * sim::kPwmPeriod_s) <= tolerance_s)) {
    throw std::invalid_argument(
        fmt::format("communication step of {} s: expected a whole number of PWM periods of 50 us.", size_s));
  }
  if (!(std::abs(point_s - self.time_s) <= tolerance_s)) {
    throw std::invalid_argument(
        fmt::format("communication point {} s: expected {} s, where the last step ended.", point_s, self.time_s));
  }
  return static_cast<std::int64_t>(periods);
}

void require_finite_outputs(const Instance& self) {
  for (const Variable& variable : self.unit->variables()) {
    const double *const *value = std::get_if<double *>(&variable.value);
    if (variable.causality == Causality::kOutput && value != nullptr && !std::isfinite(**value)) {
      throw std::runtime_error(
          fmt::format("{} is no number any more: an input was beyond what the machine can bear.", variable.name));
    }
  }
}

}  // namespace
}  // namespace trackservo::fmi

using namespace trackservo::fmi;

extern "C" {

const char *fmi3GetVersion(void) { return fmi3Version; }

fmi3Status fmi3SetDebugLogging(fmi3Instance, fmi3Boolean, size_t, const fmi3String[]) { return fmi3OK; }

fmi3Instance fmi3InstantiateCoSimulation(fmi3String, fmi3String token, fmi3String resources, fmi3Boolean, fmi3Boolean,
                                         fmi3Boolean event_mode, fmi3Boolean, const fmi3ValueReference[], size_t,
                                         fmi3InstanceEnvironment environment, fmi3LogMessageCallback log,
                                         fmi3IntermediateUpdateCallback) {
  const auto refuse = [environment, log](const std::string& reason) {
    if (log != nullptr) {
      log(environment, fmi3Error, "logStatusError", reason.c_str());
    }
    return nullptr;
  };
  try {
    auto instance = std::make_unique<Instance>();
    instance->resources = resources == nullptr ? "" : resources;
    instance->environment = environment;
    instance->log = log;
    instance->unit = make_unit(instance->resources);
    if (event_mode) {
      return refuse("eventModeUsed: this unit has no event mode (see modelDescription.xml).");
    }
    const std::string expected = instantiation_token(*instance->unit);
    if (token == nullptr || token != expected) {
      return refuse(fmt::format("instantiation token '{}': expected '{}', that of the unit's modelDescription.xml.",
                                token == nullptr ? "" : token, expected));
    }
    return instance.release();
  } catch (const std::exception& error) {
    return refuse(error.what());
  }
}

fmi3Instance fmi3InstantiateModelExchange(fmi3String, fmi3String, fmi3String, fmi3Boolean, fmi3Boolean,
                                          fmi3InstanceEnvironment, fmi3LogMessageCallback) {
  return nullptr;
}

fmi3Instance fmi3InstantiateScheduledExecution(fmi3String, fmi3String, fmi3String, fmi3Boolean, fmi3Boolean,
                                               fmi3InstanceEnvironment, fmi3LogMessageCallback, fmi3ClockUpdateCallback,
                                               fmi3LockPreemptionCallback, fmi3UnlockPreemptionCallback) {
  return nullptr;
}

void fmi3FreeInstance(fmi3Instance instance) { delete static_cast<Instance *>(instance); }

fmi3Status fmi3EnterInitializationMode(fmi3Instance instance, fmi3Boolean, fmi3Float64, fmi3Float64 start_time_s,
                                       fmi3Boolean, fmi3Float64) {
  return guarded(instance, [start_time_s](Instance& self) {
    require(self.phase == Phase::kInstantiated, "fmi3EnterInitializationMode", "once, at the beginning");
    if (!std::isfinite(start_time_s)) {
      throw std::invalid_argument(fmt::format("start time {} s: expected a finite number.", start_time_s));
    }
    self.time_s = start_time_s;
    self.phase = Phase::kInitialising;
  });
}

fmi3Status fmi3ExitInitializationMode(fmi3Instance instance) {
  return guarded(instance, [](Instance& self) {
    require(self.phase == Phase::kInitialising, "fmi3ExitInitializationMode", "in the initialization mode");
    self.start_if_needed();
    self.phase = Phase::kStepping;
  });
}

fmi3Status fmi3DoStep(fmi3Instance instance, fmi3Float64 point_s, fmi3Float64 size_s, fmi3Boolean,
                      fmi3Boolean *event_handling_needed, fmi3Boolean *terminate, fmi3Boolean *early_return,
                      fmi3Float64 *last_successful_time_s) {
  return guarded(instance, [&](Instance& self) {
    *event_handling_needed = *terminate = *early_return = fmi3False;
    *last_successful_time_s = self.time_s;
    require(self.phase == Phase::kStepping, "fmi3DoStep", "in the step mode");
    for (std::int64_t left = periods_of(self, point_s, size_s); left > 0; --left) {
      self.unit->step();
    }
    require_finite_outputs(self);
    *last_successful_time_s = self.time_s = point_s + size_s;
  });
}

fmi3Status fmi3Terminate(fmi3Instance instance) {
  return guarded(instance, [](Instance& self) {
    require(self.phase == Phase::kStepping, "fmi3Terminate", "in the step mode");
    self.phase = Phase::kTerminated;
  });
}

// As if it had been made anew.
fmi3Status fmi3Reset(fmi3Instance instance) {
  return guarded(instance, [](Instance& self) {
    self.unit = make_unit(self.resources);
    self.phase = Phase::kInstantiated;
    self.started = false;
    self.time_s = 0.0;
  });
}

fmi3Status fmi3GetFloat64(fmi3Instance instance, const fmi3ValueReference references[], size_t count,
                          fmi3Float64 values[], size_t values_count) {
  return get<double>(instance, "Float64", references, count, values, values_count);
}

fmi3Status fmi3SetFloat64(fmi3Instance instance, const fmi3ValueReference references[], size_t count,
                          const fmi3Float64 values[], size_t values_count) {
  return set<double>(instance, "Float64", references, count, values, values_count);
}

fmi3Status fmi3GetUInt64(fmi3Instance instance, const fmi3ValueReference references[], size_t count,
                         fmi3UInt64 values[], size_t values_count) {
  return get<std::uint64_t>(instance, "UInt64", references, count, values, values_count);
}

fmi3Status fmi3SetUInt64(fmi3Instance instance, const fmi3ValueReference references[], size_t count,
                         const fmi3UInt64 values[], size_t values_count) {
  return set<std::uint64_t>(instance, "UInt64", references, count, values, values_count);
}

fmi3Status fmi3GetBoolean(fmi3Instance instance, const fmi3ValueReference references[], size_t count,
                          fmi3Boolean values[], size_t values_count) {
  return get<bool>(instance, "Boolean", references, count, values, values_count);
}

fmi3Status fmi3SetBoolean(fmi3Instance instance, const fmi3ValueReference references[], size_t count,
                          const fmi3Boolean values[], size_t values_count) {
  return set<bool>(instance, "Boolean", references, count, values, values_count);
}

fmi3Status fmi3GetString(fmi3Instance instance, const fmi3ValueReference references[], size_t count,
                         fmi3String values[], size_t values_count) {
  return get<std::string>(instance, "String", references, count, values, values_count);
}

fmi3Status fmi3SetString(fmi3Instance instance, const fmi3ValueReference references[], size_t count,
                         const fmi3String values[], size_t values_count) {
  return set<std::string>(instance, "String", references, count, values, values_count);
}

// What a library must have but this kind of unit does not do, and says so in modelDescription.xml.
#define TRACKSERVO_NOT_PROVIDED(function, ...) \
  fmi3Status function(fmi3Instance instance, __VA_ARGS__) { return not_provided(instance, #function); }
#define TRACKSERVO_NOT_PROVIDED_ALONE(function) \
  fmi3Status function(fmi3Instance instance) { return not_provided(instance, #function); }
#define TRACKSERVO_NO_VARIABLES(type)                                                              \
  TRACKSERVO_NOT_PROVIDED(fmi3Get##type, const fmi3ValueReference[], size_t, fmi3##type[], size_t) \
  TRACKSERVO_NOT_PROVIDED(fmi3Set##type, const fmi3ValueReference[], size_t, const fmi3##type[], size_t)

TRACKSERVO_NO_VARIABLES(Float32)
TRACKSERVO_NO_VARIABLES(Int8)
TRACKSERVO_NO_VARIABLES(UInt8)
TRACKSERVO_NO_VARIABLES(Int16)
TRACKSERVO_NO_VARIABLES(UInt16)
TRACKSERVO_NO_VARIABLES(Int32)
TRACKSERVO_NO_VARIABLES(UInt32)
TRACKSERVO_NO_VARIABLES(Int64)
TRACKSERVO_NOT_PROVIDED(fmi3GetBinary, const fmi3ValueReference[], size_t, size_t[], fmi3Binary[], size_t)
TRACKSERVO_NOT_PROVIDED(fmi3SetBinary, const fmi3ValueReference[], size_t, const size_t[], const fmi3Binary[], size_t)
TRACKSERVO_NOT_PROVIDED(fmi3GetClock, const fmi3ValueReference[], size_t, fmi3Clock[])
TRACKSERVO_NOT_PROVIDED(fmi3SetClock, const fmi3ValueReference[], size_t, const fmi3Clock[])
TRACKSERVO_NOT_PROVIDED(fmi3GetNumberOfVariableDependencies, fmi3ValueReference, size_t *)
TRACKSERVO_NOT_PROVIDED(fmi3GetVariableDependencies, fmi3ValueReference, size_t[], fmi3ValueReference[], size_t[],
                        fmi3DependencyKind[], size_t)
TRACKSERVO_NOT_PROVIDED(fmi3GetFMUState, fmi3FMUState *)
TRACKSERVO_NOT_PROVIDED(fmi3SetFMUState, fmi3FMUState)
TRACKSERVO_NOT_PROVIDED(fmi3FreeFMUState, fmi3FMUState *)
TRACKSERVO_NOT_PROVIDED(fmi3SerializedFMUStateSize, fmi3FMUState, size_t *)
TRACKSERVO_NOT_PROVIDED(fmi3SerializeFMUState, fmi3FMUState, fmi3Byte[], size_t)
TRACKSERVO_NOT_PROVIDED(fmi3DeserializeFMUState, const fmi3Byte[], size_t, fmi3FMUState *)
TRACKSERVO_NOT_PROVIDED(fmi3GetDirectionalDerivative, const fmi3ValueReference[], size_t, const fmi3ValueReference[],
                        size_t, const fmi3Float64[], size_t, fmi3Float64[], size_t)
TRACKSERVO_NOT_PROVIDED(fmi3GetAdjointDerivative, const fmi3ValueReference[], size_t, const fmi3ValueReference[],
                        size_t, const fmi3Float64[], size_t, fmi3Float64[], size_t)
TRACKSERVO_NOT_PROVIDED_ALONE(fmi3EnterConfigurationMode)
TRACKSERVO_NOT_PROVIDED_ALONE(fmi3ExitConfigurationMode)
TRACKSERVO_NOT_PROVIDED_ALONE(fmi3EnterEventMode)
TRACKSERVO_NOT_PROVIDED(fmi3GetIntervalDecimal, const fmi3ValueReference[], size_t, fmi3Float64[],
                        fmi3IntervalQualifier[])
TRACKSERVO_NOT_PROVIDED(fmi3GetIntervalFraction, const fmi3ValueReference[], size_t, fmi3UInt64[], fmi3UInt64[],
                        fmi3IntervalQualifier[])
TRACKSERVO_NOT_PROVIDED(fmi3GetShiftDecimal, const fmi3ValueReference[], size_t, fmi3Float64[])
TRACKSERVO_NOT_PROVIDED(fmi3GetShiftFraction, const fmi3ValueReference[], size_t, fmi3UInt64[], fmi3UInt64[])
TRACKSERVO_NOT_PROVIDED(fmi3SetIntervalDecimal, const fmi3ValueReference[], size_t, const fmi3Float64[])
TRACKSERVO_NOT_PROVIDED(fmi3SetIntervalFraction, const fmi3ValueReference[], size_t, const fmi3UInt64[],
                        const fmi3UInt64[])
TRACKSERVO_NOT_PROVIDED(fmi3SetShiftDecimal, const fmi3ValueReference[], size_t, const fmi3Float64[])
TRACKSERVO_NOT_PROVIDED(fmi3SetShiftFraction, const fmi3ValueReference[], size_t, const fmi3UInt64[],
                        const fmi3UInt64[])
TRACKSERVO_NOT_PROVIDED_ALONE(fmi3EvaluateDiscreteStates)
TRACKSERVO_NOT_PROVIDED(fmi3UpdateDiscreteStates, fmi3Boolean *, fmi3Boolean *, fmi3Boolean *, fmi3Boolean *,
                        fmi3Boolean *, fmi3Float64 *)
TRACKSERVO_NOT_PROVIDED_ALONE(fmi3EnterContinuousTimeMode)
TRACKSERVO_NOT_PROVIDED(fmi3CompletedIntegratorStep, fmi3Boolean, fmi3Boolean *, fmi3Boolean *)
TRACKSERVO_NOT_PROVIDED(fmi3SetTime, fmi3Float64)
TRACKSERVO_NOT_PROVIDED(fmi3SetContinuousStates, const fmi3Float64[], size_t)
TRACKSERVO_NOT_PROVIDED(fmi3GetContinuousStateDerivatives, fmi3Float64[], size_t)
TRACKSERVO_NOT_PROVIDED(fmi3GetEventIndicators, fmi3Float64[], size_t)
TRACKSERVO_NOT_PROVIDED(fmi3GetContinuousStates, fmi3Float64[], size_t)
TRACKSERVO_NOT_PROVIDED(fmi3GetNominalsOfContinuousStates, fmi3Float64[], size_t)
TRACKSERVO_NOT_PROVIDED(fmi3GetNumberOfEventIndicators, size_t *)
TRACKSERVO_NOT_PROVIDED(fmi3GetNumberOfContinuousStates, size_t *)
TRACKSERVO_NOT_PROVIDED_ALONE(fmi3EnterStepMode)
TRACKSERVO_NOT_PROVIDED(fmi3GetOutputDerivatives, const fmi3ValueReference[], size_t, const fmi3Int32[], fmi3Float64[],
                        size_t)
TRACKSERVO_NOT_PROVIDED(fmi3ActivateModelPartition, fmi3ValueReference, fmi3Float64)

}  // extern "C"
