#include "studies/sensitivity/sensitivity.hpp"

#include <fmt/format.h>

#include "studies/shared/run_files.hpp"

namespace trackservo::sim {
namespace {

using namespace probes;

const AxisConfig& azimuth(const Study& study) { return study.plant.axis[kAzimuth]; }

std::string on_or_off(bool on) { return on ? "on" : "off"; }

Variation not_identified() {
  return {"friction parameters of the feedforward",
          false,
          {sine(), disturbed_step(), start(), steady("0.1 deg/s"), steady("0.2 deg/s"), steady("0.4 deg/s"),
           steady("1 deg/s"), steady("2 deg/s"), paper_loop(), improved_loop()},
          [](const Study& study) { return study.identified ? "identified" : "each off by 15 %"; },
          [](Study& study) { study.identified.reset(); }};
}

Variation weave() {
  return {"weave of the UAV, lateral and vertical",
          false,
          {paper_loop(), improved_loop()},
          [](const Study& study) {
            const FlyByConfig& fly_by = study.scenario.fly_by;
            return fmt::format("{:g} m, {:g} m", fly_by.weave_lateral_m, fly_by.weave_vertical_m);
          },
          [](Study& study) {
            study.scenario.fly_by.weave_lateral_m = 8.0;
            study.scenario.fly_by.weave_vertical_m = 6.0;
          }};
}

Variation encoder_reads() {
  return {"encoder reads per tick",
          false,
          {steady("0.1 deg/s"), steady("2 deg/s")},
          [](const Study& study) { return fmt::format("{}", azimuth(study).encoder.reads_per_tick); },
          [](Study& study) {
            for (AxisConfig& axis : study.plant.axis) {
              axis.encoder.reads_per_tick = 1;
            }
          }};
}

Variation setpoint_weight() {
  return {"set-point weight of the PI",
          false,
          {start()},
          [](const Study& study) { return fmt::format("{:g}", study.plant.design[kAzimuth].setpoint_weight); },
          [](Study& study) {
            for (DesignConfig& design : study.plant.design) {
              design.setpoint_weight = 1.0;
            }
          }};
}

Variation wind_corner(double factor) {
  return {"corner frequency of the wind, same rms",
          false,
          {steady("0.1 deg/s"), paper_loop()},
          [](const Study& study) { return fmt::format("{:g} Hz", azimuth(study).load.wind_turbulence_corner_hz); },
          [factor](Study& study) {
            for (AxisConfig& axis : study.plant.axis) {
              axis.load.wind_turbulence_corner_hz *= factor;
              axis.load.wind_admittance_corner_hz *= factor;
            }
          }};
}

Variation wind() {
  return {"wind, rms",
          true,
          {start(), steady("0.1 deg/s"), paper_loop(), improved_loop()},
          [](const Study& study) { return fmt::format("{:g} Nm", azimuth(study).load.wind_gust_rms_nm); },
          [](Study& study) {
            for (AxisConfig& axis : study.plant.axis) {
              axis.load.wind_mean_nm = 0.0;
              axis.load.wind_gust_rms_nm = 0.0;
            }
          }};
}

Variation friction() {
  return {"friction of the plant, feedforward as designed",
          true,
          {sine(), start(), steady("0.1 deg/s"), paper_loop()},
          [](const Study& study) { return friction_name(study.plant.friction_model); },
          [](Study& study) { study.plant.friction_model = FrictionModel::kNone; }};
}

Variation gyro_noise() {
  return {"noise of the gyro",
          true,
          {steady("0.1 deg/s")},
          [](const Study& study) { return on_or_off(azimuth(study).gyro.noise_density_rad_s_rthz > 0.0); },
          [](Study& study) {
            for (AxisConfig& axis : study.plant.axis) {
              axis.gyro.noise_density_rad_s_rthz = 0.0;
            }
          }};
}

Variation encoder_jitter() {
  return {"jitter of the encoder",
          true,
          {steady("0.1 deg/s")},
          [](const Study& study) { return on_or_off(azimuth(study).encoder.jitter_rms_rad > 0.0); },
          [](Study& study) {
            for (AxisConfig& axis : study.plant.axis) {
              axis.encoder.jitter_rms_rad = 0.0;
            }
          }};
}

Variation ripple() {
  return {"torque ripple and cogging",
          true,
          {steady("0.1 deg/s"), steady("2 deg/s")},
          [](const Study& study) { return on_or_off(!azimuth(study).motor.ripple.empty()); },
          [](Study& study) {
            for (AxisConfig& axis : study.plant.axis) {
              axis.motor.ripple.clear();
              axis.motor.cogging.clear();
            }
          }};
}

// A record without values for each metric of the probe.
std::vector<SensitivityRecord> empty_records(const SensitivityJob& job, const Study& shipped, const Study& varied,
                                             const StudyCase& study_case) {
  std::vector<SensitivityRecord> records;
  for (const std::string& metric : job.probe->metrics) {
    SensitivityRecord record;
    record.variation = job.variation->name;
    record.switches_off = job.variation->switches_off;
    record.shipped_setting = job.variation->setting(shipped);
    record.varied_setting = job.variation->setting(varied);
    record.varied = {shipped.experiment,
                     study_case.name,
                     shipped.plant.name,
                     FrictionModel::kLugre,
                     job.controller,
                     kAzimuth,
                     metric,
                     "",
                     {}};
    records.push_back(record);
  }
  return records;
}

}  // namespace

const std::vector<Variation>& variations() {
  static const std::vector<Variation> all = {not_identified(), weave(),          encoder_reads(), setpoint_weight(),
                                             wind_corner(0.5), wind_corner(2.0), wind(),          friction(),
                                             gyro_noise(),     encoder_jitter(), ripple()};
  return all;
}

std::vector<SensitivityJob> sensitivity_jobs() {
  std::vector<SensitivityJob> jobs;
  for (const Variation& variation : variations()) {
    for (const Probe& probe : variation.probes) {
      jobs.push_back({&variation, &probe, "pi"});
      jobs.push_back({&variation, &probe, "pi_vob_ftc"});
    }
  }
  return jobs;
}

std::vector<SensitivityRecord> run_sensitivity_job(const SensitivityJob& job, const std::vector<Study>& studies,
                                                   const CampaignOptions& options) {
  const auto [shipped, study_case] = find_case(*job.probe, studies);
  Study varied = *shipped;
  job.variation->change(varied);
  std::vector<SensitivityRecord> records = empty_records(job, *shipped, varied, study_case);
  for (const std::uint64_t seed : options.seeds) {
    const RunChoice choice{&controller_spec(job.controller), varied.plant.friction_model, seed,
                           options.friction_parameter_error, std::nullopt};
    const Trace trace = run_case(varied, study_case, choice);
    write_run(trace, options.out_dir / "runs/sensitivity",
              {job.variation->name, records.front().varied_setting, shipped->experiment, study_case.name,
               job.controller, fmt::format("seed_{}", seed)},
              false);
    for (const Figure& figure : measure(varied, study_case, trace)) {
      for (SensitivityRecord& record : records) {
        if (figure.axis == record.varied.axis && figure.metric == record.varied.metric) {
          record.varied.unit = figure.unit;
          record.varied.values.push_back(figure.value);
        }
      }
    }
  }
  return records;
}

}  // namespace trackservo::sim
