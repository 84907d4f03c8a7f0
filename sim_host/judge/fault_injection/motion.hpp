// SPDX-License-Identifier: Apache-2.0
// The motions in which faults are injected.
#ifndef TRACKSERVO_SIM_FAULT_INJECTION_MOTION_HPP
#define TRACKSERVO_SIM_FAULT_INJECTION_MOTION_HPP

#include <array>
#include <string>

namespace trackservo::sim {

enum class Motion { kStandstill, kSlow, kFast, kReversal, kTracking };

constexpr std::array<Motion, 5> kMotions = {Motion::kStandstill, Motion::kSlow, Motion::kFast, Motion::kReversal,
                                            Motion::kTracking};

// Returns "standstill", "1 deg/s", "20 deg/s", "reversal" (5 deg/s, once a second), "tracking" (a fly-by at up to 12
// deg/s).
std::string motion_name(Motion motion);

// Returns the set-point [rad/s] at a time [s]; it begins at 0 with at most 1 rad/s^2. Stays within +-45 deg for 3 s.
double motion_rate_rad_s(Motion motion, double time_s);

}  // namespace trackservo::sim

#endif
