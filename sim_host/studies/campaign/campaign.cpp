// SPDX-License-Identifier: Apache-2.0
#include "studies/campaign/campaign.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <mutex>
#include <numeric>
#include <tuple>

#include "machine/base/job_pool.hpp"
#include "machine/run/scenario_run.hpp"
#include "studies/margins/margin_study.hpp"
#include "studies/sensitivity/sensitivity.hpp"
#include "studies/shared/run_files.hpp"

namespace trackservo::sim {
namespace {

// Relative cost of jobs, in units of about 5.5 ms of one core; used only for the estimate of the time left.
constexpr int kIdentificationCost = 2200;
constexpr int kEvaluationCost = 17;  // of a search for the best PI
constexpr int kLeastErrorCost = 1000;
constexpr int kMarginCost = 18;

int run_cost(const Study& study) {
  const auto runs = static_cast<double>(runs_of(study.scenario).size());
  return 3 + static_cast<int>(std::lround(0.5 * runs * study.scenario.duration_s));
}

int search_cost(const SearchEffort& effort) { return kEvaluationCost * (effort.explore + effort.refine); }

struct RunSpec {
  const Study *study;
  StudyCase study_case;
  FrictionModel friction;
  const ControllerSpec *controller;
  std::size_t seed_index;
};

std::vector<RunSpec> runs_of(const Study& study, std::size_t seeds) {
  std::vector<RunSpec> runs;
  const std::vector<StudyCase> cases = cases_of(study);
  for (const FrictionModel friction : study.frictions) {
    for (const ControllerSpec& controller : controller_specs()) {
      for (const StudyCase& study_case : cases) {
        for (std::size_t seed = 0; seed < seeds; ++seed) {
          runs.push_back({&study, study_case, friction, &controller, seed});
        }
      }
    }
  }
  return runs;
}

// The properties that distinguish a run or a cell, in the order in which they are listed.
using Place = std::tuple<std::string, std::string, std::string, FrictionModel, std::string>;
using CellPlace = std::tuple<Place, int, std::string>;

Place place_of(const RunSpec& spec) {
  return {spec.study->experiment, spec.study->plant.name, spec.study_case.name, spec.friction, spec.controller->name};
}

// Runs the jobs and collects figures and files. Threads finish in any order; people and diffs need a fixed one: hence
// the maps.
class Runner {
 public:
  explicit Runner(const Campaign& campaign) : campaign_(campaign) {}

  void run(const RunSpec& spec) {
    const Study& study = *spec.study;
    RunChoice choice{spec.controller, spec.friction, campaign_.options.seeds[spec.seed_index],
                     campaign_.options.friction_parameter_error, std::nullopt};
    if (spec.controller->name == "pi_best") {
      choice.pi = campaign_.best_pi.at(study_name(study));
    }
    const Trace trace = run_case(study, spec.study_case, choice);
    const SavedRun kept = keep(spec, trace);
    const std::vector<Figure> figures = measure(study, spec.study_case, trace);
    const std::lock_guard<std::mutex> lock(mutex_);
    runs_.emplace(std::make_tuple(place_of(spec), spec.seed_index), kept);
    for (const Figure& figure : figures) {
      cell(spec, figure).values[spec.seed_index] = figure.value;
    }
  }

  // Moves the collected results into the campaign.
  void hand_over(Campaign& campaign) const {
    for (const auto& [place, cell] : cells_) {
      campaign.cells.push_back(cell);
    }
    for (const auto& [place, run] : runs_) {
      campaign.runs.push_back(run);
    }
  }

 private:
  SavedRun keep(const RunSpec& spec, const Trace& trace) const {
    const Study& study = *spec.study;
    SavedRun run{study.experiment,
                 spec.study_case.name,
                 study.plant.name,
                 spec.friction,
                 spec.controller->name,
                 campaign_.options.seeds[spec.seed_index],
                 "",
                 study.figure,
                 study.scenario.rest_s + study.scenario.settle_s};
    run.csv = "runs/" + write_run(trace, campaign_.options.out_dir / "runs",
                                  {run.experiment, run.case_name, run.plant, friction_name(run.friction),
                                   run.controller, "seed_" + std::to_string(run.seed)},
                                  spec.seed_index == 0);
    return run;
  }

  Cell& cell(const RunSpec& spec, const Figure& figure) {
    const Cell empty{
        spec.study->experiment, spec.study_case.name,  spec.study->plant.name,
        spec.friction,          spec.controller->name, figure.axis,
        figure.metric,          figure.unit,           std::vector<double>(campaign_.options.seeds.size())};
    return cells_.try_emplace({place_of(spec), figure.axis, figure.metric}, empty).first->second;
  }

