// SPDX-License-Identifier: Apache-2.0
#include "judge/attack/named_sequences.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <stdexcept>

#include "device/flash_memory.hpp"
#include "machine/base/job_pool.hpp"
#include "machine/target/target_camera.hpp"

namespace trackservo::sim {
namespace {

constexpr double kRunUp_rad = 0.9;          // from the start to the writes: the axis reaches its speed before
constexpr double kTrackingRunUp_rad = 1.2;  // likewise in mode -1
constexpr double kLargestStart_rad = 1.3;   // of which the encoder knows the turn, in the plant's own travel
constexpr double kLongestWideRunUp_s = 8.0;
constexpr double kLongestRunUp_s = 4.0;                 // then the writes come where the axis is
constexpr double kRest_s = 1.0;                         // at standstill, before the writes
constexpr double kRestsBelow_rad_s = 0.5 * kRadPerDeg;  // in the last half second
constexpr double kAtEnd_s = 0.5;
constexpr std::uint8_t kMasterNode = 5;
constexpr int kHeartbeatTicks = 20;
constexpr int kTalkTicks = 200;
constexpr int kCameraRpdo = 4;
constexpr int kFrameTicks = 20;
constexpr double kFrameAge_s = 0.02;
constexpr double kLead_rad = 0.025;  // at most: a target waits within the picture for the axis, and sways there
constexpr double kSway = 0.25;       // of it; a place that stays is that of a frozen picture
constexpr double kSway_rad_s = 30.0;
constexpr double kStands_s = 1.5;  // at first, until the picture has proven right
constexpr double kBegins_rad = 0.004;
constexpr double kPicture_rad = 0.032;
constexpr double kTarget_rad_s2 = 2.0;
constexpr double kShaking_rad_s = 3.0 * kRadPerDeg;  // allowed at rest with gains that shake

SdoWrite write(const DrivenNode& node, int axis, std::uint16_t index, std::uint8_t sub, double value) {
  const bool of_axis = index >= 0x2000 && (index < 0x3000 || index >= 0x6000);
  return sdo_write(node, of_axis ? index_of_axis(index, axis) : index, sub, value);
}

struct ObjectValue {
  std::uint16_t index;
  std::uint8_t sub;
  double value;
  bool times_direction = false;
};

std::function<std::vector<SdoWrite>(const DrivenNode&, int, double)> values(std::vector<ObjectValue> list) {
  return [list = std::move(list)](const DrivenNode& node, int axis, double direction) {
    std::vector<SdoWrite> writes;
    for (const ObjectValue& one : list) {
      writes.push_back(write(node, axis, one.index, one.sub, one.times_direction ? direction * one.value : one.value));
    }
    return writes;
  };
}

NamedSequence towards_end(const char *name, bool harmless, std::vector<ObjectValue> list) {
  NamedSequence sequence;
  sequence.name = name;
  sequence.harmless = harmless;
  sequence.writes = values(std::move(list));
  return sequence;
}

// A target is always ahead of the axis, and leads it to the end and beyond.
NamedSequence led_by_target(const char *name, std::vector<ObjectValue> list) {
  NamedSequence sequence = towards_end(name, true, std::move(list));
  sequence.mode = DRIVE_TRACKING;
  return sequence;
}

void add_tracking(std::vector<NamedSequence>& list) {
  list.push_back(led_by_target("target leads out of the travel", {}));
  list.push_back(led_by_target("target leads to the end, then no frames", {}));
  list.back().frames_stop = true;
  list.back().rests_at_end = true;
  list.back().seconds = 10;  // near the zenith the target may be expected back
  list.push_back(led_by_target("target leads, deceleration and jerk of one count, then no frames",
                               {{0x6084, 0, 1}, {0x60A4, 1, 1}}));
  list.back().frames_stop = true;
  list.push_back(led_by_target("target leads, acceleration and jerk of one count", {{0x6083, 0, 1}, {0x60A4, 1, 1}}));
  list.push_back(
      led_by_target("target leads, largest gains of tracking",
                    {{0x2011, 2, 100}, {0x2011, 3, 1000}, {0x2011, 4, 50}, {0x2011, 5, 10}, {0x2070, 1, 1}}));
  list.back().early = true;  // while both axes track they would wait
  list.push_back(
      led_by_target("target leads, loop of kind 0", {{0x2011, 1, 0}, {0x2011, 2, 5}, {0x2011, 3, 5}, {0x2070, 1, 1}}));
  list.back().early = true;
  list.push_back(
      led_by_target("target leads, speed-loop gains of 0", {{0x2000, 1, 0}, {0x2000, 2, 0}, {0x2070, 1, 1}}));
  list.push_back(led_by_target("target leads, picture turned by 180 deg", {{0x3071, 2, kPi}}));
  list.push_back(led_by_target("target leads, image scale of 1 mrad", {{0x3071, 1, 1e-3}}));
  list.push_back(led_by_target("target leads, boresight of 0.5 rad away", {{0x3071, 3, 0.5}, {0x3071, 4, -0.5}}));
  list.push_back(led_by_target("target leads past the zenith", {}));
  list.back().across_rad = 0.01;
  list.push_back(led_by_target("target leads out of the travel, azimuth may turn back", {{0x3075, 2, 1}}));
  list.back().wide = true;
  list.back().seconds = 12;
  NamedSequence unknown = led_by_target("start at 240 deg, target leads outwards", {});
  unknown.approach = Approach::kBeyondHalfTurn;
  unknown.angle_rad = 240.0 * kRadPerDeg;
  unknown.seconds = 25;
  list.push_back(unknown);
}

NamedSequence gains_at_rest(const char *name, bool harmless, double seconds, std::vector<ObjectValue> list) {
  NamedSequence sequence = towards_end(name, harmless, std::move(list));
  sequence.approach = Approach::kStandstill;
  sequence.seconds = seconds;
  sequence.max_rate_rad_s = kShaking_rad_s;
  sequence.rests_at_end = true;
  return sequence;
}

NamedSequence proportional_gain(const char *name, bool harmless, double seconds, double factor) {
  NamedSequence sequence = gains_at_rest(name, harmless, seconds, {});
  sequence.writes = [factor](const DrivenNode& node, int axis, double) {
    const auto gain = static_cast<double>(node.axis(axis).tuning.active.speed_loop.proportional_nm_s_rad);
    return std::vector<SdoWrite>{write(node, axis, 0x2000, 1, factor * gain), write(node, axis, 0x2070, 1, 1)};
  };
  return sequence;
}

NamedSequence beyond_half_turn(const char *name, bool harmless, double angle_deg, double rate_deg_s) {
  NamedSequence sequence = towards_end(name, harmless, {});
  sequence.approach = Approach::kBeyondHalfTurn;
  sequence.angle_rad = angle_deg * kRadPerDeg;
  sequence.rate_rad_s = rate_deg_s * kRadPerDeg;
  sequence.seconds = 25;  // at 4 deg/s to the end of the travel
  return sequence;
}

std::vector<NamedSequence> all_sequences() {
  std::vector<NamedSequence> list = {
      towards_end("deceleration and jerk of one count", true, {{0x6084, 0, 1}, {0x60A4, 1, 1}}),
      towards_end("quick stop with a deceleration and jerk of one count", true,
                  {{0x6085, 0, 1}, {0x60A4, 1, 1}, {0x6040, 0, 0x02}}),
      towards_end("halt with a deceleration and jerk of one count", true,
                  {{0x6084, 0, 1}, {0x60A4, 1, 1}, {0x6040, 0, 0x10F}}),
      towards_end("disable with a deceleration and jerk of one count", true,
                  {{0x6084, 0, 1}, {0x60A4, 1, 1}, {0x605C, 0, 1}, {0x6040, 0, 0x07}}),
      towards_end("disable voltage", true, {{0x6040, 0, 0x00}}),
      towards_end("speed-loop gains of 0", true, {{0x2000, 1, 0}, {0x2000, 2, 0}, {0x2070, 1, 1}}),
      towards_end("mode 0", true, {{0x6060, 0, 0}}),
      towards_end("full torque outwards", true, {{0x6071, 0, 1000, true}, {0x6060, 0, DRIVE_CYCLIC_TORQUE}}),
      towards_end("position limits wide open", true,
                  {{0x607D, 1, 0}, {0x607D, 2, 0}, {0x6084, 0, 4294967295.0}, {0x60FF, 0, 1.4e6, true}}),
  };
  list.push_back(towards_end("torque limit of 0", true, {{0x6072, 0, 0}}));
  NamedSequence offset =
      towards_end("gains of 0 and full torque offset", true,
                  {{0x60B2, 0, 1000, true}, {0x2000, 1, 0}, {0x2000, 2, 0}, {0x2020, 1, 0}, {0x2070, 1, 1}});
  offset.mode = DRIVE_CYCLIC_VELOCITY;
  list.push_back(offset);
  NamedSequence heartbeat =
      towards_end("heartbeat lost with a deceleration and jerk of one count", true, {{0x6085, 0, 1}, {0x60A4, 1, 1}});
  heartbeat.heartbeats = true;
  heartbeat.reports = FAULT_HEARTBEAT_LOST;
  list.push_back(heartbeat);
  NamedSequence silence = towards_end("silence of the master", true, {});
  silence.rate_rad_s = 20.0 * kRadPerDeg;
  silence.distance_rad = 0.9;
  silence.rests_at_end = true;
  silence.silent = true;
  silence.seconds = 2.4;
  list.push_back(silence);
  list.push_back(gains_at_rest("low-pass of 5 Hz at rest", true, 3, {{0x2040, 4, 5}, {0x2070, 1, 1}}));
  list.push_back(gains_at_rest("low-pass of 20 Hz at rest", true, 3, {{0x2040, 4, 20}, {0x2070, 1, 1}}));
  list.push_back(gains_at_rest("Kp of 20,000 at rest", true, 3, {{0x2000, 1, 20000}, {0x2070, 1, 1}}));
  list.push_back(gains_at_rest("Ki of 1e8 at rest", true, 3, {{0x2000, 2, 1e8}, {0x2070, 1, 1}}));
  list.push_back(proportional_gain("Kp times 10 at rest", true, 3, 10.0));
  list.push_back(proportional_gain("Kp times 30 at rest", true, 3, 30.0));
  list.push_back(beyond_half_turn("start at 200 deg, 20 deg/s outwards", true, 200.0, 20.0));
  list.push_back(beyond_half_turn("start at 240 deg, 20 deg/s outwards", true, 240.0, 20.0));
  list.push_back(beyond_half_turn("start at 240 deg, 55 deg/s outwards", true, 240.0, 55.0));
  add_tracking(list);
  return list;
}

struct SequencePlace {
  int axis;
  double direction;
  double distance_rad;
  bool together = false;  // mode -1: both axes track
  bool brakes = true;     // the holding brakes of the plant file are fitted
};

// One run of a sequence.
class SequenceRun {
 public:
  SequenceRun(const AttackBench& bench, const NamedSequence& sequence, const SequencePlace& place, EventLog *log)
      : sequence_(sequence),
        axis_(place.axis),
        together_(place.together),
        direction_(place.direction),
        distance_rad_(place.distance_rad),
        setup_(sequence.wide || sequence.approach == Approach::kBeyondHalfTurn ? bench.shipped() : bench.narrow()),
        master_(log),
        node_(setup_, kSeed, start_angles(), {master_.receiver(), flash_.areas(), place.brakes}),
        judge_(setup_, place.brakes),
        reporter_(log) {
    node_.fall_silent();  // only the frames of `master_` count
    master_.connect(node_);
  }

