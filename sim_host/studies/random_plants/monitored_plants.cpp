// SPDX-License-Identifier: Apache-2.0
#include "studies/random_plants/monitored_plants.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <mutex>
#include <set>
#include <stdexcept>

#include "design/commissioning/commissioning.hpp"
#include "device/driven_node.hpp"
#include "device/node_setup.hpp"
#include "judge/fault_injection/soak.hpp"
#include "machine/target/fly_by.hpp"
#include "studies/random_plants/random_plant.hpp"
#include "studies/shared/experiment.hpp"

namespace trackservo::sim {
namespace {

constexpr int kSoakTasks = 6;  // of ten seconds
constexpr std::array<double, kAxes> kMiddle_rad = {0.0, 0.6};
constexpr double kCountsPerRad = 1e7;
constexpr double kCountsPerRad_s = 1e6;
constexpr int kSettleTicks = 300;
constexpr int kStartTicks = 5000;     // until an experiment must have been accepted
constexpr double kStrayShare = 0.05;  // share of its travel: an experiment may begin this far from its place
constexpr double kJerkTime_s = 0.02;
constexpr double kNewGains_s = 12.0;  // longer than gains count as new

// What a first look finds: this machine's own numbers.
commissioning::RoughMachine rough_machine(const PlantConfig& plant, int axis) {
  const AxisConfig& config = plant.axis[static_cast<std::size_t>(axis)];
  const StribeckConfig& positive = config.friction.positive;
  const StribeckConfig& negative = config.friction.negative;
  const double coulomb_nm = 0.5 * (positive.coulomb_nm + negative.coulomb_nm);
  return {coulomb_nm, coulomb_nm / config.friction.stiffness_nm_rad,
          std::sqrt(positive.stribeck_speed_rad_s * negative.stribeck_speed_rad_s),
          axis_inertia_kg_m2(plant, axis, kMiddle_rad[kPitch])};
}

// Swept away by wind: the experiment ends there, which does no harm.
bool is_complete(const experiment& ended) {
  const bool swept = ended.state == EXPERIMENT_LEFT_TRAVEL || ended.state == EXPERIMENT_TOO_FAST;
  return ended.state == EXPERIMENT_DONE || (ended.setup.kind == STIMULUS_BREAKAWAY && swept);
}

// A device on one machine from its start on, for one kind of use.
class Use {
 public:
  Use(const NodeSetup& setup, std::uint64_t seed, const std::string& what, const std::array<double, kAxes>& angle_rad,
      MonitoredPlants& found)
      : setup_(setup), what_(fmt::format("plant {}, {}", seed, what)), node_(setup, seed, angle_rad), found_(found) {}

  // The motion of one case of an experiment of the paper, as set-points of cyclic velocity.
  void follow(const ScenarioConfig& scenario, double speed_rad_s) {
    const FlyBy target(scenario.fly_by);
    node_.enable(DRIVE_CYCLIC_VELOCITY);
    const auto ticks = static_cast<int>(scenario.duration_s / kTick_s);
    for (int turn = 0; turn < ticks && good_; ++turn) {
      const double time_s = turn * kTick_s;
      for (int axis = 0; axis < kAxes; ++axis) {
        const auto i = static_cast<std::size_t>(axis);
        if (scenario.kind == ScenarioKind::kTracking) {
          const LineOfSight line = target.at(time_s);
          node_.set_rate(axis, scenario.axes[i] ? line.rate_rad_s[i] : 0.0);
          continue;
        }
        node_.set_rate(axis, scenario.axes[i]
                                 ? static_cast<double>(speed_set_point(scenario, speed_rad_s, time_s).rate_rad_s)
                                 : 0.0);
        node_.machine().inject_torque(axis,
                                      scenario.axes[i] ? disturbance_nm(setup_.plant, scenario, axis, time_s) : 0.0);
      }
      tick();
    }
  }

  // As servoctl does, from place to place; the other axis holds its place.
  void commission(int axis, const commissioning::TestPlan& plan) {
    enable();
    brake_as(axis, plan);
    for (const commissioning::Place& place : plan.places) {
      move_to(axis, place.angle_rad, plan.moving_rad_s);
      for (const stimulus_setup& stimulus : place.experiments) {
        if (!good_) {
          return;
        }
        if (std::abs(position_rad(axis) - place.angle_rad) >
            kStrayShare * static_cast<double>(plan.limits.travel_rad)) {
          move_to(axis, place.angle_rad, plan.moving_rad_s);
        }
        perform(axis, stimulus, plan.limits);
      }
    }
  }

