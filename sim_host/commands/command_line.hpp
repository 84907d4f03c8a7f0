// SPDX-License-Identifier: Apache-2.0
// What the commands of sim_host share: warnings, progress, checks of arguments.
#ifndef TRACKSERVO_SIM_COMMANDS_COMMAND_LINE_HPP
#define TRACKSERVO_SIM_COMMANDS_COMMAND_LINE_HPP

#include <CLI/CLI.hpp>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "studies/shared/study.hpp"

namespace trackservo::sim {

constexpr const char *kDataHelp = "folder with plants/ and scenarios/";

// Writes each text to the standard error once, for however many runs it is valid.
void warn(const std::vector<std::string>& texts);

// Refuses inconsistent input and warns of unusual input, before the first run of a study. Throws like
// design_controller.
servo_params checked_design(const Study& study, const ControllerSpec& spec, const DesignOptions& options);

// Call it before the first job, whose time counts too.
void start_progress();

// Writes the progress to the standard error; see progress.hpp. Call after every finished job.
void show_progress(int done, int total, const std::string& what);

// Throws std::invalid_argument.
void refuse_repeated_seeds(std::vector<std::uint64_t> seeds);

// Returns the check for an option that is a seed.
CLI::Validator seed();

struct SeedRange {
  std::uint64_t first = 1;
  std::uint64_t count = 0;
  bool has_first = false;
};

// Returns the seeds that the text names. "N": so many, from 1 on. "A-B": from A to B. Nothing when it is neither.
std::optional<SeedRange> seed_range(const std::string& text);

// Returns the check for an option that seed_range reads, with `min` to `max` seeds.
CLI::Validator seed_range_check(int min, int max);

// Adds the option --threads, whose default is one thread per processor.
void add_threads(CLI::App& command, int& threads);

// Returns the check for an option that is a share: 0 to `most`; unlike CLI::Range it refuses NaN.
CLI::Validator share(double most);

// Parses the arguments, which runs the chosen command, and ends as every program of ours: with the code that the
// command set, 0 after --help and --version, 2 after wrong input, of which the standard error gets one sentence that
// begins with `name`.
int run_program(const char *name, CLI::App& app, int argc, char **argv, const int& code);

}  // namespace trackservo::sim

#endif