  SequenceResult run() {
    approach();
    if (!sequence_.early) {
      send(sequence_.writes(node_, axis_, direction_));
    }
    films_ = films_ && !sequence_.frames_stop;
    result_.sequence = &sequence_;
    result_.runs = 1;
    const double from_s = time_s_;
    const double from_rad = angle();
    const int ticks = static_cast<int>(sequence_.seconds / kTick_s);
    for (int i = 0; i < ticks; ++i) {
      tick(false);
      if (i >= ticks - static_cast<int>(kAtEnd_s / kTick_s)) {
        last_rate_rad_s_ = std::max(last_rate_rad_s_, std::abs(rate()));
      }
      result_.max_rate_rad_s = std::max(result_.max_rate_rad_s, std::abs(rate()));
      result_.max_travel_rad = std::max(result_.max_travel_rad, std::abs(angle() - from_rad));
      note_fault(from_s);
    }
    judge();
    return result_;
  }

 private:
  static constexpr std::uint64_t kSeed = 1;

  std::array<double, kAxes> start_angles() const {
    std::array<double, kAxes> angles = {0.3, 0.6};
    double& angle = angles[static_cast<std::size_t>(axis_)];
    if (sequence_.approach == Approach::kTowardsEnd) {
      angle = limit() - direction_ * (distance_rad_ + run_up());
      angle = sequence_.wide ? std::clamp(angle, -kLargestStart_rad, kLargestStart_rad) : angle;
    } else if (sequence_.approach == Approach::kBeyondHalfTurn) {
      angle = direction_ * sequence_.angle_rad;
    }
    return angles;
  }

