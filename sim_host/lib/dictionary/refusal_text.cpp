// SPDX-License-Identifier: Apache-2.0
#include "dictionary/refusal_text.hpp"

#include <fmt/format.h>

#include <cstring>

#include "dictionary/device_description.hpp"

extern "C" {
#include "node/objects/protection_objects.h"
#include "parameters/axis_dictionary.h"
}

namespace trackservo::dictionary {
namespace {

const od_entry *row_of(const od_table& table, std::uint32_t object) {
  for (std::uint32_t i = 0; i < table.count; ++i) {
    const od_entry& entry = table.entries[i];
    if (PARAMETER_OBJECT(entry.index, entry.sub) == object) {
      return &entry;
    }
  }
  return nullptr;
}

float value_of(const od_entry& entry, const void *values) {
  const char *place = static_cast<const char *>(values) + entry.offset;
  if (entry.type == OD_REAL32) {
    float value = 0.0F;
    std::memcpy(&value, place, sizeof value);
    return value;
  }
  std::uint32_t value = 0;
  std::memcpy(&value, place, sizeof value);
  return static_cast<float>(value);
}

// "2020:4 Observer bandwidth is 5000 rad/s"
std::string value_text(const od_entry& entry, const void *values, unsigned axis_shift) {
  const std::string unit = *entry.unit == '\0' ? "" : fmt::format(" {}", entry.unit);
  return fmt::format("{:04X}:{} {} is {:g}{}", entry.index + axis_shift, static_cast<unsigned>(entry.sub), entry.name,
                     value_of(entry, values), unit);
}

float low_of(const od_entry& entry) { return entry.type == OD_REAL32 ? entry.low.f : static_cast<float>(entry.low.i); }

std::string sentence(const parameter_refusal& refusal, const od_table& table, const void *values, unsigned axis_shift,
                     const char *verb = "; give") {
  const od_entry *wrong = row_of(table, refusal.object);
  if (wrong == nullptr) {
    return "the values do not fit each other";
  }
  std::string text =
      fmt::format("{}{} {:g} .. {:g}", value_text(*wrong, values, axis_shift), verb, refusal.low, refusal.high);
  if (const od_entry *bound = row_of(table, refusal.bound_by)) {
    return fmt::format("{}, since {}", text, value_text(*bound, values, axis_shift));
  }
  return low_of(*wrong) < refusal.low ? fmt::format("{}, or {:g}", text, low_of(*wrong)) : text;
}

std::optional<std::string> refusal_of(const servo_axis_params& params, unsigned axis_shift) {
  if (servo_axis_check(&params, SERVO_TICK_S, SERVO_PWM_PERIOD_S) == CONTROL_OK) {
    return std::nullopt;
  }
  axis_parameters copied = listed_defaults();
#define TAKE_NOTHING(...)
#define TAKE_REAL(index, sub, flags, group, member, low, high, preset, unit, name, help, to) \
  copied.group.member = params.to;
#define TAKE_WHOLE(index, sub, flags, group, member, low, high, preset, name, help, to, type) \
  copied.group.member = static_cast<std::uint32_t>(params.to);
#define TAKE_DIRECTION(sub, side, title) FRICTION_DIRECTION_ROWS(TAKE_REAL, sub, side, title)
  AXIS_PARAMETERS(TAKE_NOTHING, TAKE_REAL, TAKE_NOTHING, TAKE_WHOLE, TAKE_DIRECTION, TAKE_NOTHING)
  const parameter_refusal refusal = axis_parameters_check(&copied);
  return refusal.status == CONTROL_OK ? "the coefficients of a filter or of the current loop are not usable"
                                      : sentence(refusal, axis_parameters_table, &copied, axis_shift);
}

}  // namespace

std::string refusal_text(const parameter_refusal& refusal, const axis_parameters& parameters, unsigned axis_shift) {
  return sentence(refusal, axis_parameters_table, &parameters, axis_shift);
}

std::optional<std::string> refusal_of(const axis_parameters& parameters) {
  const parameter_refusal refusal = axis_parameters_check(&parameters);
  return refusal.status == CONTROL_OK ? std::nullopt : std::optional(refusal_text(refusal, parameters));
}

std::string refusal_reason(const axis_parameters& parameters) {
  return sentence(axis_parameters_check(&parameters), axis_parameters_table, &parameters, 0, ", not within");
}

std::optional<std::string> refusal_of(const protection_limits& limits) {
  const parameter_refusal refusal = protection_refusal(&limits);
  return refusal.status == CONTROL_OK ? std::nullopt
                                      : std::optional(sentence(refusal, protection_objects_table, &limits, 0));
}

std::string refusal_of(const std::array<axis_parameters, SERVO_AXES>& parameters,
                       const std::array<protection_limits, SERVO_AXES>& limits) {
  for (unsigned axis = 0; axis < SERVO_AXES; ++axis) {
    const parameter_refusal gains = axis_parameters_check(&parameters[axis]);
    if (gains.status != CONTROL_OK) {
      return sentence(gains, axis_parameters_table, &parameters[axis], AXIS_INDEX_SHIFT * axis);
    }
    const parameter_refusal limit = protection_refusal(&limits[axis]);
    if (limit.status != CONTROL_OK) {
      return sentence(limit, protection_objects_table, &limits[axis], AXIS_INDEX_SHIFT * axis);
    }
  }
  return "give a node id from 1 to 127 or 255, and a bit rate of 125, 250, 500 or 1000 kbit/s";
}

std::optional<std::string> refusal_of(const servo_params& params) {
  for (unsigned axis = 0; axis < SERVO_AXES; ++axis) {
    if (std::optional<std::string> text = refusal_of(params.axis[axis], AXIS_INDEX_SHIFT * axis)) {
      return text;
    }
  }
  return std::nullopt;
}

}  // namespace trackservo::dictionary
