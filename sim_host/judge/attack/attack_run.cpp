// SPDX-License-Identifier: Apache-2.0
#include "judge/attack/attack_run.hpp"

#include <fmt/format.h>

#include <cmath>

#include "device/flash_memory.hpp"

namespace trackservo::sim {
namespace {

constexpr double kNarrowStop_rad = 170.0 * kRadPerDeg;
constexpr double kNarrowShare = 0.8;  // of the seeds
constexpr int kAnswerTicks = 2000;    // resets and saves at the very end, 0.25 s each, are over by then

PlantConfig with_narrow_azimuth(PlantConfig plant) {
  EndStopConfig stops = plant.axis[kAzimuth].end_stops.value_or(EndStopConfig{});
  stops.lower_rad = -kNarrowStop_rad;
  stops.upper_rad = kNarrowStop_rad;
  plant.axis[kAzimuth].end_stops = stops;
  return plant;
}

const char *power_name(int power) {
  static constexpr const char *kNames[] = {
      "not ready",         "switch on disabled", "ready to switch on",    "switched on",
      "operation enabled", "quick stop active",  "fault reaction active", "fault"};
  return kNames[power];
}

class AttackRun {
 public:
  AttackRun(const AttackBench& bench, std::uint64_t seed, EventLog *log)
      : random_(SplitMix64::mix(seed)),
        brakes_(seed % 2 == 0),
        narrow_(random_.uniform() < kNarrowShare),
        setup_(narrow_ ? bench.narrow() : bench.shipped()),
        start_(random_start(setup_, random_)),
        master_(log),
        attacker_(bench.objects(), setup_, start_, kWrites_s, random_),
        node_(setup_, seed, {start_.axis[kAzimuth].angle_rad, start_.axis[kPitch].angle_rad},
              {master_.receiver(), flash_.areas(), brakes_}),
        judge_(setup_, brakes_),
        reporter_(log) {
    node_.fall_silent();  // only the frames of `master_` count
    master_.connect(node_);
    attacker_.connect(node_, master_);
    result_.seed = seed;
    result_.theme = start_.theme;
    result_.narrow = narrow_;
  }

  AttackResult run() {
    const auto ticks = static_cast<int>((start_.writes_from_s + kWrites_s) / kTick_s);
    for (int i = 0; i < ticks; ++i) {
      attacker_.step(time_s_);
      tick();
    }
    for (int i = 0; i < static_cast<int>(kAfter_s / kTick_s); ++i) {
      tick();
    }
    master_.send(can_frame{0x000, 0, 2, {1, 0}, 0}, "NMT start, to ask for 1000");
    result_.answers = master_.node_answers(kAnswerTicks, [this] { tick(); });
    result_.harm = judge_.harm();
    result_.writes = master_.writes();
    result_.refusals = master_.refusals();
    return result_;
  }

 private:
  void tick() {
    master_.step(time_s_);
    node_.tick();
    time_s_ += kTick_s;
    judge_.look(node_, time_s_);
    reporter_.look(node_, judge_.harm(), time_s_);
  }

  SplitMix64 random_;
  bool brakes_;
  bool narrow_;
  const NodeSetup& setup_;
  AttackStart start_;
  FlashMemory flash_;
  FrameMaster master_;
  RandomMaster attacker_;
  DrivenNode node_;
  MotionJudge judge_;
  EventReporter reporter_;
  AttackResult result_;
  double time_s_ = 0;
};

}  // namespace

AttackBench::AttackBench(const PlantConfig& plant) : shipped_(plant), narrow_(with_narrow_azimuth(plant)) {
  DrivenNode node(shipped_, 1, {0.0, 0.0});
  objects_ = std::make_unique<WritableObjects>(*servo_node_dictionary(&node.node()));
}

void EventReporter::look(const DrivenNode& node, const Harm& harm, double time_s) {
  if (log_ == nullptr) {
    return;
  }
  for (int axis = 0; axis < kAxes; ++axis) {
    const auto i = static_cast<std::size_t>(axis);
    const drive_axis& drive = node.axis(axis).drive;
    const TruthState truth = node.machine().truth();
    const auto at = [&] {
      return fmt::format("at {:.2f} deg, {:.1f} deg/s", truth.joint_angle_rad[i] * kDegPerRad,
                         truth.joint_rate_rad_s[i] * kDegPerRad);
    };
    if (static_cast<int>(drive.state.power) != power_[i]) {
      power_[i] = static_cast<int>(drive.state.power);
      log_->say(time_s, fmt::format("  {}: {} {}", axis_name(axis), power_name(power_[i]), at()));
    }
    if (static_cast<int>(drive.fault) != fault_[i]) {
      fault_[i] = static_cast<int>(drive.fault);
      log_->say(time_s, fmt::format("  {}: fault {} {}", axis_name(axis), fault_[i], at()));
    }
    if (static_cast<int>(drive.tracking) != tracking_[i]) {
      tracking_[i] = static_cast<int>(drive.tracking);
      log_->say(time_s, fmt::format("  {}: tracking state {} {}", axis_name(axis), tracking_[i], at()));
    }
    const EndStopContacts& contacts = harm.axis[i].contacts;
    if (contacts.count != contacts_[i]) {
      contacts_[i] = contacts.count;
      log_->say(time_s, fmt::format("  {}: reaches an end stop {}; fastest contact so far {:.1f} deg/s",
                                    axis_name(axis), at(), contacts.speed_rad_s * kDegPerRad));
    }
  }
}

AttackResult run_attack(const AttackBench& bench, std::uint64_t seed, EventLog *log) {
  return AttackRun(bench, seed, log).run();
}

std::string describe(const Harm& harm, bool answers) {
  std::string text;
  const auto add = [&text](const std::string& more) { text += (text.empty() ? "" : "; ") + more; };
  for (int axis = 0; axis < kAxes; ++axis) {
    const AxisHarm& one = harm.axis[static_cast<std::size_t>(axis)];
    if (one.contacts.speed_rad_s > kContactLimit_rad_s) {
      add(fmt::format("{} reaches an end stop at {:.1f} deg/s ({:.0f} Nm, {:.1f} J) after {:.3f} s", axis_name(axis),
                      one.contacts.speed_rad_s * kDegPerRad, one.contacts.torque_nm, one.contacts.energy_j,
                      one.contacts.first_time_s));
    }
    if (one.runaway == Runaway::kTooFast) {
      add(fmt::format("{} is faster than its limit after {:.3f} s, {:.1f} deg/s at most", axis_name(axis),
                      one.runaway_time_s, one.max_rate_rad_s * kDegPerRad));
    } else if (one.runaway == Runaway::kNotStopped) {
      add(fmt::format("{} still turns after {:.3f} s, although nothing lets it turn since {:.0f} s", axis_name(axis),
                      one.runaway_time_s, kStopTime_s));
    }
  }
  if (harm.not_finite) {
    add("a signal is not a number");
  }
  if (!answers) {
    add("the node no longer answers");
  }
  return text.empty() ? "no harm" : text;
}

}  // namespace trackservo::sim
