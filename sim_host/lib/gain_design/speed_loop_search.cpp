// SPDX-License-Identifier: Apache-2.0
#include "gain_design/speed_loop_search.hpp"

#include <algorithm>
#include <cmath>

#include "gain_design/speed_loop_pi.hpp"

namespace trackservo::gain_design {
namespace {

// A measured margin is up to this below the computed one.
constexpr double kGainReserve_db = 0.5;
constexpr double kPhaseReserve_deg = 2.0;

constexpr double kStep = 0.95;  // ratio from one tried pair to the next
constexpr int kSteps = 90;      // down to a hundredth

constexpr double kMaxObserver_rad_s = 999.0;  // the firmware accepts up to one per tick
constexpr double kMaxNatural_rad_s = 900.0;   // beyond 300 Hz of bandwidth

// Observers slower than half of the PI add nothing to it; faster than four times, they leave the PI nothing to do.
constexpr double kObserverRatios[] = {0.5, 0.7, 1.0, 1.4, 2.0, 2.8, 4.0};

}  // namespace

double rejection(const SpeedLoopPair& pair) {
  return 2.0 * std::log(pair.natural_rad_s) + std::log(pair.observer_rad_s);
}

speed_loop_params SpeedLoopSearch::loop_with(const SpeedLoopPair& pair) const {
  speed_loop_params loop = loop_;
  const PiRequirement pi{pair.natural_rad_s, requirement_.damping, static_cast<double>(loop_.pi.setpoint_weight)};
  loop.pi = pi_params(pi, demand_.machines.front().inertia_kg_m2);
  loop.observer_on = true;
  loop.observer.bandwidth_rad_s = static_cast<float>(pair.observer_rad_s);
  return loop;
}

SpeedLoopVerdict SpeedLoopSearch::judge(const SpeedLoopPair& pair) const {
  const speed_loop_params loop = loop_with(pair);
  SpeedLoopVerdict verdict;
  verdict.stable = is_stable(demand_.machines, loop);
  verdict.margins = worst_margins(demand_.machines, loop);
  for (const LinearMachine& machine : demand_.machines) {
    verdict.torque_noise_nm = std::max(verdict.torque_noise_nm, torque_noise_nm(machine, loop, demand_.noise));
  }
  return verdict;
}

bool SpeedLoopSearch::is_good(const SpeedLoopPair& pair, Reserve reserve) {
  const speed_loop_params loop = loop_with(pair);
  if (speed_loop_check(&loop, SERVO_TICK_S) != CONTROL_OK) {
    return false;
  }
  MinMargins least = demand_.least;
  if (reserve == Reserve::kKept) {
    least.gain_margin_db += kGainReserve_db;
    least.phase_margin_deg += kPhaseReserve_deg;
  }
  const SpeedLoopVerdict verdict = judge(pair);
  const bool in_command = verdict.stable && keeps_margins(verdict.margins, least);
  const bool quiet = verdict.torque_noise_nm <= demand_.max_torque_noise_nm;
  noise_refused_ = noise_refused_ || (in_command && !quiet);
  return in_command && quiet;
}

std::optional<SpeedLoopPair> SpeedLoopSearch::first_good(SpeedLoopPair pair, bool natural_falls, bool observer_falls) {
  for (int step = 0; step <= kSteps; ++step) {
    if (is_good(pair, Reserve::kKept)) {
      return pair;
    }
    pair.natural_rad_s *= natural_falls ? kStep : 1.0;
    pair.observer_rad_s *= observer_falls ? kStep : 1.0;
  }
  return std::nullopt;
}

std::optional<SpeedLoopPair> SpeedLoopSearch::best_of_both() {
  std::optional<SpeedLoopPair> best;
  for (const double ratio : kObserverRatios) {
    const double natural_rad_s = std::min(kMaxNatural_rad_s, kMaxObserver_rad_s / ratio);
    const auto pair = first_good({natural_rad_s, ratio * natural_rad_s}, true, true);
    if (pair && (!best || rejection(*pair) > rejection(*best))) {
      best = pair;
    }
  }
  return best;
}

SpeedLoopPair SpeedLoopSearch::fastest() const {
  constexpr double kMaxRatio = 4.0;
  if (requirement_.natural_rad_s) {
    return {*requirement_.natural_rad_s, requirement_.observer_rad_s.value_or(
                                             std::min(kMaxRatio * *requirement_.natural_rad_s, kMaxObserver_rad_s))};
  }
  const double observer_rad_s = requirement_.observer_rad_s.value_or(kMaxObserver_rad_s);
  return {std::min(kMaxRatio * observer_rad_s, kMaxNatural_rad_s), observer_rad_s};
}

SpeedLoopPair SpeedLoopSearch::slowest() const {
  const double share = std::pow(kStep, kSteps);
  return {share * fastest().natural_rad_s, share * fastest().observer_rad_s};
}

std::optional<SpeedLoopPair> SpeedLoopSearch::best() {
  if (!requirement_.natural_rad_s && !requirement_.observer_rad_s) {
    return best_of_both();
  }
  const SpeedLoopPair required = fastest();
  if (requirement_.natural_rad_s && requirement_.observer_rad_s && is_good(required, Reserve::kNone)) {
    return required;
  }
  std::optional<SpeedLoopPair> pair = requirement_.natural_rad_s
                                          ? first_good(required, false, true)   // the observer is reduced
                                          : first_good(required, true, false);  // the PI is free
  return pair ? pair : first_good(required, true, true);
}

}  // namespace trackservo::gain_design
