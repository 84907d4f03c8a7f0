// SPDX-License-Identifier: Apache-2.0
// Zero-phase low-pass: a symmetric windowed-sinc FIR, flat up to about 0.6 of its cutoff.
#ifndef TRACKSERVO_IDENTIFICATION_LOW_PASS_HPP
#define TRACKSERVO_IDENTIFICATION_LOW_PASS_HPP

#include <cstddef>
#include <vector>

namespace trackservo::identification {

class LowPass {
 public:
  // Computes the weights for 0 < cutoff_hz < 500: half the amplitude passes there.
  explicit LowPass(double cutoff_hz);

  // Returns the samples at each end that do not get the whole filter.
  std::size_t reach() const { return weights_.size() - 1; }

  // Writes smoothed ticks first..last-1 of `values`; beyond the ends the values continue point-symmetrically, so a
  // straight line stays straight. `smooth` has the length of `values`; other ticks are unchanged.
  void smooth(const std::vector<double>& values, std::size_t first, std::size_t last,
              std::vector<double>& smooth) const;

 private:
  std::vector<double> weights_;  // from the middle to one end
};

}  // namespace trackservo::identification

#endif
