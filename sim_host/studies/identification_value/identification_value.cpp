// SPDX-License-Identifier: Apache-2.0
#include "studies/identification_value/identification_value.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "judge/analysis/statistics.hpp"
#include "machine/base/job_pool.hpp"
#include "machine/base/json_file.hpp"
#include "studies/shared/experiment.hpp"
#include "studies/shared/identified_axis.hpp"

namespace trackservo::sim {
namespace {

using Json = nlohmann::ordered_json;
using Values = std::vector<double> AssumedPlantFigure::*;

constexpr Values kAssumedPlants[] = {&AssumedPlantFigure::identified, &AssumedPlantFigure::exact,
                                     &AssumedPlantFigure::wrong};

// What the experiments compare, without the rms errors: no goal judges them, they show what an error consists of.
std::vector<CaseFigures> compensated_figures(const std::vector<Experiment>& experiments) {
  std::vector<CaseFigures> all;
  for (const Experiment& experiment : experiments) {
    for (CaseFigures figures : experiment.compared) {
      std::vector<std::string>& metrics = figures.metrics;
      metrics.erase(std::remove(metrics.begin(), metrics.end(), "rms_error"), metrics.end());
      all.push_back(figures);
    }
  }
  return all;
}

Estimate estimate(const std::vector<double>& values) {
  return {mean(values), standard_deviation(values) / std::sqrt(static_cast<double>(values.size()))};
}

// At each seed: all figures as shares of their mean with wrong parameters, summed.
std::vector<double> sums(const std::vector<AssumedPlantFigure>& figures, Values assumed_plant) {
  std::vector<double> per_seed(figures.front().wrong.size());
  for (const AssumedPlantFigure& figure : figures) {
    for (std::size_t i = 0; i < per_seed.size(); ++i) {
      per_seed[i] += (figure.*assumed_plant)[i] / mean(figure.wrong);
    }
  }
  return per_seed;
}

double worst_sum(const std::vector<AssumedPlantFigure>& figures, Values assumed_plant) {
  double sum = 0;
  for (const AssumedPlantFigure& figure : figures) {
    const std::vector<double>& values = figure.*assumed_plant;
    sum += *std::max_element(values.begin(), values.end()) / mean(figure.wrong);
  }
  return sum;
}

std::vector<double> less(std::vector<double> a, const std::vector<double>& b) {
  std::transform(a.begin(), a.end(), b.begin(), a.begin(), std::minus<>());
  return a;
}

// The study with its controller designed from one of the assumed plants, and so with its parameter errors.
std::pair<Study, double> believing(const Study& shipped, Values assumed_plant, const CampaignOptions& options) {
  Study study = shipped;
  if (assumed_plant != &AssumedPlantFigure::identified) {
    study.identified.reset();
  }
  return {study, assumed_plant == &AssumedPlantFigure::wrong ? options.friction_parameter_error : 0.0};
}

// A case at a seed, with all three assumed plants.
struct ComparedCase {
  const CaseFigures *compared;
  std::size_t first_figure;  // of the case's, in consecutive order
  std::size_t seed;
};

void run_task(const ComparedCase& task, const std::vector<Study>& studies, const CampaignOptions& options,
              std::vector<AssumedPlantFigure>& figures) {
  const auto [shipped, study_case] = find_case(*task.compared, studies);
  for (const Values assumed_plant : kAssumedPlants) {
    const auto [study, error] = believing(*shipped, assumed_plant, options);
    const RunChoice choice{&controller_spec("pi_vob_ftc"), study.plant.friction_model, options.seeds[task.seed], error,
                           std::nullopt};
    for (const Figure& measured : measure(study, study_case, run_case(study, study_case, choice))) {
      for (std::size_t i = 0; i < task.compared->metrics.size(); ++i) {
        if (measured.axis == kAzimuth && measured.metric == task.compared->metrics[i]) {
          AssumedPlantFigure& figure = figures[task.first_figure + i];
          (figure.*assumed_plant)[task.seed] = measured.value;
          if (task.seed == 0) {
            figure.unit = measured.unit;
          }
        }
      }
    }
  }
}

Json json_of(const Estimate& estimate) {
  return {{"mean", estimate.mean}, {"standard_error", estimate.standard_error}};
}

Json json_of(const AssumedPlantFigure& figure) {
  return {{"experiment", figure.experiment}, {"case", figure.case_name},
          {"metric", figure.metric},         {"unit", figure.unit},
          {"identified", figure.identified}, {"exact", figure.exact},
          {"wrong", figure.wrong},           {"gain", json_of(gain_of(figure))}};
}

Json json_of(const AssumedPlantSum& sum) {
  return {{"identified", json_of(sum.identified)},
          {"exact", json_of(sum.exact)},
          {"wrong", json_of(sum.wrong)},
          {"identified_less_wrong", json_of(sum.identified_less_wrong)},
          {"identified_less_exact", json_of(sum.identified_less_exact)},
          {"worst_identified", sum.worst_identified},
          {"worst_exact", sum.worst_exact},
          {"worst_wrong", sum.worst_wrong}};
}

std::string mean_and_range(const std::vector<double>& values) {
  const auto [low, high] = std::minmax_element(values.begin(), values.end());
  return fmt::format("{:.4g} ({:.4g} .. {:.4g})", mean(values), *low, *high);
}

}  // namespace

Estimate gain_of(const AssumedPlantFigure& figure) {
  return estimate(less(sums({figure}, &AssumedPlantFigure::identified), sums({figure}, &AssumedPlantFigure::wrong)));
}

AssumedPlantSum sum_of(const std::vector<AssumedPlantFigure>& figures) {
  const std::vector<double> identified = sums(figures, &AssumedPlantFigure::identified);
  const std::vector<double> exact = sums(figures, &AssumedPlantFigure::exact);
  const std::vector<double> wrong = sums(figures, &AssumedPlantFigure::wrong);
  AssumedPlantSum sum;
  sum.identified = estimate(identified);
  sum.exact = estimate(exact);
  sum.wrong = estimate(wrong);
  sum.identified_less_wrong = estimate(less(identified, wrong));
  sum.identified_less_exact = estimate(less(identified, exact));
  sum.worst_identified = worst_sum(figures, &AssumedPlantFigure::identified);
  sum.worst_exact = worst_sum(figures, &AssumedPlantFigure::exact);
  sum.worst_wrong = worst_sum(figures, &AssumedPlantFigure::wrong);
  return sum;
}

AssumedPlantStudy run_assumed_plant_study(const CampaignOptions& options, const Progress& progress) {
  const std::vector<Experiment> experiments = load_experiments(options.data_dir, options.shipped_dir);
  std::vector<Study> studies = studies_of(experiments);
  const std::vector<PlantConfig> plants = plants_of(studies);
  const std::vector<CaseFigures> compared = compensated_figures(experiments);
  AssumedPlantStudy result;
  std::vector<ComparedCase> tasks;
  for (const CaseFigures& figures : compared) {
    for (std::size_t seed = 0; seed < options.seeds.size(); ++seed) {
      tasks.push_back({&figures, result.figures.size(), seed});
    }
    for (const std::string& metric : figures.metrics) {
      const std::vector<double> empty(options.seeds.size());
      result.figures.push_back({figures.experiment, figures.case_name, metric, "", empty, empty, empty});
    }
  }
  JobPool pool(options.threads, static_cast<int>(kAxes * plants.size() + tasks.size()), progress);
  const std::vector<IdentifiedAxis> identified = identify_plants(plants, options.out_dir, pool);
  for (Study& study : studies) {
    study.identified = assumed_plant_of(study.plant, identified);
  }
  pool.run(tasks.size(), [&](std::size_t i) {
    run_task(tasks[i], studies, options, result.figures);
    return tasks[i].compared->experiment;
  });
  result.sum = sum_of(result.figures);
  return result;
}

void print(const AssumedPlantStudy& study) {
  fmt::print("PI + VOB + FTC, azimuth; mean (best .. worst seed)\n{:<54} {:<30} {:<30} {:<30} {}\n", "figure",
             "identified", "exact", "wrong", "identified minus wrong, +- standard error");
  for (const AssumedPlantFigure& figure : study.figures) {
    const Estimate gain = gain_of(figure);
    fmt::print("{:<54} {:<30} {:<30} {:<30} {:+.1f} +- {:.1f} %\n",
               fmt::format("{}, {}: {}, {}", figure.experiment, figure.case_name, figure.metric, figure.unit),
               mean_and_range(figure.identified), mean_and_range(figure.exact), mean_and_range(figure.wrong),
               100 * gain.mean, 100 * gain.standard_error);
  }
  const AssumedPlantSum& sum = study.sum;
  fmt::print("sum of the {}, each relative to its mean with wrong parameters, +- standard error\n",
             study.figures.size());
  fmt::print("  identified {:.3f} +- {:.3f}, exact {:.3f} +- {:.3f}, wrong {:.3f} +- {:.3f}\n", sum.identified.mean,
             sum.identified.standard_error, sum.exact.mean, sum.exact.standard_error, sum.wrong.mean,
             sum.wrong.standard_error);
  fmt::print("  paired by seed: identified minus wrong {:+.3f} +- {:.3f}, identified minus exact {:+.3f} +- {:.3f}\n",
             sum.identified_less_wrong.mean, sum.identified_less_wrong.standard_error, sum.identified_less_exact.mean,
             sum.identified_less_exact.standard_error);
  fmt::print("  worst seeds: identified {:.3f}, exact {:.3f}, wrong {:.3f}\n", sum.worst_identified, sum.worst_exact,
             sum.worst_wrong);
}

void write_assumed_plant_study(const AssumedPlantStudy& study, const CampaignOptions& options, const std::string& git,
                               const std::filesystem::path& file) {
  Json json;
  json["generator"] = {{"program", "sim_host beliefs"},
                       {"git", git},
                       {"seeds", options.seeds},
                       {"friction_parameter_error", options.friction_parameter_error}};
  json["figures"] = Json::array();
  for (const AssumedPlantFigure& figure : study.figures) {
    json["figures"].push_back(json_of(figure));
  }
  json["sum"] = json_of(study.sum);
  write_json(json, file);
}

}  // namespace trackservo::sim
