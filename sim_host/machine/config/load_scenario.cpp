// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "machine/base/firmware.hpp"
#include "machine/config/scenario_config.hpp"
#include "machine/config/toml_reader.hpp"

namespace trackservo::sim {

namespace {

constexpr Range kDistance_m{-1e5, 1e5};
constexpr double kSlowest_deg_s = 1e-4;
constexpr double kMinAnalysis_s = 0.1;  // torque noise is measured relative to a mean over 51 ms
// The firmware stores this many ticks of the line of sight's motion; it does not use an older frame.
constexpr double kLongestDelay_ms = (TARGET_TRACKER_HISTORY - 1) * kTick_s * 1e3;

Keys<ScenarioConfig> scenario_keys() {
  using Config = ScenarioConfig;
  return {
      words("name", &Config::name, "name of the experiment"),
      words("title", &Config::title, "one line for the report"),
      choice("kind", {"speed_sine", "speed_step", "tracking"}, &Config::kind, "kind of reference"),
      number("duration_s", unit::kSecond, {0.01, 3600}, &Config::duration_s, "length of a run"),
      number("rest_s", unit::kSecond, {0, 3600}, &Config::rest_s, "end of the initial standstill; not in tracking")
          .or_else(0),
      number("settle_s", unit::kSecond, {0, 3600}, &Config::settle_s, "time from rest_s to the start of the analysis")
          .or_else(0),
  };
}

struct InitialKeys {
  double azimuth_rad = 0;
  double pitch_rad = 0;
};

Keys<InitialKeys> initial_keys() {
  return {
      number("initial_azimuth_deg", unit::kDegree, {-1e4, 1e4}, &InitialKeys::azimuth_rad,
             "azimuth joint angle at time 0")
          .or_else(0),
      number("initial_pitch_deg", unit::kDegree, {-180, 180}, &InitialKeys::pitch_rad, "pitch joint angle at time 0")
          .or_else(0),
  };
}

Keys<ScenarioConfig> sine_keys() {
  using Config = ScenarioConfig;
  return {
      number("speeds_deg_s", unit::kDegreePerSecond, {kSlowest_deg_s, 1e3}, &Config::speeds_rad_s,
             "amplitudes; one case each"),
      number("frequency_hz", unit::kHertz, {1e-3, 200}, &Config::frequency_hz, "frequency of the sine"),
  };
}

Keys<ScenarioConfig> step_keys() {
  using Config = ScenarioConfig;
  return {
      number("speeds_deg_s", unit::kDegreePerSecond, {-1e3, 1e3}, &Config::speeds_rad_s,
             "step heights; one case each; positive or negative, not 0"),
      choice("axes_move", {"together", "one_at_a_time"}, &Config::axes_move,
             "both axes in the same run, or each in a run of its own while the other one rests")
          .or_else(0),
      number("disturbance_amplitude_deg_s", unit::kDegreePerSecond, {0, 1e3}, &Config::disturbance_amplitude_rad_s,
             "amplitude of a sinusoidal disturbance torque from rest_s on, as the speed that it would give the bare "
             "inertia")
          .or_else(0),
      number("disturbance_frequency_hz", unit::kHertz, {0, 200}, &Config::disturbance_frequency_hz,
             "frequency of that disturbance; give both or neither")
          .or_else(0),
  };
}

Keys<FlyByConfig> fly_by_keys() {
  using Config = FlyByConfig;
  return {
      number("start_position_m", unit::kMetre, kDistance_m, &Config::start_position_m, "[ahead, left, up] at time 0"),
      number("velocity_m_s", unit::kMetrePerSecond, {-500, 500}, &Config::velocity_m_s,
             "velocity on the straight course"),
      number("weave_lateral_m", unit::kMetre, {0, 1e3}, &Config::weave_lateral_m,
             "amplitude of the weave across the course")
          .or_else(0),
      number("weave_lateral_period_s", unit::kSecond, {0.1, 1e3}, &Config::weave_lateral_period_s,
             "period of the weave across the course")
          .or_else(20),
      number("weave_vertical_m", unit::kMetre, {0, 1e3}, &Config::weave_vertical_m, "amplitude of the vertical weave")
          .or_else(0),
      number("weave_vertical_period_s", unit::kSecond, {0.1, 1e3}, &Config::weave_vertical_period_s,
             "period of the vertical weave")
          .or_else(20),
      number("evasion_m_s2", unit::kMetrePerSecondSquared, {0, 100}, &Config::evasion_m_s2,
             "acceleration of a target that evades: it never stops, and changes its direction at random times")
          .or_else(0),
      number("evasion_seed", unit::kNone, {0, 1e6}, &Config::evasion_seed, "seed of these times and directions")
          .or_else(1),
  };
}

Keys<PassConfig> pass_keys() {
  using Config = PassConfig;
  return {
      number("speed_m_s", unit::kMetrePerSecond, {0.1, 500}, &Config::speed_m_s, "speed on the course"),
      number("height_m", unit::kMetre, {1, 1e5}, &Config::height_m, "height above the tracker"),
      number("elevation_deg", unit::kDegree, {0.1, 90}, &Config::elevation_rad,
             "pitch at the closest approach; 90: through the zenith"),
      number("closest_at_s", unit::kSecond, {0, 3600}, &Config::closest_at_s, "time of the closest approach"),
      number("evasive_m_s2", unit::kMetrePerSecondSquared, {0, 100}, &Config::evasive_m_s2,
             "amplitude of a sine of horizontal acceleration across the course")
          .or_else(0),
      number("evasive_period_s", unit::kSecond, {0.1, 1e3}, &Config::evasive_period_s, "period of that sine")
          .or_else(4),
  };
}

Keys<ScenarioConfig> pointing_keys() {
  return {
      choice("pointing", {"per_axis", "line_of_sight"}, &ScenarioConfig::pointing,
             "without effect, for older files: the node tracks with one loop for both axes where both track")
          .or_else(0),
  };
}

Keys<PictureMounting> mounting_keys() {
  using Config = PictureMounting;
  return {
      number("roll_deg", unit::kDegree, {-180, 180}, &Config::roll_rad,
             "rotation of the sensor about the optical axis, counter-clockwise in the image; line_of_sight only")
          .or_else(0),
      number("boresight_x_urad", unit::kMicroradian, {-1e5, 1e5}, &Config::boresight_x_rad,
             "where the target is to be held, in cross-elevation; line_of_sight only")
          .or_else(0),
      number("boresight_y_urad", unit::kMicroradian, {-1e5, 1e5}, &Config::boresight_y_rad,
             "the same in elevation; line_of_sight only")
          .or_else(0),
  };
}

Keys<CameraConfig> camera_keys() {
  using Config = CameraConfig;
  return {
      number("frame_rate_hz", unit::kHertz, {2, 1000}, &Config::frame_rate_hz,
             "below this range the tracking loop would lose its target between two frames"),
      number("delay_ms", unit::kMillisecond, {0, kLongestDelay_ms}, &Config::delay_s,
             "time from exposure to result; less than 10 frames"),
      number("pixel_urad", unit::kMicroradian, {0.01, 1e4}, &Config::pixel_rad, "angle per pixel"),
      number("width_px", unit::kPixel, {1, 1e5}, &Config::width_px, "width of the image, along azimuth"),
      number("height_px", unit::kPixel, {1, 1e5}, &Config::height_px, "height of the image, along pitch"),
      number("centroid_noise_rms_px", unit::kPixel, {0, 100}, &Config::centroid_noise_rms_px,
             "white noise of the target position, per axis"),
      choice("geometry", {"per_axis", "line_of_sight"}, &Config::geometry,
             "error of each joint by itself, or place in the picture of a pinhole camera on both joints")
          .or_else(0),
      number("dropouts_at_s", unit::kSecond, {0, 3600}, &Config::dropouts_at_s,
             "times from which on the target is not found; give dropout_s, too")
          .or_absent(),
      number("dropout_s", unit::kSecond, {0, 100}, &Config::dropout_s, "length of each dropout").or_else(0),
  };
}

void read_axes(const TomlReader& reader, ScenarioConfig& scenario) {
  const TomlTable root = reader.root();
  const toml::node *node = root.table->get("axes");
  const toml::array *names = node != nullptr ? node->as_array() : nullptr;
  const char *remedy = "give a list of \"azimuth\" and \"pitch\", at least one";
  if (names == nullptr || names->empty()) {
    reader.fail(root, "axes", node == nullptr ? "is missing" : "must be a non-empty list", remedy);
  }
  for (const toml::node& name : *names) {
    const std::string text = name.value_or<std::string>("");
    const bool azimuth = text == axis_name(kAzimuth);
    if (!azimuth && text != axis_name(kPitch)) {
      reader.fail(root, "axes", "contains an unknown axis", remedy);
    }
    bool& takes_part = scenario.axes[azimuth ? kAzimuth : kPitch];
    if (takes_part) {
      reader.fail(root, "axes", fmt::format("contains \"{}\" twice", text), remedy);
    }
    takes_part = true;
  }
}

template <class Owner>
void read_child(const TomlReader& reader, const char *name, const Keys<Owner>& keys, Owner& owner) {
  const TomlTable table = reader.child(reader.root(), name);
  reader.refuse_unknown(table, keys);
  reader.read(table, keys, owner);
}

// The course is given as [fly_by] or as [pass].
void read_course(const TomlReader& reader, ScenarioConfig& scenario) {
  const TomlTable root = reader.root();
  if (!reader.child_if_present(root, "pass")) {
    read_child(reader, "fly_by", fly_by_keys(), scenario.fly_by);
    return;
  }
  if (root.table->contains("fly_by")) {
    reader.fail(root, "pass", "and fly_by are both given", "give one of them: a scenario has one target");
  }
  scenario.pass.emplace();
  read_child(reader, "pass", pass_keys(), *scenario.pass);
  scenario.fly_by = course_of(*scenario.pass);
}

void read_camera(const TomlReader& reader, ScenarioConfig& scenario) {
  constexpr double kMaxFramesUnderWay = 10;
  const TomlTable camera = reader.child(reader.root(), "camera");
  std::vector<std::string> mounting_names;
  for (const auto& key : mounting_keys()) {
    mounting_names.push_back(key.text.name);
  }
  reader.refuse_unknown(camera, camera_keys(), mounting_names);
  reader.read(camera, camera_keys(), scenario.camera);
  reader.read(camera, mounting_keys(), scenario.camera.mounting);
  if (scenario.camera.delay_s * scenario.camera.frame_rate_hz > kMaxFramesUnderWay) {
    reader.fail(camera, "delay_ms", "is longer than 10 frames",
                fmt::format("give at most {:g}", 1e3 * kMaxFramesUnderWay / scenario.camera.frame_rate_hz));
  }
  const bool image = scenario.camera.geometry == CameraGeometry::kLineOfSight;
  for (const std::string& name : mounting_names) {
    if (!image && camera.table->contains(name)) {
      reader.fail(camera, name, "has no effect on a camera that measures each axis by itself",
                  "remove it, or give geometry = \"line_of_sight\"");
    }
  }
  if (scenario.camera.dropouts_at_s.empty() != (scenario.camera.dropout_s == 0.0)) {
    reader.fail(camera, scenario.camera.dropouts_at_s.empty() ? "dropout_s" : "dropouts_at_s", "has no effect alone",
                "give dropouts_at_s and dropout_s together");
  }
}

void read_kind(const TomlReader& reader, ScenarioConfig& scenario) {
  const TomlTable root = reader.root();
  switch (scenario.kind) {
    case ScenarioKind::kSpeedSine:
      reader.read(root, sine_keys(), scenario);
      break;
    case ScenarioKind::kSpeedStep:
      reader.read(root, step_keys(), scenario);
      break;
    case ScenarioKind::kTracking:
      reader.read(root, pointing_keys(), scenario);
      read_course(reader, scenario);
      read_camera(reader, scenario);
      break;
  }
}

// Checks of speed references beyond the ranges of the keys.
void check_speeds(const TomlReader& reader, const ScenarioConfig& scenario) {
  std::vector<std::string> names;  // as cases are named
  for (const double speed_rad_s : scenario.speeds_rad_s) {
    const double speed_deg_s = speed_rad_s / unit::kDegreePerSecond.in_si;
    if (std::abs(speed_deg_s) < kSlowest_deg_s * (1.0 - 1e-9)) {
      reader.fail(reader.root(), "speeds_deg_s", fmt::format("{:g} is too small for a step", speed_deg_s),
                  fmt::format("give at least {:g} deg/s, forwards or backwards", kSlowest_deg_s));
    }
    const std::string name = fmt::format("{:g}", speed_deg_s);
    if (std::find(names.begin(), names.end(), name) != names.end()) {
      reader.fail(reader.root(), "speeds_deg_s", fmt::format("contains {} twice", name), "give each speed once");
    }
    names.push_back(name);
  }
  const bool amplitude = scenario.disturbance_amplitude_rad_s > 0.0;
  const bool frequency = scenario.disturbance_frequency_hz > 0.0;
  if (amplitude != frequency) {
    reader.fail(reader.root(), amplitude ? "disturbance_amplitude_deg_s" : "disturbance_frequency_hz",
                "has no effect alone", "give disturbance_amplitude_deg_s and disturbance_frequency_hz together");
  }
}

// A tracking run begins on the target: the scenario does not set where the axes start and how long they rest.
void refuse_keys_of_speed_runs(const TomlReader& reader) {
  for (const char *key : {"initial_azimuth_deg", "initial_pitch_deg", "rest_s"}) {
    if (reader.root().table->contains(key)) {
      reader.fail(reader.root(), key, "is not allowed in tracking, which starts on the target",
                  "remove it; fly_by.start_position_m or the pass defines the start");
    }
  }
}

void check_duration(const TomlReader& reader, const ScenarioConfig& scenario) {
  const double before_s = scenario.rest_s + scenario.settle_s;
  if (scenario.duration_s < before_s + kMinAnalysis_s) {
    reader.fail(
        reader.root(), "duration_s", fmt::format("leaves less than {:g} s for the analysis", kMinAnalysis_s),
        fmt::format("give at least rest_s + settle_s + {:g} = {:g}", kMinAnalysis_s, before_s + kMinAnalysis_s));
  }
}

// Keys of the scenario's kind, so that a key of another kind is refused.
std::vector<std::string> known_keys(ScenarioKind kind) {
  std::vector<std::string> known{"axes"};
  const auto add = [&known](const auto& keys) {
    for (const auto& key : keys) {
      known.push_back(key.text.name);
    }
  };
  add(scenario_keys());
  add(initial_keys());
  if (kind == ScenarioKind::kSpeedSine) {
    add(sine_keys());
  } else if (kind == ScenarioKind::kSpeedStep) {
    add(step_keys());
  } else {
    add(pointing_keys());
    known.insert(known.end(), {"fly_by", "pass", "camera"});
  }
  return known;
}

}  // namespace

FlyByConfig course_of(const PassConfig& pass) {
  const double w = 2.0 * kPi / pass.evasive_period_s;
  FlyByConfig course;
  course.start_position_m = {pass.height_m / std::tan(pass.elevation_rad), -pass.speed_m_s * pass.closest_at_s,
                             pass.height_m};
  course.velocity_m_s = {0.0, pass.speed_m_s, 0.0};
  course.weave_lateral_m = pass.evasive_m_s2 / (w * w);
  course.weave_lateral_period_s = pass.evasive_period_s;
  return course;
}

ScenarioConfig load_scenario(const std::filesystem::path& path) {
  const TomlReader reader(path);
  ScenarioConfig scenario;
  scenario.lines = reader.lines();
  reader.read(reader.root(), scenario_keys(), scenario);
  if (scenario.kind == ScenarioKind::kTracking) {
    refuse_keys_of_speed_runs(reader);
  }
  reader.refuse_unknown(reader.root(), known_keys(scenario.kind));
  InitialKeys initial;
  reader.read(reader.root(), initial_keys(), initial);
  scenario.initial_joint_angle_rad = {initial.azimuth_rad, initial.pitch_rad};
  read_axes(reader, scenario);
  read_kind(reader, scenario);
  check_speeds(reader, scenario);
  check_duration(reader, scenario);
  return scenario;
}

std::string scenario_keys_markdown() {
  std::vector<KeyText> camera = texts_of(camera_keys());
  const std::vector<KeyText> mounting = texts_of(mounting_keys());
  camera.insert(camera.end(), mounting.begin(), mounting.end());
  return sections_markdown(
      "Keys of a scenario file",
      "What you can write into a scenario file: each key with unit, allowed values, default and meaning. A scenario "
      "says\n"
      "what an experiment does: which axes move, with which reference, and for how long. Start with a copy of\n"
      "[`sine`](../sim_host/studies/sine/scenario.toml). The build prints this page from the reader of the files. Do "
      "not\n"
      "edit it: run `tools/update-docs keys`.",
      {{"(top of the file)", "Also `axes`: a list of \"azimuth\" and \"pitch\".", texts_of(scenario_keys())},
       {"kind = \"speed_sine\" or \"speed_step\"", "At the top of the file.", texts_of(initial_keys())},
       {"kind = \"speed_sine\"", "At the top of the file.", texts_of(sine_keys())},
       {"kind = \"speed_step\"", "At the top of the file.", texts_of(step_keys())},
       {"kind = \"tracking\"", "At the top of the file.", texts_of(pointing_keys())},
       {"[fly_by], kind = \"tracking\"", "", texts_of(fly_by_keys())},
       {"[pass], kind = \"tracking\"",
        "Instead of [fly_by]: a level, straight course that is closest to the tracker straight ahead.",
        texts_of(pass_keys())},
       {"[camera], kind = \"tracking\"", "", camera}});
}

}  // namespace trackservo::sim
