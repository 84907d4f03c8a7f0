// SPDX-License-Identifier: Apache-2.0
#include "design/frequency_measurement.hpp"

#include <cmath>

#include "machine/base/random.hpp"
#include "machine/run/machine.hpp"

namespace trackservo::sim {
namespace {

constexpr double kRatio = 1.07;  // between neighbouring tones
constexpr int kSettleTicks = 3000;
constexpr double kSpacing_hz = 0.25;  // tones are multiples of it
constexpr int kMeasureTicks = 16000;  // a whole number of periods of every tone

struct Tone {
  double frequency_hz;
  double phase_rad;
};

// Tones on a 0.25 Hz grid, each at least 7 % above the last, with random phases to keep the peak low.
std::vector<Tone> multisine(const MeasurementRequest& request) {
  RandomStream phases(request.seed, "multisine.phase", request.axis);
  std::vector<Tone> tones;
  const int count = 1 + static_cast<int>(std::log(request.last_hz / request.first_hz) / std::log(kRatio));
  for (int i = 0; i < count; ++i) {
    const double grid_hz = kSpacing_hz * std::round(request.first_hz * std::pow(kRatio, i) / kSpacing_hz);
    if (tones.empty() || grid_hz > tones.back().frequency_hz) {
      tones.push_back({grid_hz, 2.0 * kPi * phases.uniform()});
    }
  }
  return tones;
}

double torque_of(const std::vector<Tone>& tones, double amplitude_nm, double time_s) {
  double sum = 0.0;
  for (const Tone& tone : tones) {
    sum += std::sin(2.0 * kPi * tone.frequency_hz * time_s + tone.phase_rad);
  }
  return amplitude_nm * sum;
}

}  // namespace

gain_design::FrequencyResponse measured_loop_gain(const MeasurementRequest& request) {
  Machine machine(*request.plant, request.params, request.seed, {0.0, request.pitch_rad});
  for (servo_axis_command& command : machine.command().axis) {
    command.mode = SERVO_SPEED;
  }
  machine.command().axis[request.axis].speed.rate_rad_s = static_cast<float>(request.bias_rate_rad_s);

  const std::vector<Tone> tones = multisine(request);
  const double amplitude_nm = request.torque_rms_nm * std::sqrt(2.0 / static_cast<double>(tones.size()));
  std::vector<std::complex<double>> controller(tones.size());
  std::vector<std::complex<double>> injected(tones.size());
  for (int tick = 0; tick < kSettleTicks + kMeasureTicks; ++tick) {
    const double time_s = tick * kTick_s;
    const double torque_nm = torque_of(tones, amplitude_nm, time_s);
    machine.inject_torque(request.axis, torque_nm);
    machine.advance_tick();
    if (tick < kSettleTicks) {
      continue;
    }
    const double command_nm = static_cast<double>(machine.firmware(request.axis).commanded_nm);
    for (std::size_t i = 0; i < tones.size(); ++i) {
      const std::complex<double> turn = std::polar(1.0, -2.0 * kPi * tones[i].frequency_hz * time_s);
      controller[i] += command_nm * turn;
      injected[i] += torque_nm * turn;
    }
  }
  gain_design::FrequencyResponse response;
  for (std::size_t i = 0; i < tones.size(); ++i) {
    response.frequency_hz.push_back(tones[i].frequency_hz);
    response.loop_gain.push_back(-controller[i] / (controller[i] + injected[i]));
  }
  return response;
}

}  // namespace trackservo::sim
