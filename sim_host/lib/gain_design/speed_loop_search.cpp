// SPDX-License-Identifier: Apache-2.0
#include "gain_design/speed_loop_search.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "gain_design/speed_loop_pi.hpp"

namespace trackservo::gain_design {
namespace {

// A measured margin is up to this below the computed one.
constexpr double kGainReserve_db = 0.5;
constexpr double kPhaseReserve_deg = 2.0;

constexpr double kStep = 0.95;  // ratio from one try to the next
constexpr int kSteps = 90;      // down to a hundredth

constexpr double kMaxObserver_rad_s = 999.0;  // the firmware accepts up to one per tick
constexpr double kMaxNatural_rad_s = 900.0;   // beyond 300 Hz of bandwidth

// Observers slower than half of the PI add nothing to it; faster than four times, they leave the PI nothing to do.
constexpr double kObserverRatios[] = {0.5, 0.7, 1.0, 1.4, 2.0, 2.8, 4.0};

// Coordinates of the search for the least error, as logarithms: they are changed by a step, which is halved when no
// change is better. The natural frequency is a share of the highest one that is good with the others, so that the
// search goes along the limits that margins and noise set.
enum Coordinate { kDamping, kRatio, kCrossover, kShare, kCoordinates };
using Point = std::array<double, kCoordinates>;
constexpr double kNone = -std::numeric_limits<double>::infinity();
constexpr double kFirstStep = 0.32;
constexpr double kLastStep = 0.04;

struct Bounds {
  double lowest;
  double highest;
};

// What the search may choose, by coordinate. Below a damping of 0.4 a step of the set-point overshoots by more than
// half. A crossover below 8 Hz lets more of a mast's sway through than it saves in noise of the gyro.
constexpr Bounds kBounds[kCoordinates] = {{0.4, 2.0}, {0.25, 8.0}, {8.0 / kHzPerRad_s, 50.0 / kHzPerRad_s}, {0.1, 1.0}};

bool is_within_bounds(int coordinate, const Point& x) {
  constexpr double kRounding = 1e-9;
  const double value = std::exp(x[static_cast<std::size_t>(coordinate)]);
  return value >= kBounds[coordinate].lowest * (1.0 - kRounding) &&
         value <= kBounds[coordinate].highest * (1.0 + kRounding);
}

}  // namespace

double SpeedLoopSearch::merit(const SpeedLoopGains& gains) const {
  if (!demand_.for_least_error) {
    return 2.0 * std::log(gains.natural_rad_s) + std::log(gains.observer_rad_s);
  }
  return -std::log(
      rate_error(demand_.machines.front(), loop_with(gains), demand_.disturbance.value(), demand_.noise).rad_s());
}

speed_loop_params SpeedLoopSearch::loop_with(const SpeedLoopGains& gains) const {
  speed_loop_params loop = loop_;
  const PiRequirement pi{gains.natural_rad_s, gains.damping, static_cast<double>(loop_.pi.setpoint_weight)};
  loop.pi = pi_params(pi, demand_.machines.front().inertia_kg_m2);
  loop.observer_on = true;
  loop.observer.bandwidth_rad_s = static_cast<float>(gains.observer_rad_s);
  loop.rate_fusion.crossover_rad_s = static_cast<float>(gains.crossover_rad_s);
  return loop;
}

SpeedLoopVerdict SpeedLoopSearch::judge(const SpeedLoopGains& gains) const {
  const speed_loop_params loop = loop_with(gains);
  SpeedLoopVerdict verdict;
  verdict.stable = is_stable(demand_.machines, loop);
  verdict.margins = worst_margins(demand_.machines, loop);
  for (const LinearMachine& machine : demand_.machines) {
    verdict.torque_noise_nm = std::max(verdict.torque_noise_nm, torque_noise_nm(machine, loop, demand_.noise));
  }
  return verdict;
}

bool SpeedLoopSearch::is_good(const SpeedLoopGains& gains, Reserve reserve) {
  const speed_loop_params loop = loop_with(gains);
  if (speed_loop_check(&loop, SERVO_TICK_S) != CONTROL_OK) {
    return false;
  }
  MinMargins least = demand_.least;
  if (reserve == Reserve::kKept) {
    least.gain_margin_db += kGainReserve_db;
    least.phase_margin_deg += kPhaseReserve_deg;
  }
  const SpeedLoopVerdict verdict = judge(gains);
  const bool in_command = verdict.stable && keeps_margins(verdict.margins, least);
  const bool quiet = verdict.torque_noise_nm <= demand_.max_torque_noise_nm;
  noise_refused_ = noise_refused_ || (in_command && !quiet);
  return in_command && quiet;
}

SpeedLoopGains SpeedLoopSearch::gains(double natural_rad_s, double observer_rad_s) const {
  return {natural_rad_s, requirement_.damping.value_or(1.0), observer_rad_s,
          static_cast<double>(loop_.rate_fusion.crossover_rad_s)};
}

std::optional<SpeedLoopGains> SpeedLoopSearch::first_good(SpeedLoopGains gains, bool natural_falls,
                                                          bool observer_falls) {
  for (int step = 0; step <= kSteps; ++step) {
    if (is_good(gains, Reserve::kKept)) {
      return gains;
    }
    gains.natural_rad_s *= natural_falls ? kStep : 1.0;
    gains.observer_rad_s *= observer_falls ? kStep : 1.0;
  }
  return std::nullopt;
}

std::optional<SpeedLoopGains> SpeedLoopSearch::best_of_both() {
  std::optional<SpeedLoopGains> best;
  for (const double ratio : kObserverRatios) {
    const double natural_rad_s = std::min(kMaxNatural_rad_s, kMaxObserver_rad_s / ratio);
    const auto found = first_good(gains(natural_rad_s, ratio * natural_rad_s), true, true);
    if (found && (!best || merit(*found) > merit(*best))) {
      best = found;
    }
  }
  return best;
}

std::optional<double> SpeedLoopSearch::highest_natural_rad_s(SpeedLoopGains gains) {
  constexpr double kFactor = 1.2;
  constexpr int kHalvings = 5;  // to half a percent
  const double ratio = gains.observer_rad_s / gains.natural_rad_s;
  const double limit_rad_s = std::min(kMaxNatural_rad_s, kMaxObserver_rad_s / ratio);
  const auto good_at = [&](double natural_rad_s) {
    gains.natural_rad_s = natural_rad_s;
    gains.observer_rad_s = ratio * natural_rad_s;
    return is_good(gains, Reserve::kKept);
  };
  double good_rad_s = std::min(gains.natural_rad_s, limit_rad_s);
  for (int step = 0; !good_at(good_rad_s); ++step) {
    if (step == kSteps) {
      return std::nullopt;
    }
    good_rad_s /= kFactor;
  }
  double bad_rad_s = kFactor * good_rad_s;
  while (bad_rad_s < limit_rad_s && good_at(bad_rad_s)) {
    good_rad_s = bad_rad_s;
    bad_rad_s *= kFactor;
  }
  for (int i = 0; i < kHalvings; ++i) {
    const double middle_rad_s = std::sqrt(good_rad_s * bad_rad_s);
    (middle_rad_s <= limit_rad_s && good_at(middle_rad_s) ? good_rad_s : bad_rad_s) = middle_rad_s;
  }
  return good_rad_s;
}

// Hooke and Jeeves, J. ACM 8, 1961: one coordinate at a time; after a better point, the whole change once more. NLopt,
// which searches the best PI of a study, is no static library, and this program goes into a wheel.
class SpeedLoopSearch::LeastError {
 public:
  LeastError(SpeedLoopSearch& search, const SpeedLoopGains& start)
      : search_(search),
        best_(start),
        most_(search.merit(start)),
        x_{std::log(start.damping), std::log(start.observer_rad_s / start.natural_rad_s),
           std::log(start.crossover_rad_s), 0.0} {}

