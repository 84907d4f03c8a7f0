// SPDX-License-Identifier: Apache-2.0
#include "identification/position_terms.hpp"

#include <algorithm>
#include <cmath>

#include "units.hpp"

namespace trackservo::identification {

namespace {

constexpr double kNearlyATurn_rad = 330.0 * kRadPerDeg;
constexpr double kHardlyAny_rad = 20.0 * kRadPerDeg;

PositionBasis basis_of(double travel_rad) {
  if (travel_rad >= kNearlyATurn_rad) {
    return PositionBasis::kTurn;
  }
  return travel_rad >= kHardlyAny_rad ? PositionBasis::kTravel : PositionBasis::kNone;
}

int count_of(PositionBasis basis) {
  switch (basis) {
    case PositionBasis::kTurn:
      return 4;
    case PositionBasis::kTravel:
      return 2;
    case PositionBasis::kNone:
      break;
  }
  return 0;
}

}  // namespace

PositionTerms::PositionTerms(double lowest_rad, double highest_rad)
    : lowest_rad_(lowest_rad),
      highest_rad_(highest_rad),
      basis_(basis_of(highest_rad - lowest_rad)),
      count_(count_of(basis_)) {}

PositionTerms::PositionTerms(const Recording& recording)
    : PositionTerms(*std::min_element(recording.joint_angle_rad.begin(), recording.joint_angle_rad.end()),
                    *std::max_element(recording.joint_angle_rad.begin(), recording.joint_angle_rad.end())) {}

std::string PositionTerms::name(int term) const {
  static const char *const turn[] = {"cos(angle)", "sin(angle)", "cos(2 angle)", "sin(2 angle)"};
  static const char *const travel[] = {"P1(travel)", "P2(travel)"};
  return basis_ == PositionBasis::kTurn ? turn[term] : travel[term];
}

std::array<double, PositionTerms::kMax> PositionTerms::at(double angle_rad) const {
  if (basis_ == PositionBasis::kTurn) {
    const double cosine = std::cos(angle_rad);
    const double sine = std::sin(angle_rad);
    return {cosine, sine, cosine * cosine - sine * sine, 2.0 * sine * cosine};
  }
  if (basis_ == PositionBasis::kTravel) {
    const double x = (2.0 * angle_rad - lowest_rad_ - highest_rad_) / (highest_rad_ - lowest_rad_);
    return {x, 0.5 * (3.0 * x * x - 1.0), 0.0, 0.0};
  }
  return {};
}

}  // namespace trackservo::identification
