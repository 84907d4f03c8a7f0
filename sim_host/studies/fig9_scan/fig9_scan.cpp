#include "studies/fig9_scan/fig9_scan.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "base/axis.hpp"
#include "base/job_pool.hpp"
#include "base/random.hpp"
#include "plant/joint.hpp"

namespace trackservo::sim {
namespace {

constexpr int kStepsPerTick = 1;  // four of them change no overshoot of the scan by 0.01 points

double logarithmic(RandomStream& random, double low, double high) {
  return low * std::pow(high / low, random.uniform());
}

double linear(RandomStream& random, double low, double high) { return low + (high - low) * random.uniform(); }

AxisConfig axis_of(const Fig9Setup& setup, const Fig9Set& set) {
  AxisConfig axis = setup.axis;
  for (StribeckConfig *direction : {&axis.friction.positive, &axis.friction.negative}) {
    direction->coulomb_nm = set.coulomb_nm;
    direction->breakaway_nm = set.breakaway_share * set.coulomb_nm;
    direction->stribeck_speed_rad_s = set.stribeck_speed_deg_s / kDegPerRad;
  }
  return axis;
}

// u = kp (b r - y) + i, as in the firmware's pi_controller.h, with ideal torque.
struct Pi {
  double proportional;
  double integral;
  double setpoint_weight;
  double held_nm = 0.0;

  Pi(const Fig9Set& set, double inertia_kg_m2)
      : proportional(2.0 * set.damping * set.natural_frequency_rad_s * inertia_kg_m2),
        integral(set.natural_frequency_rad_s * set.natural_frequency_rad_s * inertia_kg_m2),
        setpoint_weight(set.setpoint_weight) {}