  SpeedLoopGains run() {
    for (const double damping : {0.5, 0.6, 0.7, 1.0}) {
      for (const double ratio : {1.0, 1.4, 2.0, 2.8}) {
        const Point start = x_;
        (void)attempt(
            {is_free(kDamping) ? std::log(damping) : start[kDamping], std::log(ratio), start[kCrossover], 0.0});
      }
    }
    for (double step = kFirstStep; step >= kLastStep;) {
      const Point before = x_;
      if (!explore(before, step)) {
        step *= 0.5;
        continue;
      }
      Point ahead;
      for (std::size_t i = 0; i < ahead.size(); ++i) {
        ahead[i] = 2.0 * x_[i] - before[i];
      }
      (void)explore(ahead, step);
    }
    return best_;
  }

 private:
  bool is_free(int coordinate) const {
    return (coordinate != kDamping || !search_.requirement_.damping) &&
           (coordinate != kCrossover || search_.loop_.rate_fusion.source == RATE_FUSED);
  }

  // Keeps a better point. Returns its merit; what is not free stays exactly as it was at the start.
  double attempt(const Point& x) {
    for (int coordinate = 0; coordinate < kCoordinates; ++coordinate) {
      if (is_free(coordinate) && !is_within_bounds(coordinate, x)) {
        return kNone;
      }
    }
    SpeedLoopGains gains = best_;
    gains.damping = is_free(kDamping) ? std::exp(x[kDamping]) : best_.damping;
    gains.crossover_rad_s = is_free(kCrossover) ? std::exp(x[kCrossover]) : best_.crossover_rad_s;
    gains.observer_rad_s = std::exp(x[kRatio]) * gains.natural_rad_s;
    const std::optional<double> highest_rad_s = search_.highest_natural_rad_s(gains);
    if (!highest_rad_s) {
      return kNone;
    }
    gains.natural_rad_s = std::exp(x[kShare]) * *highest_rad_s;
    gains.observer_rad_s = std::exp(x[kRatio]) * gains.natural_rad_s;
    if (!search_.is_good(gains, Reserve::kKept)) {
      return kNone;
    }
    const double merit = search_.merit(gains);
    if (merit > most_ + kWorthwhile) {
      most_ = merit;
      best_ = gains;
      x_ = x;
    }
    return merit;
  }

