// SPDX-License-Identifier: Apache-2.0
#include "judge/fault_injection/shaking_gains.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "design/loop_margins.hpp"
#include "machine/base/job_pool.hpp"

namespace trackservo::sim {
namespace {

constexpr double kBefore_s = 2.0;
constexpr double kLongestRun_s = 8.0;  // that a run goes on without being caught,
constexpr double kCalming_s = 1.5;     // and after that
constexpr double kEnd_s = 0.5;         // of it
constexpr double kShareOfTravel = 0.9;
constexpr double kWidestPath_rad = 2.6;  // so that a single-turn encoder knows the turn at the start
constexpr double kSpeedUp_rad_s2 = 1.0;
constexpr double kSlowest_deg_s = 1.0;
constexpr double kFastest_deg_s = 20.0;

double log_uniform(SplitMix64& random, double low, double high) {
  return std::exp(std::log(low) + (std::log(high) - std::log(low)) * random.uniform());
}

// How long an axis may move at this rate with the new gains; its path must fit into its travel.
double longest_s(const NodeSetup& setup, int axis, double rate_rad_s) {
  const protection_limits& limits = setup.limits[static_cast<std::size_t>(axis)];
  const double travel_rad = kShareOfTravel * static_cast<double>(limits.maximum_rad - limits.minimum_rad);
  return std::min(kLongestRun_s,
                  std::min(travel_rad, kWidestPath_rad) / std::max(1e-3, std::abs(rate_rad_s)) - kBefore_s);
}

// The joint's angle at the start, so that half of its path is in either half of the travel.
double start_rad(const NodeSetup& setup, int axis, double rate_rad_s) {
  const protection_limits& limits = setup.limits[static_cast<std::size_t>(axis)];
  const double middle_rad = 0.5 * static_cast<double>(limits.minimum_rad + limits.maximum_rad);
  return middle_rad - 0.5 * rate_rad_s * (kBefore_s + longest_s(setup, axis, rate_rad_s));
}

struct RateRange {
  double low = std::numeric_limits<double>::infinity();
  double high = -std::numeric_limits<double>::infinity();
  void add(double value) {
    low = std::min(low, value);
    high = std::max(high, value);
  }
  double size() const { return std::max(0.0, high - low); }
};

class Shaken {
 public:
  Shaken(const NodeSetup& setup, int axis, double rate_deg_s, std::uint64_t seed)
      : axis_(axis),
        longest_s_(longest_s(setup, axis, rate_deg_s * kRadPerDeg)),
        goal_rad_s_(rate_deg_s * kRadPerDeg),
        node_(setup, seed, angles(setup, axis, rate_deg_s * kRadPerDeg)) {}

  ShakingRun run(const axis_parameters& gains) {
    node_.enable(DRIVE_CYCLIC_VELOCITY);
    for (int i = 0; i < ticks(kBefore_s); ++i) {
      tick();
    }
    apply(gains);
    double end_s = longest_s_;
    for (int i = 0; i < ticks(end_s); ++i) {
      tick();
      note(i * kTick_s, i >= ticks(end_s - kEnd_s));
      end_s = result_.caught_s < 0.0 ? end_s : std::min(longest_s_, result_.caught_s + kCalming_s);
    }
    result_.swing_deg_s = rate_range_.size() / kRadPerDeg;
    return result_;
  }

 private:
  static int ticks(double time_s) { return static_cast<int>(std::lround(time_s / kTick_s)); }

  static std::array<double, kAxes> angles(const NodeSetup& setup, int axis, double rate_rad_s) {
    std::array<double, kAxes> all{};
    for (int each = 0; each < kAxes; ++each) {
      all[static_cast<std::size_t>(each)] = start_rad(setup, each, each == axis ? rate_rad_s : 0.0);
    }
    return all;
  }

  servo_node_axis& moved() { return node_.node().axis[axis_]; }

  void tick() {
    const double step_rad_s = kSpeedUp_rad_s2 * kTick_s;
    rate_rad_s_ += std::clamp(goal_rad_s_ - rate_rad_s_, -step_rad_s, step_rad_s);
    node_.set_rate(axis_, rate_rad_s_);
    node_.tick();
  }

  void apply(const axis_parameters& gains) {
    axis_tuning& tuning = moved().tuning;
    servo_board& board = node_.node().board;
    tuning.staged = gains;
    while (result_.verdict == LOOP_RUNNING) {
      result_.verdict = axis_tuning_judge(&tuning);
    }
    if (axis_tuning_apply(&tuning, &board.app.axis[axis_], &board.app.params.axis[axis_], SERVO_TICK_S) != CONTROL_OK) {
      throw std::runtime_error("the device cannot apply the gains");
    }
  }

