// Which numbers that the paper does not print would reproduce both of its figures, the sine of Fig. 7 and the step of
// Fig. 9?
//
// Inertia, sigma0, sigma1 and sigma2 are published. Tc, Ts, the Stribeck speed, the PI gains and the entry point of the
// disturbance of Fig. 9 are not. The scan draws those at random. Each set is an axis of eq. (6) with LuGre friction,
// eqs (1)-(3), under PI alone: ideal torque and ideal measurement, one PI tick per millisecond. A set matches when its
// speed error on the sine is that of Fig. 7. Its step is compared with the same step without friction in both readings
// of "the overshoot increases by 25 %": as a difference in points of the set-point, and as a ratio of the two
// overshoots.
#ifndef TRACKSERVO_SIM_STUDIES_FIG9_SCAN_FIG9_SCAN_HPP
#define TRACKSERVO_SIM_STUDIES_FIG9_SCAN_FIG9_SCAN_HPP

#include <cstdint>
#include <string>
#include <vector>

#include "base/job_pool.hpp"
#include "studies/shared/campaign_options.hpp"
#include "studies/shared/derived.hpp"

namespace trackservo::sim {

constexpr double kFig7Low_deg_s = 0.2;  // the sine's peak error as read off Fig. 7
constexpr double kFig7High_deg_s = 0.3;

enum class Fig9Disturbance {
  kSpeed,
  kTorque
};  // added to the axis' speed, or a torque that alone would cause that speed

// Numbers that the paper does not print.
struct Fig9Set {
  double coulomb_nm = 10.0;              // 0.2 .. 40, logarithmic
  double breakaway_share = 1.4;          // Ts / Tc, 1 .. 2.5
  double stribeck_speed_deg_s = 0.5;     // 0.05 .. 3, logarithmic
  double natural_frequency_rad_s = 6.5;  // 1.6 .. 100, logarithmic
  double damping = 1.0;                  // 0.3 .. 2
  double setpoint_weight = 1.0;          // 0, 0.5 or 1
  Fig9Disturbance disturbance = Fig9Disturbance::kTorque;
  double disturbance_phase_rad = 0.0;  // of its sine at the step, 0 .. 2 pi
};

struct Fig9Outcome {
  Fig9Set set;
  double sine_error_deg_s = 0;  // peak after the first period
  double overshoot = 0;         // of the disturbed step [%]
  double free_overshoot = 0;    // the same without friction [%]

  bool matches_fig7() const { return sine_error_deg_s >= kFig7Low_deg_s && sine_error_deg_s <= kFig7High_deg_s; }
  double points() const { return overshoot - free_overshoot; }
  bool has_ratio() const { return free_overshoot >= kMinFreeOvershoot; }
  double ratio() const { return overshoot / free_overshoot; }
};

// "The overshoot increases by 25 %", as the experiment step_disturbed gives it.
struct Fig9Paper {
  double points = 0;
  double ratio = 0;
};

struct Fig9Setup {
  AxisConfig axis;                // with the published numbers; motor and sensors are not used
  ScenarioConfig sine;            // of Fig. 7
  ScenarioConfig disturbed_step;  // of Fig. 9
  Fig9Paper paper;
  int samples = 6000;
  std::uint64_t seed = 1;
  int threads = usable_threads();
};

struct Fig9Summary {
  int matching = 0;           // sets that reproduce Fig. 7
  int matching_points = 0;    // of them: at least 25 points above friction-free
  int matching_ratio = 0;     // of them: at least 1.25 times the friction-free overshoot
  Fig9Outcome max_points;     // of the matching ones
  Fig9Outcome nearest_ratio;  // of the matching ones: ratio nearest to 1.25
  Fig9Outcome max_ratio;      // of the matching ones
  int any_points = 0;         // of all sets, regardless of their sine: at least 25 points
  double any_most_points = 0;
};

// Set number `index` of a seed; the same on every machine.
Fig9Set fig9_set(std::uint64_t seed, int index);

Fig9Outcome try_fig9_set(const Fig9Setup& setup, const Fig9Set& set);

// Every set, in order. Progress counts sets.
std::vector<Fig9Outcome> scan_fig9(const Fig9Setup& setup, const Progress& progress);

// Throws std::runtime_error when no set matches Fig. 7.
Fig9Summary summary_of(const std::vector<Fig9Outcome>& outcomes, const Fig9Paper& paper);

}  // namespace trackservo::sim

#endif
