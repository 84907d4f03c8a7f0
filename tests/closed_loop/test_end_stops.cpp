// SPDX-License-Identifier: Apache-2.0
// How fast an axis can reach its end stop: legal objects, written while it moves at full speed shortly before the end
// of its travel, with default limits and without opening the lock; and a start in an unknown turn.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <functional>
#include <optional>
#include <string>

#include "bench.hpp"
#include "device/driven_node.hpp"
#include "device/node_setup.hpp"
#include "support/test_size.h"

namespace sim = trackservo::sim;

extern "C" void setUp() {}
extern "C" void tearDown() {}

namespace {

constexpr std::int8_t kProfilePosition = 1;
constexpr std::int8_t kProfileVelocity = 3;
constexpr std::int8_t kCyclicPosition = 8;
constexpr std::int8_t kCyclicVelocity = 9;
constexpr std::int8_t kCyclicTorque = 10;
constexpr double kDeg = sim::kPi / 180.0;
constexpr double kContact_rad_s = 5.0 * kDeg;
constexpr std::int64_t kFast = 1400000;

sim::PlantConfig tracker() { return sim::load_plant("sim_host/plants/tracker.toml"); }

// The tracker with end stops of the azimuth at +-70 degrees: a start anywhere is in a known turn.
sim::NodeSetup narrow_setup() {
  sim::PlantConfig plant = tracker();
  plant.axis[sim::kAzimuth].end_stops->lower_rad = -70.0 * kDeg;
  plant.axis[sim::kAzimuth].end_stops->upper_rad = 70.0 * kDeg;
  return sim::NodeSetup(plant);
}

struct Outcome {
  double contact_rad_s = 0;  // fastest beyond the end stop's angle
  double beyond_rad = -1e3;  // farthest beyond the end of the hard travel
  double peak_rad_s = 0;     // since the attack
  double rest_rad_s = 0;     // in the last half second
  double stopped_s = 0;      // from the attack to the last motion above 1 degree per second
  double travel_rad = 0;     // from the attack to the end
  fault_id fault = FAULT_NONE;
};

class Ride {
 public:
  Ride(const sim::NodeSetup& setup, int axis, std::uint64_t seed, double start_rad, bool brakes = true,
       double pitch_rad = 0.4)
      : setup_(setup),
        axis_(axis),
        i_(static_cast<std::size_t>(axis)),
        brakes_(brakes),
        node_(setup, seed, start_of(axis, start_rad, pitch_rad)) {
    if (brakes) {
      node_.machine().fit_holding_brakes();
    }
  }

  // Up to full speed, until this far before the end of the hard travel.
  void approach(std::int8_t mode, double room_rad) {
    node_.write(axis_, 0x607F, 0, 0xFFFFFFFF);
    node_.write(axis_, 0x6083, 0, 5000000);
    node_.write(axis_, 0x6084, 0, 0xFFFFFFFF);
    node_.write(axis_, 0x607D, 1, 0);
    node_.write(axis_, 0x607D, 2, 0);
    std::array<std::int8_t, sim::kAxes> modes = {kProfileVelocity, kProfileVelocity};
    modes[i_] = mode;
    node_.enable(modes);
    for (int tick = 0; tick < 20000 && room() > room_rad; ++tick) {
      refresh();
      step();
    }
    from_rad_ = angle();
    fastest_before_rad_s_ = rate();
  }

  Outcome attack(const std::function<void(Ride&)>& what, double duration_s) {
    outcome_ = {};
    what(*this);
    const int ticks = static_cast<int>(duration_s / sim::kTick_s);
    for (int tick = 0; tick < ticks; ++tick) {
      refresh();
      step();
      note(tick, ticks);
    }
    outcome_.travel_rad = angle() - from_rad_;
    outcome_.fault = node_.axis(axis_).drive.fault;
    return outcome_;
  }

  void apply(std::initializer_list<std::pair<std::uint32_t, double>> reals) {
    for (const auto& [object, value] : reals) {
      node_.write_real(axis_, static_cast<std::uint16_t>(object >> 8), static_cast<std::uint8_t>(object & 0xFF), value);
    }
  }

  // Applies the written gains, or has them refused as unstable.
  void try_parameter_set() {
    try {
      node_.write(axis_, 0x2070, 1, 1);
    } catch (const std::runtime_error&) {
      std::printf("(refused) ");
    }
  }

