// SPDX-License-Identifier: Apache-2.0
#include "studies/base_motion/base_motion.hpp"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <complex>
#include <limits>
#include <nlohmann/json.hpp>

#include "design/control_design.hpp"
#include "design/margin_measurement.hpp"
#include "device/tracking_run.hpp"
#include "judge/analysis/metrics.hpp"
#include "machine/base/json_file.hpp"
#include "machine/run/scenario_run.hpp"

namespace trackservo::sim {
namespace {

constexpr std::array<BaseAxis, 3> kBaseAxes{BaseAxis::kRoll, BaseAxis::kPitch, BaseAxis::kYaw};
constexpr std::array<FeedbackSource, 3> kFeedbacks{FeedbackSource::kEncoder, FeedbackSource::kFused,
                                                   FeedbackSource::kGyro};

const char *const kController = "pi_vob_ftc";

// Of the tracking loop (2011h), as in the straight passes.
constexpr double kEstimator_rad_s = 6.0;
constexpr double kProportional_per_s = 30.0;

constexpr double kTrackingSettle_s = 6.0;
constexpr double kTracking_s = 20.0;  // two periods of the slowest motion
constexpr double kIsolationSettle_s = 3.0;
constexpr double kIsolation_s = 2.0;  // at least
constexpr double kTarget_m = 1000.0;

DesignOptions design_of(std::uint64_t seed) {
  DesignOptions design;
  design.tracker = TRACKER_PREDICTIVE;
  design.seed = seed;
  return design;
}

servo_params params_of(const PlantConfig& plant, const std::string& controller, std::uint64_t seed) {
  return design_controller(plant, controller_spec(controller), design_of(seed));
}

NodeSetup node_of(const PlantConfig& plant, std::uint64_t seed) {
  std::array<axis_parameters, kAxes> parameters = design_axes(plant, controller_spec(kController), design_of(seed));
  for (axis_parameters& axis : parameters) {
    axis.tracking_loop.estimator_rad_s = static_cast<float>(kEstimator_rad_s);
    axis.tracking_loop.proportional_per_s = static_cast<float>(kProportional_per_s);
  }
  return {plant, parameters};
}

void feed_back(PlantConfig& plant, FeedbackSource feedback) {
  for (DesignConfig& design : plant.design) {
    design.feedback = feedback;
  }
}

// A target at rest, and a pinhole camera on both joints.
ScenarioConfig standing_target(double pitch_rad) {
  ScenarioConfig scenario;
  scenario.name = "base_motion";
  scenario.kind = ScenarioKind::kTracking;
  scenario.camera.geometry = CameraGeometry::kLineOfSight;
  scenario.duration_s = kTrackingSettle_s + kTracking_s;
  scenario.settle_s = kTrackingSettle_s;
  scenario.axes = {true, true};
  scenario.fly_by.start_position_m = {kTarget_m * std::cos(pitch_rad), 0.0, kTarget_m * std::sin(pitch_rad)};
  return scenario;
}

// The inertial rate of a window.
std::vector<double> rates_of(const Trace& trace, int axis, Window window) {
  std::vector<double> rates_rad_s;
  for (const TraceRow& row : trace) {
    if (row.time_s >= window.begin_s - 0.5 * kTick_s && row.time_s < window.end_s - 0.5 * kTick_s) {
      rates_rad_s.push_back(row.axis[static_cast<std::size_t>(axis)].rate_rad_s);
    }
  }
  return rates_rad_s;
}

// At a frequency, over whole periods.
double amplitude_of(const std::vector<double>& rates_rad_s, double frequency_hz) {
  std::complex<double> sum = 0.0;
  for (std::size_t i = 0; i < rates_rad_s.size(); ++i) {
    sum += rates_rad_s[i] * std::polar(1.0, -2.0 * kPi * frequency_hz * static_cast<double>(i) * kTick_s);
  }
  return 2.0 * std::abs(sum) / static_cast<double>(rates_rad_s.size());
}

// Rms of the angle, without a straight line: the gyro's bias turns the axis slowly.
double angle_rms_rad(const std::vector<double>& rates_rad_s) {
  const auto count = static_cast<Eigen::Index>(rates_rad_s.size());
  Eigen::MatrixX2d line(count, 2);
  Eigen::VectorXd angle_rad(count);
  double sum_rad = 0.0;
  for (Eigen::Index i = 0; i < count; ++i) {
    sum_rad += kTick_s * rates_rad_s[static_cast<std::size_t>(i)];
    angle_rad[i] = sum_rad;
    line.row(i) << 1.0, static_cast<double>(i) / static_cast<double>(count);
  }
  const Eigen::Vector2d fitted = (line.transpose() * line).ldlt().solve(line.transpose() * angle_rad);
  return (angle_rad - line * fitted).norm() / std::sqrt(static_cast<double>(count));
}

bool is_goal(const IsolationPoint& point) {
  return point.feedback == FeedbackSource::kGyro && point.frequency_hz == kIsolationGoal_hz &&
         std::abs(point.amplitude_rad - kIsolationGoal_rad) < 1e-9;
}

bool meets_goal(const PitchMargins& margins) {
  return keeps_margins(margins.computed) && keeps_margins(margins.measured);
}

const char *seal_name(bool pre_sliding) { return pre_sliding ? "pre-sliding" : "sliding"; }

nlohmann::ordered_json json_of(const Margins& margins) {
  return {{"gain_margin_db", margins.gain_margin_db}, {"phase_margin_deg", margins.phase_margin_deg}};
}

nlohmann::ordered_json json_of(const BaseMotionSetup& setup, const TrackingOnBase& tracking) {
  nlohmann::ordered_json json{{"base_axis", base_axis_name(tracking.base_axis)},
                              {"frequency_hz", tracking.frequency_hz},
                              {"amplitude_deg", kDegPerRad * setup.amplitude_rad},
                              {"pitch_deg", kDegPerRad * tracking.pitch_rad},
                              {"meets_goal", worst_sigma_rad(tracking) <= kBaseSigmaGoal_rad},
                              {"runs", nlohmann::ordered_json::array()}};
  for (std::size_t i = 0; i < setup.seeds.size(); ++i) {
    json["runs"].push_back({{"seed", setup.seeds[i]},
                            {"cross_elevation_sigma_urad", 1e6 * tracking.sigma_rad[i][kAzimuth]},
                            {"elevation_sigma_urad", 1e6 * tracking.sigma_rad[i][kPitch]}});
  }
  return json;
}

// The worst of all seeds, which follow one another.
std::vector<IsolationPoint> worst_of(const std::vector<IsolationPoint>& points) {
  std::vector<IsolationPoint> worst;
  for (const IsolationPoint& point : points) {
    const bool known = !worst.empty() && worst.back().feedback == point.feedback &&
                       worst.back().amplitude_rad == point.amplitude_rad &&
                       worst.back().frequency_hz == point.frequency_hz;
    if (!known) {
      worst.push_back(point);
    }
    for (std::size_t i = 0; i < kAxes; ++i) {
      worst.back().isolation_db[i] = std::min(worst.back().isolation_db[i], point.isolation_db[i]);
      worst.back().residual_db[i] = std::min(worst.back().residual_db[i], point.residual_db[i]);
    }
  }
  return worst;
}

Margins smaller_of(const Margins& a, const Margins& b) {
  Margins smaller = a;
  smaller.gain_margin_db = std::min(a.gain_margin_db, b.gain_margin_db);
  smaller.phase_margin_deg = std::min(a.phase_margin_deg, b.phase_margin_deg);
  return smaller;
}

std::vector<PitchMargins> worst_of(const std::vector<PitchMargins>& all) {
  std::vector<PitchMargins> worst;
  for (const PitchMargins& one : all) {
    const bool known =
        !worst.empty() && worst.back().pitch_rad == one.pitch_rad && worst.back().pre_sliding == one.pre_sliding;
    if (!known) {
      worst.push_back(one);
    }
    worst.back().measured = smaller_of(worst.back().measured, one.measured);
  }
  return worst;
}

// One object for each curve.
nlohmann::ordered_json curves_of(const std::vector<IsolationPoint>& points) {
  nlohmann::ordered_json curves = nlohmann::ordered_json::array();
  for (int axis = 0; axis < kAxes; ++axis) {
    for (const IsolationPoint& point : points) {
      const double amplitude_deg = kDegPerRad * point.amplitude_rad;
      if (curves.empty() || curves.back()["axis"] != axis_name(axis) ||
          curves.back()["feedback"] != feedback_name(point.feedback) ||
          curves.back()["amplitude_deg"] != amplitude_deg) {
        curves.push_back({{"axis", axis_name(axis)},
                          {"feedback", feedback_name(point.feedback)},
                          {"amplitude_deg", amplitude_deg},
                          {"frequency_hz", nlohmann::ordered_json::array()},
                          {"isolation_db", nlohmann::ordered_json::array()},
                          {"residual_db", nlohmann::ordered_json::array()}});
      }
      curves.back()["frequency_hz"].push_back(point.frequency_hz);
      curves.back()["isolation_db"].push_back(point.isolation_db[static_cast<std::size_t>(axis)]);
      curves.back()["residual_db"].push_back(point.residual_db[static_cast<std::size_t>(axis)]);
    }
  }
  return curves;
}

BaseMotionStudy choices_of(const BaseMotionSetup& setup) {
  BaseMotionStudy study;
  for (const double pitch_rad : setup.tracking_pitch_rad) {
    for (const BaseAxis axis : kBaseAxes) {
      for (const double frequency_hz : setup.tracking_hz) {
        study.tracking.push_back({axis, frequency_hz, pitch_rad, {}});
        study.tracking.back().sigma_rad.resize(setup.seeds.size());
      }
    }
  }
  for (const FeedbackSource feedback : kFeedbacks) {
    for (const double amplitude_rad : setup.isolation_rad) {
      for (const double frequency_hz : setup.isolation_hz) {
        study.isolation.insert(study.isolation.end(), setup.seeds.size(),
                               {feedback, amplitude_rad, frequency_hz, {}, {}});
      }
    }
  }
  for (const double pitch_rad : setup.margin_pitch_rad) {
    for (const bool pre_sliding : {false, true}) {
      PitchMargins margins;
      margins.pitch_rad = pitch_rad;
      margins.pre_sliding = pre_sliding;
      study.margins.insert(study.margins.end(), setup.seeds.size(), margins);
    }
  }
  return study;
}

// For each seed, of the worst axis of the base.
std::vector<double> worst_sigmas_urad(const BaseMotionStudy& study, double frequency_hz, double pitch_rad, int axis) {
  std::vector<double> worst_urad;
  for (const TrackingOnBase& tracking : study.tracking) {
    if (tracking.frequency_hz == frequency_hz && tracking.pitch_rad == pitch_rad) {
      worst_urad.resize(tracking.sigma_rad.size());
      for (std::size_t i = 0; i < worst_urad.size(); ++i) {
        worst_urad[i] = std::max(worst_urad[i], 1e6 * tracking.sigma_rad[i][static_cast<std::size_t>(axis)]);
      }
    }
  }
  return worst_urad;
}

void add_margins(const BaseMotionSetup& setup, const BaseMotionStudy& study, std::vector<Requirement>& requirements) {
  if (study.margins.empty()) {
    return;
  }
  std::string angles;
  for (const double pitch_rad : setup.margin_pitch_rad) {
    angles += fmt::format("{}{:g}", angles.empty() ? "" : ", ", kDegPerRad * pitch_rad);
  }
  const std::string name = fmt::format("speed loop at pitch {} deg", angles);
  const std::size_t seeds = setup.seeds.size();
  std::vector<double> gain_db(seeds, std::numeric_limits<double>::infinity());
  std::vector<double> phase_deg = gain_db;
  for (std::size_t i = 0; i < study.margins.size(); ++i) {
    gain_db[i % seeds] = std::min(gain_db[i % seeds], study.margins[i].measured.gain_margin_db);
    phase_deg[i % seeds] = std::min(phase_deg[i % seeds], study.margins[i].measured.phase_margin_deg);
  }
  const gain_design::MinMargins least;
  const char *const azimuth = axis_name(kAzimuth);
  requirements.push_back({name, azimuth, "gain_margin", "dB", least.gain_margin_db, gain_db, Bound::kAtLeast});
  requirements.push_back({name, azimuth, "phase_margin", "deg", least.phase_margin_deg, phase_deg, Bound::kAtLeast});
}

void print_tracking(const BaseMotionStudy& study) {
  const char *const line = "  {:<10} {:<9} {:<9} {}\n";
  fmt::print(fmt::runtime(line), "base axis", "motion", "pitch", "line of sight 1 sigma, worst seed and axis, urad");
  for (const TrackingOnBase& tracking : study.tracking) {
    fmt::print(fmt::runtime(line), base_axis_name(tracking.base_axis), fmt::format("{:g} Hz", tracking.frequency_hz),
               fmt::format("{:g} deg", kDegPerRad * tracking.pitch_rad),
               fmt::format("{:.2f}", 1e6 * worst_sigma_rad(tracking)));
  }
}

void print_isolation(const BaseMotionStudy& study) {
  fmt::print("Isolation at the frequency of the base, and of the rms angle, worst seed, dB; azimuth / pitch:\n");
  for (const IsolationPoint& point : worst_of(study.isolation)) {
    fmt::print("  {:<8} {:g} deg, {:g} Hz: {:.1f} / {:.1f}, {:.1f} / {:.1f}{}\n", feedback_name(point.feedback),
               kDegPerRad * point.amplitude_rad, point.frequency_hz, point.isolation_db[kAzimuth],
               point.isolation_db[kPitch], point.residual_db[kAzimuth], point.residual_db[kPitch],
               is_goal(point) ? fmt::format(" (goal {:g})", kIsolationGoal_db) : "");
  }
}

void print_margins(const BaseMotionStudy& study) {
  fmt::print("Margins of the azimuth, computed / measured (worst seed); with gains that do not follow:\n");
  for (const PitchMargins& margins : worst_of(study.margins)) {
    fmt::print("  {:g} deg, {:<11}  {:.1f} / {:.1f} dB, {:.1f} / {:.1f} deg; {:.1f} dB, {:.1f} deg\n",
               kDegPerRad * margins.pitch_rad, seal_name(margins.pre_sliding), margins.computed.gain_margin_db,
               margins.measured.gain_margin_db, margins.computed.phase_margin_deg, margins.measured.phase_margin_deg,
               margins.fixed.gain_margin_db, margins.fixed.phase_margin_deg);
  }
}

}  // namespace

const char *feedback_name(FeedbackSource feedback) {
  switch (feedback) {
    case FeedbackSource::kEncoder:
      return "encoder";
    case FeedbackSource::kGyro:
      return "gyro";
    case FeedbackSource::kFused:
    default:
      return "fused";
  }
}

const char *base_axis_name(BaseAxis axis) {
  switch (axis) {
    case BaseAxis::kRoll:
      return "roll";
    case BaseAxis::kPitch:
      return "pitch";
    case BaseAxis::kYaw:
    default:
      return "yaw";
  }
}

double worst_sigma_rad(const TrackingOnBase& tracking) {
  double worst = 0.0;
  for (const std::array<double, kAxes>& sigma_rad : tracking.sigma_rad) {
    worst = std::max({worst, sigma_rad[kAzimuth], sigma_rad[kPitch]});
  }
  return worst;
}

std::array<double, kAxes> tracking_on_base(const BaseMotionSetup& setup, const TrackingOnBase& choice,
                                           GyroMounting mounting, std::uint64_t seed) {
  PlantConfig plant = setup.plant;
  feed_back(plant, FeedbackSource::kGyro);
  for (AxisConfig& axis : plant.axis) {
    axis.gyro.mounting = mounting;
  }
  plant.base_spectrum.clear();
  plant.base_motion = {{choice.base_axis, choice.frequency_hz, setup.amplitude_rad, 0.0}};
  const ScenarioConfig scenario = standing_target(choice.pitch_rad);
  const Trace trace = run_tracking(node_of(plant, seed), scenario, seed);
  const Window window{scenario.settle_s, scenario.duration_s};
  return {tracking_sigma_rad(trace, kAzimuth, window), tracking_sigma_rad(trace, kPitch, window)};
}

PitchMargins azimuth_margins(const PlantConfig& plant, double pitch_rad, bool pre_sliding, std::uint64_t seed) {
  const servo_params params = params_of(plant, kController, seed);
  const speed_loop_params& loop = params.axis[kAzimuth].speed;
  LinearMachine machine = linear_machine(plant, kAzimuth, pre_sliding);
  machine.inertia_kg_m2 = axis_inertia_kg_m2(plant, kAzimuth, pitch_rad);
  const std::vector<double> frequencies = log_space(0.05, 450.0, 2000);
  PitchMargins margins;
  margins.pitch_rad = pitch_rad;
  margins.pre_sliding = pre_sliding;
  margins.computed =
      margins_of(computed_loop_gain(machine, loop_at_pitch(plant, kAzimuth, loop, pitch_rad), frequencies));
  margins.fixed = margins_of(computed_loop_gain(machine, loop, frequencies));
  margins.measured =
      margins_of(measured_near_crossover(plant, params, kAzimuth, pre_sliding, margins.computed, seed, pitch_rad));
  return margins;
}

IsolationPoint isolation_at(const PlantConfig& plant_at_rest, const std::string& controller, FeedbackSource feedback,
                            double amplitude_rad, double frequency_hz, std::uint64_t seed) {
  PlantConfig plant = plant_at_rest;
  feed_back(plant, feedback);
  for (AxisConfig& axis : plant.axis) {
    axis.load.wind_mean_nm = 0.0;
    axis.load.wind_gust_rms_nm = 0.0;
    axis.base_sway.rms_rad = 0.0;
  }
  plant.base_spectrum.clear();
  plant.base_motion = {{BaseAxis::kYaw, frequency_hz, amplitude_rad, 0.0},
                       {BaseAxis::kPitch, frequency_hz, amplitude_rad, 0.0}};
  ScenarioConfig scenario;
  scenario.name = "isolation";
  scenario.kind = ScenarioKind::kSpeedStep;
  const double periods_s = std::ceil(std::max(2.0, kIsolation_s * frequency_hz)) / frequency_hz;
  scenario.duration_s = kIsolationSettle_s + periods_s;
  scenario.axes = {true, true};
  RunRequest request;
  request.plant = &plant;
  request.scenario = &scenario;
  request.params = params_of(plant, controller, seed);
  request.seed = seed;
  const Trace trace = run_scenario(request);
  const Window window{kIsolationSettle_s, scenario.duration_s};
  const double base_rad_s = 2.0 * kPi * frequency_hz * amplitude_rad;
  IsolationPoint point{feedback, amplitude_rad, frequency_hz, {}, {}};
  for (int axis = 0; axis < kAxes; ++axis) {
    const auto i = static_cast<std::size_t>(axis);
    const std::vector<double> rates_rad_s = rates_of(trace, axis, window);
    point.isolation_db[i] = 20.0 * std::log10(base_rad_s / amplitude_of(rates_rad_s, frequency_hz));
    point.residual_db[i] = 20.0 * std::log10(std::sqrt(0.5) * amplitude_rad / angle_rms_rad(rates_rad_s));
  }
  return point;
}

BaseMotionStudy run_base_motion(const BaseMotionSetup& setup,
                                const std::function<void(int, int, const std::string&)>& progress) {
  BaseMotionStudy study = choices_of(setup);
  const std::size_t seeds = setup.seeds.size();
  const std::size_t tracking_jobs = study.tracking.size() * seeds;
  const std::size_t isolation_jobs = study.isolation.size();
  const std::size_t jobs = tracking_jobs + isolation_jobs + study.margins.size();
  JobPool pool(setup.threads, static_cast<int>(jobs), progress);
  pool.run(jobs, [&](std::size_t job) -> std::string {
    if (job < tracking_jobs) {
      TrackingOnBase& tracking = study.tracking[job / seeds];
      tracking.sigma_rad[job % seeds] =
          tracking_on_base(setup, tracking, GyroMounting::kLineOfSight, setup.seeds[job % seeds]);
      return fmt::format("tracking on a base: {}", base_axis_name(tracking.base_axis));
    }
    if (job < tracking_jobs + isolation_jobs) {
      const std::size_t i = job - tracking_jobs;
      IsolationPoint& point = study.isolation[i];
      point = isolation_at(setup.plant, kController, point.feedback, point.amplitude_rad, point.frequency_hz,
                           setup.seeds[i % seeds]);
      return fmt::format("isolation: {}", feedback_name(point.feedback));
    }
    const std::size_t i = job - tracking_jobs - isolation_jobs;
    PitchMargins& margins = study.margins[i];
    margins = azimuth_margins(setup.plant, margins.pitch_rad, margins.pre_sliding, setup.seeds[i % seeds]);
    return fmt::format("margins at {:g} deg", kDegPerRad * margins.pitch_rad);
  });
  return study;
}

std::vector<Requirement> requirements_of(const BaseMotionSetup& setup, const BaseMotionStudy& study) {
  std::vector<Requirement> requirements;
  for (const double pitch_rad : setup.tracking_pitch_rad) {
    for (const double frequency_hz : setup.tracking_hz) {
      const std::string name = fmt::format("base turns by {:g} deg at {:g} Hz, pitch {:g} deg",
                                           kDegPerRad * setup.amplitude_rad, frequency_hz, kDegPerRad * pitch_rad);
      for (int axis = 0; axis < kAxes; ++axis) {
        requirements.push_back({name, axis_name(axis), "sigma", "urad", 1e6 * kBaseSigmaGoal_rad,
                                worst_sigmas_urad(study, frequency_hz, pitch_rad, axis)});
      }
    }
  }
  std::array<std::vector<double>, kAxes> isolation_db;
  for (const IsolationPoint& point : study.isolation) {
    for (std::size_t i = 0; i < kAxes && is_goal(point); ++i) {
      isolation_db[i].push_back(point.residual_db[i]);
    }
  }
  for (int axis = 0; axis < kAxes && !isolation_db[0].empty(); ++axis) {
    requirements.push_back({fmt::format("base turns by {:g} deg at {:g} Hz, gyro feedback",
                                        kDegPerRad * kIsolationGoal_rad, kIsolationGoal_hz),
                            axis_name(axis), "isolation", "dB", kIsolationGoal_db,
                            isolation_db[static_cast<std::size_t>(axis)], Bound::kAtLeast});
  }
  add_margins(setup, study, requirements);
  return requirements;
}

void print(const BaseMotionSetup& setup, const BaseMotionStudy& study) {
  fmt::print("A base that turns by {:g} deg: gyros on the line of sight, {} seeds, on {}\n",
             kDegPerRad * setup.amplitude_rad, setup.seeds.size(), setup.plant.name);
  print_tracking(study);
  print_isolation(study);
  print_margins(study);
}

void write_base_motion(const BaseMotionSetup& setup, const BaseMotionStudy& study, const std::string& git,
                       const std::filesystem::path& file) {
  const gain_design::MinMargins least;
  nlohmann::ordered_json json;
  json["generator"] = {
      {"program", "sim_host base-motion"}, {"git", git}, {"plant", setup.plant.name}, {"seeds", setup.seeds}};
  json["goal"] = {{"sigma_urad", 1e6 * kBaseSigmaGoal_rad}, {"isolation_db", kIsolationGoal_db},
                  {"isolation_hz", kIsolationGoal_hz},      {"isolation_deg", kDegPerRad * kIsolationGoal_rad},
                  {"gain_margin_db", least.gain_margin_db}, {"phase_margin_deg", least.phase_margin_deg}};
  json["tracking"] = nlohmann::ordered_json::array();
  for (const TrackingOnBase& tracking : study.tracking) {
    json["tracking"].push_back(json_of(setup, tracking));
  }
  json["isolation"] = curves_of(worst_of(study.isolation));
  json["margins"] = nlohmann::ordered_json::array();
  for (const PitchMargins& margins : worst_of(study.margins)) {
    json["margins"].push_back({{"pitch_deg", kDegPerRad * margins.pitch_rad},
                               {"seal", seal_name(margins.pre_sliding)},
                               {"meets_goal", meets_goal(margins)},
                               {"computed", json_of(margins.computed)},
                               {"measured", json_of(margins.measured)},
                               {"gains_fixed", json_of(margins.fixed)}});
  }
  write_json(json, file);
}

}  // namespace trackservo::sim
