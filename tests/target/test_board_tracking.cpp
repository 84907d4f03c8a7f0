// SPDX-License-Identifier: Apache-2.0
// The emulated board tracks a target over CAN, beside the host's firmware: the same machine, noise, target and camera.
//
// Each run: power on at the first angles of the course, set up the camera's PDO at 0.4 s without the first dither,
// whose end depends on the frames, and enable both axes in mode -1 at 0.6 s with the gains of a new device; the target
// begins its course at 1 s. Frames come over the bus, 20 ms after exposure. The figures are those of the tracking
// experiment: standard deviation of target minus line of sight.
//
// TESTS_SIZE=large: the whole fly-by with five seeds and both loops, and 20 targets that move already.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <optional>
#include <string>
#include <vector>

#include "board_steps.hpp"
#include "device/tracking_node.hpp"
#include "machine/target/target_camera.hpp"
#include "rig.hpp"
#include "support/moving_target.hpp"
#include "support/test_size.h"
#include "support/turned_picture.hpp"
#include "unity.h"

using bench::BoardRig;
using bench::HostRig;
namespace sim = trackservo::sim;
using sim::TargetCamera;

void setUp(void) {}
void tearDown(void) {}

namespace {

constexpr double kSetUpAt_s = 0.4;
constexpr double kEnabledAt_s = 0.6;
constexpr double kSendingPhase_s = 0.6e-3;  // from a tick of the board to the frames of the master and the camera
constexpr double kBegins_s = 1.0;
constexpr int kTracking = 0xFF;  // -1 as an 8-bit number
constexpr double kUrad = 1e-6;
constexpr double kPicture_rad = 0.032;

using Error = std::array<double, sim::kAxes>;

bool whole_windows() { return test_size_wanted() == TEST_LARGE; }

sim::ScenarioConfig fly_by() {
  sim::ScenarioConfig scenario = sim::load_scenario("sim_host/scenarios/tracking.toml");
  if (!whole_windows()) {
    scenario.duration_s = 15.0;
  }
  return scenario;
}

// 85 deg high, 500 m up, 20 m/s: the azimuth turns by up to 26 deg/s.
sim::ScenarioConfig steep_pass() {
  sim::ScenarioConfig scenario = sim::load_scenario("sim_host/studies/straight_passes/scenario.toml");
  scenario.pass->elevation_rad = 85.0 * sim::kRadPerDeg;
  scenario.fly_by = sim::course_of(*scenario.pass);
  return scenario;
}

std::uint32_t bits_of(float value) {
  std::uint32_t bits = 0;
  std::memcpy(&bits, &value, sizeof bits);
  return bits;
}

// A master that has not seen the device before. 2011:1 to :4 of the loop, or all as delivered.
template <typename Rig>
void set_up(Rig& rig, const std::optional<target_tracker_params>& loop) {
  for (const sim::ObjectWrite& write : sim::camera_mapping(4, sim::kCameraCobId)) {
    const bool is_count = write.sub == 0;
    const std::string text = fmt::format("{:04X}:{}", write.index, write.sub);
    TEST_ASSERT_TRUE_MESSAGE(rig.client.write(write.index, write.sub, write.value, is_count ? 1 : 4), text.c_str());
  }
  for (const int shift : {0, 0x800}) {
    const auto of_axis = [shift](int index) { return static_cast<std::uint16_t>(index + shift); };
    if (loop) {
      TEST_ASSERT_TRUE(rig.client.write(of_axis(0x2011), 1, static_cast<std::uint32_t>(loop->kind), 4));
      TEST_ASSERT_TRUE(rig.client.write(of_axis(0x2011), 2, bits_of(loop->proportional_per_s), 4));
      TEST_ASSERT_TRUE(rig.client.write(of_axis(0x2011), 3, bits_of(loop->integral_per_s2), 4));
      TEST_ASSERT_TRUE(rig.client.write(of_axis(0x2011), 4, bits_of(loop->estimator_rad_s), 4));
      TEST_ASSERT_TRUE(rig.client.write(of_axis(0x2070), 1, 1, 1));
    }
  }
  TEST_ASSERT_TRUE(rig.client.write(0x3073, 8, bits_of(0.0F), 4));  // no first dither
  TEST_ASSERT_TRUE(rig.client.write(0x3040, 1, 0x6E65706F, 4));
  TEST_ASSERT_TRUE(rig.client.write(0x2061, 5, 0, 1));  // it stands in this turn
  TEST_ASSERT_TRUE(rig.client.write(0x3040, 1, 0, 4));
}

// Error of each tick from the beginning of the course.
template <typename Rig>
std::vector<Error> track(Rig& rig, TargetCamera& camera, const sim::ScenarioConfig& scenario,
                         const std::optional<target_tracker_params>& loop) {
  const auto pass_ms = [&rig, &camera] {
    if (const std::optional<can_frame> frame = camera.look(rig.truth())) {
      rig.client.send(*frame);
    }
    rig.client.pass(1);
  };
  const auto pass_until = [&rig](double time_s) {
    while (rig.truth().time_s < time_s - 0.5 * sim::kTick_s) {
      rig.client.pass(1);
    }
  };
  pass_until(kSetUpAt_s);
  set_up(rig, loop);
  pass_until(kEnabledAt_s);
  rig.client.start_node();
  TEST_ASSERT_TRUE_MESSAGE(rig.client.enable(kTracking), "both axes must be enabled");
  while (rig.truth().time_s < kBegins_s) {
    pass_ms();
  }
  std::vector<Error> errors;
  while (rig.truth().time_s < kBegins_s + scenario.duration_s) {
    pass_ms();
    errors.push_back(camera.error_rad(rig.truth()));
  }
  TEST_ASSERT_EQUAL_HEX32(0, rig.client.error_code(0));
  TEST_ASSERT_EQUAL_HEX32(0, rig.client.error_code(1));
  return errors;
}

std::vector<Error> on_host(const sim::PlantConfig& plant, const sim::ScenarioConfig& scenario,
                           const std::optional<target_tracker_params>& loop, std::uint64_t seed) {
  TargetCamera camera(scenario, seed, kBegins_s);
  HostRig host(plant, seed, camera.first_angle_rad());
  return track(host, camera, scenario, loop);
}

std::vector<Error> on_board(const sim::PlantConfig& plant, const sim::ScenarioConfig& scenario,
                            const std::optional<target_tracker_params>& loop, std::uint64_t seed) {
  TargetCamera camera(scenario, seed, kBegins_s);
  BoardRig board(plant, seed, false, camera.first_angle_rad());
  board.client.pass(bench::kBoot_ms);
  TEST_ASSERT_TRUE(board.machine.run_after_tick(kSendingPhase_s));
  const std::vector<Error> errors = track(board, camera, scenario, loop);
  for (const std::string& violation : board.machine.chip().violations.list()) {
    TEST_FAIL_MESSAGE(violation.c_str());
  }
  TEST_ASSERT_EQUAL_INT(0, board.machine.chip().resets());
  return errors;
}

double spread_urad(const std::vector<Error>& errors, std::size_t axis, double begin_s) {
  double sum = 0.0;
  double squares = 0.0;
  int count = 0;
  for (auto i = static_cast<std::size_t>(1e3 * begin_s); i < errors.size(); ++i, ++count) {
    sum += errors[i][axis];
    squares += errors[i][axis] * errors[i][axis];
  }
  const double mean = sum / count;
  return std::sqrt(squares / count - mean * mean) / kUrad;
}

double rms_difference_urad(const std::vector<Error>& a, const std::vector<Error>& b, std::size_t axis, double begin_s) {
  double squares = 0.0;
  int count = 0;
  for (auto i = static_cast<std::size_t>(1e3 * begin_s); i < std::min(a.size(), b.size()); ++i, ++count) {
    squares += (a[i][axis] - b[i][axis]) * (a[i][axis] - b[i][axis]);
  }
  return std::sqrt(squares / count) / kUrad;
}

void compare(const std::string& name, const sim::ScenarioConfig& scenario,
             const std::optional<target_tracker_params>& loop, Error max_urad, std::uint64_t seed = 1) {
  const sim::PlantConfig plant = bench::tracker_plant();
  const std::vector<Error> expected = on_host(plant, scenario, loop, seed);
  const std::vector<Error> ideal = on_host(bench::without_quantisation(plant), scenario, loop, seed);
  const std::vector<Error> found = on_board(plant, scenario, loop, seed);
  for (std::size_t axis = 0; axis < sim::kAxes; ++axis) {
    const double s_urad = rms_difference_urad(expected, ideal, axis, scenario.settle_s);
    const double difference_urad = rms_difference_urad(found, expected, axis, scenario.settle_s);
    const double board_urad = spread_urad(found, axis, scenario.settle_s);
    const std::string text = fmt::format(
        "{}, {}: {:.2f} urad on the board, {:.2f} on the host; errors differ by {:.2f} urad rms ({:.2f} allowed)", name,
        sim::axis_name(static_cast<int>(axis)), board_urad, spread_urad(expected, axis, scenario.settle_s),
        difference_urad, bench::kMaxDifference * s_urad);
    TEST_MESSAGE(text.c_str());
    TEST_ASSERT_TRUE_MESSAGE(difference_urad <= bench::kMaxDifference * s_urad, text.c_str());
    TEST_ASSERT_TRUE_MESSAGE(board_urad <= max_urad[axis], text.c_str());
  }
}

int seeds() { return by_size(1, 1, 5); }

void test_the_fly_by_on_the_board_is_the_hosts() {
  for (int seed = 1; seed <= seeds(); ++seed) {
    compare(fmt::format("fly-by, seed {}", seed), fly_by(), std::nullopt, {2.5, 3.0}, static_cast<std::uint64_t>(seed));
  }
}

// 10 % more than `sim_host run` has, as for the node on the host.
void test_the_papers_loop_on_the_board_is_the_hosts() {
  const target_tracker_params loop = sim::designed_tracking_loop(bench::tracker_plant(), TRACKER_PI);
  for (int seed = 1; seed <= seeds(); ++seed) {
    compare(fmt::format("fly-by, paper's loop, seed {}", seed), fly_by(), loop, {11.9, 14.6},
            static_cast<std::uint64_t>(seed));
  }
}

void test_a_steep_pass_on_the_board_is_the_hosts() {
  target_tracker_params loop = sim::designed_tracking_loop(bench::tracker_plant(), TRACKER_PREDICTIVE);
  loop.proportional_per_s = sim::kPassProportional_per_s;
  loop.estimator_rad_s = sim::kPassEstimator_rad_s;
  compare("pass at 85 deg", steep_pass(), loop, {5.0, 5.0});
}

constexpr std::uint32_t kRight = 1;  // 3072:9; higher: the picture is turned or mirrored

// The targets of test_swinging_target, in pictures of the azimuth; the pitch sees its target in the centre.
void test_a_target_that_moves_already_stops_no_axis_of_the_board() {
  const int count = by_size(1, 4, 20);
  for (int i = 0; i < count; ++i) {
    const MovingTarget target = moving_target(i);
    BoardRig board(bench::tracker_plant(), static_cast<std::uint64_t>(i) + 1, false, {0.0, 0.0});
    board.client.pass(bench::kBoot_ms);
    TEST_ASSERT_TRUE(board.machine.run_after_tick(kSendingPhase_s));
    set_up(board, std::nullopt);
    board.client.start_node();
    TEST_ASSERT_TRUE_MESSAGE(board.client.enable(kTracking), "both axes must be enabled");
    sim::CameraSender sender(sim::kCameraCobId);
    std::vector<double> errors_rad;  // of each tick
    for (int tick = 0; tick < 2500; ++tick) {
      errors_rad.push_back(target.angle_rad(tick) - board.truth().joint_angle_rad[sim::kAzimuth]);
      const int exposed = tick - target.age_ticks;
      if (exposed >= 0 && exposed % target.period_ticks == 0) {
        const double seen_rad = errors_rad[static_cast<std::size_t>(exposed)];
        const bool found = std::abs(seen_rad) < kPicture_rad;
        board.client.send(
            sender.frame_of({0.0, target.stated_ticks * sim::kTick_s, {found ? seen_rad : 0.0, 0.0}, found}));
      }
      board.client.pass(1);
    }
    const std::string text =
        fmt::format("{}: {}, in the end {:.2f} mrad off", i, target.text(), 1e3 * errors_rad.back());
    TEST_MESSAGE(text.c_str());
    TEST_ASSERT_EQUAL_HEX32_MESSAGE(0, board.client.error_code(0), text.c_str());
    TEST_ASSERT_EQUAL_HEX32_MESSAGE(0, board.client.error_code(1), text.c_str());
    TEST_ASSERT_TRUE_MESSAGE(board.client.read(0x3072, 9).value_or(99) <= kRight, text.c_str());
  }
}

// What test_turned_picture shows for many pictures, at the image: 3072:5, :9, EMCY, and a right picture beside it.
void test_a_wrong_picture_stops_the_board() {
  constexpr int kWrong = 6;
  constexpr JointPair kTarget_rad = {0.004, 0.003};
  const TurnedPicture pictures[] = {{"upside down", 180.0},
                                    {},
                                    {"mirrored", 0.0, true},
                                    {"turned by 90 deg", 90.0},
                                    {"upside down, twice as large", 180.0, false, 2.0},
                                    {"turned by -90 deg, half as large", -90.0, false, 0.5},
                                    {"right, twice as large", 0.0, false, 2.0}};
  const int count = by_size(1, 7, 7);
  for (int i = 0; i < count; ++i) {
    const TurnedPicture& picture = pictures[i];
    BoardRig board(bench::tracker_plant(), static_cast<std::uint64_t>(i) + 1, false, {0.0, 0.0});
    board.client.pass(bench::kBoot_ms);
    TEST_ASSERT_TRUE(board.machine.run_after_tick(kSendingPhase_s));
    set_up(board, std::nullopt);
    board.client.start_node();
    TEST_ASSERT_TRUE_MESSAGE(board.client.enable(kTracking), "both axes must be enabled");
    sim::CameraSender sender(sim::kCameraCobId);
    PictureRun run(picture, {}, [&kTarget_rad](double) { return kTarget_rad; });
    for (int tick = 0; tick < 1500; ++tick) {
      const sim::TruthState truth = board.truth();
      PictureRun::Frame frame{};
      if (run.look({truth.joint_angle_rad[sim::kAzimuth], truth.joint_angle_rad[sim::kPitch]}, &frame)) {
        board.client.send(sender.frame_of(
            {0.0, frame.age_ticks * sim::kTick_s, {frame.x_urad * kUrad, frame.y_urad * kUrad}, frame.found}));
      }
      board.client.pass(1);
    }
    const bool right = picture.roll_deg == 0.0 && !picture.mirrored;
    const std::uint32_t state = board.client.read(0x3072, 5).value_or(99);
    const std::uint32_t verdict = board.client.read(0x3072, 9).value_or(99);
    const std::string text =
        fmt::format("{}: 3072:5 = {}, 3072:9 = {}, {:.2f} mrad off, {:.2f} deg moved", picture.name, state, verdict,
                    1e3 * run.error_rad(), run.ways_rad().back() / sim::kRadPerDeg);
    TEST_MESSAGE(text.c_str());
    if (right) {
      TEST_ASSERT_EQUAL_INT_MESSAGE(1, verdict, text.c_str());
      TEST_ASSERT_TRUE_MESSAGE(run.error_rad() < 1e-3, text.c_str());
      continue;
    }
    TEST_ASSERT_EQUAL_INT_MESSAGE(kWrong, state, text.c_str());
    TEST_ASSERT_EQUAL_INT_MESSAGE(picture.mirrored ? 4 : 3, verdict, text.c_str());
    TEST_ASSERT_TRUE_MESSAGE(run.ways_rad().back() < 2.3 * sim::kRadPerDeg, text.c_str());
    TEST_ASSERT_TRUE_MESSAGE(bench::has_heard(board, 0x7000, 7), text.c_str());
  }
}

}  // namespace

int main() {
  UNITY_BEGIN();
  RUN_TEST(test_the_fly_by_on_the_board_is_the_hosts);
  RUN_TEST(test_the_papers_loop_on_the_board_is_the_hosts);
  RUN_TEST(test_a_steep_pass_on_the_board_is_the_hosts);
  RUN_TEST(test_a_target_that_moves_already_stops_no_axis_of_the_board);
  RUN_TEST(test_a_wrong_picture_stops_the_board);
  return UNITY_END();
}
