// SPDX-License-Identifier: Apache-2.0
// Plant and scenario files: the shipped ones load, bad ones are refused with file, line, key, reason and remedy.
#include <unistd.h>

#include <algorithm>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>

#include "support/bench.hpp"
#include "support/check.h"

namespace {

std::filesystem::path folder;

}  // namespace

extern "C" void setUp(void) {
  folder = std::filesystem::temp_directory_path() / ("trackservo_config_" + std::to_string(getpid()));
  std::filesystem::create_directories(folder);
}

extern "C" void tearDown(void) { std::filesystem::remove_all(folder); }

namespace {

using namespace bench;

std::string shipped_text(const std::string& path) {
  std::ifstream stream(std::string(TRACKSERVO_SOURCE_DIR) + "/sim_host/" + path);
  std::stringstream text;
  text << stream.rdbuf();
  return text.str();
}

// One change to a shipped file, at the first occurrence after an anchor.
struct Change {
  const char *after;
  const char *from;
  const char *to;
};

struct Edited {
  std::filesystem::path path;
  int line;  // of the change
};

Edited edited(const std::string& shipped, const Change& change) {
  std::string text = shipped_text(shipped);
  const std::size_t anchor = text.find(change.after);
  TEST_ASSERT_TRUE_MESSAGE(anchor != std::string::npos, change.after);
  const std::size_t place = text.find(change.from, anchor);
  TEST_ASSERT_TRUE_MESSAGE(place != std::string::npos, change.from);
  text.replace(place, std::string(change.from).size(), change.to);
  const auto line = 1 + std::count(text.begin(), text.begin() + static_cast<std::ptrdiff_t>(place), '\n');
  const std::filesystem::path path = folder / "bad.toml";
  std::ofstream(path) << text;
  return {path, static_cast<int>(line)};
}

template <class Load>
std::string refusal(Load load, const std::filesystem::path& path) {
  try {
    load(path);
  } catch (const ConfigError& error) {
    return error.what();
  }
  return "";
}

struct BadValue {
  Change change;
  const char *key;
  const char *reason;
  const char *remedy;
};

// `line_shift`: from the change to the named line, where that is another one.
template <class Load>
void check_refusals(const std::string& shipped, Load load, const std::vector<BadValue>& cases, int line_shift = 0) {
  for (const BadValue& bad : cases) {
    const Edited file = edited(shipped, bad.change);
    const std::string text = refusal(load, file.path);
    const std::string where = file.path.string() + ":" + std::to_string(file.line + line_shift) + ": " + bad.key + ": ";
    const bool complete = text.rfind(where, 0) == 0 && text.find(bad.reason) != std::string::npos &&
                          text.find(bad.remedy) != std::string::npos;
    const std::string message = "want " + where + bad.reason + ", " + bad.remedy + " but got " + text;
    TEST_ASSERT_TRUE_MESSAGE(complete, message.c_str());
  }
}

void test_shipped_plants_load_in_si_units() {
  const PlantConfig plant = shipped_plant("tracker");
  TEST_ASSERT_EQUAL_STRING("tracker", plant.name.c_str());
  TEST_ASSERT_TRUE(plant.friction_model == FrictionModel::kLugre);
  CHECK_NEAR("Stribeck speed in rad/s", 0.3 * kRadPerDeg, plant.axis[kAzimuth].friction.positive.stribeck_speed_rad_s,
             1e-12);
  CHECK_NEAR("inductance in H", 3e-3, plant.axis[kAzimuth].motor.inductance_h, 1e-12);
  CHECK_NEAR("ripple", 0.015, plant.axis[kPitch].motor.ripple.at(1).fraction, 1e-12);
  CHECK_NEAR("scale error", 300e-6, plant.axis[kAzimuth].gyro.scale_error, 1e-12);
  CHECK_NEAR("inertia at the horizon", 6.0, axis_inertia_kg_m2(plant, kAzimuth, 0.0), 1e-12);
  CHECK_NEAR("inertia at the zenith", 3.0, axis_inertia_kg_m2(plant, kAzimuth, 0.5 * kPi), 1e-12);
  TEST_ASSERT_TRUE(plant.axis[kPitch].end_stops.has_value());
  CHECK_AT_LEAST("assumptions listed", 5, plant.assumptions.size());
}

void test_paper_plant_holds_the_published_numbers() {
  const PlantConfig plant = shipped_plant("paper_simulation");
  for (const AxisConfig& axis : plant.axis) {
    CHECK_SAME("J", 23.5, axis.inertia_kg_m2);
    CHECK_SAME("sigma0", 308.1, axis.friction.stiffness_nm_rad);
    CHECK_SAME("sigma1", 108.46, axis.friction.damping_nm_s_rad);
    CHECK_NEAR("sigma2 from sigma1", std::sqrt(2.0 * 23.5 * 308.1) - 108.46, axis.friction.positive.viscous_nm_s_rad,
               1e-3);
    TEST_ASSERT_FALSE(axis.end_stops.has_value());
  }
  CHECK_NEAR("natural frequency in rad/s", 6.5, plant.design[kAzimuth].speed_loop_natural_frequency_rad_s.value(), 1.0);
}

void test_shipped_scenarios_load() {
  CHECK_NEAR("sine in deg/s", 1.0, shipped_scenario("sine").speeds_rad_s.at(0) / kRadPerDeg, 1e-12);
  CHECK_NEAR("disturbance in Hz", 2.0, shipped_scenario("step_disturbed").disturbance_frequency_hz, 1e-12);
  TEST_ASSERT_EQUAL(3, shipped_scenario("low_speed_start").speeds_rad_s.size());
  TEST_ASSERT_EQUAL(5, shipped_scenario("steady_speed").speeds_rad_s.size());
  const CameraConfig camera = shipped_scenario("tracking").camera;
  CHECK_NEAR("pixel in urad", 11.499, camera.pixel_rad * 1e6, 1e-9);
  CHECK_NEAR("delay in s", 0.02, camera.delay_s, 1e-12);
}

void test_steps_of_the_joints_that_do_not_divide_the_tick_are_refused() {
  const std::string tracker = shipped_text("plants/tracker.toml");
  const auto with_periods = [&](const std::string& periods) {
    return parse_plant("machine", tracker + "\n[mechanics]\npwm_periods_per_step = " + periods + "\n");
  };
  TEST_ASSERT_EQUAL_INT(4, with_periods("4").mechanics.pwm_periods_per_step);
  try {
    (void)with_periods("3");
    TEST_FAIL_MESSAGE("3 periods per step were accepted");
  } catch (const ConfigError& error) {
    const std::string text = error.what();
    TEST_ASSERT_TRUE_MESSAGE(text.find("mechanics.pwm_periods_per_step: 3 does not divide") != std::string::npos,
                             text.c_str());
    TEST_ASSERT_TRUE_MESSAGE(text.find("give 1, 2 or 4") != std::string::npos, text.c_str());
  }
}

void test_bad_plants_are_refused_with_line_key_reason_and_remedy() {
  check_refusals(
      "plants/tracker.toml", [](const auto& path) { load_plant(path); },
      {
          {{"[azimuth]", "inertia_kg_m2 = 3.0", "inertia_kg_m2 = -3.0"},
           "azimuth.inertia_kg_m2",
           "-3 is out of range",
           "give number from"},
          {{"[azimuth]", "inertia_kg_m2 = 3.0", "inertia_kg_m2 = 0"}, "azimuth.inertia_kg_m2", "out of range", "1e-06"},
          {{"[pitch]", "inertia_kg_m2 = 2.5", "inertia_kg_m2 = nan"}, "pitch.inertia_kg_m2", "is nan", "finite"},
          {{"[pitch]", "inertia_kg_m2 = 2.5", "inertia_kg_m2 = inf"}, "pitch.inertia_kg_m2", "is inf", "finite"},
          {{"[pitch]", "inertia_kg_m2 = 2.5", "inertia_kg_m2 = \"2.5\""},
           "pitch.inertia_kg_m2",
           "is text",
           "give number"},
          {{"[pitch]", "inertia_kg_m2 = 2.5", "inertia_kg_m2 = true"},
           "pitch.inertia_kg_m2",
           "is true or false",
           "give number"},
          {{"[azimuth.motor]", "resistance_ohm = 1.2", "resistance_ohms = 1.2"},
           "azimuth.motor.resistance_ohms",
           "not a known key",
           "did you mean resistance_ohm?"},
          {{"[azimuth.motor]", "resistance_ohm = 1.2", "colour = 1.2"},
           "azimuth.motor.colour",
           "not a known key",
           "remove it"},
          {{"[azimuth.friction.positive]", "breakaway_nm = 9.0", "breakaway_nm = 5.0"},
           "azimuth.friction.positive.breakaway_nm",
           "below coulomb_nm = 6",
           "at least 6"},
          {{"[azimuth.friction]", "stiffness_nm_rad = 30000.0", "stiffness_nm_rad = 1"},
           "azimuth.friction.stiffness_nm_rad",
           "more than 1 rad",
           "at least"},
          {{"[friction]", "model = \"lugre\"", "model = \"lugree\""},
           "friction.model",
           "is not known",
           "\"maxwell_slip\""},
          {{"[azimuth.encoder]", "resolution_bits = 26", "resolution_bits = 0"},
           "azimuth.encoder.resolution_bits",
           "0 is out of range",
           "8 to 32"},
          {{"[azimuth.encoder]", "resolution_bits = 26", "resolution_bits = 26.0"},
           "azimuth.encoder.resolution_bits",
           "is a number",
           "integer"},
          {{"[azimuth.encoder]", "resolution_bits = 26", "resolution_bits = 99999999999"},
           "azimuth.encoder.resolution_bits",
           "out of range",
           "8 to 32"},
          {{"[pitch]", "end_stops_deg = [-20.0, 95.0]", "end_stops_deg = [95.0, -20.0]"},
           "pitch.end_stops_deg",
           "must be two angles in ascending order",
           "[lower, upper]"},
          {{"[pitch]", "end_stops_deg = [-20.0, 95.0]", "end_stops_deg = 95.0"},
           "pitch.end_stops_deg",
           "is a number",
           "brackets"},
          {{"[pitch.gyro]", "bandwidth_hz = 440.0", "bandwidth_hz = -1.0"},
           "pitch.gyro.bandwidth_hz",
           "out of range",
           "Hz"},
          {{"[supply]", "pwm_counts = 4250", "pwm_counts = 1"}, "supply.pwm_counts", "out of range", "16"},
          {{"[[azimuth.motor.ripple]]", "harmonic = 8", "harmonic = 0"},
           "azimuth.motor.ripple[0].harmonic",
           "out of range",
           "1 to 1000"},
          {{"[design.pitch]", "feedback = \"fused\"", "feedback = 3"},
           "design.pitch.feedback",
           "is an integer",
           "quotes"},
          {{"[design.pitch]", "rate_window_ticks = 2", "rate_window_ticks = 17"},
           "design.pitch.rate_window_ticks",
           "out of range",
           "2 to 16"},
          {{"[design.pitch]", "speed_loop_bandwidth_hz = 30.0",
            "speed_loop_bandwidth_hz = 30.0\nspeed_loop_natural_frequency_rad_s = 6.5"},
           "design.pitch.speed_loop_bandwidth_hz",
           "excludes",
           "exactly one"},
      });
}

void test_missing_keys_and_tables_are_named() {
  const auto text_of = [](const Change& change) {
    return refusal([](const auto& path) { load_plant(path); }, edited("plants/tracker.toml", change).path);
  };
  const auto contains = [](const std::string& text, const char *part) {
    TEST_ASSERT_TRUE_MESSAGE(text.find(part) != std::string::npos, (std::string(part) + " in " + text).c_str());
  };
  std::string text = text_of({"[azimuth.motor]", "resistance_ohm = 1.2\n", ""});
  contains(text, "azimuth.motor.resistance_ohm: is missing, give number from 0.0001 to 10000 ohm");
  text = text_of({"[supply]", "[supply]", "[supply_of_power]"});
  contains(text, "supply_of_power: is not a known key");
  text = text_of({"[pitch.gyro]", "[pitch.gyro]", "[pitch.load.gyro]"});
  contains(text, "pitch.load");
  text = text_of({"[design.azimuth]", "speed_loop_bandwidth_hz = 30.0\n", ""});
  contains(text, "give exactly one");
  text = text_of({"title", "title = ", "title = \"\" # "});
  contains(text, ":4: title: is empty");
}

void test_a_swing_inertia_of_pitch_is_refused() {
  const Edited file = edited("plants/tracker.toml",
                             {"[pitch]", "inertia_kg_m2 = 2.5", "inertia_kg_m2 = 2.5\ninertia_swing_kg_m2 = 1.0"});
  const std::string text = refusal([](const auto& path) { load_plant(path); }, file.path);
  const std::string want = ":" + std::to_string(file.line + 1) + ": pitch.inertia_swing_kg_m2: belongs to azimuth only";
  TEST_ASSERT_TRUE_MESSAGE(text.find(want) != std::string::npos, text.c_str());
}

void test_bad_scenarios_are_refused_with_line_key_reason_and_remedy() {
  check_refusals(
      "scenarios/steady_speed.toml", [](const auto& path) { load_scenario(path); },
      {
          {{"kind", "kind = \"speed_step\"", "kind = \"speed_jump\""}, "kind", "not known", "\"speed_step\""},
          {{"kind", "duration_s = 23.5", "duration_s = 3.0"},
           "duration_s",
           "leaves less than 0.1 s for the analysis",
           "at least rest_s + settle_s + 0.1 = 3.6"},
          {{"kind", "duration_s = 23.5", "duration_s = 3.55"}, "duration_s", "less than 0.1 s", "= 3.6"},
          {{"kind", "duration_s = 23.5", "duration_s = nan"}, "duration_s", "is nan", "finite"},
          {{"kind", "axes = [\"azimuth\", \"pitch\"]", "axes = [\"roll\"]"}, "axes", "an unknown axis", "\"azimuth\""},
          {{"kind", "axes = [\"azimuth\", \"pitch\"]", "axes = []"},
           "axes",
           "must be a non-empty list",
           "at least one"},
          {{"kind", "axes = [\"azimuth\", \"pitch\"]", "axes = [\"pitch\", \"pitch\"]"},
           "axes",
           "\"pitch\" twice",
           "at least one"},
          {{"kind", "speeds_deg_s = [0.1,", "speeds_deg_s = [0.0,"},
           "speeds_deg_s",
           "0 is too small for a step",
           "0.0001 deg/s"},
          {{"kind", "speeds_deg_s = [0.1,", "speeds_deg_s = [-0.00005,"},
           "speeds_deg_s",
           "too small for a step",
           "backwards"},
          {{"kind", "speeds_deg_s = [0.1,", "speeds_deg_s = [2,"}, "speeds_deg_s", "contains 2 twice", "once"},
          {{"kind", "speeds_deg_s = [0.1,", "speeds_deg_s = [1001,"}, "speeds_deg_s", "out of range", "to 1000 deg/s"},
          {{"kind", "initial_pitch_deg = 0.0", "initial_pitch_deg = 200"}, "initial_pitch_deg", "out of range", "180"},
          {{"kind", "speeds_deg_s = [0.1,", "speeds_deg_s = [inf,"}, "speeds_deg_s", "is inf", "finite"},
          {{"kind", "speeds_deg_s = [0.1,", "frequency_hz = 1.0 #"}, "frequency_hz", "not a known key", ""},
      });
  check_refusals(
      "scenarios/tracking.toml", [](const auto& path) { load_scenario(path); },
      {
          {{"[camera]", "delay_ms = 20.0", "delay_ms = 150.0"}, "camera.delay_ms", "out of range", "0 to 127 ms"},
          {{"[camera]", "frame_rate_hz = 50.0", "frame_rate_hz = 1.0"}, "camera.frame_rate_hz", "range", "from 2"},
          {{"kind", "settle_s = 5.0", "rest_s = 1.0\nsettle_s = 5.0"},
           "rest_s",
           "is not allowed in tracking",
           "remove it"},
          {{"kind", "settle_s = 5.0", "initial_pitch_deg = 3\nsettle_s = 5.0"},
           "initial_pitch_deg",
           "is not allowed in tracking",
           "fly_by.start_position_m"},
          {{"[fly_by]", "velocity_m_s = [-20.0, 0.0, 0.0]", "velocity_m_s = [-20.0, 0.0]"},
           "fly_by.velocity_m_s",
           "has 2 elements",
           "3 numbers"},
          {{"[camera]", "width_px = 1920", "width_px = 1920.5"}, "camera.width_px", "is a number", "integer"},
      });
}

void test_a_pass_and_a_picture_are_scenario_keys() {
  const ScenarioConfig scenario = load_scenario(
      edited("studies/straight_passes/scenario.toml", {"[camera]", "geometry = \"line_of_sight\"",
                                                       "geometry = \"line_of_sight\"\nroll_deg = 90\nboresight_y_urad "
                                                       "= 5\ndropouts_at_s = [1, 2.5]\ndropout_s = 0.2"})
          .path);
  TEST_ASSERT_TRUE(scenario.camera.geometry == CameraGeometry::kLineOfSight);
  CHECK_NEAR("roll in rad", 0.5 * kPi, scenario.camera.mounting.roll_rad, 1e-12);
  CHECK_NEAR("boresight in rad", 5e-6, scenario.camera.mounting.boresight_y_rad, 1e-18);
  CHECK_SAME("second dropout", 2.5, scenario.camera.dropouts_at_s.at(1));
  CHECK_NEAR("ahead at the closest approach in m", 500.0 / std::sqrt(3.0), scenario.fly_by.start_position_m[0], 1e-9);
  CHECK_NEAR("to the right at the start in m", -500.0, scenario.fly_by.start_position_m[1], 1e-9);
  PassConfig evasive = scenario.pass.value();
  evasive.evasive_m_s2 = 5.0;
  evasive.evasive_period_s = 4.0;
  CHECK_NEAR("weave in m", 5.0 * 4.0 / (kPi * kPi), course_of(evasive).weave_lateral_m, 1e-9);
  const ScenarioConfig paper = shipped_scenario("tracking");
  TEST_ASSERT_TRUE(paper.camera.geometry == CameraGeometry::kPerAxis);
  TEST_ASSERT_FALSE(paper.pass.has_value());
}

void test_passes_and_pictures_without_sense_are_refused() {
  const auto load = [](const auto& path) { load_scenario(path); };
  const char *const image = "geometry = \"line_of_sight\"";
  check_refusals(
      "studies/straight_passes/scenario.toml", load,
      {{{"[pass]", "elevation_deg = 60.0", "elevation_deg = 91"}, "pass.elevation_deg", "out of range", "to 90 deg"},
       {{"[pass]", "height_m = 500.0", "height_m = 0"}, "pass.height_m", "out of range", "from 1"},
       {{"kind", "axes", "pointing = \"both\"\naxes"}, "pointing", "both", "\"per_axis\""}});
  check_refusals("studies/straight_passes/scenario.toml", load,
                 {{{"[camera]", image, "geometry = \"line_of_sight\"\ndropout_s = 1"},
                   "camera.dropout_s",
                   "has no effect alone",
                   "dropouts_at_s"},
                  {{"[camera]", image, "geometry = \"line_of_sight\"\ndropouts_at_s = [3]"},
                   "camera.dropouts_at_s",
                   "has no effect alone",
                   "dropout_s"}},
                 1);
  const std::string rolled = refusal(
      load, edited("scenarios/tracking.toml", {"[camera]", "width_px = 1920", "roll_deg = 3\nwidth_px = 1920"}).path);
  TEST_ASSERT_TRUE_MESSAGE(
      rolled.find("camera.roll_deg: has no effect on a camera that measures each axis") != std::string::npos,
      rolled.c_str());
  const std::string two = refusal(load, edited("studies/straight_passes/scenario.toml",
                                               {"[pass]", "speed_m_s = 20.0", "speed_m_s = 20.0\n[fly_by]"})
                                            .path);
  TEST_ASSERT_TRUE_MESSAGE(two.find("pass: and fly_by are both given, give one of them") != std::string::npos,
                           two.c_str());
}

void test_disturbances_and_sines_without_sense_are_refused() {
  const auto load = [](const auto& path) { load_scenario(path); };
  check_refusals("scenarios/step_disturbed.toml", load,
                 {{{"kind", "disturbance_frequency_hz = 2.0", ""},
                   "disturbance_amplitude_deg_s",
                   "has no effect alone",
                   "together"}},
                 -1);
  check_refusals("scenarios/step_disturbed.toml", load,
                 {{{"kind", "disturbance_frequency_hz = 2.0", "disturbance_frequency_hz = 501"},
                   "disturbance_frequency_hz",
                   "501 is out of range",
                   "to 200 Hz"},
                  {{"kind", "disturbance_amplitude_deg_s = 0.02", "disturbance_amplitude_deg_s = -0.02"},
                   "disturbance_amplitude_deg_s",
                   "out of range",
                   "from 0"}});
  check_refusals("scenarios/sine.toml", load,
                 {{{"kind", "speeds_deg_s = [1.0]", "speeds_deg_s = [-1.0]"}, "speeds_deg_s", "out of range", "0.0001"},
                  {{"kind", "frequency_hz = 0.1", "frequency_hz = 0"}, "frequency_hz", "out of range", "0.001"}});
}

void test_a_camera_may_be_as_late_as_the_firmware_remembers_and_ten_frames() {
  const auto scenario_with = [](const char *camera) {
    return edited("scenarios/tracking.toml", {"[camera]", "frame_rate_hz = 50.0\ndelay_ms = 20.0", camera}).path;
  };
  CHECK_NEAR("delay in s", 0.127, load_scenario(scenario_with("frame_rate_hz = 50\ndelay_ms = 127")).camera.delay_s,
             1e-12);
  const std::string text =
      refusal([](const auto& path) { load_scenario(path); }, scenario_with("frame_rate_hz = 100\ndelay_ms = 101"));
  TEST_ASSERT_TRUE_MESSAGE(text.find("longer than 10 frames, give at most 100") != std::string::npos, text.c_str());
}

void test_converters_must_show_what_they_convert() {
  check_refusals("plants/tracker.toml", [](const auto& path) { load_plant(path); },
                 {{{"[adc]", "current_full_scale_a = 25.0", "current_full_scale_a = 10.0"},
                   "adc.current_full_scale_a",
                   "is below the current limit of azimuth",
                   "current_limit_a = 16"},
                  {{"[adc]", "voltage_full_scale_v = 66.0", "voltage_full_scale_v = 40.0"},
                   "adc.voltage_full_scale_v",
                   "is below the supply voltage",
                   "voltage_v = 48"}});
}

void test_unreadable_and_malformed_files_are_refused() {
  const auto load = [](const auto& path) { load_plant(path); };
  const std::string missing = refusal(load, folder / "none.toml");
  TEST_ASSERT_TRUE_MESSAGE(missing.find("none.toml:1: file: cannot be read") != std::string::npos, missing.c_str());
  TEST_ASSERT_TRUE(refusal(load, folder).find("cannot be read") != std::string::npos);
  std::ofstream(folder / "broken.toml") << "title = \"x\"\n\n[azimuth\n";
  const std::string broken = refusal(load, folder / "broken.toml");
  TEST_ASSERT_TRUE_MESSAGE(broken.find("broken.toml:3: syntax: ") != std::string::npos, broken.c_str());
  std::ofstream(folder / "twice.toml") << "title = \"x\"\ntitle = \"y\"\n";
  const std::string twice = refusal(load, folder / "twice.toml");
  TEST_ASSERT_TRUE_MESSAGE(twice.find("twice.toml:2: syntax: ") != std::string::npos, twice.c_str());
  std::ofstream(folder / "deep.toml") << "title = \"x...\"\n" << std::string(50000, '.') << "a = 1\n";
  const std::string deep = refusal(load, folder / "deep.toml");
  TEST_ASSERT_TRUE_MESSAGE(deep.find("deep.toml:2: syntax: a name of more than") != std::string::npos, deep.c_str());
}

void test_the_reference_pages_name_every_shipped_key() {
  const std::string pages = plant_keys_markdown() + scenario_keys_markdown();
  for (const char *file : {"plants/tracker.toml", "scenarios/tracking.toml", "scenarios/steady_speed.toml",
                           "studies/straight_passes/scenario.toml"}) {
    std::istringstream lines(shipped_text(file));
    std::string line;
    while (std::getline(lines, line)) {
      const std::size_t equals = line.find(" = ");
      if (equals == std::string::npos || line[0] == '#' || line.rfind("axes", 0) == 0) {
        continue;
      }
      const std::string key = "| `" + line.substr(0, equals) + "` |";
      TEST_ASSERT_TRUE_MESSAGE(pages.find(key) != std::string::npos, key.c_str());
    }
  }
}

}  // namespace

