// SPDX-License-Identifier: Apache-2.0
#include "study_commands.hpp"

#include <fmt/format.h>

#include <memory>
#include <numeric>

#include "command_line.hpp"
#include "machine/base/checksum.hpp"
#include "machine/base/job_pool.hpp"
#include "machine/config/arguments.hpp"
#include "machine/config/data_folder.hpp"
#include "output_files.hpp"
#include "studies/base_motion/base_motion.hpp"
#include "studies/campaign/campaign.hpp"
#include "studies/campaign/results.hpp"
#include "studies/identification_value/identification_value.hpp"
#include "studies/node_tracking/node_tracking.hpp"
#include "studies/random_plants/random_plants_report.hpp"
#include "studies/shared/assumed_plant_file.hpp"
#include "studies/shared/experiment.hpp"

namespace trackservo::sim {
namespace {

void experiments(const CampaignOptions& options) {
  refuse_repeated_seeds(options.seeds);
  for (const Study& study : studies_of(load_experiments(options.data_dir, options.shipped_dir))) {
    for (const ControllerSpec& spec : controller_specs()) {
      if (!spec.least_error) {  // that takes seconds, and the campaign does it once
        checked_design(study, spec, {});
      }
    }
  }
  start_progress();
  const Campaign campaign = run_campaign(options, show_progress);
  write_results(campaign, TRACKSERVO_GIT, options.out_dir / "results.json");
  fmt::print("written {}\n", (options.out_dir / "results.json").string());
}

void assumed_plants(const CampaignOptions& options) {
  refuse_repeated_seeds(options.seeds);
  start_progress();
  const AssumedPlantStudy study = run_assumed_plant_study(options, show_progress);
  print(study);
  write_assumed_plant_study(study, options, TRACKSERVO_GIT, options.out_dir / "beliefs.json");
  fmt::print("written {}\n", (options.out_dir / "beliefs.json").string());
}

constexpr int kMinPlants = 2;
constexpr int kMaxPlants = 1000000;

struct RandomPlantsOptions {
  std::filesystem::path data_dir = data_folder();
  std::filesystem::path plant;  // empty: the tracker of the data folder
  std::string seeds;            // instead of the setup's seed and count, if not empty
  RandomPlantsSetup setup;
  std::filesystem::path identified;
  std::vector<std::filesystem::path> merge;
  bool all_seeds_given = false;
  std::filesystem::path out_dir;
  std::shared_ptr<OutputFiles> outputs;
};

// An existing file is only read, also from a folder that cannot be written.
std::string identified_file_problem(const std::filesystem::path& file) {
  std::error_code ignored;
  return std::filesystem::is_regular_file(file, ignored) ? "" : output_file_problem(file);
}

// It is read, and then continued.
std::string log_file_problem(const std::filesystem::path& file) {
  std::error_code ignored;
  const std::string problem = output_file_problem(file);
  const bool is_other = std::filesystem::exists(file, ignored) && !std::filesystem::is_regular_file(file, ignored);
  return problem.empty() && is_other ? fmt::format("{}: is not a regular file; give one, or a new name", file.string())
                                     : problem;
}

std::filesystem::path plant_of(const RandomPlantsOptions& options) {
  return options.plant.empty() ? options.data_dir / "plants/tracker.toml" : options.plant;
}

// The setup without what is identified.
RandomPlantsSetup random_plants_setup(const RandomPlantsOptions& options, const std::filesystem::path& plant) {
  RandomPlantsSetup setup = options.setup;
  if (!options.seeds.empty()) {
    const SeedRange range = *seed_range(options.seeds);  // it was checked
    setup.seed = range.first;
    setup.count = range.count;
  }
  setup.study.plant = load_plant(plant);
  const std::vector<Experiment> experiments = load_experiments(options.data_dir, data_folder());
  const Experiment& steady = experiment_named("steady_speed", experiments);
  setup.study.scenario = steady.studies.front().scenario;
  setup.study.experiment = steady.name;
  setup.paper = steady.paper;
  const std::vector<std::filesystem::path> inputs = {plant, setup.study.scenario.lines.file()};
  setup.origin = {TRACKSERVO_GIT, plant.filename().string(), checksum_of(inputs), ""};
  return setup;
}

AssumedPlantRecord assumed_plant_for(const RandomPlantsOptions& options, const std::filesystem::path& plant,
                                     const RandomPlantsSetup& setup) {
  const IdentifiedBy by{TRACKSERVO_GIT, plant};
  if (std::filesystem::exists(options.identified)) {
    return read_assumed_plant(options.identified, by);
  }
  options.outputs->check("--out", options.out_dir / kIdentificationFolder);
  JobPool pool(setup.threads, kAxes, show_progress);
  return identify_assumed_plant(setup.study.plant, by, options.out_dir, options.identified, pool);
}

RandomPlants run_random_plants(const RandomPlantsOptions& options, const std::filesystem::path& plant,
                               RandomPlantsSetup setup) {
  checked_design(setup.study, controller_spec("pi_vob_ftc"), {});
  start_progress();
  const AssumedPlantRecord assumed = assumed_plant_for(options, plant, setup);
  setup.study.identified = assumed.plant;
  setup.origin.identified = assumed.checksum;
  return try_random_plants(setup, show_progress);
}

void random_plants(const RandomPlantsOptions& options) {
  const std::filesystem::path plant = plant_of(options);
  const RandomPlantsSetup setup = random_plants_setup(options, plant);
  const RandomPlants tried = options.merge.empty() ? run_random_plants(options, plant, setup)
                                                   : merge_random_plants(setup, options.merge, options.all_seeds_given);
  const RandomPlantsSummary summary = summary_of(tried);
  print(tried, summary);
  write_random_plants(tried, summary, TRACKSERVO_GIT, options.out_dir);
  fmt::print("Wrote {0}/random_plants.json and {0}/random_plants.csv\n", options.out_dir.string());
}

// Options of every study, including its seeds.
CLI::Option *add_study_options(CLI::App& command, CampaignOptions& options, const std::vector<std::string>& files) {
  options.data_dir = data_folder();
  options.shipped_dir = data_folder();
  OutputFiles(command).folder("--out", options.out_dir, "folder for the results", files)->required();
  command.add_option("--data", options.data_dir, kDataHelp)->check(CLI::ExistingDirectory);
  add_threads(command, options.threads);
  return command.add_option("--seeds", options.seeds, "seeds to run")->check(seed())->capture_default_str();
}

template <class Results>
std::vector<Requirement> requirements_of_all(const std::vector<Results>& results) {
  std::vector<Requirement> requirements;
  for (const Results& result : results) {
    const std::vector<Requirement> more = requirements_of(result);
    requirements.insert(requirements.end(), more.begin(), more.end());
  }
  return requirements;
}

// Writes a study's own file and its rows of results.json.
template <class Write>
void write_study(const RequirementSource& source, const std::vector<Requirement>& requirements,
                 const std::filesystem::path& folder, const char *file, const Write& write) {
  if (folder.empty()) {
    return;
  }
  write(folder / file);
  const bool recorded = record_requirements(source, requirements, folder);
  fmt::print("written {}{}\n", (folder / file).string(), recorded ? " and the rows of results.json" : "");
}

struct BaseMotionOptions {
  BaseMotionSetup setup;
  std::filesystem::path plant = data_folder() / "plants/tracker.toml";
  std::filesystem::path out_dir;
};

void base_motion(const BaseMotionOptions& options) {
  BaseMotionSetup setup = options.setup;
  refuse_repeated_seeds(setup.seeds);
  setup.plant = load_plant(options.plant);
  start_progress();
  const BaseMotionStudy study = run_base_motion(setup, show_progress);
  print(setup, study);
  write_study({"sim_host base-motion", TRACKSERVO_GIT, setup.plant.name}, requirements_of(setup, study),
              options.out_dir, "base_motion.json",
              [&](const std::filesystem::path& file) { write_base_motion(setup, study, TRACKSERVO_GIT, file); });
}

struct NodeTrackingOptions {
  NodeTrackingSetup setup;
  std::filesystem::path plant = data_folder() / "plants/tracker.toml";
  std::filesystem::path out_dir;
};

void node_tracking(const NodeTrackingOptions& options) {
  NodeTrackingSetup setup = options.setup;
  refuse_repeated_seeds(setup.seeds);
  setup.plant = load_plant(options.plant);
  setup.cases = shipped_node_tracking(setup.plant, data_folder());
  start_progress();
  const std::vector<NodeTrackingResult> results = run_node_tracking(setup, show_progress);
  print(setup, results);
  write_study({"sim_host node-tracking", TRACKSERVO_GIT, setup.plant.name}, requirements_of_all(results),
              options.out_dir, "node_tracking.json",
              [&](const std::filesystem::path& file) { write_node_tracking(setup, results, TRACKSERVO_GIT, file); });
}

}  // namespace

void add_experiments(CLI::App& app) {
  auto options = std::make_shared<CampaignOptions>();
  auto quick = std::make_shared<bool>(false);
  CLI::App *command = app.add_subcommand("experiments", "run all experiments of the paper");
  CLI::Option *seeds =
      add_study_options(*command, *options, {"results.json", "runs/", "margins/", kIdentificationFolder});
  command->add_flag("--quick", *quick, "run one seed only, for a first look")->excludes(seeds);
  command->callback([options, quick] {
    if (*quick) {
      options->seeds = {1};
    }
    experiments(*options);
  });
}

void add_assumed_plants(CLI::App& app) {
  constexpr std::uint64_t kSeeds = 20;
  auto options = std::make_shared<CampaignOptions>();
  options->seeds.resize(kSeeds);
  std::iota(options->seeds.begin(), options->seeds.end(), 1);
  CLI::App *command = app.add_subcommand(
      "identification-value",
      "study the value of identification: compensation with identified, exact and wrong friction parameters");
  command->alias("beliefs");
  add_study_options(*command, *options, {"beliefs.json", kIdentificationFolder})
      ->expected(2, CLI::detail::expected_max_vector_size);
  command->callback([options] { assumed_plants(*options); });
}

void add_random_plants(CLI::App& app) {
  auto options = std::make_shared<RandomPlantsOptions>();
  RandomPlantsSetup& setup = options->setup;
  CLI::App *command = app.add_subcommand(
      "random-plants",
      "study steady speed on plants that differ in every parameter from the one that the gains were designed for");
  options->outputs = std::make_shared<OutputFiles>(*command);
  OutputFiles& outputs = *options->outputs;
  outputs.reads([options] { return std::vector<std::filesystem::path>{plant_of(*options)}; });
  command->add_option("--data", options->data_dir, kDataHelp)->check(CLI::ExistingDirectory);
  command->add_option("--plant", options->plant, "nominal plant file (TOML); default: plants/tracker.toml of --data")
      ->check(CLI::ExistingFile);
  CLI::Option *count = command->add_option("--count", setup.count, "number of plants")
                           ->check(CLI::Range(kMinPlants, kMaxPlants))
                           ->capture_default_str();
  command->add_option("--share", setup.share, "largest relative deviation of each parameter")
      ->check(share(0.9))
      ->capture_default_str();
  CLI::Option *first =
      command->add_option("--seed", setup.seed, "seed of the first plant; the following plants use the following seeds")
          ->check(seed())
          ->capture_default_str();
  CLI::Option *seeds = command
                           ->add_option("--seeds", options->seeds,
                                        "number of plants, or the seeds of the first and of the last one: 1001-2000")
                           ->check(seed_range_check(kMinPlants, kMaxPlants))
                           ->excludes(count)
                           ->excludes(first);
  CLI::Option *identified =
      command
          ->add_option("--identified,--belief", options->identified,
                       "file with both identified axes, used instead of an identification; if it does not exist, they "
                       "are identified and written to it")
          ->check(CLI::Validator(identified_file_problem, "FILE"));
  outputs.kept(identified);
  CLI::Option *log = command
                         ->add_option("--log", setup.log,
                                      "append each plant's result to this CSV file, and do not repeat the plants that "
                                      "it has")
                         ->check(CLI::Validator(log_file_problem, "FILE"));
  outputs.kept(log);
  command
      ->add_option("--merge", options->merge,
                   "run nothing; write the results of these logs, which must have each seed once (with --seeds: all of "
                   "these)")
      ->check(CLI::ExistingFile)
      ->excludes(identified)
      ->excludes(log);
  add_threads(*command, setup.threads);
  outputs.folder("--out", options->out_dir, "folder for the results", {"random_plants.json", "random_plants.csv"})
      ->required();
  command->callback([options, count, first, seeds] {
    options->all_seeds_given = count->count() + first->count() + seeds->count() > 0;
    random_plants(*options);
  });
}

void add_node_tracking(CLI::App& app) {
  auto options = std::make_shared<NodeTrackingOptions>();
  CLI::App *command = app.add_subcommand(
      "node-tracking", "study tracking in the running node: camera frames over CAN, both axes in mode -1");
  command->alias("passes");  // which had a study of its own
  OutputFiles outputs(*command);
  outputs.input("--plant", options->plant, "plant file (TOML)");
  command->add_option("--seeds", options->setup.seeds, "seeds to run")->check(seed())->capture_default_str();
  add_threads(*command, options->setup.threads);
  outputs.folder("--out", options->out_dir, "folder for node_tracking.json, and of the results.json that gets the rows",
                 {"node_tracking.json"});
  command->callback([options] { node_tracking(*options); });
}

void add_base_motion(CLI::App& app) {
  auto options = std::make_shared<BaseMotionOptions>();
  CLI::App *command = app.add_subcommand(
      "base-motion", "study a base that turns: line of sight while tracking, isolation, margins over the pitch");
  OutputFiles outputs(*command);
  outputs.input("--plant", options->plant, "plant file (TOML)");
  command->add_option("--seeds", options->setup.seeds, "seeds to run")->check(seed())->capture_default_str();
  add_threads(*command, options->setup.threads);
  outputs.folder("--out", options->out_dir, "folder for base_motion.json, and of the results.json that gets the rows",
                 {"base_motion.json"});
  command->callback([options] { base_motion(*options); });
}

}  // namespace trackservo::sim
