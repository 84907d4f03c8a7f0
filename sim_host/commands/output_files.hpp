// SPDX-License-Identifier: Apache-2.0
// The files that a command writes. None replaces a file that exists unless --overwrite asks for it, and none replaces
// what the same command reads, named or by default.
#ifndef TRACKSERVO_SIM_COMMANDS_OUTPUT_FILES_HPP
#define TRACKSERVO_SIM_COMMANDS_OUTPUT_FILES_HPP

#include <CLI/CLI.hpp>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace trackservo::sim {

// Adds the options that name what a command writes, and --overwrite. They are checked when the command line has been
// read, before the command runs: std::invalid_argument names the option, the file and the remedy. Devices and pipes may
// always be written. The paths must live as long as the command.
class OutputFiles {
 public:
  explicit OutputFiles(CLI::App& command);

  CLI::Option *file(const std::string& option, std::filesystem::path& path, const std::string& help);

  // Adds an option for a folder, made if it does not exist, with all `files` that the command writes into it: a name,
  // or "NAME/" for every result (.csv, .json) in this folder and below.
  CLI::Option *folder(const std::string& option, std::filesystem::path& path, const std::string& help,
                      const std::vector<std::string>& files);

  // Notes that `option` names a file that the command reads if it exists, and continues or makes: no other option may
  // write it.
  CLI::Option *kept(CLI::Option *option);

  // Adds an option for a file that the command reads, also when `path` has kept its default. Files of options without a
  // default need no call: each file that an option names is read, unless it is an output.
  CLI::Option *input(const std::string& option, std::filesystem::path& path, const std::string& help);
  void reads(const std::function<std::vector<std::filesystem::path>()>& files);

  // Refuses `file`, a name that the command derives from an option's value, when another option writes it, too. Call
  // before the command writes it.
  void apart(const std::string& option, const std::filesystem::path& file) const;

  // Checks a name that the command derives from an option's value. Call before the command writes any file. "NAME/" as
  // in folder().
  void check(const std::string& option, const std::filesystem::path& file) const;

 private:
  struct Names;

  CLI::Option *written(CLI::Option *option, const std::vector<std::string>& files, bool is_kept);

  std::shared_ptr<Names> names_;  // the command's callback keeps it, too
};

}  // namespace trackservo::sim

#endif