  // This set, gains and motor data, checked by the device; then the chirps that measure margins, and motion while the
  // gains count as new.
  void tune(int axis, const axis_parameters& gains, const commissioning::TestPlan& chirps) {
    node_.unlock();
    node_.node().axis[axis].tuning.staged = gains;
    try {
      node_.write(axis, 0x2070, 1, 1);
    } catch (const std::runtime_error&) {
      found_.broken_off.push_back(fmt::format("{}: the device refuses the designed gains of {}, 2070:3 is {}", what_,
                                              axis_name(axis),
                                              static_cast<int>(node_.node().axis[axis].tuning.last_result)));
      return;
    }
    commission(axis, chirps);
    select(axis, DRIVE_CYCLIC_VELOCITY);
    for (int turn = 0; turn < static_cast<int>(kNewGains_s / kTick_s) && good_; ++turn) {
      const double time_s = turn * kTick_s;
      const bool steps = std::fmod(time_s, 4.0) >= 2.0;
      const double wave = std::sin(2.0 * kPi * time_s);
      node_.set_rate(axis, steps ? (std::fmod(time_s, 0.5) < 0.25 ? 0.017 : -0.017) : 0.05 * wave);
      tick();
    }
  }

  double hours() const { return ticks_ * kTick_s / 3600.0; }

  // Runs a part of it; what the device refuses is an early end.
  template <class Part>
  void run(Part part) {
    try {
      part(*this);
    } catch (const std::runtime_error& error) {
      if (good_) {
        found_.broken_off.push_back(fmt::format("{}: {}", what_, error.what()));
      }
    }
    found_.hours += hours();
  }

 private:
  void tick() {
    node_.tick();
    ++ticks_;
    const fault_log& log = node_.node().log;
    if (log.count > 0 && good_) {
      good_ = false;
      const fault_log_entry *first = fault_log_find(&log, log.count - 1);
      found_.false_trips.push_back(fmt::format("{}: fault {} of {} after {:.3f} s", what_, first->fault,
                                               first->source < kAxes ? axis_name(first->source) : "the board",
                                               ticks_ * kTick_s));
    }
  }

  void ticks(int count) {
    for (int i = 0; i < count && good_; ++i) {
      tick();
    }
  }

  double position_rad(int axis) { return node_.axis(axis).objects.position.actual / kCountsPerRad; }

  void enable() {
    node_.enable(0);
    ticks(kSettleTicks);
  }

  void select(int axis, std::int8_t mode) {
    node_.write(axis, 0x6060, 0, mode);
    ticks(2);
  }

  void brake_as(int axis, const commissioning::TestPlan& plan) {
    double fastest_rad_s2 = 0.0;
    for (const commissioning::Place& place : plan.places) {
      for (const stimulus_setup& stimulus : place.experiments) {
        fastest_rad_s2 = std::max(fastest_rad_s2, static_cast<double>(stimulus.acceleration_rad_s2));
      }
    }
    const drive_limit_objects& limit = node_.axis(axis).objects.limit;
    const double count = fastest_rad_s2 * kCountsPerRad_s;
    node_.write(axis, 0x6084, 0, std::llround(std::max(count, static_cast<double>(limit.deceleration))));
    node_.write(axis, 0x60A4, 1, std::llround(std::max(count / kJerkTime_s, static_cast<double>(limit.jerk))));
  }

  void move_to(int axis, double angle_rad, double rate_rad_s) {
    select(axis, DRIVE_PROFILE_POSITION);
    node_.write(axis, 0x6081, 0, std::llround(rate_rad_s * kCountsPerRad_s));
    node_.write(axis, 0x607A, 0, std::llround(angle_rad * kCountsPerRad));
    node_.write(axis, 0x6040, 0, 0x3F);
    ticks(2);
    node_.write(axis, 0x6040, 0, 0x0F);
    const double patience_s = 5.0 + 2.0 * (std::abs(angle_rad - position_rad(axis)) / rate_rad_s + 1.0);
    for (int waited = 0; (node_.axis(axis).objects.state.statusword & 0x0400U) == 0 && good_; ++waited) {
      if (waited * kTick_s > patience_s) {
        throw std::runtime_error(fmt::format("{} does not reach {:.3f} rad", axis_name(axis), angle_rad));
      }
      tick();
    }
    select(axis, 0);
    ticks(kSettleTicks);
  }

  void perform(int axis, const stimulus_setup& stimulus, const experiment_limits& limits) {
    experiment_objects& objects = node_.node().axis[axis].experiment;
    objects.setup = stimulus;
    objects.kind = static_cast<std::uint8_t>(stimulus.kind);
    objects.limits = limits;
    const std::uint8_t started = objects.started;
    for (int waited = 0; objects.started == started && good_; ++waited) {
      try {
        node_.write(axis, 0x2100, 1, 1);
      } catch (const std::runtime_error&) {  // the ramp has not ended
        if (waited > kStartTicks) {
          throw;
        }
        tick();
      }
    }
    while (objects.running.state == EXPERIMENT_RUNNING && good_) {
      tick();
    }
    if (good_ && !is_complete(objects.running)) {
      found_.broken_off.push_back(fmt::format("{}: experiment of kind {} of {} at {:.3f} rad ends with state {}", what_,
                                              static_cast<int>(stimulus.kind), axis_name(axis), position_rad(axis),
                                              static_cast<int>(objects.running.state)));
      return;
    }
    found_.experiments += good_ ? 1 : 0;
  }