  const Campaign& campaign_;
  std::mutex mutex_;
  std::map<CellPlace, Cell> cells_;
  std::map<std::tuple<Place, std::size_t>, SavedRun> runs_;
};

// The shipped figure beside every varied one.
void add_shipped(Campaign& campaign) {
  for (SensitivityRecord& record : campaign.sensitivity) {
    const Cell& varied = record.varied;
    const auto same = [&](const Cell& cell) {
      return cell.experiment == varied.experiment && cell.case_name == varied.case_name &&
             cell.friction == FrictionModel::kLugre && cell.controller == varied.controller &&
             cell.axis == varied.axis && cell.metric == varied.metric;
    };
    record.shipped = *std::find_if(campaign.cells.begin(), campaign.cells.end(), same);
  }
}

SearchEffort effort_of(const CampaignOptions& options) {
  return options.quick() ? SearchEffort{12, 8} : SearchEffort{};
}

void search_best_pis(Campaign& campaign, const std::vector<Study>& studies, JobPool& pool) {
  const SearchEffort effort = effort_of(campaign.options);
  std::mutex mutex;
  pool.run(
      studies.size(),
      [&](std::size_t i) {
        const PiRequirement best = best_pi(studies[i], effort);
        const std::lock_guard<std::mutex> lock(mutex);
        campaign.best_pi[study_name(studies[i])] = best;
        return "best PI for " + study_name(studies[i]);
      },
      search_cost(effort));
}

void search_least_errors(std::vector<Study>& studies, JobPool& pool) {
  pool.run(
      studies.size(),
      [&](std::size_t i) {
        studies[i].least_error =
            design_axes(studies[i].plant, controller_spec("least_error"), design_options(studies[i]));
        return "least rate error for " + study_name(studies[i]);
      },
      kLeastErrorCost);
}

int variation_cost(const CampaignOptions& options) { return 16 * static_cast<int>(options.seeds.size()); }

void run_sensitivity(Campaign& campaign, const std::vector<SensitivityJob>& jobs, const std::vector<Study>& studies,
                     JobPool& pool) {
  std::vector<std::vector<SensitivityRecord>> records(jobs.size());
  pool.run(
      jobs.size(),
      [&](std::size_t i) {
        records[i] = run_sensitivity_job(jobs[i], studies, campaign.options);
        return std::string("what if we had chosen otherwise");
      },
      variation_cost(campaign.options));
  for (const std::vector<SensitivityRecord>& of_job : records) {
    campaign.sensitivity.insert(campaign.sensitivity.end(), of_job.begin(), of_job.end());
  }
  add_shipped(campaign);
}

void run_margins(Campaign& campaign, const std::vector<Study>& studies, JobPool& pool) {
  const std::vector<MarginJob> jobs = margin_jobs_of(campaign.plants, studies, campaign.best_pi);
  campaign.margins.resize(jobs.size());
  pool.run(
      jobs.size(),
      [&](std::size_t i) {
        campaign.margins[i] = run_margin_job(jobs[i], campaign.options.out_dir);
        return std::string("stability margins");
      },
      kMarginCost);
}

int cost_of(const Campaign& campaign, const std::vector<Study>& studies, std::size_t variations) {
  const auto times = [](std::size_t count, int cost) { return static_cast<int>(count) * cost; };
  const int fixed = times(kAxes * campaign.plants.size(), kIdentificationCost) +
                    times(studies.size(), search_cost(effort_of(campaign.options)) + kLeastErrorCost) +
                    times(variations, variation_cost(campaign.options)) +
                    times(margin_jobs_of(campaign.plants, studies, campaign.best_pi).size(), kMarginCost);
  return std::accumulate(studies.begin(), studies.end(), fixed, [&](int sum, const Study& study) {
    return sum + times(runs_of(study, campaign.options.seeds.size()).size(), run_cost(study));
  });
}

}  // namespace

Campaign run_campaign(const CampaignOptions& options, const Progress& progress) {
  Campaign campaign;
  campaign.options = options;
  for (const char *folder : {"runs", "runs/sensitivity", "margins"}) {
    std::filesystem::create_directories(options.out_dir / folder);
  }
  campaign.experiments = load_experiments(options.data_dir, options.shipped_dir);
  std::vector<Study> studies = studies_of(campaign.experiments);
  campaign.plants = plants_of(studies);
  for (const Study& study : studies) {
    campaign.best_pi[study_name(study)] = pi_requirement(study.plant, kAzimuth, {});  // until it is found
  }
  const std::vector<Variation> varied = options.quick() ? std::vector<Variation>{} : variations(campaign.experiments);
  const std::vector<SensitivityJob> jobs = sensitivity_jobs(varied);
  JobPool pool(options.threads, cost_of(campaign, studies, jobs.size()), progress);

  campaign.identified = identify_plants(campaign.plants, options.out_dir, pool, kIdentificationCost);
  for (Study& study : studies) {
    study.identified = assumed_plant_of(study.plant, campaign.identified);
  }
  search_best_pis(campaign, studies, pool);
  search_least_errors(studies, pool);
  Runner runner(campaign);
  for (const Study& study : studies) {
    const std::vector<RunSpec> runs = runs_of(study, options.seeds.size());
    pool.run(
        runs.size(),
        [&](std::size_t i) {
          runner.run(runs[i]);
          return "runs of " + study_name(study);
        },
        run_cost(study));
  }
  runner.hand_over(campaign);
  run_sensitivity(campaign, jobs, studies, pool);
  run_margins(campaign, studies, pool);
  return campaign;
}

}  // namespace trackservo::sim
