// SPDX-License-Identifier: Apache-2.0
#include "gain_design/margins.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "units.hpp"

namespace trackservo::gain_design {
namespace {

using Complex = std::complex<double>;

// Where a straight line from (x0, y0) to (x1, y1) meets y = 0.
double crossing(double x0, double y0, double x1, double y1) { return x0 + (x1 - x0) * y0 / (y0 - y1); }

Margins margins_on(const LinearMachine& machine, const speed_loop_params& loop) {
  return margins_of(computed_loop_gain(machine, loop, log_space_with_modes(machine, 0.05, 450.0, 1200)));
}

}  // namespace

Margins margins_of(const FrequencyResponse& response) {
  const double none = std::numeric_limits<double>::infinity();
  Margins margins{none, none, 0.0, none};
  for (std::size_t i = 1; i < response.loop_gain.size(); ++i) {
    const Complex a = response.loop_gain[i - 1];
    const Complex b = response.loop_gain[i];
    const double gain_a_db = 20.0 * std::log10(std::abs(a));
    const double gain_b_db = 20.0 * std::log10(std::abs(b));
    // Distance of the phase to -180 deg, continuous over this short step.
    const double phase_a_deg = std::arg(-a) * kDegPerRad;
    const double phase_b_deg = phase_a_deg + std::arg(b / a) * kDegPerRad;
    if ((gain_a_db > 0.0) != (gain_b_db > 0.0)) {
      const double share = crossing(0.0, gain_a_db, 1.0, gain_b_db);
      const double phase_deg = phase_a_deg + share * (phase_b_deg - phase_a_deg);
      margins.phase_margin_deg = std::min(margins.phase_margin_deg, std::abs(phase_deg));
      margins.crossover_hz =
          response.frequency_hz[i - 1] + share * (response.frequency_hz[i] - response.frequency_hz[i - 1]);
    }
    if ((phase_a_deg > 0.0) != (phase_b_deg > 0.0) && std::abs(phase_a_deg) < 90.0) {
      const double share = crossing(0.0, phase_a_deg, 1.0, phase_b_deg);
      const double gain_margin_db = std::abs(gain_a_db + share * (gain_b_db - gain_a_db));
      if (gain_margin_db < margins.gain_margin_db) {
        margins.gain_margin_db = gain_margin_db;
        margins.phase_crossover_hz =
            response.frequency_hz[i - 1] + share * (response.frequency_hz[i] - response.frequency_hz[i - 1]);
      }
    }
  }
  return margins;
}

Margins worst_margins(const std::vector<LinearMachine>& machines, const speed_loop_params& loop) {
  Margins worst = margins_on(machines.front(), loop);
  for (std::size_t i = 1; i < machines.size(); ++i) {
    const Margins margins = margins_on(machines[i], loop);
    worst.gain_margin_db = std::min(worst.gain_margin_db, margins.gain_margin_db);
    worst.phase_margin_deg = std::min(worst.phase_margin_deg, margins.phase_margin_deg);
  }
  return worst;
}

bool keeps_margins(const Margins& margins, const MinMargins& least) {
  return margins.gain_margin_db >= least.gain_margin_db && margins.phase_margin_deg >= least.phase_margin_deg;
}

bool is_stable_in_closed_loop(const FrequencyResponse& response) {
  const std::vector<std::complex<double>>& gain = response.loop_gain;
  if (std::abs(gain.back()) >= 1.0) {
    return false;  // still controlled at half the tick's rate: nothing bounds the phase there
  }
  // n integrators begin at -90 n degrees, which atan2 alone would wrap into one turn; the slope of |L| gives n.
  const double slope =
      gain.front() == 0.0 || std::abs(gain.front()) < 1.0
          ? 0.0
          : std::log(std::abs(gain[1] / gain[0])) / std::log(response.frequency_hz[1] / response.frequency_hz[0]);
  const double expected = 0.5 * M_PI * slope;
  const double folded = std::arg(1.0 + gain.front());
  double phase = folded + 2.0 * M_PI * std::round((expected - folded) / (2.0 * M_PI));
  for (std::size_t i = 1; i < gain.size(); ++i) {
    phase += std::arg((1.0 + gain[i]) / (1.0 + gain[i - 1]));
  }
  return std::abs(phase) < 0.5 * M_PI;
}

bool is_stable(const std::vector<LinearMachine>& machines, const speed_loop_params& loop) {
  return std::all_of(machines.begin(), machines.end(), [&](const LinearMachine& machine) {
    // From below any bandwidth that may be required, up to half the tick's rate.
    return is_stable_in_closed_loop(
        computed_loop_gain(machine, loop, log_space_with_modes(machine, 1e-4, 499.0, 1000)));
  });
}

}  // namespace trackservo::gain_design
