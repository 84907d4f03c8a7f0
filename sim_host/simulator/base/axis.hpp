// The two axes of the tracker and the two clocks of the simulation.
//
// Azimuth carries pitch; both are indexed everywhere by AxisIndex. The plant advances by PWM periods; the slow parts
// (wind, base motion, gravity, ripple shape) are updated once per tick.
#ifndef TRACKSERVO_SIM_BASE_AXIS_HPP
#define TRACKSERVO_SIM_BASE_AXIS_HPP

namespace trackservo::sim {

enum AxisIndex { kAzimuth = 0, kPitch = 1 };
constexpr int kAxes = 2;

constexpr const char *axis_name(int axis) { return axis == kAzimuth ? "azimuth" : "pitch"; }

constexpr double kPwmPeriod_s = 50e-6;
constexpr double kTick_s = 1e-3;
constexpr int kPwmPerTick = 20;

constexpr double kPi = 3.14159265358979323846;
constexpr double kDegPerRad = 180.0 / kPi;

}  // namespace trackservo::sim

#endif
