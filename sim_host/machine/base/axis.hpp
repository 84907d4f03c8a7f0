// SPDX-License-Identifier: Apache-2.0
// The two axes of the tracker and the two clocks of the simulation.
//
// Azimuth carries pitch; both are indexed everywhere by AxisIndex. The plant advances by PWM periods; the slow parts
// (wind, base motion, gravity, ripple shape) are updated once per tick.
#ifndef TRACKSERVO_SIM_BASE_AXIS_HPP
#define TRACKSERVO_SIM_BASE_AXIS_HPP

#include "units.hpp"

namespace trackservo::sim {

using trackservo::kDegPerRad;
using trackservo::kPi;
using trackservo::kRadPerDeg;
using trackservo::kTick_s;

enum AxisIndex { kAzimuth = 0, kPitch = 1 };
constexpr int kAxes = 2;

constexpr const char *axis_name(int axis) { return axis == kAzimuth ? "azimuth" : "pitch"; }

constexpr double kPwmPeriod_s = 50e-6;
constexpr int kPwmPerTick = 20;

}  // namespace trackservo::sim

#endif
