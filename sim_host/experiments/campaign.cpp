#include "experiments/campaign.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <mutex>

#include "experiments/job_pool.hpp"
#include "experiments/margin_study.hpp"

namespace trackservo::sim {
namespace {

constexpr std::size_t kKeptRows = 6000;  // per CSV at most; longer runs are decimated

struct RunSpec {
  std::size_t study;
  FrictionModel friction;
  std::size_t controller;
  std::size_t case_index;
  std::size_t seed_index;
};

// Friction-free runs are the floor for the experiments that are compared with it.
std::vector<FrictionModel> frictions_of(const Study& study) {
  std::vector<FrictionModel> models = {FrictionModel::kLugre, FrictionModel::kMaxwellSlip};
  if (study.experiment == "step_disturbed" || study.experiment == "tracking") {
    models.push_back(FrictionModel::kNone);
  }
  return models;
}

std::vector<RunSpec> all_runs(const std::vector<Study>& studies, const CampaignOptions& options) {
  std::vector<RunSpec> runs;
  for (std::size_t study = 0; study < studies.size(); ++study) {
    for (const FrictionModel friction : frictions_of(studies[study])) {
      for (std::size_t controller = 0; controller < controller_specs().size(); ++controller) {
        for (std::size_t c = 0; c < cases_of(studies[study]).size(); ++c) {
          for (std::size_t seed = 0; seed < options.seeds.size(); ++seed) {
            runs.push_back({study, friction, controller, c, seed});
          }
        }
      }
    }
  }
  return runs;
}

servo_params params_of(const Study& study, const ControllerSpec& spec, const Campaign& campaign, std::uint64_t seed) {
  servo_params params =
      design_controller(study.plant, spec, {seed, campaign.options.friction_parameter_error, study.tracker});
  if (spec.name == "pi_best") {
    for (int axis = 0; axis < kAxes; ++axis) {
      set_pi(params, study.plant, axis, campaign.best_pi.at(study_name(study)));
    }
  }
  return params;
}

std::string file_stem(const KeptRun& run) {
  std::string stem = fmt::format("{}-{}-{}-{}-{}", run.experiment, run.case_name, run.plant,
                                 friction_name(run.friction), run.controller);
  std::replace_if(
      stem.begin(), stem.end(), [](char c) { return c == ' ' || c == '/' || c == ','; }, '_');
  return stem;
}

// One run: its figures go into the cells, the first seed's trace into a file.
class Runner {
 public:
  Runner(const std::vector<Study>& studies, Campaign& campaign) : studies_(studies), campaign_(campaign) {}

  void run(const RunSpec& spec) {
    const Study& study = studies_[spec.study];
    const ControllerSpec& controller = controller_specs()[spec.controller];
    const StudyCase study_case = cases_of(study)[spec.case_index];
    const std::uint64_t seed = campaign_.options.seeds[spec.seed_index];
    PlantConfig plant = study.plant;
    plant.friction_model = spec.friction;
    const Trace trace = run_scenario(
        {&plant, &study.scenario, study_case.speed_rad_s, params_of(study, controller, campaign_, seed), seed});
    if (spec.seed_index == 0) {
      keep(study, study_case, spec, trace);
    }
    const std::vector<Figure> figures = measure(study, study_case, trace);
    const std::lock_guard<std::mutex> lock(mutex_);
    for (const Figure& figure : figures) {
      cell(study, study_case, spec, figure).values[spec.seed_index] = figure.value;
    }
  }

 private:
  void keep(const Study& study, const StudyCase& study_case, const RunSpec& spec, const Trace& trace) {
    const ScenarioConfig& scenario = study.scenario;
    KeptRun run{study.experiment,
                study_case.name,
                study.plant.name,
                spec.friction,
                controller_specs()[spec.controller].name,
                campaign_.options.seeds[spec.seed_index],
                "",
                study.figure,
                scenario.rest_s + scenario.settle_s};
    run.csv = "runs/" + file_stem(run) + ".csv";
    write_csv(trace, campaign_.options.out_dir / run.csv, static_cast<int>((trace.size() + kKeptRows - 1) / kKeptRows));
    const std::lock_guard<std::mutex> lock(mutex_);
    campaign_.runs.push_back(run);
  }