  const NodeSetup& setup_;
  std::string what_;
  DrivenNode node_;
  MonitoredPlants& found_;
  int ticks_ = 0;
  bool good_ = true;  // the log of the device is empty
};

void add(MonitoredPlants& all, const MonitoredPlants& one) {
  all.plants += one.plants;
  all.hours += one.hours;
  all.experiments += one.experiments;
  all.false_trips.insert(all.false_trips.end(), one.false_trips.begin(), one.false_trips.end());
  all.broken_off.insert(all.broken_off.end(), one.broken_off.begin(), one.broken_off.end());
}

void commission_both(const MonitoredPlantsSetup& setup, const NodeSetup& machine, std::uint64_t seed,
                     MonitoredPlants& found) {
  for (int axis = 0; axis < kAxes; ++axis) {
    const commissioning::MotionLimits limits = motion_limits(setup.nominal, axis);
    const commissioning::RoughMachine rough = rough_machine(machine.plant, axis);
    Use(machine, seed, fmt::format("identification of {}", axis_name(axis)), kMiddle_rad, found).run([&](Use& use) {
      use.commission(axis, commissioning::first_look(limits));
      use.commission(axis, commissioning::test_plan_for(limits, rough));
      use.commission(axis, commissioning::structure_look(limits, rough));
    });
    const axis_parameters gains = node_parameters(machine.plant, axis);
    Use(machine, seed, fmt::format("tuning of {}", axis_name(axis)), kMiddle_rad, found).run([&](Use& use) {
      use.tune(axis, gains, commissioning::structure_look(limits, rough));
    });
  }
}

}  // namespace

std::vector<ScenarioConfig> scenarios_of_experiments(const std::filesystem::path& data_dir) {
  std::vector<ScenarioConfig> scenarios;
  std::set<std::string> names;
  for (const Experiment& experiment : load_experiments(data_dir)) {
    for (const Study& study : experiment.studies) {
      if (names.insert(study.scenario.name).second) {
        scenarios.push_back(study.scenario);
      }
    }
  }
  return scenarios;
}

MonitoredPlants monitor_plant(const MonitoredPlantsSetup& setup, std::uint64_t seed) {
  const NodeSetup nominal(setup.nominal);
  PlantConfig plant = random_plant(setup.nominal, setup.share, seed).config;
  plant.supply = setup.nominal.supply;  // the limits of its voltage are those of the supply
  const NodeSetup machine(plant, nominal.parameters, nominal.limits);
  MonitoredPlants found;
  found.plants = 1;
  const SoakResult shift = run_shift(machine, seed, kSoakTasks);
  found.hours += shift.hours;
  for (const std::string& trip : shift.false_trips) {
    found.false_trips.push_back(fmt::format("plant {}, operation: {}", seed, trip));
  }
  for (const ScenarioConfig& scenario : setup.scenarios) {
    const std::vector<double> speeds_rad_s =
        scenario.kind == ScenarioKind::kTracking ? std::vector<double>{0.0} : scenario.speeds_rad_s;
    const std::array<double, kAxes> start_rad = scenario.kind == ScenarioKind::kTracking
                                                    ? FlyBy(scenario.fly_by).at(0.0).angle_rad
                                                    : scenario.initial_joint_angle_rad;
    for (const double speed_rad_s : speeds_rad_s) {
      Use(machine, seed, fmt::format("experiment {}", scenario.name), start_rad, found).run([&](Use& use) {
        use.follow(scenario, speed_rad_s);
      });
    }
  }
  commission_both(setup, machine, seed, found);
  return found;
}

MonitoredPlants monitor_plants(const MonitoredPlantsSetup& setup, const Progress& progress) {
  MonitoredPlants all;
  std::mutex mutex;
  JobPool pool(setup.threads, setup.count, progress);
  pool.run(static_cast<std::size_t>(setup.count), [&](std::size_t i) {
    const MonitoredPlants one = monitor_plant(setup, setup.seed + i);
    const std::lock_guard<std::mutex> lock(mutex);
    add(all, one);
    return std::string("monitored plants");
  });
  std::sort(all.false_trips.begin(), all.false_trips.end());
  std::sort(all.broken_off.begin(), all.broken_off.end());
  return all;
}

std::string print(const MonitoredPlants& all) {
  std::string text =
      fmt::format("{} plants, {:.1f} simulated hours, {} experiments of identification and tuning; false trips: {}\n",
                  all.plants, all.hours, all.experiments, all.false_trips.size());
  for (const std::string& trip : all.false_trips) {
    text += trip + "\n";
  }
  text += all.broken_off.empty() ? "" : fmt::format("ended early without a fault: {}\n", all.broken_off.size());
  for (const std::string& end : all.broken_off) {
    text += end + "\n";
  }
  return text;
}

}  // namespace trackservo::sim