  double limit() const {
    const protection_limits& limits = setup_.limits[static_cast<std::size_t>(axis_)];
    return static_cast<double>(direction_ < 0.0 ? limits.minimum_rad : limits.maximum_rad);
  }
  // A target takes longer to make the axis fast.
  double run_up() const { return sequence_.mode == DRIVE_TRACKING ? kTrackingRunUp_rad : kRunUp_rad; }
  double angle() const { return node_.machine().truth().joint_angle_rad[static_cast<std::size_t>(axis_)]; }
  double rate() const { return node_.machine().truth().joint_rate_rad_s[static_cast<std::size_t>(axis_)]; }

  void send(const std::vector<SdoWrite>& writes) {
    for (const SdoWrite& one : writes) {
      (void)master_.write(one);
    }
  }

  // In csv the master sends a set-point in each tick, in RPDO 3.
  void send_rate() {
    can_frame frame{0x401, 0, 8, {}, 0};
    const auto rate_counts = static_cast<std::int32_t>(direction_ * sequence_.rate_rad_s * 1e6);
    std::memcpy(frame.data + (axis_ == kPitch ? sizeof rate_counts : 0), &rate_counts, sizeof rate_counts);
    master_.send(frame, "RPDO 3");
  }

  // A target that stands beside the axis when it begins to track, then runs ahead of it; the other axis need not move.
  // The picture of a frame is that of the frame before.
  void film() {
    const TruthState truth = node_.machine().truth();
    const auto led = static_cast<std::size_t>(axis_);
    for (int axis = 0; axis < kAxes; ++axis) {
      const auto i = static_cast<std::size_t>(axis);
      const bool beside = axis != axis_ && sequence_.across_rad != 0.0;
      if (beside || node_.axis(axis).drive.tracking == DRIVE_NOT_TRACKING) {
        target_rad_[i] = truth.inertial_angle_rad[i] + (axis == axis_ ? direction_ * kBegins_rad : 0.0);
        target_rad_s_ = axis == axis_ ? 0.0 : target_rad_s_;
        filmed_s_ = axis == axis_ ? 0.0 : filmed_s_;
      }
    }
    filmed_s_ += kTick_s;
    if (filmed_s_ > kStands_s) {
      const double looks_rad = truth.inertial_angle_rad[led];
      const double lead_rad = kLead_rad * (1.0 - kSway * (1.0 + std::sin(kSway_rad_s * filmed_s_)));
      target_rad_s_ = std::min(target_rad_s_ + kTarget_rad_s2 * kTick_s, sequence_.rate_rad_s);
      target_rad_[led] = std::clamp(target_rad_[led] + direction_ * target_rad_s_ * kTick_s, looks_rad - lead_rad,
                                    looks_rad + lead_rad);
    }
    if (ticks_ % kFrameTicks == 0) {
      master_.send(sender_.frame_of(picture_), "camera");
      picture_ = picture(truth);
    }
  }

