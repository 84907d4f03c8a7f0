// SPDX-License-Identifier: Apache-2.0
// Numbers of both axes side by side: one operation computes both, each exactly as it would compute one alone.
//
// Code that is written for a `Real` is compiled for one axis (double) and for both (Pair). A comparison of two Reals
// gives a Mask, the truth of each lane; the functions below take the place of the branches of a single number. A Pair
// is a vector type of gcc and clang, which every 64-bit processor has instructions for.
#ifndef TRACKSERVO_SIM_PLANT_LANES_HPP
#define TRACKSERVO_SIM_PLANT_LANES_HPP

#include <cmath>
#include <cstddef>

namespace trackservo::sim {

using Pair = double __attribute__((vector_size(2 * sizeof(double))));
using PairMask = decltype(Pair{} < Pair{});

template <class Real>
using Mask = decltype(Real{} < Real{});

template <class Real>
inline constexpr std::size_t kLanes = sizeof(Real) / sizeof(double);

inline double lane(double value, std::size_t) { return value; }
inline double lane(Pair value, std::size_t i) { return value[i]; }

inline void set_lane(double& value, std::size_t, double to) { value = to; }
inline void set_lane(Pair& value, std::size_t i, double to) { value[i] = to; }

// The same number in every lane.
template <class Real>
Real every(double value) {
  return value - Real{};
}

inline bool is_set(bool mask, std::size_t) { return mask; }
inline bool is_set(PairMask mask, std::size_t i) { return mask[i] != 0; }

inline bool any(bool mask) { return mask; }
inline bool any(PairMask mask) { return (mask[0] | mask[1]) != 0; }

inline bool both(bool a, bool b) { return a && b; }
inline PairMask both(PairMask a, PairMask b) { return a & b; }

inline bool opposite(bool mask) { return !mask; }
inline PairMask opposite(PairMask mask) { return ~mask; }

template <class Real>
Mask<Real> all_lanes() {
  return Real{} == Real{};
}

inline double select(bool mask, double yes, double no) { return mask ? yes : no; }
inline Pair select(PairMask mask, Pair yes, Pair no) { return mask ? yes : no; }

// Exchanges two numbers in some lanes.
template <class Real>
void exchange(Mask<Real> where, Real& a, Real& b) {
  const Real before = a;
  a = select(where, b, a);
  b = select(where, before, b);
}

inline double with_sign(double value, double sign) { return std::copysign(value, sign); }
inline Pair with_sign(Pair value, Pair sign) {
  const auto sign_bit = reinterpret_cast<PairMask>(Pair{-0.0, -0.0});
  return reinterpret_cast<Pair>((~sign_bit & reinterpret_cast<PairMask>(value)) |
                                (sign_bit & reinterpret_cast<PairMask>(sign)));
}

inline double magnitude(double value) { return std::abs(value); }
inline Pair magnitude(Pair value) { return with_sign(value, Pair{}); }

}  // namespace trackservo::sim

#endif
