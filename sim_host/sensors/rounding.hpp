// Rounding to whole codes, without a library call.
#ifndef TRACKSERVO_SIM_SENSORS_ROUNDING_HPP
#define TRACKSERVO_SIM_SENSORS_ROUNDING_HPP

#include <cstdint>

namespace trackservo::sim {

// The nearest whole number, halves away from zero. |value| must be below 2^62; the callers clip before.
inline double nearest_whole(double value) {
  return static_cast<double>(static_cast<std::int64_t>(value + (value < 0.0 ? -0.5 : 0.5)));
}

}  // namespace trackservo::sim

#endif