  CameraFrame picture(const TruthState& truth) const {
    CameraFrame result;
    result.delay_s = kFrameAge_s;
    result.error_rad = picture_of(camera_axes_of({target_rad_, truth.base}, 0.0).col(0), pose_of(truth), {});
    result.error_rad[kAzimuth] += sequence_.across_rad;
    result.valid =
        std::abs(result.error_rad[kAzimuth]) < kPicture_rad && std::abs(result.error_rad[kPitch]) < kPicture_rad;
    result.error_rad = result.valid ? result.error_rad : std::array<double, kAxes>{};
    return result;
  }

  void tick(bool master_lives) {
    ticks_++;
    if (sequence_.heartbeats && master_lives && ticks_ % kHeartbeatTicks == 0) {
      master_.send(can_frame{0x700U + kMasterNode, 0, 1, {5}, 0}, "heartbeat of the master");
    }
    if ((master_lives || !sequence_.silent) && ticks_ % kTalkTicks == 0) {
      master_.keep_alive();
    }
    if (streams_) {
      send_rate();
    }
    if (films_) {
      film();
    }
    master_.step(time_s_);
    node_.tick();
    time_s_ += kTick_s;
    judge_.look(node_, time_s_);
    reporter_.look(node_, judge_.harm(), time_s_);
  }

