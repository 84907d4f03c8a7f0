// SPDX-License-Identifier: Apache-2.0
// Why the firmware refuses a set of parameters, as a sentence: which value is wrong, and what would be right.
#ifndef TRACKSERVO_DICTIONARY_REFUSAL_TEXT_HPP
#define TRACKSERVO_DICTIONARY_REFUSAL_TEXT_HPP

#include <array>
#include <optional>
#include <string>

extern "C" {
#include "base/refusal.h"
#include "parameters/axis_parameters.h"
#include "protection/axis_protection.h"
#include "servo/servo_app.h"
}

namespace trackservo::dictionary {

// Returns "2020:4 Observer bandwidth is 5000 rad/s; give 0.01 .. 1000", for the caller to end. Where another value sets
// the limit, its name and value follow. `parameters` are those that were refused; `axis_shift` AXIS_INDEX_SHIFT names
// pitch's objects.
std::string refusal_text(const parameter_refusal& refusal, const axis_parameters& parameters, unsigned axis_shift = 0);

// Returns the sentence for the first value that is wrong; none when the firmware takes the set.
std::optional<std::string> refusal_of(const axis_parameters& parameters);
std::optional<std::string> refusal_of(const protection_limits& limits);

// Returns the same as a reason, where other advice follows: "2020:5 Observer limit is 16000 N m, not within 0 ..
// 10000".
std::string refusal_reason(const axis_parameters& parameters);

// Returns what a node does not start with: the gains or limits of an axis, else its place on the bus.
std::string refusal_of(const std::array<axis_parameters, SERVO_AXES>& parameters,
                       const std::array<protection_limits, SERVO_AXES>& limits);

// Returns the sentence for what is in the blocks already: only values that the list of parameters copies can be named.
std::optional<std::string> refusal_of(const servo_params& params);

}  // namespace trackservo::dictionary

#endif
