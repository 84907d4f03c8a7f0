// SPDX-License-Identifier: Apache-2.0
// A master that moves the axes, mostly towards the ends of their travel, and then writes whatever is legal.
#ifndef TRACKSERVO_SIM_ATTACK_RANDOM_MASTER_HPP
#define TRACKSERVO_SIM_ATTACK_RANDOM_MASTER_HPP

#include <array>
#include <cstdint>
#include <string>

#include "judge/attack/frame_master.hpp"
#include "judge/attack/random_camera.hpp"
#include "judge/attack/writable_objects.hpp"

namespace trackservo::sim {

// What most of the writes of a seed concern.
enum class Theme { kProfiles, kGains, kStates, kBus, kStorage, kExperiments, kEverything, kTracking };

constexpr std::array<Theme, 8> kThemes = {Theme::kProfiles, Theme::kGains,       Theme::kStates,     Theme::kBus,
                                          Theme::kStorage,  Theme::kExperiments, Theme::kEverything, Theme::kTracking};

std::string theme_name(Theme theme);

// How an axis moves when the random writes begin.
struct AxisStart {
  std::int8_t mode = 0;
  double rate_rad_s = 0;  // signed
  double angle_rad = 0;   // of the joint at the start of the run
  bool heads_for_end = false;
};

struct AttackStart {
  Theme theme = Theme::kEverything;
  double writes_from_s = 1;
  double acceleration_rad_s2 = 3;
  std::array<AxisStart, kAxes> axis;
};

// Returns a start that depends on nothing but the seed and the travel.
AttackStart random_start(const NodeSetup& setup, SplitMix64& random);

class RandomMaster {
 public:
  RandomMaster(const WritableObjects& objects, const NodeSetup& setup, const AttackStart& start, double writes_s,
               SplitMix64& random);

  // Connects to a node and to the master of its frames. Call before the first tick.
  void connect(DrivenNode& node, FrameMaster& master);

  // Call before each tick.
  void step(double time_s);

 private:
  static constexpr std::size_t kMaxActions = 256;

  // A motion of csp or csv that continues by one RPDO per tick.
  struct Stream {
    int ticks_left = 0;
    double rate_rad_s = 0;
    double position_rad = 0;
    bool of_rate = false;  // csv: the rate itself
  };

  double uniform(double low, double high) { return low + (high - low) * random_.uniform(); }
  bool chance(double probability) { return random_.uniform() < probability; }
  int below(std::size_t count) { return static_cast<int>(random_() % count); }
  int any_axis() { return below(kAxes); }
  double joint_angle(int axis) const;

  void put(int axis, std::uint16_t index, std::uint8_t sub, std::uint8_t bytes, std::int64_t value);
  void command(int axis, std::uint16_t controlword) { put(axis, 0x6040, 0, 2, controlword); }
  void begin_motion(int axis);
  void enable(int axis);
  void go(int axis, std::int8_t mode, double rate_rad_s);
  std::int8_t random_mode();
  void track(int axis, double rate_rad_s);
  bool camera_is_mapped() const;
  void film(double time_s);
  void revive(double time_s);
  void act();
  void act_on_bus();
  void write_random(ObjectGroup group);
  std::uint32_t special_value(const WritableObject& object);
  std::uint32_t random_cob_id(std::uint32_t present);
  void experiment();
  void remap();
  void store();
  void send_rpdo(int n, bool stream);
  void send_nmt(std::uint8_t command);
  void send_sync();
  void send_heartbeat();
  void stream();

  const WritableObjects& objects_;
  const NodeSetup& setup_;
  AttackStart start_;
  SplitMix64& random_;
  DrivenNode *node_ = nullptr;
  FrameMaster *master_ = nullptr;
  std::array<double, kMaxActions> action_s_{};
  std::size_t actions_ = 0;
  std::size_t next_action_ = 0;
  double next_revival_s_ = 0;
  bool revives_ = true;
  bool talks_ = true;  // between its actions, so that the node does not stop the axes of a silent master (6007)
  double next_talk_s_ = 0;
  bool started_ = false;
  std::array<Stream, kAxes> stream_{};
  RandomCamera camera_;
  int camera_rpdo_ = 0;  // from 0
  double time_s_ = 0;
};

}  // namespace trackservo::sim

#endif