  void note(double time_s, bool at_the_end) {
    const auto i = static_cast<std::size_t>(axis_);
    const TruthState& truth = node_.machine().truth();
    const double error_rad_s = rate_rad_s_ - truth.inertial_rate_rad_s[i];
    const double error_deg_s = std::abs(error_rad_s) / kRadPerDeg;
    if (result_.visible_s < 0.0 && error_deg_s > kVisibleShaking_deg_s) {
      result_.visible_s = time_s;
    }
    if (result_.caught_s < 0.0 && (moved().tuning.proven_is_active || moved().drive.fault != FAULT_NONE)) {
      result_.caught_s = time_s;
      result_.taken_back = moved().tuning.proven_is_active;
    }
    if (result_.fault != FAULT_NONE) {
      return;
    }
    result_.fault = moved().drive.fault;
    travel_rad_ += error_rad_s * kTick_s;
    result_.peak_deg_s = std::max(result_.peak_deg_s, error_deg_s);
    result_.travel_deg = std::max(result_.travel_deg, std::abs(travel_rad_) / kRadPerDeg);
    if (at_the_end) {
      result_.after_deg_s = std::max(result_.after_deg_s, error_deg_s);
      rate_range_.add(error_rad_s);
    }
  }

  int axis_;
  double longest_s_;
  double goal_rad_s_;
  double rate_rad_s_ = 0.0;
  double travel_rad_ = 0.0;
  DrivenNode node_;
  RateRange rate_range_;
  ShakingRun result_;
};

std::string text_of(const axis_parameters& p) {
  return fmt::format(
      "2000:1 {:g} 2000:2 {:g} 2020:1 {} 2020:2 {:g} 2020:4 {:g} 2040:1 {:g} 2040:2 {:g} 2040:4 {:g} 2040:5 {:g} "
      "2050:1 {} 2050:3 {}",
      p.speed_loop.proportional_nm_s_rad, p.speed_loop.integral_nm_rad, p.observer.on, p.observer.inertia_kg_m2,
      p.observer.bandwidth_rad_s, p.filters.notch_hz, p.filters.notch_width_hz, p.filters.lowpass_hz,
      p.filters.lowpass_damping, p.sensors.source, p.sensors.window_ticks);
}

// A set, and its runs at rest and moving.
struct Candidate {
  int axis = 0;
  axis_parameters gains{};
  double rate_deg_s[2] = {0.0, 0.0};
  std::uint64_t seed = 0;
  ShakingRun run[2];

  bool shakes() const { return run[0].shakes() || run[1].shakes(); }
};

class Source {
 public:
  Source(const NodeSetup& setup, std::uint64_t seed) : setup_(setup), seed_(seed), random_(seed) {}

  // In range, and unstable in sliding or in pre-sliding by the true plant of the simulation.
  Candidate next() {
    Candidate made;
    made.axis = number_ % kAxes;
    servo_axis_params built;
    do {
      made.gains = random_gains(setup_.parameters[static_cast<std::size_t>(made.axis)], random_);
    } while (axis_parameters_build(&made.gains, &built) != CONTROL_OK ||
             speed_loop_is_stable(setup_.plant, made.axis, built.speed));
    const double direction = random_.uniform() < 0.5 ? -1.0 : 1.0;
    made.rate_deg_s[1] = direction * log_uniform(random_, kSlowest_deg_s, kFastest_deg_s);
    made.seed = SplitMix64::mix(seed_ * 1000000 + static_cast<std::uint64_t>(number_));
    number_++;
    return made;
  }

