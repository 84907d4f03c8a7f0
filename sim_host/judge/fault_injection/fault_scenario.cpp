// SPDX-License-Identifier: Apache-2.0
#include "judge/fault_injection/fault_scenario.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "judge/fault_injection/braking.hpp"
#include "machine/config/toml_reader.hpp"

namespace trackservo::sim {
namespace {

std::vector<std::string> motion_names() {
  std::vector<std::string> names;
  std::transform(kMotions.begin(), kMotions.end(), std::back_inserter(names), motion_name);
  return names;
}

std::vector<std::string> part_names() {
  std::vector<std::string> names;
  for (const FaultInjection& one : fault_injections()) {
    names.push_back(one.name);
  }
  return names;
}

Keys<FaultScenario> scenario_keys() {
  return {
      choice("motion", motion_names(), &FaultScenario::motion, "motion of both axes"),
      number("duration_s", unit::kSecond, {0.1, 3600}, &FaultScenario::duration_s, "length of the run"),
      number("seed", unit::kNone, {0, 1e9}, &FaultScenario::seed, "of noise, wind and the size of an injected fault")
          .or_else(1),
  };
}

Keys<PlannedFaultInjection> fault_injection_keys() {
  return {
      choice("part", part_names(), &PlannedFaultInjection::part, "fault to inject"),
      choice("axis", {axis_name(kAzimuth), axis_name(kPitch)}, &PlannedFaultInjection::axis, "axis of the fault"),
      number("at_s", unit::kSecond, {0, 3600}, &PlannedFaultInjection::at_s, "injection instant"),
  };
}

const FaultInjection& part_of(const PlannedFaultInjection& planned) {
  return fault_injections()[static_cast<std::size_t>(planned.part)];
}

class ScenarioRun {
 public:
  ScenarioRun(const NodeSetup& setup, const FaultScenario& scenario)
      : scenario_(scenario),
        random_(SplitMix64::mix(static_cast<std::uint64_t>(scenario.seed))),
        node_(setup, static_cast<std::uint64_t>(scenario.seed), {0.2, 0.4}) {}

  std::string run() {
    prepare();
    const auto ticks = static_cast<int>(std::lround(scenario_.duration_s / kTick_s));
    for (int i = 0; i < ticks; ++i) {
      time_s_ = i * kTick_s;
      break_parts(i);
      for (int axis = 0; axis < kAxes; ++axis) {
        const Motion motion = kMotions[static_cast<std::size_t>(scenario_.motion)];
        node_.move(axis, motion_rate_rad_s(motion, time_s_));
      }
      node_.tick();
      for (int axis = 0; axis < kAxes; ++axis) {
        look(axis);
      }
    }
    return text_;
  }

 private:
  void say(int axis, const std::string& what) {
    text_ += fmt::format("{:8.3f} s  {:<8} {}\n", time_s_, axis_name(axis), what);
  }

  void prepare() {
    std::array<std::int8_t, kAxes> modes;
    modes.fill(DRIVE_CYCLIC_VELOCITY);
    for (const PlannedFaultInjection& planned : scenario_.fault_injections) {
      part_of(planned).prepare(node_, planned.axis);
      modes[static_cast<std::size_t>(planned.axis)] = part_of(planned).mode;
    }
    node_.enable(modes);
  }

  void break_parts(int tick) {
    for (const PlannedFaultInjection& planned : scenario_.fault_injections) {
      const auto from_tick = static_cast<int>(std::lround(planned.at_s / kTick_s));
      const FaultInjection& part = part_of(planned);
      if (tick < from_tick) {
        part.keep_up(node_, planned.axis);
      } else if (tick == from_tick) {
        say(planned.axis, part.name);
        part.begin(node_, planned.axis, random_);
        broken_[static_cast<std::size_t>(planned.axis)] = &part;
      }
    }
  }

  void look(int axis) {
    const auto i = static_cast<std::size_t>(axis);
    const fault_id fault = node_.axis(axis).drive.fault;
    const double rate_rad_s = node_.machine().truth().joint_rate_rad_s[i];
    if (fault != reported_[i]) {
      static const char *const reactions[] = {"reported", "the speed loop brakes", "protection brakes",
                                              "the shorted motor brakes", "bridge off at once"};
      const fault_row& row = fault_table[fault];
      say(axis, fmt::format("fault {} (0x{:04X}) at {:.3f} deg/s: {}", static_cast<int>(fault), row.code,
                            rate_rad_s * kDegPerRad, reactions[row.reaction]));
      if (broken_[i] != nullptr) {  // remove the external torque
        broken_[i]->end(node_, axis);
      }
      reported_[i] = fault;
      if (!braking_[i].at_rest()) {
        braking_[i] = Braking(node_.machine().truth().joint_angle_rad[i]);
      }
    }
    if (fault != FAULT_NONE && braking_[i].step(node_.machine().truth(), axis)) {
      say(axis, fmt::format("at rest after a further {:.3f} deg", braking_[i].travel_rad() * kDegPerRad));
    }
  }

  FaultScenario scenario_;
  SplitMix64 random_;
  DrivenNode node_;
  double time_s_ = 0;
  std::array<const FaultInjection *, kAxes> broken_{};
  std::array<fault_id, kAxes> reported_{};
  std::array<Braking, kAxes> braking_{};
  std::string text_;
};

}  // namespace

FaultScenario load_fault_scenario(const std::filesystem::path& path) {
  const TomlReader reader(path);
  FaultScenario scenario;
  reader.read(reader.root(), scenario_keys(), scenario);
  reader.refuse_unknown(reader.root(), scenario_keys(), {"breakage"});
  for (const TomlTable& table : reader.children(reader.root(), "breakage")) {
    PlannedFaultInjection planned;
    reader.read(table, fault_injection_keys(), planned);
    reader.refuse_unknown(table, fault_injection_keys());
    if (planned.at_s >= scenario.duration_s) {
      reader.fail(table, "at_s", "is after the end of the run", "give less than duration_s");
    }
    for (const PlannedFaultInjection& other : scenario.fault_injections) {
      if (other.axis == planned.axis && part_of(other).mode != part_of(planned).mode) {
        reader.fail(table, "part", "needs a different mode of operation than an earlier fault injection on this axis",
                    "use a separate file for it");
      }
    }
    scenario.fault_injections.push_back(planned);
  }
  return scenario;
}

std::string run_fault_scenario(const PlantConfig& plant, const FaultScenario& scenario) {
  const NodeSetup setup(plant);
  return ScenarioRun(setup, scenario).run();
}

}  // namespace trackservo::sim
