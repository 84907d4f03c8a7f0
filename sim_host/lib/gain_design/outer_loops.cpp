// SPDX-License-Identifier: Apache-2.0
#include "gain_design/outer_loops.hpp"

#include <algorithm>
#include <cmath>

namespace trackservo::gain_design {

double tracking_frequency_rad_s(double bandwidth_hz, double delay_s) {
  double low = 0.1;
  double high = 2.0 * M_PI * bandwidth_hz;
  for (int i = 0; i < 60; ++i) {
    const double w = 0.5 * (low + high);
    const std::complex<double> s(0.0, 2.0 * M_PI * bandwidth_hz);
    const std::complex<double> loop = (2.0 * w * s + w * w) / (s * s) * std::exp(-s * delay_s);
    (std::abs(loop / (1.0 + loop)) < M_SQRT1_2 ? low : high) = w;
  }
  return low;
}

Margins outer_margins(const std::vector<LinearMachine>& machines, const speed_loop_params& speed_loop,
                      const OuterLoop& outer) {
  Margins worst;
  for (std::size_t i = 0; i < machines.size(); ++i) {
    FrequencyResponse response{log_space(0.01, 450.0, 800), {}};
    for (const double f_hz : response.frequency_hz) {
      const std::complex<double> s(0.0, 2.0 * M_PI * f_hz);
      response.loop_gain.push_back((outer.proportional_per_s + outer.integral_per_s2 / s) / s *
                                   std::exp(-s * outer.delay_s) * closed_loop_gain(machines[i], speed_loop, f_hz));
    }
    const Margins margins = margins_of(response);
    worst = i == 0 ? margins : worst;
    worst.gain_margin_db = std::min(worst.gain_margin_db, margins.gain_margin_db);
    worst.phase_margin_deg = std::min(worst.phase_margin_deg, margins.phase_margin_deg);
  }
  return worst;
}

}  // namespace trackservo::gain_design