  double tick(double reference_rad_s, double measured_rad_s) {
    const double torque_nm = proportional * (setpoint_weight * reference_rad_s - measured_rad_s) + held_nm;
    held_nm += kTick_s * integral * (reference_rad_s - measured_rad_s);
    return torque_nm;
  }
};

// Runs the axis; `reference` and `disturbance` return rad/s at a time from the start of the motion, and `look` receives
// the speed at every tick.
template <class Reference, class Disturbance, class Look>
void run(const AxisConfig& axis, FrictionModel friction, const Fig9Set& set, const ScenarioConfig& scenario,
         Reference reference, Disturbance disturbance, Look look) {
  const double step_s = kTick_s / kStepsPerTick;
  Joint joint(axis, friction, MaxwellSlipConfig{}, step_s);
  joint.place(0.0);
  Pi pi(set, axis.inertia_kg_m2);
  const bool as_speed = set.disturbance == Fig9Disturbance::kSpeed;
  const auto ticks = static_cast<int>(std::lround((scenario.duration_s - scenario.rest_s) / kTick_s));
  for (int tick = 0; tick < ticks; ++tick) {
    const double time_s = tick * kTick_s;
    const double speed_rad_s = joint.rate_rad_s() + (as_speed ? disturbance(time_s) : 0.0);
    look(time_s, speed_rad_s);
    const double torque_nm = pi.tick(reference(time_s), speed_rad_s);
    for (int step = 0; step < kStepsPerTick; ++step) {
      const double now_s = time_s + step * step_s;
      // The torque's impulse over the step: it changes the speed of the bare inertia exactly by the disturbance.
      const double pushed_nm =
          as_speed ? 0.0 : axis.inertia_kg_m2 * (disturbance(now_s + step_s) - disturbance(now_s)) / step_s;
      joint.step(axis.inertia_kg_m2, torque_nm + pushed_nm, 0.0);
    }
  }
}

double sine_error_deg_s(const Fig9Setup& setup, const Fig9Set& set) {
  const ScenarioConfig& sine = setup.sine;
  const double w = 2.0 * kPi * sine.frequency_hz;
  const auto reference = [&](double time_s) { return sine.speeds_rad_s.front() * std::sin(w * time_s); };
  double peak_rad_s = 0.0;
  run(
      axis_of(setup, set), FrictionModel::kLugre, set, sine, reference, [](double) { return 0.0; },
      [&](double time_s, double speed_rad_s) {
        if (time_s >= sine.settle_s) {
          peak_rad_s = std::max(peak_rad_s, std::abs(reference(time_s) - speed_rad_s));
        }
      });
  return kDegPerRad * peak_rad_s;
}

double overshoot(const Fig9Setup& setup, const Fig9Set& set, FrictionModel friction) {
  const ScenarioConfig& step = setup.disturbed_step;
  const double speed_rad_s = step.speeds_rad_s.front();
  const double w = 2.0 * kPi * step.disturbance_frequency_hz;
  double highest = 1.0;
  run(
      axis_of(setup, set), friction, set, step, [&](double) { return speed_rad_s; },
      [&](double time_s) {
        return step.disturbance_amplitude_rad_s * std::sin(w * time_s + set.disturbance_phase_rad);
      },
      [&](double, double now_rad_s) { highest = std::max(highest, now_rad_s / speed_rad_s); });
  return 100.0 * (highest - 1.0);
}

}  // namespace

Fig9Set fig9_set(std::uint64_t seed, int index) {
  RandomStream random(seed, "fig9", index);
  Fig9Set set;
  set.coulomb_nm = logarithmic(random, 0.2, 40.0);
  set.breakaway_share = linear(random, 1.0, 2.5);
  set.stribeck_speed_deg_s = logarithmic(random, 0.05, 3.0);
  set.natural_frequency_rad_s = logarithmic(random, 1.6, 100.0);
  set.damping = linear(random, 0.3, 2.0);
  set.setpoint_weight = 0.5 * std::floor(3.0 * random.uniform());
  set.disturbance = random.uniform() < 0.5 ? Fig9Disturbance::kSpeed : Fig9Disturbance::kTorque;
  set.disturbance_phase_rad = linear(random, 0.0, 2.0 * kPi);
  return set;
}

Fig9Outcome try_fig9_set(const Fig9Setup& setup, const Fig9Set& set) {
  return {set, sine_error_deg_s(setup, set), overshoot(setup, set, FrictionModel::kLugre),
          overshoot(setup, set, FrictionModel::kNone)};
}

std::vector<Fig9Outcome> scan_fig9(const Fig9Setup& setup, const Progress& progress) {
  std::vector<Fig9Outcome> outcomes(static_cast<std::size_t>(setup.samples));
  JobPool pool(setup.threads, setup.samples, progress);
  pool.run(outcomes.size(), [&](std::size_t i) {
    outcomes[i] = try_fig9_set(setup, fig9_set(setup.seed, static_cast<int>(i)));
    return std::string("sets of unpublished numbers for Fig. 9");
  });
  return outcomes;
}

Fig9Summary summary_of(const std::vector<Fig9Outcome>& outcomes, const Fig9Paper& paper) {
  Fig9Summary summary;
  const auto far = [&](const Fig9Outcome& outcome) { return std::abs(outcome.ratio() - paper.ratio); };
  bool has_ratio = false;
  for (const Fig9Outcome& outcome : outcomes) {
    summary.any_points += outcome.points() >= paper.points ? 1 : 0;
    summary.any_most_points = std::max(summary.any_most_points, outcome.points());
    if (!outcome.matches_fig7()) {
      continue;
    }
    if (summary.matching++ == 0 || outcome.points() > summary.max_points.points()) {
      summary.max_points = outcome;
    }
    summary.matching_points += outcome.points() >= paper.points ? 1 : 0;
    if (!outcome.has_ratio()) {
      continue;
    }
    summary.matching_ratio += outcome.ratio() >= paper.ratio ? 1 : 0;
    if (!has_ratio || far(outcome) < far(summary.nearest_ratio)) {
      summary.nearest_ratio = outcome;
    }
    if (!has_ratio || outcome.ratio() > summary.max_ratio.ratio()) {
      summary.max_ratio = outcome;
    }
    has_ratio = true;
  }
  if (!has_ratio) {
    throw std::runtime_error("no set reproduces the sine of Fig. 7: draw more with --samples; 6000 is usual");
  }
  return summary;
}

}  // namespace trackservo::sim
