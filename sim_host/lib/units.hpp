// SPDX-License-Identifier: Apache-2.0
// The tick of the servo, pi and the degree, once for the libraries, the simulator and their tests.
#ifndef TRACKSERVO_UNITS_HPP
#define TRACKSERVO_UNITS_HPP

namespace trackservo {

constexpr double kTick_s = 1e-3;

constexpr double kPi = 3.14159265358979323846;
constexpr double kRadPerDeg = kPi / 180.0;
constexpr double kDegPerRad = 180.0 / kPi;

}  // namespace trackservo

#endif
