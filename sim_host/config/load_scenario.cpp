#include <fmt/format.h>

#include <algorithm>

#include "config/scenario_config.hpp"
#include "config/toml_reader.hpp"

namespace trackservo::sim {

namespace {

constexpr Range kDistance_m{-1e5, 1e5};

Keys<ScenarioConfig> scenario_keys() {
  using Config = ScenarioConfig;
  return {
      words("name", &Config::name, "of the experiment"),
      words("title", &Config::title, "one line for the report"),
      choice("kind", {"speed_sine", "speed_step", "tracking"}, &Config::kind, "what the reference is"),
      number("duration_s", unit::kSecond, {0.01, 3600}, &Config::duration_s, "length of a run"),
      number("rest_s", unit::kSecond, {0, 3600}, &Config::rest_s, "reference at rest until then").or_else(0),
      number("settle_s", unit::kSecond, {0, 3600}, &Config::settle_s, "from there to the start of the analysis")
          .or_else(0),
  };
}

struct InitialKeys {
  double azimuth_rad = 0;
  double pitch_rad = 0;
};

Keys<InitialKeys> initial_keys() {
  return {
      number("initial_azimuth_deg", unit::kDegree, {-1e4, 1e4}, &InitialKeys::azimuth_rad, "joint angle at time 0")
          .or_else(0),
      number("initial_pitch_deg", unit::kDegree, {-180, 180}, &InitialKeys::pitch_rad, "joint angle at time 0")
          .or_else(0),
  };
}

Keys<ScenarioConfig> sine_keys() {
  using Config = ScenarioConfig;
  return {
      number("speeds_deg_s", unit::kDegreePerSecond, {1e-4, 1e3}, &Config::speeds_rad_s, "amplitudes, one case each"),
      number("frequency_hz", unit::kHertz, {1e-3, 200}, &Config::frequency_hz, "of the sine"),
  };
}

Keys<ScenarioConfig> step_keys() {
  using Config = ScenarioConfig;
  return {
      number("speeds_deg_s", unit::kDegreePerSecond, {-1e3, 1e3}, &Config::speeds_rad_s, "steps, one case each"),
      number("disturbance_amplitude_deg_s", unit::kDegreePerSecond, {0, 1e3}, &Config::disturbance_amplitude_rad_s,
             "sine added to the speed reference signal")
          .or_else(0),
      number("disturbance_frequency_hz", unit::kHertz, {0, 200}, &Config::disturbance_frequency_hz, "of that sine")
          .or_else(0),
  };
}

Keys<FlyByConfig> fly_by_keys() {
  using Config = FlyByConfig;
  return {
      number("start_position_m", unit::kMetre, kDistance_m, &Config::start_position_m, "[ahead, left, up] at time 0"),
      number("velocity_m_s", unit::kMetrePerSecond, {-500, 500}, &Config::velocity_m_s, "of the straight course"),
      number("weave_lateral_m", unit::kMetre, {0, 1e3}, &Config::weave_lateral_m, "amplitude across the course")
          .or_else(0),
      number("weave_lateral_period_s", unit::kSecond, {0.1, 1e3}, &Config::weave_lateral_period_s, "").or_else(20),
      number("weave_vertical_m", unit::kMetre, {0, 1e3}, &Config::weave_vertical_m, "amplitude up and down").or_else(0),
      number("weave_vertical_period_s", unit::kSecond, {0.1, 1e3}, &Config::weave_vertical_period_s, "").or_else(20),
  };
}

Keys<CameraConfig> camera_keys() {
  using Config = CameraConfig;
  return {
      number("frame_rate_hz", unit::kHertz, {1, 1000}, &Config::frame_rate_hz, ""),
      number("delay_ms", unit::kMillisecond, {0, 1000}, &Config::delay_s,
             "from exposure to result; less than 10 frames"),
      number("pixel_urad", unit::kMicroradian, {0.01, 1e4}, &Config::pixel_rad, "angle of a pixel"),
      number("width_px", unit::kPixel, {1, 1e5}, &Config::width_px, "along azimuth"),
      number("height_px", unit::kPixel, {1, 1e5}, &Config::height_px, "along pitch"),
      number("centroid_noise_rms_px", unit::kPixel, {0, 100}, &Config::centroid_noise_rms_px, "white, per axis"),
  };
}

void read_axes(const TomlReader& reader, ScenarioConfig& scenario) {
  const TomlTable root = reader.root();
  const toml::node *node = root.table->get("axes");
  const toml::array *names = node != nullptr ? node->as_array() : nullptr;
  const char *remedy = "give a list of \"azimuth\" and \"pitch\", at least one";
  if (names == nullptr || names->empty()) {
    reader.fail(root, "axes", node == nullptr ? "is missing" : "is not a list with elements", remedy);
  }
  for (const toml::node& name : *names) {
    const std::string text = name.value_or<std::string>("");
    const bool azimuth = text == axis_name(kAzimuth);
    if (!azimuth && text != axis_name(kPitch)) {
      reader.fail(root, "axes", "holds something else", remedy);
    }
    scenario.axes[azimuth ? kAzimuth : kPitch] = true;
  }
}

template <class Owner>
void read_child(const TomlReader& reader, const char *name, const Keys<Owner>& keys, Owner& owner) {
  const TomlTable table = reader.child(reader.root(), name);
  reader.refuse_unknown(table, keys);
  reader.read(table, keys, owner);
}

void read_kind(const TomlReader& reader, ScenarioConfig& scenario) {
  constexpr double kMostFramesUnderWay = 10;
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
      if (scenario.camera.delay_s * scenario.camera.frame_rate_hz > kMostFramesUnderWay) {
        reader.fail(reader.child(root, "camera"), "delay_ms", "is longer than 10 frames", "give a shorter delay");
      }
      break;
  }
}

// Keys that the scenario's kind knows, so that a key of another kind is refused.
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
  scenario.file = path.string();
  reader.read(reader.root(), scenario_keys(), scenario);
  reader.refuse_unknown(reader.root(), known_keys(scenario.kind));
  InitialKeys initial;
  reader.read(reader.root(), initial_keys(), initial);
  scenario.initial_joint_angle_rad = {initial.azimuth_rad, initial.pitch_rad};
  read_axes(reader, scenario);
  read_kind(reader, scenario);
  if (scenario.rest_s + scenario.settle_s >= scenario.duration_s) {
    reader.fail(reader.root(), "duration_s", "leaves nothing to analyse",
                fmt::format("give more than rest_s + settle_s = {:g}", scenario.rest_s + scenario.settle_s));
  }
  return scenario;
}

std::string scenario_keys_markdown() {
  std::vector<KeyText> common = texts_of(scenario_keys());
  for (const KeyText& key : texts_of(initial_keys())) {
    common.push_back(key);
  }
  return sections_markdown("Keys of a scenario file",
                           {{"(top of the file)", "And `axes`: a list of \"azimuth\" and \"pitch\".", common},
                            {"kind = \"speed_sine\"", "At the top of the file.", texts_of(sine_keys())},
                            {"kind = \"speed_step\"", "At the top of the file.", texts_of(step_keys())},
                            {"[fly_by], kind = \"tracking\"", "", texts_of(fly_by_keys())},
                            {"[camera], kind = \"tracking\"", "", texts_of(camera_keys())}});
}

}  // namespace trackservo::sim