 private:
  const NodeSetup& setup_;
  std::uint64_t seed_;
  SplitMix64 random_;
  int number_ = 0;
};

void add(ShakingGains& result, const Candidate& set) {
  (set.shakes() ? result.sets : result.quiet_sets)++;
  for (int moving = 0; moving < 2; ++moving) {
    const ShakingRun& run = set.run[moving];
    ShakingRow& row = result.rows[2 * static_cast<std::size_t>(set.axis) + static_cast<std::size_t>(moving)];
    row.runs++;
    row.refused += run.verdict == LOOP_REFUSED ? 1 : 0;
    const std::string problem = run.verdict == LOOP_REFUSED ? shaking_problem(run, set.rate_deg_s[moving])
                                                            : "the device does not refuse the set";
    if (!problem.empty()) {
      result.errors.push_back(fmt::format("{} at {:.2f} deg/s, {}: {}", axis_name(set.axis), set.rate_deg_s[moving],
                                          text_of(set.gains), problem));
    }
    if (!run.shakes()) {
      row.calm_deg_s = std::max(row.calm_deg_s, run.swing_deg_s);
      continue;
    }
    row.shook++;
    row.caught += problem.empty() ? 1 : 0;
    row.longest_s = std::max(row.longest_s, run.seen_for_s());
    row.longest_from_gains_s = std::max(row.longest_from_gains_s, run.caught_s);
    row.peak_deg_s = std::max(row.peak_deg_s, run.peak_deg_s);
    row.travel_deg = std::max(row.travel_deg, run.travel_deg);
  }
}

}  // namespace

axis_parameters random_gains(const axis_parameters& good, SplitMix64& random) {
  const auto yes = [&](double share) { return random.uniform() < share; };
  const auto between = [&](double low, double high) { return static_cast<float>(log_uniform(random, low, high)); };
  axis_parameters p = good;
  if (yes(0.5)) {
    p.speed_loop.proportional_nm_s_rad = between(10.0, 1e6);
  }
  if (yes(0.5)) {
    p.speed_loop.integral_nm_rad = between(100.0, 1e8);
  }
  if (yes(0.3)) {
    p.observer.inertia_kg_m2 = between(0.1, 1000.0);
  }
  if (yes(0.3)) {
    p.observer.bandwidth_rad_s = between(1.0, 1000.0);
  }
  if (yes(0.2)) {
    p.observer.on = 0;
  }
  if (yes(0.3)) {
    p.filters.lowpass_hz = between(1.0, 490.0);
    p.filters.lowpass_damping = between(0.1, 2.0);
  }
  if (yes(0.2)) {
    p.filters.notch_hz = between(2.0, 400.0);
    p.filters.notch_width_hz = p.filters.notch_hz * between(0.01, 1.0);
  }
  if (yes(0.3)) {
    p.sensors.window_ticks = 2 + static_cast<std::uint32_t>(random() % 15);
  }
  if (yes(0.2)) {
    p.sensors.source = static_cast<std::uint32_t>(random() % 3);
  }
  return p;
}

double ShakingRun::seen_for_s() const { return visible_s < 0.0 ? 0.0 : std::max(0.0, caught_s - visible_s); }

ShakingRun shake(const NodeSetup& setup, int axis, const axis_parameters& gains, double rate_deg_s,
                 std::uint64_t seed) {
  return Shaken(setup, axis, rate_deg_s, seed).run(gains);
}

std::string shaking_problem(const ShakingRun& run, double rate_deg_s) {
  if (!run.shakes()) {
    return "";
  }
  const std::string figures = fmt::format(
      "fault {}, visible after {:.3f} s, ended after {:.3f} s, peak {:.2f} deg/s, travel {:.3f} deg, {:.2f} deg/s at "
      "the end",
      static_cast<int>(run.fault), run.visible_s, run.caught_s, run.peak_deg_s, run.travel_deg, run.after_deg_s);
  if (!run.taken_back || run.fault != FAULT_NONE) {
    return "is not taken back; " + figures;
  }
  const double peak_deg_s = rate_deg_s == 0.0 ? kShakingAtRest_deg_s : kShakingMoving_deg_s;
  const bool within = run.seen_for_s() <= kLongestShaking_s && run.peak_deg_s <= peak_deg_s &&
                      run.travel_deg <= kShakingTravel_deg && run.after_deg_s <= kVisibleShaking_deg_s;
  return within ? "" : "exceeds a limit; " + figures;
}

ShakingGains run_shaking_gains(const PlantConfig& plant, const ShakingOptions& options,
                               std::function<void(int, int, const std::string&)> progress) {
  const NodeSetup setup(plant);
  Source source(setup, options.seed);
  ShakingGains result;
  for (int axis = 0; axis < kAxes; ++axis) {
    for (const bool moving : {false, true}) {
      result.rows.push_back({});
      result.rows.back().axis = axis;
      result.rows.back().moving = moving;
    }
  }
  JobPool pool(options.threads, options.sets, std::move(progress));
  while (result.sets < options.sets) {
    std::vector<Candidate> batch;
    for (int i = result.sets; i < options.sets; ++i) {
      batch.push_back(source.next());
    }
    pool.run(batch.size(), [&](std::size_t i) {
      Candidate& set = batch[i];
      for (int moving = 0; moving < 2; ++moving) {
        set.run[moving] = shake(setup, set.axis, set.gains, set.rate_deg_s[moving], set.seed);
      }
      return std::string(axis_name(set.axis));
    });
    for (const Candidate& set : batch) {
      add(result, set);
    }
  }
  return result;
}

std::string print(const ShakingGains& result) {
  std::string text =
      fmt::format("{:<16} {:>5} {:>8} {:>6} {:>7} {:>9} {:>11} {:>11} {:>9} {:>11}\n", "axis", "runs", "refused",
                  "shook", "caught", "after, s", "of gains, s", "peak, deg/s", "path, deg", "calm, deg/s");
  for (const ShakingRow& row : result.rows) {
    text += fmt::format("{:<16} {:>5} {:>8} {:>6} {:>7} {:>9.3f} {:>11.3f} {:>11.2f} {:>9.3f} {:>11.2f}\n",
                        fmt::format("{}{}", axis_name(row.axis), row.moving ? ", moving" : ", at rest"), row.runs,
                        row.refused, row.shook, row.caught, row.longest_s, row.longest_from_gains_s, row.peak_deg_s,
                        row.travel_deg, row.calm_deg_s);
  }
  text += fmt::format("{} sets shake; {} others are unstable, but neither motion exceeded 1 deg/s.\n", result.sets,
                      result.quiet_sets);
  for (const std::string& error : result.errors) {
    text += error + "\n";
  }
  return text;
}

}  // namespace trackservo::sim