int main() {
  UNITY_BEGIN();
  RUN_TEST(test_shipped_plants_load_in_si_units);
  RUN_TEST(test_paper_plant_holds_the_published_numbers);
  RUN_TEST(test_shipped_scenarios_load);
  RUN_TEST(test_steps_of_the_joints_that_do_not_divide_the_tick_are_refused);
  RUN_TEST(test_bad_plants_are_refused_with_line_key_reason_and_remedy);
  RUN_TEST(test_missing_keys_and_tables_are_named);
  RUN_TEST(test_a_swing_inertia_of_pitch_is_refused);
  RUN_TEST(test_bad_scenarios_are_refused_with_line_key_reason_and_remedy);
  RUN_TEST(test_a_pass_and_a_picture_are_scenario_keys);
  RUN_TEST(test_passes_and_pictures_without_sense_are_refused);
  RUN_TEST(test_disturbances_and_sines_without_sense_are_refused);
  RUN_TEST(test_a_camera_may_be_as_late_as_the_firmware_remembers_and_ten_frames);
  RUN_TEST(test_converters_must_show_what_they_convert);
  RUN_TEST(test_unreadable_and_malformed_files_are_refused);
  RUN_TEST(test_the_reference_pages_name_every_shipped_key);
  return UNITY_END();
}
