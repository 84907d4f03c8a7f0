// SPDX-License-Identifier: Apache-2.0
#include "test_plan/test_plan_text.hpp"

#include <fmt/format.h>

#include <cmath>
#include <string>

#include "units.hpp"

namespace trackservo::commissioning {

namespace {

double real(float value) { return static_cast<double>(value); }

const char *title(Stage stage) {
  switch (stage) {
    case Stage::kFirstLook:
      return "First look";
    case Stage::kStructure:
      return "Structure";
    case Stage::kIdentification:
    default:
      return "Identification";
  }
}

std::string text_of(const stimulus_setup& e) {
  const double low_deg_s = real(e.low_rad_s) * kDegPerRad;
  switch (e.kind) {
    case STIMULUS_SWEEP:
      return fmt::format("sweep: {} speeds, {:.3g} to {:.3g} deg/s, {:.3g} s in each direction", e.count, low_deg_s,
                         real(stimulus_peak_rate_rad_s(&e)) * kDegPerRad, real(e.dwell_s));
    case STIMULUS_TORQUE_RAMPS:
      return fmt::format("torque ramps: {} of +-{:.3g} Nm", e.count, real(e.amplitude_nm));
    case STIMULUS_HYSTERESIS:
      return fmt::format("hysteresis loops: {} of +-{:.3g} mdeg in {:.3g} s", e.count,
                         real(e.amplitude_rad) * 1e3 * kDegPerRad, real(e.dwell_s));
    case STIMULUS_CHIRP:
      return fmt::format("chirp: {:.3g} Nm, {:.3g} to {:.3g} Hz, at {:.3g} deg/s", real(e.amplitude_nm), real(e.low_hz),
                         real(e.high_hz), low_deg_s);
    case STIMULUS_BREAKAWAY:
      return fmt::format("break-away: {} times, up to {:.3g} Nm", e.count, real(e.amplitude_nm));
    case STIMULUS_NONE:
    default:
      return "nothing";
  }
}

}  // namespace

void print(const TestPlan& test_plan, double start_rad) {
  fmt::print("{}: {} positions, about {:.0f} s, moves at {:.3g} deg/s\n", title(test_plan.stage),
             test_plan.places.size(), duration_s(test_plan, start_rad), test_plan.moving_rad_s * kDegPerRad);
  fmt::print("Limits: {:.3g} deg to each side of a position, {:.3g} deg/s, {:.3g} Nm\n",
             real(test_plan.limits.travel_rad) * kDegPerRad, real(test_plan.limits.rate_rad_s) * kDegPerRad,
             real(test_plan.limits.torque_nm));
  for (const Place& place : test_plan.places) {
    fmt::print("at {:+.1f} deg\n", place.angle_rad * kDegPerRad);
    for (const stimulus_setup& experiment : place.experiments) {
      fmt::print("  {:6.1f} s  {}\n", real(stimulus_duration_s(&experiment)), text_of(experiment));
    }
  }
}

}  // namespace trackservo::commissioning