  void enable(int axis, double rate_counts) {
    std::vector<SdoWrite> writes;
    const auto put = [&](std::uint16_t index, std::uint8_t sub, double value) {
      writes.push_back(write(node_, axis, index, sub, value));
    };
    put(0x607F, 0, 1.4e6);
    put(0x6083, 0, 3e6);
    put(0x6084, 0, 1e9);  // so that it is still fast near the end
    if (sequence_.mode != DRIVE_TRACKING) {
      put(0x60A4, 1, 1e9);  // with a target the envelope then ends most runs at once, with fault 52
    }
    put(0x6060, 0, sequence_.mode);
    for (const double word : {0x06, 0x07, 0x0F}) {
      put(0x6040, 0, word);
    }
    put(0x60FF, 0, rate_counts);
    send(writes);
  }

  void approach() {
    const bool moves = sequence_.approach != Approach::kStandstill;
    const double rate_counts = moves ? direction_ * sequence_.rate_rad_s * 1e6 : 0.0;
    master_.send(can_frame{0x000, 0, 2, {1, 0}, 0}, "NMT start");
    if (sequence_.heartbeats) {
      send({write(node_, axis_, 0x1016, 1, kMasterNode << 16 | 100)});
    }
    films_ = sequence_.mode == DRIVE_TRACKING;
    if (films_) {
      master_.map_camera(kCameraRpdo, kCameraCobId);
    }
    if (sequence_.early) {
      send(sequence_.writes(node_, axis_, direction_));
    }
    if (together_) {
      enable(kAzimuth + kPitch - axis_, 0.0);
    }
    enable(axis_, rate_counts);
    streams_ = sequence_.mode == DRIVE_CYCLIC_VELOCITY;
    const double run_up_s = !moves ? kRest_s : sequence_.wide ? kLongestWideRunUp_s : kLongestRunUp_s;
    const double longest_s = run_up_s + (films_ ? kStands_s : 0.0);
    const bool stops_by_place = sequence_.approach == Approach::kTowardsEnd;
    while (time_s_ < longest_s && !(stops_by_place && direction_ * (limit() - angle()) < distance_rad_)) {
      tick(true);
      if (sequence_.approach == Approach::kBeyondHalfTurn && master_.is_idle()) {
        return;
      }
    }
  }

  void note_fault(double from_s) {
    const int fault = static_cast<int>(node_.axis(axis_).drive.fault);
    reported_ = reported_ || sequence_.reports == FAULT_NONE || fault == static_cast<int>(sequence_.reports);
    if (fault != FAULT_NONE && result_.faults.empty()) {
      result_.faults.push_back(fault);
      result_.last_fault_s = time_s_ - from_s;
    }
  }

  void judge() {
    result_.harm = judge_.harm();
    for (const AxisHarm& one : result_.harm.axis) {
      result_.max_contact_rad_s = std::max(result_.max_contact_rad_s, one.contacts.speed_rad_s);
      result_.max_torque_nm = std::max(result_.max_torque_nm, one.contacts.torque_nm);
    }
    const bool rests = last_rate_rad_s_ < kRestsBelow_rad_s;
    result_.harmless = reported_ && !result_.harm.hits_hard() && !result_.harm.runs_away() &&
                       !result_.harm.not_finite && result_.max_rate_rad_s <= sequence_.max_rate_rad_s &&
                       (rests || !sequence_.rests_at_end);
  }