  Cell& cell(const Study& study, const StudyCase& study_case, const RunSpec& spec, const Figure& figure) {
    const std::string& controller = controller_specs()[spec.controller].name;
    for (Cell& cell : campaign_.cells) {
      if (cell.experiment == study.experiment && cell.case_name == study_case.name && cell.plant == study.plant.name &&
          cell.friction == spec.friction && cell.controller == controller && cell.axis == figure.axis &&
          cell.metric == figure.metric) {
        return cell;
      }
    }
    campaign_.cells.push_back({study.experiment, study_case.name, study.plant.name, spec.friction, controller,
                               figure.axis, figure.metric, figure.unit,
                               std::vector<double>(campaign_.options.seeds.size())});
    return campaign_.cells.back();
  }

  const std::vector<Study>& studies_;
  Campaign& campaign_;
  std::mutex mutex_;
};

Study make_study(const std::filesystem::path& data_dir, const char *experiment, const char *plant, const char *figure,
                 tracker_kind tracker = TRACKER_PI) {
  Study study;
  study.experiment = experiment;
  study.plant = load_plant(data_dir / "plants" / (std::string(plant) + ".toml"));
  study.scenario = load_scenario(data_dir / "scenarios" / (std::string(experiment) + ".toml"));
  study.tracker = tracker;
  study.figure = figure;
  return study;
}

// Threads finish in any order; people and diffs want one order.
void sort_results(Campaign& campaign) {
  const auto rank = [](const auto& a) {
    return std::make_tuple(a.experiment, a.plant, a.case_name, static_cast<int>(a.friction), a.controller);
  };
  std::stable_sort(campaign.runs.begin(), campaign.runs.end(),
                   [&](const KeptRun& a, const KeptRun& b) { return rank(a) < rank(b); });
  std::stable_sort(campaign.cells.begin(), campaign.cells.end(), [&](const Cell& a, const Cell& b) {
    return std::tuple_cat(rank(a), std::make_tuple(a.axis, a.metric)) <
           std::tuple_cat(rank(b), std::make_tuple(b.axis, b.metric));
  });
}

}  // namespace

std::string study_name(const Study& study) {
  const bool improved = study.tracker == TRACKER_PREDICTIVE;
  return study.experiment + " on " + study.plant.name + (improved ? ", improved loop" : "");
}

std::string friction_name(FrictionModel model) {
  switch (model) {
    case FrictionModel::kLugre:
      return "lugre";
    case FrictionModel::kMaxwellSlip:
      return "maxwell_slip";
    case FrictionModel::kNone:
    default:
      return "none";
  }
}

std::vector<Study> paper_studies(const std::filesystem::path& data_dir) {
  return {make_study(data_dir, "sine", "paper_simulation", "fig7"),
          make_study(data_dir, "step_disturbed", "paper_simulation", "fig9"),
          make_study(data_dir, "low_speed_start", "tracker", "fig14"),
          make_study(data_dir, "steady_speed", "tracker", "table2"),
          make_study(data_dir, "tracking", "tracker", "fig16"),
          make_study(data_dir, "tracking", "tracker", "fig16", TRACKER_PREDICTIVE)};
}

Campaign run_campaign(const CampaignOptions& options, const Progress& progress) {
  Campaign campaign;
  campaign.options = options;
  std::filesystem::create_directories(options.out_dir / "runs");
  std::filesystem::create_directories(options.out_dir / "margins");
  const std::vector<Study> studies = paper_studies(options.data_dir);
  for (const Study& study : studies) {
    const auto same = [&](const PlantConfig& plant) { return plant.name == study.plant.name; };
    if (std::none_of(campaign.plants.begin(), campaign.plants.end(), same)) {
      campaign.plants.push_back(study.plant);
    }
  }

  const std::vector<RunSpec> runs = all_runs(studies, options);
  std::vector<MarginJob> margin_jobs = margin_jobs_of(campaign.plants);
  JobPool pool(options.threads, static_cast<int>(runs.size() + studies.size() + margin_jobs.size()), progress);

  std::mutex mutex;
  pool.run(studies.size(), [&](std::size_t i) {
    const PiWish best = best_pi(studies[i]);
    const std::lock_guard<std::mutex> lock(mutex);
    campaign.best_pi[study_name(studies[i])] = best;
    return "best PI for " + study_name(studies[i]);
  });
  Runner runner(studies, campaign);
  pool.run(runs.size(), [&](std::size_t i) {
    runner.run(runs[i]);
    return study_name(studies[runs[i].study]);
  });
  campaign.margins.resize(margin_jobs.size());
  pool.run(margin_jobs.size(), [&](std::size_t i) {
    campaign.margins[i] = run_margin_job(margin_jobs[i], options.out_dir);
    return std::string("stability margins");
  });
  sort_results(campaign);
  return campaign;
}

}  // namespace trackservo::sim
