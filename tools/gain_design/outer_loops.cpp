#include "gain_design/outer_loops.hpp"

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

}  // namespace trackservo::gain_design