  const NamedSequence& sequence_;
  int axis_;
  bool together_;
  double direction_;
  double distance_rad_;
  const NodeSetup& setup_;
  FlashMemory flash_;
  FrameMaster master_;
  DrivenNode node_;
  MotionJudge judge_;
  EventReporter reporter_;
  SequenceResult result_;
  bool reported_ = false;  // the fault that must be
  double last_rate_rad_s_ = 0;
  double filmed_s_ = 0;  // since the axis tracks
  CameraSender sender_{kCameraCobId};
  CameraFrame picture_;
  std::array<double, kAxes> target_rad_{};  // joint angles that look at it
  double target_rad_s_ = 0;                 // of `axis_`
  double time_s_ = 0;
  int ticks_ = 0;
  bool streams_ = false;
  bool films_ = false;
};

// Azimuth and pitch, up and down, at several distances from the end; only azimuth can turn more than half a turn.
std::vector<SequencePlace> places_of(const NamedSequence& sequence) {
  std::vector<SequencePlace> places;
  for (const double direction : {1.0, -1.0}) {
    for (int axis = 0; axis < kAxes; ++axis) {
      if ((sequence.wide || sequence.approach == Approach::kBeyondHalfTurn) && axis != kAzimuth) {
        continue;
      }
      // In mode -1 with both axes, except at the middle distance.
      const bool tracks = sequence.mode == DRIVE_TRACKING;
      places.push_back({axis, direction, sequence.distance_rad, tracks});
      if (sequence.approach == Approach::kTowardsEnd && !sequence.silent) {
        places.push_back({axis, direction, 0.7 * sequence.distance_rad, false});
        places.push_back({axis, direction, 0.3 * sequence.distance_rad, tracks});
      }
    }
  }
  const std::size_t with_brakes = places.size();
  for (std::size_t i = 0; i < with_brakes; ++i) {
    places.push_back(places[i]);
    places.back().brakes = false;
  }
  return places;
}

void add(SequenceResult& worst, const SequenceResult& one) {
  if (one.max_contact_rad_s > worst.max_contact_rad_s) {
    worst.harm = one.harm;
  }
  worst.harmless = worst.harmless && one.harmless;
  worst.max_contact_rad_s = std::max(worst.max_contact_rad_s, one.max_contact_rad_s);
  worst.max_torque_nm = std::max(worst.max_torque_nm, one.max_torque_nm);
  worst.max_rate_rad_s = std::max(worst.max_rate_rad_s, one.max_rate_rad_s);
  worst.max_travel_rad = std::max(worst.max_travel_rad, one.max_travel_rad);
  worst.last_fault_s = std::max(worst.last_fault_s, one.last_fault_s);
  worst.faults.insert(worst.faults.end(), one.faults.begin(), one.faults.end());
  worst.runs++;
}

}  // namespace

const std::vector<NamedSequence>& named_sequences() {
  static const std::vector<NamedSequence> list = all_sequences();
  return list;
}

std::vector<SequenceResult> run_named_sequences(const AttackBench& bench, int threads) {
  const std::vector<NamedSequence>& list = named_sequences();
  std::vector<SequenceResult> results(list.size());
  JobPool pool(threads, static_cast<int>(list.size()), [](int, int, const std::string&) {});
  pool.run(list.size(), [&](std::size_t i) {
    results[i].sequence = &list[i];
    for (const SequencePlace& place : places_of(list[i])) {
      add(results[i], SequenceRun(bench, list[i], place, nullptr).run());
    }
    std::vector<int>& faults = results[i].faults;
    std::sort(faults.begin(), faults.end());
    faults.erase(std::unique(faults.begin(), faults.end()), faults.end());
    return list[i].name;
  });
  return results;
}

std::string replay(const AttackBench& bench, const NamedSequence& sequence) {
  std::string worst;
  double fastest_rad_s = -1.0;
  for (const SequencePlace& place : places_of(sequence)) {
    EventLog log;
    const SequenceResult result = SequenceRun(bench, sequence, place, &log).run();
    if (std::max(result.max_contact_rad_s, result.max_rate_rad_s * 1e-3) > fastest_rad_s) {
      fastest_rad_s = std::max(result.max_contact_rad_s, result.max_rate_rad_s * 1e-3);
      worst = log.text() + fmt::format("{}: {}\n", sequence.name, describe(result.harm, true));
    }
  }
  return worst;
}

const NamedSequence& named_sequence(const std::string& name) {
  std::string names;
  for (const NamedSequence& one : named_sequences()) {
    if (one.name == name) {
      return one;
    }
    names += (names.empty() ? "" : ", ") + one.name;
  }
  throw std::invalid_argument(fmt::format("Unknown sequence \"{}\"; choose one of: {}", name, names));
}

std::string print(const std::vector<SequenceResult>& results) {
  std::string text = fmt::format("{:<55} {:>5} {:>8} {:>7} {:>8} {:>8} {:>8}  {:<8} {}\n", "sequence", "runs",
                                 "contact", "Nm", "fastest", "travel", "fault s", "faults", "harm");
  for (const SequenceResult& one : results) {
    std::string faults;
    for (const int fault : one.faults) {
      faults += fmt::format("{}{}", faults.empty() ? "" : ",", fault);
    }
    text +=
        fmt::format("{:<55} {:>5} {:>8.1f} {:>7.0f} {:>8.1f} {:>8.1f} {:>8.3f}  {:<8} {}{}\n", one.sequence->name,
                    one.runs, one.max_contact_rad_s / kRadPerDeg, one.max_torque_nm, one.max_rate_rad_s / kRadPerDeg,
                    one.max_travel_rad / kRadPerDeg, one.last_fault_s, faults, one.harmless ? "no" : "yes",
                    one.harmless == one.sequence->harmless ? "" : " (expected otherwise)");
  }
  return text;
}

}  // namespace trackservo::sim
