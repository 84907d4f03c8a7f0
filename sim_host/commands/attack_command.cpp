// SPDX-License-Identifier: Apache-2.0
#include "attack_command.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <memory>
#include <optional>

#include "command_line.hpp"
#include "judge/attack/attack_campaign.hpp"
#include "judge/attack/named_sequences.hpp"
#include "machine/config/arguments.hpp"
#include "machine/config/data_folder.hpp"
#include "output_files.hpp"

namespace trackservo::sim {
namespace {

struct AttackCommand {
  std::filesystem::path plant = data_folder() / "plants/tracker.toml";
  AttackOptions attack;
  std::string seeds = "5000";
  std::optional<std::uint64_t> replay;
  std::string sequence;
  std::filesystem::path json;
};

constexpr int kMaxSeeds = 10000000;

// The seeds of the options in one piece.
AttackOptions attack_options(const AttackCommand& command) {
  AttackOptions options = command.attack;
  const SeedRange range = *seed_range(command.seeds);  // it was checked
  options.seeds = range.count;
  options.first_seed = range.has_first ? range.first : options.first_seed;
  return options;
}

int attack(const AttackCommand& command) {
  const AttackBench bench(load_plant(command.plant));
  if (command.replay) {
    EventLog log;
    const AttackResult result = run_attack(bench, *command.replay, &log);
    fmt::print("{}seed {}, {}{}: {}\n", log.text(), result.seed, theme_name(result.theme),
               result.narrow ? ", azimuth within half a turn" : "", describe(result.harm, result.answers));
    return result.harmless() ? 0 : 1;
  }
  if (!command.sequence.empty()) {
    fmt::print("{}", replay(bench, named_sequence(command.sequence)));
    return 0;
  }
  const std::vector<SequenceResult> sequences = run_named_sequences(bench, command.attack.threads);
  fmt::print("{}\n", print(sequences));
  (void)std::fflush(stdout);
  start_progress();
  const AttackCampaign campaign = run_attacks(bench, attack_options(command), show_progress);
  fmt::print("{}", print(campaign));
  if (!command.json.empty()) {
    write_attacks(campaign, TRACKSERVO_GIT, command.json);
    fmt::print("Wrote {}\n", command.json.string());
  }
  const bool harmless =
      std::all_of(sequences.begin(), sequences.end(), [](const SequenceResult& one) { return one.harmless; });
  return harmless && campaign.harmful.empty() ? 0 : 1;
}

}  // namespace

void add_attack(CLI::App& app, int& code) {
  auto options = std::make_shared<AttackCommand>();
  CLI::App *command = app.add_subcommand(
      "attack",
      "move both axes and write random legal values by SDO and PDO, without unlocking anything; exit code 1: "
      "an axis reached an end stop faster than 5 deg/s or ran away");
  OutputFiles outputs(*command);
  outputs.input("--plant", options->plant, "plant file (TOML)");
  CLI::Option *seeds =
      command->add_option("--seeds", options->seeds, "number of seeds, or the first and the last one: 1-1000")
          ->check(seed_range_check(1, kMaxSeeds))
          ->capture_default_str();
  CLI::Option *first = command->add_option("--first-seed", options->attack.first_seed, "the first of them")
                           ->check(seed())
                           ->capture_default_str();
  CLI::Option *json = outputs.file("--json", options->json, "file for the results");
  command->add_option("--replay", options->replay, "run one seed and print every write, frame and event with its time")
      ->check(seed())
      ->excludes(seeds)
      ->excludes(first)
      ->excludes(json);
  command
      ->add_option("--replay-sequence", options->sequence,
                   "run one of the known sequences and print its worst run in the same way")
      ->excludes(seeds)
      ->excludes(first)
      ->excludes(json);
  add_threads(*command, options->attack.threads);
  command->callback([options, first, &code] {
    if (first->count() > 0 && seed_range(options->seeds)->has_first) {
      throw CLI::ValidationError("--first-seed", "the range of --seeds already has a first seed; give one of them");
    }
    code = attack(*options);
  });
}

}  // namespace trackservo::sim
