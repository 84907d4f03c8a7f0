// SPDX-License-Identifier: Apache-2.0
// All contents of a scenario file, in SI units: the reference, its duration, and the analysis.
//
// One scenario holds one or several cases (speeds). A run lasts `duration_s`; errors count from `settle_s` after the
// start of the reference, which is at `rest_s`. Load it with load_scenario(); the result is checked and complete.
#ifndef TRACKSERVO_SIM_CONFIG_SCENARIO_CONFIG_HPP
#define TRACKSERVO_SIM_CONFIG_SCENARIO_CONFIG_HPP

#include <array>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "machine/base/axis.hpp"
#include "machine/config/source_lines.hpp"
#include "machine/sensors/camera.hpp"

namespace trackservo::sim {

enum class ScenarioKind { kSpeedSine = 0, kSpeedStep = 1, kTracking = 2 };

// A UAV on a straight course with gentle weaving. Tracker at the origin, x ahead, y to the left, z up.
struct FlyByConfig {
  std::array<double, 3> start_position_m{};
  std::array<double, 3> velocity_m_s{};
  double weave_lateral_m = 0;  // horizontal, across the course
  double weave_lateral_period_s = 1;
  double weave_vertical_m = 0;
  double weave_vertical_period_s = 1;
  double evasion_m_s2 = 0;  // acceleration of random manoeuvres (target/evasion.hpp)
  int evasion_seed = 1;
};

// A level, straight course: closest to the tracker straight ahead, where it passes from the right to the left.
struct PassConfig {
  double speed_m_s = 0;
  double height_m = 0;
  double elevation_rad = 0;  // at the closest approach; pi/2: through the zenith
  double closest_at_s = 0;
  double evasive_m_s2 = 0;  // amplitude of a sine of horizontal acceleration across the course
  double evasive_period_s = 1;
};

// Returns the same course as start, velocity and weave.
FlyByConfig course_of(const PassConfig& pass);

// A key of old files: which tracking loop ran. The node decides that by itself.
enum class Pointing { kPerAxis = 0, kLineOfSight = 1 };

// Whether the axes of a scenario of speeds move in the same run. One at a time, each moves in a run of its own while
// the other one holds its initial angle: then the azimuth's gains do not follow a pitch that moves.
enum class AxesMove { kTogether = 0, kOneAtATime = 1 };

struct ScenarioConfig {
  std::string name;  // as in the file; equals the experiment
  SourceLines lines;
  std::string title;
  ScenarioKind kind = ScenarioKind::kSpeedSine;
  double duration_s = 0;
  double rest_s = 0;    // reference zero until then
  double settle_s = 0;  // from rest_s to the start of the analysis
  std::array<bool, kAxes> axes{};
  std::array<double, kAxes> initial_joint_angle_rad{};
  AxesMove axes_move = AxesMove::kTogether;

  // kSpeedSine: speeds are the amplitudes. kSpeedStep: speeds are the steps. Each is one case.
  std::vector<double> speeds_rad_s;
  double frequency_hz = 0;  // kSpeedSine only
  // The paper's "external speed disturbance signal" (Figs 8 and 9; both 0: none): a torque J d(speed)/dt at the motor
  // shaft, which alone would move the bare inertia J with speed = amplitude * sin(2 pi f t). The reference is
  // unchanged.
  double disturbance_amplitude_rad_s = 0;
  double disturbance_frequency_hz = 0;

  // kTracking only.
  FlyByConfig fly_by;
  std::optional<PassConfig> pass;  // where the file gives one; `fly_by` is its course
  CameraConfig camera;
  Pointing pointing = Pointing::kPerAxis;  // without effect
};

// Reads and checks a scenario file. Throws ConfigError, also when the file cannot be read.
ScenarioConfig load_scenario(const std::filesystem::path& path);

// Returns the reference page of all scenario keys, as plant_keys_markdown().
std::string scenario_keys_markdown();

}  // namespace trackservo::sim

#endif
