// SPDX-License-Identifier: Apache-2.0
// Terms that may depend on the joint angle, as far as the travel can resolve them.
//
// Over (nearly) a whole turn: once and twice per turn. Over less, these cannot be distinguished, and a straight line
// and a parabola over the travel replace them. Both have mean zero there, so a friction level is always the mean over
// the recorded travel. Over almost no travel nothing depends on the angle.
#ifndef TRACKSERVO_IDENTIFICATION_POSITION_TERMS_HPP
#define TRACKSERVO_IDENTIFICATION_POSITION_TERMS_HPP

#include <array>
#include <string>
#include <vector>

#include "identification/recording.hpp"

namespace trackservo::identification {

enum class PositionBasis { kNone, kTravel, kTurn };

class PositionTerms {
 public:
  static constexpr int kMax = 4;

  explicit PositionTerms(const Recording& recording);
  PositionTerms(double lowest_rad, double highest_rad);

  PositionBasis basis() const { return basis_; }
  double lowest_rad() const { return lowest_rad_; }
  double highest_rad() const { return highest_rad_; }

  int count() const { return count_; }
  std::string name(int term) const;  // "cos 2 angle", "travel^2"
  std::array<double, kMax> at(double angle_rad) const;

 private:
  double lowest_rad_;
  double highest_rad_;
  PositionBasis basis_;
  int count_;
};

}  // namespace trackservo::identification

#endif
