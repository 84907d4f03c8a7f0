// SPDX-License-Identifier: Apache-2.0
#include "studies/margins/margin_study.hpp"

#include <fmt/format.h>

#include <cmath>
#include <fstream>
#include <limits>
#include <stdexcept>

#include "design/margin_measurement.hpp"
#include "studies/shared/run_files.hpp"

namespace trackservo::sim {
namespace {

double decibel(std::complex<double> gain) { return 20.0 * std::log10(std::abs(gain)); }
double degrees(std::complex<double> gain) { return std::arg(gain) * kDegPerRad; }

void write_response(const FrequencyResponse& computed, const FrequencyResponse& measured,
                    const std::filesystem::path& file) {
  std::ofstream stream(file);
  stream << "frequency_hz,computed_magnitude_db,computed_phase_deg,measured_magnitude_db,measured_phase_deg\n";
  for (std::size_t i = 0; i < computed.frequency_hz.size(); ++i) {
    stream << fmt::format("{:.6g},{:.6g},{:.6g},{:.6g},{:.6g}\n", computed.frequency_hz[i],
                          decibel(computed.loop_gain[i]), degrees(computed.loop_gain[i]),
                          decibel(measured.loop_gain[i]), degrees(measured.loop_gain[i]));
  }
  if (!stream.flush()) {
    throw std::runtime_error(fmt::format("{}: cannot be written; is the disk full?", file.string()));
  }
}

void add_jobs(std::vector<MarginJob>& jobs, MarginJob job) {
  for (job.axis = 0; job.axis < kAxes; ++job.axis) {
    for (const bool pre_sliding : {false, true}) {
      job.pre_sliding = pre_sliding;
      jobs.push_back(job);
    }
  }
}

servo_params params_of(const MarginJob& job) {
  servo_params params = design_controller(*job.plant, controller_spec(job.controller), job.design);
  for (int axis = 0; axis < kAxes && job.pi; ++axis) {
    set_pi(params, axis, *job.pi);
  }
  return params;
}

DesignOptions design_for(const PlantConfig& plant, const std::vector<Study>& studies) {
  for (const Study& study : studies) {
    if (study.plant.name == plant.name) {
      return design_options(study);
    }
  }
  return {};
}

}  // namespace

std::vector<MarginJob> margin_jobs_of(const std::vector<PlantConfig>& plants, const std::vector<Study>& studies,
                                      const std::map<std::string, PiRequirement>& best_pi) {
  std::vector<MarginJob> jobs;
  for (const PlantConfig& plant : plants) {
    for (const ControllerSpec& controller : controller_specs()) {
      if (controller.name != "pi_best") {
        add_jobs(jobs, {&plant, controller.name, 0, false, "", std::nullopt, design_for(plant, studies)});
      }
    }
    for (const Study& study : studies) {
      if (study.plant.name == plant.name) {
        add_jobs(jobs, {&plant, "pi_best", 0, false, study_name(study), best_pi.at(study_name(study)),
                        design_options(study)});
      }
    }
  }
  return jobs;
}

MarginRecord run_margin_job(const MarginJob& job, const std::filesystem::path& out_dir) {
  const servo_params params = params_of(job);
  const speed_loop_params& loop = params.axis[job.axis].speed;
  const LinearMachine machine = linear_machine(*job.plant, job.axis, job.pre_sliding);

  MarginRecord record;
  record.plant = job.plant->name;
  record.controller = job.controller;
  record.study = job.study;
  record.axis = job.axis;
  record.pre_sliding = job.pre_sliding;
  record.computed = margins_of(computed_loop_gain(machine, loop, log_space(0.05, 450.0, 2000)));
  record.bandwidth_hz =
      job.pre_sliding ? std::numeric_limits<double>::quiet_NaN() : closed_loop_bandwidth_hz(machine, loop);

  const FrequencyResponse measured =
      measured_near_crossover(*job.plant, params, job.axis, job.pre_sliding, record.computed);
  record.measured = margins_of(measured);
  record.csv = "margins/" + file_name({record.plant, record.controller, record.study, axis_name(job.axis),
                                       job.pre_sliding ? "pre_sliding" : "sliding"});
  write_response(computed_loop_gain(machine, loop, measured.frequency_hz), measured, out_dir / record.csv);
  return record;
}

}  // namespace trackservo::sim