  // In the loops themselves: the check of a parameter set may refuse it, and the envelope must not depend on that.
  void gains_off() {
    speed_loop_params& speed = node_.node().board.app.params.axis[axis_].speed;
    speed.pi.proportional_gain = 0.0F;
    speed.pi.integral_gain = 0.0F;
    speed.acceleration_inertia_kg_m2 = 0.0F;
    speed.observer_on = false;
    speed.friction.model = FRICTION_NONE;
  }

  void set(std::uint16_t index, std::uint8_t sub, std::int64_t value) { node_.write(axis_, index, sub, value); }
  sim::DrivenNode& node() { return node_; }
  sim::BrokenAxis& broken() { return node_.machine().broken().axis[i_]; }
  double angle() { return node_.machine().truth().joint_angle_rad[i_]; }
  double rate() { return node_.machine().truth().joint_rate_rad_s[i_]; }
  double speed_before() const { return fastest_before_rad_s_; }
  void keep_pushing(std::int64_t permille) { torque_ = permille; }
  void keep_writing(std::optional<std::int64_t> target) { target_ = target; }
  void step() { node_.tick(); }

 private:
  static std::array<double, sim::kAxes> start_of(int axis, double start_rad, double pitch_rad) {
    std::array<double, sim::kAxes> start = {0.2, pitch_rad};
    start[static_cast<std::size_t>(axis)] = start_rad;
    return start;
  }

  // Cyclic set-points go on.
  void refresh() {
    if (target_) {
      node_.write(axis_, 0x60FF, 0, *target_);
    }
    if (torque_) {
      node_.write(axis_, 0x6071, 0, *torque_);
    }
  }

  double room() { return static_cast<double>(setup_.limits[i_].maximum_rad) - angle(); }

  // Wind may turn an axis that has come to rest without torque and has no holding brake (docs/safety.md): not counted.
  void note(int tick, int ticks) {
    const bool off = node_.axis(axis_).drive.state.action == DRIVE_OFF;
    rested_ = rested_ || (!brakes_ && off && std::abs(rate()) < 1.0 * kDeg);
    if (rested_) {
      return;
    }
    const double end_stop_rad = setup_.plant.axis[i_].end_stops->upper_rad;
    outcome_.beyond_rad = std::max(outcome_.beyond_rad, -room());
    outcome_.peak_rad_s = std::max(outcome_.peak_rad_s, std::abs(rate()));
    if (angle() > end_stop_rad || angle() < setup_.plant.axis[i_].end_stops->lower_rad) {
      outcome_.contact_rad_s = std::max(outcome_.contact_rad_s, std::abs(rate()));
    }
    if (std::abs(rate()) > 1.0 * kDeg) {
      outcome_.stopped_s = (tick + 1) * sim::kTick_s;
    }
    if (tick > ticks - 500) {
      outcome_.rest_rad_s = std::max(outcome_.rest_rad_s, std::abs(rate()));
    }
  }

