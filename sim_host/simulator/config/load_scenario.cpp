#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "base/firmware.hpp"
#include "config/scenario_config.hpp"
#include "config/toml_reader.hpp"

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

void read_kind(const TomlReader& reader, ScenarioConfig& scenario) {
  constexpr double kMaxFramesUnderWay = 10;
  const TomlTable root = reader.root();
  switch (scenario.kind) {
    case ScenarioKind::kSpeedSine:
      reader.read(root, sine_keys(), scenario);
      break;
    case ScenarioKind::kSpeedStep:
      reader.read(root, step_keys(), scenario);
      break;
    case ScenarioKind::kTracking:
      read_child(reader, "fly_by", fly_by_keys(), scenario.fly_by);
      read_child(reader, "camera", camera_keys(), scenario.camera);
      if (scenario.camera.delay_s * scenario.camera.frame_rate_hz > kMaxFramesUnderWay) {
        reader.fail(reader.child(root, "camera"), "delay_ms", "is longer than 10 frames",
                    fmt::format("give at most {:g}", 1e3 * kMaxFramesUnderWay / scenario.camera.frame_rate_hz));
      }
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
                  "remove it; fly_by.start_position_m defines the start");
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
    known.insert(known.end(), {"fly_by", "camera"});
  }
  return known;
}

}  // namespace

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
       {"[fly_by], kind = \"tracking\"", "", texts_of(fly_by_keys())},
       {"[camera], kind = \"tracking\"", "", texts_of(camera_keys())}});
}

}  // namespace trackservo::sim
