#include "experiments/margin_study.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <fstream>
#include <limits>
#include <stdexcept>

#include "analysis/frequency_measurement.hpp"

namespace trackservo::sim {
namespace {

constexpr double kBiasRate_rad_s = 2.0 * kPi / 180.0;

// Strong enough to stand out of wind and noise, weak enough to stay in the regime (no reversal, no break-away).
double torque_rms_nm(const MarginJob& job) {
  const double coulomb_nm = job.plant->axis[static_cast<std::size_t>(job.axis)].friction.positive.coulomb_nm;
  return (job.pre_sliding ? 0.2 : 1.0) * coulomb_nm;
}

double decibel(std::complex<double> gain) { return 20.0 * std::log10(std::abs(gain)); }
double degrees(std::complex<double> gain) { return std::arg(gain) * 180.0 / kPi; }

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

}  // namespace

std::vector<MarginJob> margin_jobs_of(const std::vector<PlantConfig>& plants) {
  std::vector<MarginJob> jobs;
  for (const PlantConfig& plant : plants) {
    for (const ControllerSpec& controller : controller_specs()) {
      for (int axis = 0; axis < kAxes && controller.name != "pi_best"; ++axis) {
        jobs.push_back({&plant, controller.name, axis, false});
        jobs.push_back({&plant, controller.name, axis, true});
      }
    }
  }
  return jobs;
}

MarginRecord run_margin_job(const MarginJob& job, const std::filesystem::path& out_dir) {
  const servo_params params = design_controller(*job.plant, controller_spec(job.controller), {});
  const speed_loop_params& loop = params.axis[job.axis].speed;
  const LinearMachine machine = linear_machine(*job.plant, job.axis, job.pre_sliding);

  MeasurementRequest request;
  request.plant = job.plant;
  request.params = params;
  request.axis = job.axis;
  request.bias_rate_rad_s = job.pre_sliding ? 0.0 : kBiasRate_rad_s;
  request.torque_rms_nm = torque_rms_nm(job);

  MarginRecord record;

  record.plant = job.plant->name;
  record.controller = job.controller;
  record.axis = job.axis;
  record.pre_sliding = job.pre_sliding;
  record.computed = margins_of(computed_loop_gain(machine, loop, log_space(0.05, 450.0, 2000)));
  record.bandwidth_hz =
      job.pre_sliding ? std::numeric_limits<double>::quiet_NaN() : closed_loop_bandwidth_hz(machine, loop);
  // Around the crossover: below, the wind is stronger than any test torque; above, the loop gain drowns in noise.
  request.first_hz = record.computed.crossover_hz / 4.0;
  request.last_hz = std::min(10.0 * record.computed.crossover_hz, 450.0);
  const FrequencyResponse measured = measured_loop_gain(request);
  record.measured = margins_of(measured);
  record.csv = fmt::format("margins/{}-{}-{}-{}.csv", record.plant, record.controller, axis_name(job.axis),
                           job.pre_sliding ? "pre_sliding" : "sliding");
  write_response(computed_loop_gain(machine, loop, measured.frequency_hz), measured, out_dir / record.csv);
  return record;
}

}  // namespace trackservo::sim