  const sim::NodeSetup& setup_;
  int axis_;
  std::size_t i_;
  bool brakes_;
  bool rested_ = false;
  sim::DrivenNode node_;
  std::optional<std::int64_t> target_ = kFast;
  std::optional<std::int64_t> torque_;
  Outcome outcome_;
  double from_rad_ = 0;
  double fastest_before_rad_s_ = 0;
};

struct Attack {
  const char *name;
  std::int8_t mode;
  std::function<void(Ride&)> what;
  bool holds;                 // nothing is wrong with the stop that it orders, so no fault of the envelope is needed
  bool needs_brakes = false;  // no master can do it: with damaged gains (fault 51) the shorted motor alone stops
  std::function<void(Ride&)> first = nullptr;  // before the axis is enabled
  double earlier_rad = 0;                      // that the axis turns before what has been written takes effect
};

const std::vector<Attack>& attacks() {
  static const std::vector<Attack> list = {
      {"6084 = 1 and 60A4:1 = 1", kProfileVelocity,
       [](Ride& r) {
         r.set(0x6084, 0, 1);
         r.set(0x60A4, 1, 1);
       },
       false},
      {"6072 = 0", kProfileVelocity, [](Ride& r) { r.set(0x6072, 0, 0); }, false},
      {"60E0 = 60E1 = 0", kProfileVelocity,
       [](Ride& r) {
         r.set(0x60E0, 0, 0);
         r.set(0x60E1, 0, 0);
       },
       false},
      {"6076 = 1", kProfileVelocity, [](Ride& r) { r.set(0x6076, 0, 1); }, false},
      {"quick stop with 6085 = 1 and 60A4:1 = 1", kProfileVelocity,
       [](Ride& r) {
         r.set(0x6085, 0, 1);
         r.set(0x60A4, 1, 1);
         r.set(0x6040, 0, 0x0B);
       },
       true},
      {"halt with 6084 = 1", kProfileVelocity,
       [](Ride& r) {
         r.set(0x6084, 0, 1);
         r.set(0x6040, 0, 0x10F);
       },
       true},
      {"all gains of the speed loop 0", kProfileVelocity, [](Ride& r) { r.gains_off(); }, true, true},
      {"csv, gains 0, 60B2 = +100 %", kCyclicVelocity,
       [](Ride& r) {
         r.gains_off();
         r.set(0x60B2, 0, 1000);
       },
       false, true},
      {"cst, 6071 = +100 %", kProfileVelocity,
       [](Ride& r) {
         r.set(0x6060, 0, kCyclicTorque);
         r.keep_pushing(1000);
       },
       true},
      {"2020:2 = 1e-9", kProfileVelocity,
       [](Ride& r) {
         r.apply({{0x202002, 1e-9}});
         r.try_parameter_set();
       },
       true},
      {"low-pass of 5 Hz", kProfileVelocity,
       [](Ride& r) {
         r.apply({{0x204004, 5.0}});
         r.try_parameter_set();
       },
       true},
      {"disable voltage", kProfileVelocity, [](Ride& r) { r.set(0x6040, 0, 0x00); }, true},
      {"quick stop with 605A = 0", kProfileVelocity,
       [](Ride& r) {
         r.set(0x605A, 0, 0);
         r.set(0x6040, 0, 0x0B);
       },
       true},
      {"heartbeat lost with 6085 = 1", kProfileVelocity,
       [](Ride& r) {
         r.set(0x6085, 0, 1);
         r.set(0x60A4, 1, 1);
         r.set(0x1016, 1, 0x7F << 16 | 50);
         r.node().receive(can_frame{0x77F, 0, 1, {0x05}, 0});
       },
       true},
      {"heartbeat lost with 605E = 0", kProfileVelocity,
       [](Ride& r) {
         r.set(0x605E, 0, 0);
         r.set(0x1016, 1, 0x7F << 16 | 50);
         r.node().receive(can_frame{0x77F, 0, 1, {0x05}, 0});
       },
       true},
      {"NMT stop with 6085 = 1", kProfileVelocity,
       [](Ride& r) {
         r.set(0x6085, 0, 1);
         r.set(0x60A4, 1, 1);
         r.node().receive(can_frame{0x000, 0, 2, {0x02, 0x00}, 0});
       },
       true},
      {"reset of the node", kProfileVelocity,
       [](Ride& r) {
         r.node().receive(can_frame{0x000, 0, 2, {0x81, 0x00}, 0});
       },
       true},
      {"2062 = 1, a second before", kProfileVelocity, [](Ride& r) { r.set(0x2062, 0, 1); }, false, false, nullptr, 1.1},
      {"csv against a torque offset, with weak gains", kCyclicTorque,
       [](Ride& r) {
         r.set(0x6060, 0, kCyclicVelocity);
         r.keep_writing(-1);
         r.set(0x60B2, 0, 1000);
       },
       false, false,
       [](Ride& r) {
         r.apply({{0x200001, 1.0}, {0x200002, 0.0}, {0x202001, 0.0}});
         r.set(0x2070, 1, 1);
         r.keep_pushing(1000);
       }},
  };
  return list;
}

// 0.30 rad before the end of the travel, at the fastest rate that the drive allows, in wind, in every inertia that the
// pitch gives the azimuth, with and without holding brakes: no contact.
void test_no_write_at_full_speed_near_the_end_reaches_the_end_stop(void) {
  const sim::NodeSetup setup = narrow_setup();
  double worst_beyond_rad = -1e3;
  for (const Attack& attack : attacks()) {
    for (const int axis : {sim::kAzimuth, sim::kPitch}) {
      for (const double room_rad : {0.30, 0.20}) {
        for (int n = 1; n <= by_size(2, 6, 60); ++n) {
          const auto seed = static_cast<std::uint64_t>(n);
          const protection_limits& travel = setup.limits[static_cast<std::size_t>(axis)];
          const double end_rad = static_cast<double>(travel.maximum_rad);
          const double start_rad =
              std::max(end_rad - 1.1 - attack.earlier_rad, static_cast<double>(travel.minimum_rad) + 0.1);
          const bool brakes = n % 2 != 0 || attack.needs_brakes;
          Ride ride(setup, axis, seed, start_rad, brakes);
          if (attack.first) {
            attack.first(ride);
          }
          ride.approach(attack.mode, room_rad + attack.earlier_rad);
          const Outcome o = ride.attack(attack.what, 4.0);
          const std::string text = fmt::format(
              "{}, {} holding brakes, axis {}, {:.2f} rad before the end at {:.2f} rad/s, seed {}: contact at {:.2f} "
              "deg/s, {:.1f} mrad "
              "beyond the hard travel, fault {}, peak {:.2f} rad/s, moved for {:.2f} s",
              attack.name, brakes ? "with" : "without", axis, room_rad, ride.speed_before(), seed,
              o.contact_rad_s / kDeg, 1e3 * o.beyond_rad, static_cast<int>(o.fault), o.peak_rad_s, o.stopped_s);
          if (seed <= 2) {
            std::printf("%s\n", text.c_str());
          }
          TEST_ASSERT_TRUE_MESSAGE(ride.speed_before() > 0.85, text.c_str());
          TEST_ASSERT_TRUE_MESSAGE(o.contact_rad_s == 0.0, text.c_str());
          TEST_ASSERT_TRUE_MESSAGE(o.peak_rad_s < 1.55, text.c_str());
          TEST_ASSERT_TRUE_MESSAGE(attack.holds || o.fault != FAULT_NONE, text.c_str());
          worst_beyond_rad = std::max(worst_beyond_rad, o.beyond_rad);
        }
      }
    }
  }
  std::printf("%.1f mrad beyond the hard travel at most; the end stop is at 17.5\n", 1e3 * worst_beyond_rad);
}

// --- defects near the end ----------------------------------------------------------------------------------------

struct Defect {
  const char *name;
  void (*begin)(Ride&);
  fault_id fault;
  double contact_deg_s;  // at most, of an axis without a holding brake
};

// What the envelope brakes by is good while a gyro is wrong. Where the encoder, the converters or the values in use are
// wrong, the motor is shorted, and brakes as strongly as its speed: too little so near the end.
void test_a_defect_at_full_speed_near_the_end_has_a_stated_contact(void) {
  const Defect defects[] = {
      {"gyro saturated", [](Ride& r) { r.broken().gyro_reads_rad_s = 10.0; }, FAULT_GYRO_SATURATED, 0.0},
      {"gyro stuck", [](Ride& r) { r.broken().gyro_stuck = true; }, FAULT_SENSORS_DISAGREE, 45.0},
      {"gyro lost", [](Ride& r) { r.broken().gyro_lost = true; }, FAULT_GYRO_LOST, 0.0},
      {"encoder lost", [](Ride& r) { r.broken().encoder_lost = true; }, FAULT_ENCODER_LOST, 45.0},
      {"encoder stuck", [](Ride& r) { r.broken().encoder_stuck = true; }, FAULT_ENCODER_JUMP, 45.0},
      {"bus reads 10 V", [](Ride& r) { r.node().machine().broken().bus_reads_v = 10.0; }, FAULT_UNDER_VOLTAGE, 45.0},
      {"set damaged", [](Ride& r) { r.gains_off(); }, FAULT_ACTIVE_SET, 45.0},
  };
  const sim::NodeSetup setup = narrow_setup();
  for (const Defect& defect : defects) {
    for (const bool brakes : {true, false}) {
      for (const int axis : {sim::kAzimuth, sim::kPitch}) {
        double contact_deg_s = 0.0;
        for (int seed = 1; seed <= by_size(1, 3, 20); ++seed) {
          const protection_limits& travel = setup.limits[static_cast<std::size_t>(axis)];
          const double start_rad =
              std::max(static_cast<double>(travel.maximum_rad) - 1.1, static_cast<double>(travel.minimum_rad) + 0.1);
          const double pitch_rad = seed % 2 != 0 ? 0.4 : 1.35;  // there the azimuth has least inertia
          Ride ride(setup, axis, static_cast<std::uint64_t>(seed), start_rad, brakes, pitch_rad);
          ride.approach(kProfileVelocity, 0.18);
          const Outcome o = ride.attack([&defect](Ride& r) { defect.begin(r); }, 4.0);
          contact_deg_s = std::max(contact_deg_s, o.contact_rad_s / kDeg);
          TEST_ASSERT_EQUAL_MESSAGE(defect.fault, o.fault, defect.name);
        }
        std::printf("%-16s %-8s, %-7s holding brake: contact at %4.1f deg/s\n", defect.name,
                    axis == sim::kAzimuth ? "azimuth" : "pitch", brakes ? "with" : "without", contact_deg_s);
        TEST_ASSERT_TRUE_MESSAGE(contact_deg_s <= (brakes ? 0.0 : defect.contact_deg_s), defect.name);
      }
    }
  }
}

// Far from the ends: a stop that the bus loss or a command orders ends in the stated time and distance, whatever the
// objects say.
void test_an_ordered_stop_ends_in_the_stated_time_and_distance(void) {
  sim::NodeSetup setup(tracker());
  for (const Attack& attack : attacks()) {
    const std::string name = attack.name;
    if (name.find("stop") == std::string::npos && name.find("heartbeat") == std::string::npos) {
      continue;
    }
    Ride ride(setup, sim::kAzimuth, 5, -1.2);
    ride.approach(attack.mode, 4.9);
    const Outcome o = ride.attack(attack.what, 6.0);
    const std::string text = fmt::format("{}: at {:.2f} rad/s, stopped after {:.2f} s and {:.2f} rad, fault {}", name,
                                         ride.speed_before(), o.stopped_s, o.travel_rad, static_cast<int>(o.fault));
    std::printf("%s\n", text.c_str());
    TEST_ASSERT_TRUE_MESSAGE(o.stopped_s < 3.7 && o.travel_rad < 3.4, text.c_str());
  }
}

// --- the turn of the start ---------------------------------------------------------------------------------------

// The tracker's azimuth turns by +-280 degrees; its encoder knows one turn.
struct UnknownStart {
  double start_deg;
  std::int8_t mode;
  double direction;
};

void test_a_start_in_an_unknown_turn_moves_slowly_until_it_is_known(void) {
  const sim::NodeSetup setup(tracker());
  int contacts = 0;
  for (const double start_deg : {-240.0, -200.0, 200.0, 240.0}) {
    for (const std::int8_t mode : {kProfileVelocity, kCyclicVelocity}) {
      for (const double direction : {-1.0, 1.0}) {
        Ride ride(setup, sim::kAzimuth, 7, start_deg * kDeg);
        ride.keep_writing(std::nullopt);
        ride.set(0x607F, 0, 0xFFFFFFFF);
        ride.set(0x6083, 0, 5000000);
        ride.node().enable(mode);
        ride.keep_writing(static_cast<std::int64_t>(direction * kFast));
        const Outcome o = ride.attack([](Ride&) {}, 50.0);
        const servo_node_axis& axis = ride.node().axis(sim::kAzimuth);
        const bool known = (axis.monitor.restrictions & RESTRICTED_POSITION_UNKNOWN) == 0;
        const double error_rad = axis.objects.position.actual * 1e-7 - ride.angle();
        const std::string text = fmt::format(
            "start at {:.0f} deg, mode {}, {:+.0f}: contact at {:.2f} deg/s, fault {}, {}, position wrong by {:.4f} "
            "rad",
            start_deg, mode, direction, o.contact_rad_s / kDeg, static_cast<int>(o.fault),
            known ? "known" : "not known", error_rad);
        std::printf("%s\n", text.c_str());
        TEST_ASSERT_TRUE_MESSAGE(o.contact_rad_s <= kContact_rad_s, text.c_str());
        TEST_ASSERT_TRUE_MESSAGE(known || o.fault != FAULT_NONE, text.c_str());
        TEST_ASSERT_TRUE_MESSAGE(!known || std::abs(error_rad) < 1e-3, text.c_str());
        contacts += o.contact_rad_s > 0.0 ? 1 : 0;
      }
    }
  }
  std::printf("%d of 16 touched the end stop\n", contacts);
}

// Full torque, no gains, at the largest allowed speed: the slow limit holds as well.
void test_no_write_makes_an_axis_in_an_unknown_turn_fast(void) {
  const sim::NodeSetup setup(tracker());
  for (const Attack& attack : attacks()) {
    Ride ride(setup, sim::kAzimuth, 11, 240.0 * kDeg);
    ride.node().enable(attack.mode);
    (void)ride.attack([](Ride&) {}, 3.0);
    const Outcome o = ride.attack(attack.what, 12.0);
    const std::string text =
        fmt::format("{} in an unknown turn: peak {:.2f} deg/s, contact {:.2f} deg/s, fault {}", attack.name,
                    o.peak_rad_s / kDeg, o.contact_rad_s / kDeg, static_cast<int>(o.fault));
    std::printf("%s\n", text.c_str());
    TEST_ASSERT_TRUE_MESSAGE(o.peak_rad_s <= 1.3 * kContact_rad_s, text.c_str());
    TEST_ASSERT_TRUE_MESSAGE(o.contact_rad_s <= kContact_rad_s, text.c_str());
  }
}

void test_absolute_targets_wait_until_the_operator_has_confirmed_the_turn(void) {
  const sim::NodeSetup setup(tracker());
  for (const std::int8_t mode : {kProfilePosition, kCyclicPosition}) {
    Ride ride(setup, sim::kAzimuth, 3, 240.0 * kDeg);
    ride.keep_writing(std::nullopt);
    ride.node().enable(mode);
    const double before_rad = ride.angle();
    const auto target = static_cast<std::int64_t>(1e7 * 200.0 * kDeg);
    for (int tick = 0; tick < 2000; ++tick) {
      ride.set(0x607A, 0, target);
      ride.set(0x6040, 0, tick == 0 ? 0x0F : 0x1F);
      ride.step();
    }
    TEST_ASSERT_TRUE(std::abs(ride.angle() - before_rad) < 1e-3);
    TEST_ASSERT_TRUE((ride.node().axis(0).objects.state.statusword & 1U << 11) != 0);
    ride.node().unlock();
    bool refused = false;
    try {
      ride.set(0x2061, 5, 1);  // the axis has power
    } catch (const std::exception&) {
      refused = true;
    }
    TEST_ASSERT_TRUE(refused);
    for (const int axis : {sim::kAzimuth, sim::kPitch}) {  // the lock opens for axes that are off
      ride.node().write(axis, 0x6040, 0, 0x00);
    }
    ride.step();
    ride.step();
    ride.node().unlock();
    ride.set(0x2061, 5, 1);
    for (int tick = 0; tick < 8; ++tick) {
      ride.step();
    }
    ride.node().enable(mode);
    TEST_ASSERT_TRUE(std::abs(ride.node().axis(0).objects.position.actual * 1e-7 - ride.angle()) < 1e-3);
    for (int tick = 0; tick < 6000; ++tick) {
      ride.set(0x607A, 0, target);
      ride.set(0x6040, 0, tick == 0 ? 0x0F : 0x1F);
      ride.step();
    }
    TEST_ASSERT_TRUE(std::abs(ride.angle() - 200.0 * kDeg) < (mode == kProfilePosition ? 1e-3 : 1e-2));
  }
}

}  // namespace

int main() {
  UNITY_BEGIN();
  RUN_TEST(test_no_write_at_full_speed_near_the_end_reaches_the_end_stop);
  RUN_TEST(test_a_defect_at_full_speed_near_the_end_has_a_stated_contact);
  RUN_TEST(test_an_ordered_stop_ends_in_the_stated_time_and_distance);
  RUN_TEST(test_a_start_in_an_unknown_turn_moves_slowly_until_it_is_known);
  RUN_TEST(test_no_write_makes_an_axis_in_an_unknown_turn_fast);
  RUN_TEST(test_absolute_targets_wait_until_the_operator_has_confirmed_the_turn);
  return UNITY_END();
}
