// SPDX-License-Identifier: Apache-2.0
#include "studies/node_tracking/node_tracking.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "judge/analysis/error_spread.hpp"
#include "studies/shared/lost_time.hpp"

namespace trackservo::sim {
namespace {

constexpr double kPerReference = 1.1;

constexpr double kRateLimit_rad_s = 1.0;               // 607F as delivered
constexpr double kDeliveredAcceleration_rad_s2 = 1.0;  // 6083
constexpr double kPassAcceleration_rad_s2 = 5.0;

constexpr double kEvasion_m_s2 = 5.0;

constexpr double kDropoutAt_s = 20.0;
constexpr double kDropout_s = 1.0;  // the one with a goal
constexpr double kBack_s = 0.5;
constexpr float kCoast_s = 3.0F;
constexpr double kStep_nm = 3.0;  // a third of the break-away torque

// The interval of the delay is narrow enough for a correction after 20 s; the errors count from the middle on.
constexpr double kDelayFlight_s = 90.0;
constexpr double kDelayFarther = 2.0;
constexpr double kMisstated_ms = 10.0;

NodeTrackingCase pass_at(double elevation_deg, double height_m, const std::filesystem::path& data_dir,
                         const target_tracker_params& loop) {
  NodeTrackingCase tried;
  tried.name = fmt::format("pass at {:g} deg, {:g} m up", elevation_deg, height_m);
  tried.scenario = load_scenario(data_dir / "studies/straight_passes/scenario.toml");
  tried.scenario.pass->elevation_rad = elevation_deg * kRadPerDeg;
  tried.scenario.pass->height_m = height_m;
  tried.scenario.fly_by = course_of(*tried.scenario.pass);
  tried.loop = loop;
  tried.loop.proportional_per_s = kPassProportional_per_s;
  tried.loop.estimator_rad_s = kPassEstimator_rad_s;
  tried.goal.sigma_rad = {5.0 * kUrad, 5.0 * kUrad};
  tried.count_from_s = tried.scenario.settle_s;
  return tried;
}

// The node counts ages in whole ticks. So exposures at any time between two of them, and ages that err by two counts of
// 3070:3.
NodeTrackingCase between_ticks(const NodeTrackingCase& pass) {
  NodeTrackingCase tried = pass;
  tried.name += ", exposed between ticks";
  tried.scenario.camera.exposure_jitter_s = kTick_s;
  tried.age_jitter_s = 20e-6;
  return tried;
}

NodeTrackingCase evasive_pass(const NodeTrackingCase& pass) {
  NodeTrackingCase tried = pass;
  tried.name += fmt::format(", evades {:g} m/s2", kEvasion_m_s2);
  tried.scenario.fly_by.evasion_m_s2 = kEvasion_m_s2;
  tried.goal = {};
  return tried;
}

// For information: no requirement has this motion.
NodeTrackingCase on_base(const NodeTrackingCase& still, const std::string& name,
                         const std::array<BaseSpectrum, 3>& base) {
  NodeTrackingCase tried = still;
  tried.name += ", " + name;
  tried.scenario.camera.geometry = CameraGeometry::kLineOfSight;
  tried.base.assign(base.begin(), base.end());
  tried.goal = {};
  return tried;
}

BaseSpectrum band(BaseAxis axis, double rms_deg, double low_hz, double high_hz) {
  BaseSpectrum spectrum;
  spectrum.axis = axis;
  spectrum.rms_rad = rms_deg * kRadPerDeg;
  spectrum.low_hz = low_hz;
  spectrum.high_hz = high_hz;
  return spectrum;
}

// Rolling and pitching of a ship in waves: the power of the angle falls as 1 / f^4.
const std::array<BaseSpectrum, 3> kShip{band(BaseAxis::kRoll, 2.0, 0.1, 0.5), band(BaseAxis::kPitch, 1.0, 0.1, 0.5),
                                        band(BaseAxis::kYaw, 0.5, 0.1, 0.5)};

// A vehicle off the road.
const std::array<BaseSpectrum, 3> kVehicle{band(BaseAxis::kRoll, 0.3, 0.5, 10.0),
                                           band(BaseAxis::kPitch, 0.3, 0.5, 10.0),
                                           band(BaseAxis::kYaw, 0.3, 0.5, 10.0)};

// Beyond the limits of the azimuth.
NodeTrackingCase lost_pass_at(double elevation_deg, double height_m, const std::filesystem::path& data_dir,
                              const target_tracker_params& loop) {
  NodeTrackingCase tried = pass_at(elevation_deg, height_m, data_dir, loop);
  tried.acceleration_rad_s2 = kDeliveredAcceleration_rad_s2;
  tried.goal = {};
  tried.goal.lost_s =
      kLostGoal * optimal_lost_s(*tried.scenario.pass, {kRateLimit_rad_s, kDeliveredAcceleration_rad_s2});
  return tried;
}

NodeTrackingCase with_acceleration(const NodeTrackingCase& delivered, double acceleration_rad_s2) {
  NodeTrackingCase tried = delivered;
  tried.name += fmt::format(", 6083 x {:g}", acceleration_rad_s2 / kDeliveredAcceleration_rad_s2);
  tried.acceleration_rad_s2 = acceleration_rad_s2;
  tried.goal.lost_s = kLostGoal * optimal_lost_s(*tried.scenario.pass, {kRateLimit_rad_s, acceleration_rad_s2});
  return tried;
}

// The fly-by from twice as far, so that it lasts long enough to measure the delay.
NodeTrackingCase wrong_age(const NodeTrackingCase& fly_by, double misstated_ms) {
  NodeTrackingCase tried = fly_by;
  tried.name = fmt::format("fly-by, stated age {:+g} ms wrong", misstated_ms);
  for (double& place_m : tried.scenario.fly_by.start_position_m) {
    place_m *= kDelayFarther;
  }
  tried.scenario.duration_s = kDelayFlight_s;
  tried.count_from_s = 0.5 * kDelayFlight_s;
  tried.misstated_s = 1e-3 * misstated_ms;
  tried.goal = {};
  tried.goal.per_reference = kPerReference;
  return tried;
}

PlantConfig moving(PlantConfig plant, const NodeTrackingCase& tried, std::uint64_t seed) {
  for (BaseSpectrum band : tried.base) {
    band.seed = static_cast<int>(seed);
    plant.base_spectrum.push_back(band);
  }
  for (DesignConfig& design : plant.design) {
    design.feedback = tried.feedback;
  }
  for (AxisConfig& axis : plant.axis) {
    axis.gyro.mounting = GyroMounting::kLineOfSight;
  }
  plant.axis[kAzimuth].gyro.mounting = tried.azimuth_gyro;
  return plant;
}

NodeTrackingCase with_dropout(const NodeTrackingCase& fly_by, double dropout_s) {
  NodeTrackingCase dropout = fly_by;
  dropout.name = fmt::format("fly-by, {:g} s without the target, 2011:5 {:g} s", dropout_s, kCoast_s);
  dropout.loop.coast_s = kCoast_s;
  dropout.scenario.camera.dropouts_at_s = {kDropoutAt_s};
  dropout.scenario.camera.dropout_s = dropout_s;
  dropout.scenario.duration_s = kDropoutAt_s + dropout_s + 10.0;
  dropout.count_from_s = kDropoutAt_s + dropout_s + kBack_s;
  dropout.goal = {};
  if (dropout_s == kDropout_s) {
    dropout.goal.sigma_rad = {5.0 * kUrad, 5.0 * kUrad};
    dropout.goal.step_nm = kStep_nm;
  }
  return dropout;
}

// For information.
NodeTrackingCase with_frame_rate(const NodeTrackingCase& fly_by, double frame_rate_hz) {
  NodeTrackingCase tried = fly_by;
  tried.name = fmt::format("fly-by, {:g} frames a second", frame_rate_hz);
  tried.scenario.camera.frame_rate_hz = frame_rate_hz;
  tried.goal = {};
  return tried;
}

// 3073:1
constexpr std::int64_t kDelayReported = 1;
constexpr std::int64_t kDelayCorrected = 2;

void configure(TrackingNode& tracking, const NodeTrackingCase& tried) {
  tracking.node().write(kAzimuth, 0x3073, 1, tried.misstated_s != 0.0 ? kDelayCorrected : kDelayReported);
  for (int axis = 0; axis < kAxes && tried.acceleration_rad_s2 > 0.0; ++axis) {
    tracking.node().write(axis, 0x6083, 0, std::llround(1e6 * tried.acceleration_rad_s2));
  }
}

NodeTrackingRun flight_of(const NodeSetup& setup, const NodeTrackingCase& tried, std::uint64_t seed) {
  ScenarioConfig scenario = tried.scenario;
  scenario.fly_by.evasion_seed = static_cast<int>(seed);
  TrackingNode tracking(setup, scenario, seed, tried.loop, tried.base_rates);
  configure(tracking, tried);
  SplitMix64 jitter(seed);
  NodeTrackingRun run;
  ErrorSpread spread;
  LostTime lost;
  std::array<double, kAxes> last_nm{};
  while (tracking.time_s() < tried.scenario.duration_s) {
    const bool settled = tracking.time_s() > tried.scenario.settle_s;
    for (int axis = 0; axis < kAxes; ++axis) {
      const double now_nm = static_cast<double>(tracking.node().machine().firmware(axis).commanded_nm);
      double& last = last_nm[static_cast<std::size_t>(axis)];
      run.step_nm = settled ? std::max(run.step_nm, std::abs(now_nm - last)) : 0.0;
      last = now_nm;
    }
    tracking.misstate_age(tried.misstated_s + tried.age_jitter_s * (2.0 * jitter.uniform() - 1.0));
    const std::array<double, kAxes> error_rad = tracking.error_rad();
    if (tracking.time_s() >= tried.count_from_s) {
      spread.add(error_rad);
    }
    if (settled) {
      lost.add(tracking.time_s(), std::hypot(error_rad[kAzimuth], error_rad[kPitch]));
    }
    tracking.tick();
  }
  run.sigma_rad = spread.sigma_rad();
  run.lost_s = lost.seconds();
  run.dropped = tracking.node().node().tracking.frames.dropped;
  return run;
}

std::array<double, kAxes> sigma_of_right_age(const NodeSetup& setup, NodeTrackingCase tried, std::uint64_t seed) {
  tried.misstated_s = 0.0;
  return flight_of(setup, tried, seed).sigma_rad;
}

}  // namespace

std::vector<NodeTrackingCase> shipped_node_tracking(const PlantConfig& plant, const std::filesystem::path& data_dir) {
  const target_tracker_params predictive = designed_tracking_loop(plant, TRACKER_PREDICTIVE);
  NodeTrackingCase fly_by;
  fly_by.scenario = load_scenario(data_dir / "scenarios/tracking.toml");
  fly_by.count_from_s = fly_by.scenario.settle_s;
  fly_by.name = "fly-by, paper's loop";
  fly_by.loop = designed_tracking_loop(plant, TRACKER_PI);
  std::vector<NodeTrackingCase> cases{fly_by};
  fly_by.name = "fly-by, predictive loop";
  fly_by.loop = predictive;
  fly_by.goal.sigma_rad = {2.5 * kUrad, 3.0 * kUrad};
  cases.push_back(fly_by);
  for (const double elevation_deg : {60.0, 80.0, 85.0}) {
    cases.push_back(pass_at(elevation_deg, 500.0, data_dir, predictive));
    cases.push_back(between_ticks(cases.back()));
  }
  for (const auto& [elevation_deg, height_m] : {std::pair{88.0, 500.0}, std::pair{85.0, 150.0}}) {
    cases.push_back(lost_pass_at(elevation_deg, height_m, data_dir, predictive));
    cases.push_back(with_acceleration(cases.back(), kPassAcceleration_rad_s2));
  }
  cases.push_back(lost_pass_at(90.0, 500.0, data_dir, predictive));
  cases.push_back(with_acceleration(cases.back(), kPassAcceleration_rad_s2));
  for (const double misstated_ms : {kMisstated_ms, -kMisstated_ms}) {
    cases.push_back(wrong_age(fly_by, misstated_ms));
  }
  for (const double dropout_s : {0.1, 0.5, kDropout_s, 2.0}) {
    cases.push_back(with_dropout(fly_by, dropout_s));
  }
  cases.push_back(with_dropout(fly_by, kDropout_s));
  cases.back().name = fmt::format("fly-by, {:g} s without the target, 2011:5 as delivered", kDropout_s);
  cases.back().loop = predictive;
  cases.back().goal = {};
  cases.back().goal.step_nm = kStep_nm;
  for (const double frame_rate_hz : {10.0, 60.0, 500.0}) {
    cases.push_back(with_frame_rate(fly_by, frame_rate_hz));
  }
  cases.push_back(evasive_pass(pass_at(60.0, 500.0, data_dir, predictive)));
  cases.push_back(on_base(pass_at(80.0, 500.0, data_dir, predictive), "on a ship", kShip));
  fly_by.name = "fly-by";
  cases.push_back(on_base(fly_by, "on a ship", kShip));
  cases.push_back(on_base(fly_by, "on a vehicle", kVehicle));
  for (const bool base_rates : {false, true}) {
    const char *const what = base_rates ? "base rates over CAN" : "no base rates";
    cases.push_back(on_base(fly_by, fmt::format("on a ship, gyro on the stage, {}", what), kShip));
    cases.back().azimuth_gyro = GyroMounting::kJoint;
    cases.back().base_rates = base_rates;
    cases.push_back(on_base(fly_by, fmt::format("on a ship, no gyro, {}", what), kShip));
    cases.back().feedback = FeedbackSource::kEncoder;
    cases.back().base_rates = base_rates;
  }
  return cases;
}

NodeTrackingRun run_of(const NodeSetup& still, const NodeTrackingCase& tried, std::uint64_t seed) {
  const NodeSetup setup = tried.base.empty() ? still : NodeSetup(moving(still.plant, tried, seed));
  NodeTrackingRun run = flight_of(setup, tried, seed);
  if (tried.goal.per_reference) {
    run.reference_sigma_rad = sigma_of_right_age(setup, tried, seed);
  }
  return run;
}

std::vector<NodeTrackingResult> run_node_tracking(const NodeTrackingSetup& setup,
                                                  const std::function<void(int, int, const std::string&)>& progress) {
  const NodeSetup node(setup.plant);
  std::vector<NodeTrackingResult> results;
  for (const NodeTrackingCase& tried : setup.cases) {
    results.push_back({tried, std::vector<NodeTrackingRun>(setup.seeds.size())});
  }
  const std::size_t seeds = setup.seeds.size();
  JobPool pool(setup.threads, static_cast<int>(results.size() * seeds), progress);
  pool.run(results.size() * seeds, [&](std::size_t job) {
    NodeTrackingResult& result = results[job / seeds];
    result.runs[job % seeds] = run_of(node, result.tried, setup.seeds[job % seeds]);
    return result.tried.name;
  });
  return results;
}

}  // namespace trackservo::sim
