// SPDX-License-Identifier: Apache-2.0
// Rounding to whole codes, without a library call and without a branch.
#ifndef TRACKSERVO_SIM_SENSORS_ROUNDING_HPP
#define TRACKSERVO_SIM_SENSORS_ROUNDING_HPP

#include <cfloat>

namespace trackservo::sim {

// Returns the nearest whole number, halves to the even one. |value| must be below 2^51; the callers clip before.
inline double nearest_whole(double value) {
  static_assert(FLT_EVAL_METHOD == 0, "needs sums that are rounded to double at once");
  constexpr double kNoRoomForFractions = 0x1.8p52;  // of either sign of `value`
  return (value + kNoRoomForFractions) - kNoRoomForFractions;
}

}  // namespace trackservo::sim

#endif
