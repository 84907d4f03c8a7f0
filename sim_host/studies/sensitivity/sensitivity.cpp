// SPDX-License-Identifier: Apache-2.0
#include "studies/sensitivity/sensitivity.hpp"

#include <fmt/format.h>

#include "studies/shared/run_files.hpp"

namespace trackservo::sim {
namespace {

// Cases of one experiment.
struct Cases {
  const char *experiment;
  std::vector<const char *> names;
};

const Cases kSine{"sine", {"1 deg/s, 0.1 Hz"}};
const Cases kStart{"low_speed_start", {"0.1 deg/s"}};
const Cases kSlowest{"steady_speed", {"0.1 deg/s"}};
const Cases kSlowestAndFastest{"steady_speed", {"0.1 deg/s", "2 deg/s"}};
const Cases kPaperLoop{"tracking", {"paper loop"}};
const Cases kBothLoops{"tracking", {"paper loop", "improved loop"}};

// Finds what the experiments' folders say to compare of a case.
class CompareAt {
 public:
  explicit CompareAt(const std::vector<Experiment>& experiments) : experiments_(experiments) {}

  std::vector<CaseFigures> operator()(const std::vector<Cases>& wanted) const {
    std::vector<CaseFigures> all;
    for (const Cases& cases : wanted) {
      for (const char *name : cases.names) {
        all.push_back(compared_figures(cases.experiment, name, experiments_));
      }
    }
    return all;
  }

  std::vector<CaseFigures> everywhere() const {
    std::vector<CaseFigures> all;
    for (const Experiment& experiment : experiments_) {
      all.insert(all.end(), experiment.compared.begin(), experiment.compared.end());
    }
    return all;
  }

 private:
  const std::vector<Experiment>& experiments_;
};

const AxisConfig& azimuth(const Study& study) { return study.plant.axis[kAzimuth]; }

std::string on_or_off(bool on) { return on ? "on" : "off"; }

Variation not_identified(const CompareAt& at) {
  return {"friction parameters of the feedforward", false, at.everywhere(),
          [](const Study& study) { return study.identified ? "identified" : "each off by 15 %"; },
          [](Study& study) { study.identified.reset(); }};
}

Variation weave(const CompareAt& at) {
  return {"weave of the UAV, lateral and vertical", false, at({kBothLoops}),
          [](const Study& study) {
            const FlyByConfig& fly_by = study.scenario.fly_by;
            return fmt::format("{:g} m, {:g} m", fly_by.weave_lateral_m, fly_by.weave_vertical_m);
          },
          [](Study& study) {
            study.scenario.fly_by.weave_lateral_m = 8.0;
            study.scenario.fly_by.weave_vertical_m = 6.0;
          }};
}

Variation encoder_reads(const CompareAt& at) {
  return {"encoder reads per tick", false, at({kSlowestAndFastest}),
          [](const Study& study) { return fmt::format("{}", azimuth(study).encoder.reads_per_tick); },
          [](Study& study) {
            for (AxisConfig& axis : study.plant.axis) {
              axis.encoder.reads_per_tick = 1;
            }
          }};
}

Variation setpoint_weight(const CompareAt& at) {
  return {"set-point weight of the PI", false, at({kStart}),
          [](const Study& study) { return fmt::format("{:g}", study.plant.design[kAzimuth].setpoint_weight); },
          [](Study& study) {
            for (DesignConfig& design : study.plant.design) {
              design.setpoint_weight = 1.0;
            }
          }};
}

Variation wind_corner(const CompareAt& at, double factor) {
  return {"corner frequency of the wind, same rms", false, at({kSlowest, kPaperLoop}),
          [](const Study& study) { return fmt::format("{:g} Hz", azimuth(study).load.wind_turbulence_corner_hz); },
          [factor](Study& study) {
            for (AxisConfig& axis : study.plant.axis) {
              axis.load.wind_turbulence_corner_hz *= factor;
              axis.load.wind_admittance_corner_hz *= factor;
            }
          }};
}

Variation wind(const CompareAt& at) {
  return {"wind, rms", true, at({kStart, kSlowest, kBothLoops}),
          [](const Study& study) { return fmt::format("{:g} Nm", azimuth(study).load.wind_gust_rms_nm); },
          [](Study& study) {
            for (AxisConfig& axis : study.plant.axis) {
              axis.load.wind_mean_nm = 0.0;
              axis.load.wind_gust_rms_nm = 0.0;
            }
          }};
}

Variation friction(const CompareAt& at) {
  return {"friction of the plant, feedforward as designed", true, at({kSine, kStart, kSlowest, kPaperLoop}),
          [](const Study& study) { return friction_name(study.plant.friction_model); },
          [](Study& study) { study.plant.friction_model = FrictionModel::kNone; }};
}

Variation gyro_noise(const CompareAt& at) {
  return {"noise of the gyro", true, at({kSlowest}),
          [](const Study& study) { return on_or_off(azimuth(study).gyro.noise_density_rad_s_rthz > 0.0); },
          [](Study& study) {
            for (AxisConfig& axis : study.plant.axis) {
              axis.gyro.noise_density_rad_s_rthz = 0.0;
            }
          }};
}

Variation encoder_jitter(const CompareAt& at) {
  return {"jitter of the encoder", true, at({kSlowest}),
          [](const Study& study) { return on_or_off(azimuth(study).encoder.jitter_rms_rad > 0.0); },
          [](Study& study) {
            for (AxisConfig& axis : study.plant.axis) {
              axis.encoder.jitter_rms_rad = 0.0;
            }
          }};
}

Variation ripple(const CompareAt& at) {
  return {"torque ripple and cogging", true, at({kSlowestAndFastest}),
          [](const Study& study) { return on_or_off(!azimuth(study).motor.ripple.empty()); },
          [](Study& study) {
            for (AxisConfig& axis : study.plant.axis) {
              axis.motor.ripple.clear();
              axis.motor.cogging.clear();
            }
          }};
}

// A record without values for each metric of the job.
std::vector<SensitivityRecord> empty_records(const SensitivityJob& job, const Study& shipped, const Study& varied,
                                             const StudyCase& study_case) {
  std::vector<SensitivityRecord> records;
  for (const std::string& metric : job.figures->metrics) {
    SensitivityRecord record{};
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

std::vector<Variation> variations(const std::vector<Experiment>& experiments) {
  const CompareAt at(experiments);
  return {not_identified(at),
          weave(at),
          encoder_reads(at),
          setpoint_weight(at),
          wind_corner(at, 0.5),
          wind_corner(at, 2.0),
          wind(at),
          friction(at),
          gyro_noise(at),
          encoder_jitter(at),
          ripple(at)};
}

std::vector<SensitivityJob> sensitivity_jobs(const std::vector<Variation>& variations) {
  std::vector<SensitivityJob> jobs;
  for (const Variation& variation : variations) {
    for (const CaseFigures& figures : variation.looked_at) {
      jobs.push_back({&variation, &figures, "pi"});
      jobs.push_back({&variation, &figures, "pi_vob_ftc"});
    }
  }
  return jobs;
}

std::vector<SensitivityRecord> run_sensitivity_job(const SensitivityJob& job, const std::vector<Study>& studies,
                                                   const CampaignOptions& options) {
  const auto [shipped, study_case] = find_case(*job.figures, studies);
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
