// SPDX-License-Identifier: Apache-2.0
#include "judge/analysis/metrics.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

namespace trackservo::sim {
namespace {

constexpr double kNoValue = std::numeric_limits<double>::quiet_NaN();

// Calls `visit` with every row of the axis inside the window; returns how many there were.
template <typename Visitor>
int for_window(const Trace& trace, int axis, Window window, Visitor visit) {
  int rows = 0;
  for (const TraceRow& row : trace) {
    if (row.time_s >= window.begin_s && row.time_s < window.end_s) {
      visit(row.time_s, row.axis[static_cast<std::size_t>(axis)]);
      ++rows;
    }
  }
  return rows;
}

double rate_error_rad_s(const AxisRow& row) { return row.rate_rad_s - row.reference_rad_s; }

double or_no_value(int rows, double value) { return rows > 0 ? value : kNoValue; }

}  // namespace

double peak_rate_error_rad_s(const Trace& trace, int axis, Window window) {
  double peak = 0.0;
  const int rows = for_window(
      trace, axis, window, [&](double, const AxisRow& row) { peak = std::max(peak, std::abs(rate_error_rad_s(row))); });
  return or_no_value(rows, peak);
}

double rms_rate_error_rad_s(const Trace& trace, int axis, Window window) {
  double sum = 0.0;
  const int rows = for_window(
      trace, axis, window, [&](double, const AxisRow& row) { sum += rate_error_rad_s(row) * rate_error_rad_s(row); });
  return or_no_value(rows, std::sqrt(sum / rows));
}

double time_to_90_percent_s(const Trace& trace, int axis, Window window, double step_rad_s) {
  // Half a tick: times are sums of ticks, and a dwell of 100 of them must not depend on their last bit.
  const double dwell_s = kArrivalDwell_s - 0.5 * static_cast<double>(SERVO_TICK_S);
  std::optional<double> since_s;  // at 90 % without interruption
  std::optional<double> arrived_s;
  const int rows = for_window(trace, axis, window, [&](double time_s, const AxisRow& row) {
    if (row.rate_rad_s / step_rad_s < 0.9) {
      since_s.reset();
      return;
    }
    since_s = since_s.value_or(time_s);
    if (!arrived_s && time_s - *since_s >= dwell_s) {
      arrived_s = since_s;
    }
  });
  constexpr double kNever = std::numeric_limits<double>::infinity();
  return or_no_value(step_rad_s == 0.0 ? 0 : rows, arrived_s.value_or(kNever) - window.begin_s);
}

double overshoot_fraction(const Trace& trace, int axis, Window window, double step_rad_s) {
  double highest = 1.0;
  const int rows = for_window(trace, axis, window, [&](double, const AxisRow& row) {
    highest = std::max(highest, row.rate_rad_s / step_rad_s);
  });
  return or_no_value(step_rad_s == 0.0 ? 0 : rows, highest - 1.0);
}

double tracking_sigma_rad(const Trace& trace, int axis, Window window) {
  double sum = 0.0;
  double sum_of_squares = 0.0;
  const int rows = for_window(trace, axis, window, [&](double, const AxisRow& row) {
    sum += row.tracking_error_rad;
    sum_of_squares += row.tracking_error_rad * row.tracking_error_rad;
  });
  const double mean = sum / rows;
  return or_no_value(rows, std::sqrt(std::max(0.0, sum_of_squares / rows - mean * mean)));
}

double torque_noise_nm(const Trace& trace, int axis, Window window) {
  std::vector<double> torque;
  for_window(trace, axis, window, [&](double, const AxisRow& row) { torque.push_back(row.command_nm); });
  constexpr std::size_t kHalf = 25;  // ticks: a mean over 51 ms
  if (torque.size() <= 2 * kHalf) {
    return kNoValue;
  }
  double window_sum = 0.0;
  for (std::size_t i = 0; i < 2 * kHalf; ++i) {
    window_sum += torque[i];
  }
  double sum_of_squares = 0.0;
  for (std::size_t i = kHalf; i + kHalf < torque.size(); ++i) {
    window_sum += torque[i + kHalf];
    const double deviation = torque[i] - window_sum / (2 * kHalf + 1);
    sum_of_squares += deviation * deviation;
    window_sum -= torque[i - kHalf];
  }
  return std::sqrt(sum_of_squares / static_cast<double>(torque.size() - 2 * kHalf));
}

Trace ensemble_mean(const std::vector<Trace>& runs) {
  Trace mean = runs.empty() ? Trace{} : runs.front();
  for (std::size_t i = 0; i < mean.size(); ++i) {
    for (std::size_t axis = 0; axis < mean[i].axis.size(); ++axis) {
      double rate = 0.0;
      double tracking = 0.0;
      for (const Trace& run : runs) {
        rate += run[i].axis[axis].rate_rad_s;
        tracking += run[i].axis[axis].tracking_error_rad;
      }
      mean[i].axis[axis].rate_rad_s = rate / static_cast<double>(runs.size());
      mean[i].axis[axis].tracking_error_rad = tracking / static_cast<double>(runs.size());
    }
  }
  return mean;
}

}  // namespace trackservo::sim