  // Looks around `x`. Returns whether a better point than before was found.
  bool explore(Point x, double step) {
    const double before = most_;
    double here = attempt(x);
    for (int coordinate = 0; coordinate < kCoordinates; ++coordinate) {
      for (const double change : {step, -step}) {
        Point other = x;
        other[static_cast<std::size_t>(coordinate)] += change;
        const double there = is_free(coordinate) ? attempt(other) : kNone;
        if (there > here) {
          x = other;
          here = there;
          break;
        }
      }
    }
    return most_ > before;
  }

  static constexpr double kWorthwhile = 1e-4;  // of the error

  SpeedLoopSearch& search_;
  SpeedLoopGains best_;
  double most_;
  Point x_;
};

SpeedLoopGains SpeedLoopSearch::fastest() const {
  constexpr double kMaxRatio = 4.0;
  if (requirement_.natural_rad_s) {
    return gains(*requirement_.natural_rad_s, requirement_.observer_rad_s.value_or(std::min(
                                                  kMaxRatio * *requirement_.natural_rad_s, kMaxObserver_rad_s)));
  }
  const double observer_rad_s = requirement_.observer_rad_s.value_or(kMaxObserver_rad_s);
  return gains(std::min(kMaxRatio * observer_rad_s, kMaxNatural_rad_s), observer_rad_s);
}

SpeedLoopGains SpeedLoopSearch::slowest() const {
  const double share = std::pow(kStep, kSteps);
  return gains(share * fastest().natural_rad_s, share * fastest().observer_rad_s);
}

std::optional<SpeedLoopGains> SpeedLoopSearch::best() {
  if (!requirement_.natural_rad_s && !requirement_.observer_rad_s) {
    const std::optional<SpeedLoopGains> start = best_of_both();
    return start && demand_.for_least_error ? LeastError(*this, *start).run() : start;
  }
  const SpeedLoopGains required = fastest();
  if (requirement_.natural_rad_s && requirement_.observer_rad_s && is_good(required, Reserve::kNone)) {
    return required;
  }
  const std::optional<SpeedLoopGains> found = requirement_.natural_rad_s
                                                  ? first_good(required, false, true)   // the observer is reduced
                                                  : first_good(required, true, false);  // the PI is free
  return found ? found : first_good(required, true, true);
}

}  // namespace trackservo::gain_design
