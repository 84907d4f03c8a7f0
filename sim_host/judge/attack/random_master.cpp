// SPDX-License-Identifier: Apache-2.0
#include "judge/attack/random_master.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "machine/target/target_camera.hpp"

namespace trackservo::sim {
namespace {

constexpr double kCountsPerRad = 1e7;    // of positions
constexpr double kCountsPerRad_s = 1e6;  // of rates, accelerations and jerks
constexpr double kFastest_rad_s = 1.4;   // the drive uses 80 % of 2060:1, whatever 607F says
constexpr double kEnding_rad = 0.03;     // closer to a hard limit no run starts
constexpr double kSettling_s = 0.03;     // from the first frame to a moving set-point
constexpr double kTalk_s = 0.4;
constexpr std::uint32_t kSave = 0x65766173;
constexpr std::uint32_t kLoad = 0x64616F6C;
constexpr std::uint32_t kOff = 0x80000000;
constexpr std::array<std::int8_t, 7> kModes = {DRIVE_PROFILE_POSITION, DRIVE_PROFILE_VELOCITY, DRIVE_CYCLIC_POSITION,
                                               DRIVE_CYCLIC_VELOCITY,  DRIVE_CYCLIC_TORQUE,    DRIVE_HOMING,
                                               DRIVE_TRACKING};
constexpr std::array<std::int8_t, 4> kHomingMethods = {-1, -2, 35, 37};
constexpr double kTracks = 0.1;      // share of the seeds that start in tracking, with any theme
constexpr double kTracksBoth = 0.6;  // of these, with both axes
constexpr double kLeftAlone = 0.3;   // share of the tracking seeds in which nothing moves again that has stopped

constexpr std::array<ObjectGroup, kObjectGroups> kGroups = {
    ObjectGroup::kSetPoints,   ObjectGroup::kStates,        ObjectGroup::kProfiles, ObjectGroup::kGains,
    ObjectGroup::kGainCommand, ObjectGroup::kCommunication, ObjectGroup::kStorage,  ObjectGroup::kExperiments,
    ObjectGroup::kTracking,    ObjectGroup::kOthers,        ObjectGroup::kGuarded};

// Shares of a theme's single writes, in the order of kGroups; then those of frames without SDO, of remapping, of
// storing and of experiments.
struct Shares {
  std::array<int, kObjectGroups> group;
  int frames;
  int remap;
  int store;
  int experiment;
};

constexpr std::array<Shares, kThemes.size()> kShares = {{
    {{20, 6, 57, 2, 2, 1, 0, 0, 3, 0, 0}, 9, 0, 0, 0},       // profiles
    {{10, 3, 5, 45, 25, 0, 0, 0, 5, 0, 2}, 4, 0, 1, 0},      // gains
    {{17, 45, 15, 0, 0, 1, 0, 0, 3, 0, 0}, 19, 0, 0, 0},     // states
    {{10, 5, 5, 0, 0, 32, 0, 0, 3, 0, 0}, 35, 10, 0, 0},     // bus
    {{10, 5, 20, 12, 10, 5, 10, 0, 3, 0, 2}, 10, 0, 13, 0},  // storage
    {{5, 10, 10, 5, 5, 0, 0, 30, 3, 7, 0}, 5, 0, 0, 20},     // experiments
    {{13, 10, 20, 9, 8, 8, 1, 4, 6, 2, 2}, 12, 2, 2, 1},     // everything
    {{6, 12, 20, 5, 10, 4, 0, 0, 36, 2, 1}, 3, 1, 0, 0},     // tracking
}};

double hard_limit(const NodeSetup& setup, int axis, double direction) {
  const protection_limits& limits = setup.limits[static_cast<std::size_t>(axis)];
  return static_cast<double>(direction < 0.0 ? limits.minimum_rad : limits.maximum_rad);
}

// Ramps, limits and reactions; the other objects of CiA 402 only report, or monitor a window.
bool shapes_motion(const od_entry& entry) {
  return (entry.index >= 0x605A && entry.index <= 0x605E) || entry.index == 0x6072 ||
         (entry.index >= 0x607D && entry.index <= 0x60E1 && entry.index != 0x6086);
}

std::uint32_t bits_of(std::int64_t value) { return static_cast<std::uint32_t>(value); }

// Both axes, or one of them.
void start_in_tracking(AttackStart& start, SplitMix64& random) {
  const bool both = random.uniform() < kTracksBoth;
  const std::size_t one = random() % kAxes;
  for (std::size_t axis = 0; axis < kAxes; ++axis) {
    start.writes_from_s += 0.5 * random.uniform();  // a target may take longer than a set-point
    start.axis[axis].mode = both || axis == one ? static_cast<std::int8_t>(DRIVE_TRACKING) : start.axis[axis].mode;
  }
}

}  // namespace

std::string theme_name(Theme theme) {
  switch (theme) {
    case Theme::kProfiles:
      return "profiles and limits";
    case Theme::kGains:
      return "gains";
    case Theme::kStates:
      return "states and modes";
    case Theme::kBus:
      return "bus";
    case Theme::kStorage:
      return "storage";
    case Theme::kExperiments:
      return "experiments";
    case Theme::kTracking:
      return "tracking";
    case Theme::kEverything:
    default:
      return "everything";
  }
}

AttackStart random_start(const NodeSetup& setup, SplitMix64& random) {
  const auto uniform = [&random](double low, double high) { return low + (high - low) * random.uniform(); };
  AttackStart start;
  start.theme = kThemes[random() % kThemes.size()];
  start.writes_from_s = uniform(0.6, 1.2);
  start.acceleration_rad_s2 = uniform(2.0, 6.0);
  for (int axis = 0; axis < kAxes; ++axis) {
    AxisStart& one = start.axis[static_cast<std::size_t>(axis)];
    const double low_rad = hard_limit(setup, axis, -1.0);
    const double high_rad = hard_limit(setup, axis, 1.0);
    const double kind = uniform(0.0, 1.0);
    const double direction = uniform(0.0, 1.0) < 0.5 ? -1.0 : 1.0;
    const double fast = uniform(0.0, 1.0) < 0.6 ? kFastest_rad_s : uniform(0.1, kFastest_rad_s);
    one.mode =
        uniform(0.0, 1.0) < 0.5 ? static_cast<std::int8_t>(DRIVE_PROFILE_VELOCITY) : kModes[random() % kModes.size()];
    one.rate_rad_s = kind < 0.85 ? direction * fast : 0.0;
    one.heads_for_end = kind < 0.65;
    if (one.heads_for_end) {
      const double ramp_s = fast / start.acceleration_rad_s2;
      const double travel_rad = fast * std::max(start.writes_from_s - kSettling_s - 0.5 * ramp_s, 0.0);
      const double left_rad = uniform(0.0, 1.0) < 0.5 ? uniform(0.02, 0.3) : uniform(0.3, 1.0);
      one.angle_rad = hard_limit(setup, axis, direction) - direction * (travel_rad + left_rad);
    } else {
      one.angle_rad = uniform(low_rad, high_rad);
    }
    one.angle_rad = std::clamp(one.angle_rad, low_rad + kEnding_rad, high_rad - kEnding_rad);
  }
  if (start.theme == Theme::kTracking || random.uniform() < kTracks) {
    start_in_tracking(start, random);
  }
  return start;
}

RandomMaster::RandomMaster(const WritableObjects& objects, const NodeSetup& setup, const AttackStart& start,
                           double writes_s, SplitMix64& random)
    : objects_(objects), setup_(setup), start_(start), random_(random), camera_(kCameraCobId, random) {
  actions_ = static_cast<std::size_t>(8.0 * std::pow(2.0, uniform(0.0, 5.0)));
  actions_ = std::min(actions_, kMaxActions);
  for (std::size_t i = 0; i < actions_; ++i) {
    const double share = random_.uniform();
    action_s_[i] = start_.writes_from_s + writes_s * share * share;  // more of them early, while the axes are fast
  }
  std::sort(action_s_.begin(), action_s_.begin() + static_cast<std::ptrdiff_t>(actions_));
  next_revival_s_ = start_.writes_from_s + uniform(0.3, 1.0);
  talks_ = chance(0.8);
  camera_rpdo_ = below(4);
  revives_ = start_.theme != Theme::kTracking || !chance(kLeftAlone);
}

void RandomMaster::connect(DrivenNode& node, FrameMaster& master) {
  node_ = &node;
  master_ = &master;
}

double RandomMaster::joint_angle(int axis) const {
  return static_cast<double>(node_->axis(axis).objects.position.actual) / kCountsPerRad;
}

void RandomMaster::put(int axis, std::uint16_t index, std::uint8_t sub, std::uint8_t bytes, std::int64_t value) {
  (void)master_->write({index_of_axis(index, axis), sub, bytes, bits_of(value)});
}

void RandomMaster::enable(int axis) {
  static constexpr std::array<std::uint16_t, 5> kWords = {0x0000, 0x0080, 0x0006, 0x0007, 0x000F};
  for (const std::uint16_t controlword : kWords) {
    command(axis, controlword);
  }
}

void RandomMaster::go(int axis, std::int8_t mode, double rate_rad_s) {
  const double direction = rate_rad_s < 0.0 ? -1.0 : 1.0;
  put(axis, 0x6060, 0, 1, mode);
  switch (mode) {
    case DRIVE_PROFILE_POSITION:
      put(axis, 0x6081, 0, 4, std::llround(std::abs(rate_rad_s) * kCountsPerRad_s));
      put(axis, 0x607A, 0, 4, std::llround(hard_limit(setup_, axis, direction) * kCountsPerRad));
      command(axis, 0x003F);
      break;
    case DRIVE_CYCLIC_POSITION:
      stream_[static_cast<std::size_t>(axis)] = {100 + below(2000), rate_rad_s, joint_angle(axis), false};
      break;
    case DRIVE_CYCLIC_VELOCITY:
      stream_[static_cast<std::size_t>(axis)] = {100 + below(2000), rate_rad_s, 0.0, true};
      break;
    case DRIVE_HOMING:
      put(axis, 0x6098, 0, 1, kHomingMethods[static_cast<std::size_t>(below(kHomingMethods.size()))]);
      command(axis, 0x000F);
      command(axis, 0x001F);
      break;
    case DRIVE_TRACKING:
      track(axis, rate_rad_s);
      break;
    case DRIVE_CYCLIC_TORQUE:
      put(axis, 0x6071, 0, 2, std::llround(direction * uniform(200.0, 1000.0)));
      break;
    default:
      put(axis, 0x60FF, 0, 4, std::llround(rate_rad_s * kCountsPerRad_s));
      break;
  }
}

std::int8_t RandomMaster::random_mode() {
  const bool tracks = start_.theme == Theme::kTracking && chance(0.6);
  return tracks ? static_cast<std::int8_t>(DRIVE_TRACKING) : kModes[static_cast<std::size_t>(below(kModes.size()))];
}

bool RandomMaster::camera_is_mapped() const {
  const canopen_node& canopen = node_->node().canopen;
  const pdo_map& map = canopen.rpdos[camera_rpdo_].map;
  return canopen.objects.rpdo[camera_rpdo_].cob_id == kCameraCobId && map.count > 0 &&
         map.item[map.count - 1].object.entry != nullptr && map.item[map.count - 1].object.entry->index == 0x3070;
}

// Towards a target that leads it, or the present one, or none.
void RandomMaster::track(int axis, double rate_rad_s) {
  if (!camera_is_mapped() && chance(0.95)) {
    master_->map_camera(camera_rpdo_ + 1, kCameraCobId);
  }
  camera_.lead(axis, rate_rad_s);
  if (time_s_ < start_.writes_from_s) {
    camera_.begin_to_lead(time_s_, start_.writes_from_s + uniform(-0.2, 2.0));
  } else if (chance(camera_.has_begun() ? 0.5 : 0.95)) {
    camera_.begin(time_s_);
  }
}

void RandomMaster::film(double time_s) {
  if (!camera_.has_begun()) {
    return;
  }
  const std::array<bool, kAxes> tracks = {node_->axis(kAzimuth).drive.tracking != DRIVE_NOT_TRACKING,
                                          node_->axis(kPitch).drive.tracking != DRIVE_NOT_TRACKING};
  const std::optional<can_frame> frame = camera_.look(time_s, node_->machine().truth(), tracks);
  if (frame) {
    master_->send(*frame, "camera");
  }
}

void RandomMaster::begin_motion(int axis) {
  const AxisStart& start = start_.axis[static_cast<std::size_t>(axis)];
  const std::int64_t acceleration = std::llround(start_.acceleration_rad_s2 * kCountsPerRad_s);
  put(axis, 0x607F, 0, 4, std::llround(kFastest_rad_s * kCountsPerRad_s));
  put(axis, 0x6083, 0, 4, acceleration);
  if (chance(0.5)) {
    put(axis, 0x6084, 0, 4, acceleration);
  }
  enable(axis);
  go(axis, start.mode, start.rate_rad_s);
}

// Whatever the writes have stopped moves again, so that there is something to attack.
void RandomMaster::revive(double time_s) {
  if (time_s < next_revival_s_ || !revives_) {
    return;
  }
  next_revival_s_ = time_s + uniform(0.2, 1.2);
  if (node_->node().canopen.state != NMT_OPERATIONAL && chance(0.8)) {
    send_nmt(1);
  }
  for (int axis = 0; axis < kAxes; ++axis) {
    const bool enabled = node_->axis(axis).drive.state.power == DRIVE_OPERATION_ENABLED;
    if (!enabled && chance(0.9)) {
      enable(axis);
    }
    if (chance(enabled ? 0.3 : 0.9)) {
      go(axis, random_mode(), uniform(0.3, kFastest_rad_s) * (chance(0.5) ? -1.0 : 1.0));
    }
  }
}

void RandomMaster::step(double time_s) {
  time_s_ = time_s;
  if (!started_) {
    started_ = true;
    send_nmt(1);
    for (int axis = 0; axis < kAxes; ++axis) {
      begin_motion(axis);
    }
    if (start_.theme == Theme::kTracking && chance(0.5)) {
      (void)master_->write({0x3075, 2, 1, 1});  // the azimuth may turn back by a revolution
    }
  }
  while (next_action_ < actions_ && time_s >= action_s_[next_action_]) {
    next_action_++;
    act();
  }
  revive(time_s);
  stream();
  film(time_s);
  if (talks_ && time_s >= next_talk_s_) {
    next_talk_s_ = time_s + kTalk_s;
    master_->keep_alive();
  }
}

void RandomMaster::act() {
  const Shares& shares = kShares[static_cast<std::size_t>(start_.theme)];
  int drawn = below(100);
  for (std::size_t i = 0; i < kObjectGroups; ++i) {
    drawn -= shares.group[i];
    if (drawn < 0) {
      return write_random(kGroups[i]);
    }
  }
  if ((drawn -= shares.frames) < 0) {
    return act_on_bus();
  }
  if ((drawn -= shares.remap) < 0) {
    return remap();
  }
  if (drawn < shares.store) {
    return store();
  }
  return experiment();
}

void RandomMaster::write_random(ObjectGroup group) {
  const std::vector<WritableObject>& objects = objects_.group(group);
  if (objects.empty()) {
    return;
  }
  std::size_t chosen = static_cast<std::size_t>(below(objects.size()));
  if (group == ObjectGroup::kProfiles && !shapes_motion(*objects[chosen].entry)) {
    chosen = static_cast<std::size_t>(below(objects.size()));  // once more, so that most writes have an effect
  }
  const WritableObject& object = objects[chosen];
  (void)master_->write(
      {object.index, object.sub, static_cast<std::uint8_t>(object.entry->bytes), special_value(object)});
  const bool of_axis = group == ObjectGroup::kGains || (group == ObjectGroup::kTracking && object.index < 0x3000);
  if (of_axis && chance(0.4)) {
    (void)master_->write({index_of_axis(0x2070, object.index >= 0x2800 ? kPitch : kAzimuth), 1, 1, 1});
  }
}

std::uint32_t RandomMaster::random_cob_id(std::uint32_t present) {
  switch (below(6)) {
    case 0:
      return present | kOff;
    case 1:
      return present & ~kOff;
    case 2:  // an identifier that another object has already
      return node_->node().canopen.objects.rpdo[below(RPDO_COUNT)].cob_id;
    case 3:
      return node_->node().canopen.objects.sync.cob_id;
    default:
      return static_cast<std::uint32_t>(0x80 + below(0x680)) | (chance(0.3) ? kOff : 0);
  }
}

// Values that need more than a range to have an effect.
std::uint32_t RandomMaster::special_value(const WritableObject& object) {
  const std::uint16_t index = object.entry->index;
  const int axis = object.index == index ? kAzimuth : kPitch;
  const bool of_pdo = index >= 0x1400 && index < 0x1C00;
  if (index == 0x6040 && chance(0.85)) {
    static constexpr std::array<std::uint16_t, 16> kWords = {0x00, 0x02, 0x06, 0x07,  0x0B, 0x0F,  0x1F,  0x2F,
                                                             0x3F, 0x5F, 0x80, 0x10F, 0x07, 0x10B, 0x11F, 0x0D};
    return kWords[static_cast<std::size_t>(below(kWords.size()))];
  }
  if (index == 0x6060 && chance(0.9)) {
    return bits_of(random_mode());
  }
  if (index == 0x2070 && chance(0.7)) {
    return chance(0.7) ? 1 : 3;
  }
  if (index == 0x1010 || index == 0x1011) {
    return index == 0x1010 ? kSave : kLoad;
  }
  if ((index == 0x607A || index == 0x607D) && chance(0.5)) {
    const double limit_rad = hard_limit(setup_, axis, chance(0.5) ? -1.0 : 1.0);
    return bits_of(std::llround((limit_rad + uniform(-0.05, 0.05)) * kCountsPerRad));
  }
  if (index == 0x1005 || index == 0x1014 || index == 0x1201 || (of_pdo && (index & 0x200) == 0 && object.sub == 1)) {
    std::uint32_t present = 0;
    od_object found;
    if (od_find(servo_node_dictionary(&node_->node()), object.index, object.sub, &found) == OD_OK) {
      present = bits_of(od_get(&found).i);
    }
    return random_cob_id(present);
  }
  if (of_pdo && (index & 0x200) != 0 && object.sub > 0 && chance(0.9)) {
    const std::vector<std::uint32_t>& mappable = objects_.mappable();
    return mappable[static_cast<std::size_t>(below(mappable.size()))];
  }
  if (index == 0x1016 && chance(0.8)) {
    return 0x050000U | static_cast<std::uint32_t>(10 + below(2000));
  }
  return random_value(*object.entry, random_);
}

void RandomMaster::experiment() {
  const int axis = any_axis();
  put(axis, 0x6060, 0, 1, 0);
  put(axis, 0x2100, 4, 1, 1 + below(5));
  put(axis, 0x2100, 1, 1, 1);
}

// In the only order that the node accepts; with random objects.
void RandomMaster::remap() {
  const auto n = static_cast<std::uint16_t>(below(RPDO_COUNT));
  const auto bytes = static_cast<std::uint8_t>(4);
  const std::uint32_t cob_id = node_->node().canopen.objects.rpdo[n].cob_id;
  const std::uint16_t communication = static_cast<std::uint16_t>(0x1400 + n);
  const std::uint16_t mapping = static_cast<std::uint16_t>(0x1600 + n);
  const std::vector<std::uint32_t>& mappable = objects_.mappable();
  (void)master_->write({communication, 1, bytes, cob_id | kOff});
  (void)master_->write({mapping, 0, 1, 0});
  int left_bits = 64;
  std::uint32_t count = 0;
  for (int i = 0; i < 4; ++i) {
    const std::uint32_t entry = mappable[static_cast<std::size_t>(below(mappable.size()))];
    left_bits -= static_cast<int>(entry & 0xFF);
    if (left_bits < 0) {
      break;
    }
    count++;
    (void)master_->write({mapping, static_cast<std::uint8_t>(count), bytes, entry});
  }
  (void)master_->write({communication, 2, 1, chance(0.5) ? 255U : static_cast<std::uint32_t>(below(3))});
  (void)master_->write({mapping, 0, 1, count});
  (void)master_->write({communication, 1, bytes, cob_id & ~kOff});
}

// A save needs axes without torque; a load takes effect with the next reset.
void RandomMaster::store() {
  const auto group = static_cast<std::uint8_t>(1 + below(3));
  if (chance(0.5)) {
    (void)master_->write({0x1011, group, 4, kLoad});
  } else {
    for (int axis = 0; axis < kAxes; ++axis) {
      command(axis, 0);
    }
    (void)master_->write({0x1010, group, 4, kSave});
  }
  if (chance(0.6)) {
    send_nmt(chance(0.7) ? 129 : 130);
  }
}

void RandomMaster::send_nmt(std::uint8_t command) {
  static constexpr const char *kNames[] = {"start", "stop", "pre-operational", "reset node", "reset communication"};
  const int name = command == 1 ? 0 : command == 2 ? 1 : command - 126;
  master_->send(can_frame{0x000, 0, 2, {command, 0}, 0}, master_->explains() ? std::string("NMT ") + kNames[name] : "");
}

void RandomMaster::send_sync() {
  const std::uint32_t identifier = node_->node().canopen.objects.sync.cob_id & 0x7FF;
  const std::uint8_t overflow = node_->node().canopen.objects.sync.overflow;
  can_frame frame{identifier, 0, 0, {}, 0};
  if (overflow > 0) {
    frame.length = 1;
    frame.data[0] = static_cast<std::uint8_t>(1 + below(overflow));
  }
  master_->send(frame, "SYNC");
}

void RandomMaster::send_heartbeat() {
  master_->send(can_frame{0x705, 0, 1, {static_cast<std::uint8_t>(chance(0.9) ? 5 : 4)}, 0}, "heartbeat of node 5");
}

void RandomMaster::act_on_bus() {
  const int kind = below(20);
  if (kind < 11) {
    return send_rpdo(below(RPDO_COUNT), false);
  }
  if (kind < 14) {
    return send_sync();
  }
  if (kind < 16) {
    return send_heartbeat();
  }
  static constexpr std::array<std::uint8_t, 8> kCommands = {1, 1, 1, 1, 2, 128, 129, 130};
  send_nmt(kCommands[static_cast<std::size_t>(below(kCommands.size()))]);
}

// Legal values of whatever this RPDO is mapped to. As a stream: the next position or rate, and what is there already.
void RandomMaster::send_rpdo(int n, bool stream) {
  const canopen_node& canopen = node_->node().canopen;
  const pdo_map& map = canopen.rpdos[n].map;
  can_frame frame{canopen.objects.rpdo[n].cob_id & 0x7FF, 0, map.length, {}, 0};
  std::uint8_t *place = frame.data;
  for (int i = 0; i < map.count; ++i) {
    const pdo_item& item = map.item[i];
    std::uint32_t value = 0;
    if (item.object.entry != nullptr) {
      const std::uint16_t index = od_index(&item.object);
      const int axis = item.object.part->shift == 0 ? kAzimuth : kPitch;
      const Stream& moved = stream_[static_cast<std::size_t>(axis)];
      const bool moves = stream && moved.ticks_left > 0 && item.object.entry->index == 0x607A;
      value = moves    ? bits_of(std::llround(moved.position_rad * kCountsPerRad))
              : stream ? bits_of(od_get(&item.object).i)
                       : special_value({index, item.object.entry->sub, item.object.entry});
    }
    std::memcpy(place, &value, item.bytes);
    place += item.bytes;
  }
  master_->send(frame, master_->explains() ? "RPDO " + std::to_string(n + 1) : "");
}

// As a master in csp and csv does: a set-point for each tick, in the RPDO that carries it by default.
void RandomMaster::stream() {
  constexpr int kRates = 2;
  constexpr int kPositions = 3;
  bool rates = false;
  bool positions = false;
  for (Stream& one : stream_) {
    if (one.ticks_left > 0) {
      one.ticks_left--;
      one.position_rad += one.rate_rad_s * kTick_s;
      (one.of_rate ? rates : positions) = true;
    }
  }
  if (rates) {
    send_rpdo(kRates, true);
  }
  if (positions) {
    send_rpdo(kPositions, true);
  }
}

}  // namespace trackservo::sim
