// The files that a command writes. None replaces a file that exists unless --overwrite asks for it, and none replaces
// what the same command reads.
#ifndef TRACKSERVO_SIM_COMMANDS_OUTPUT_FILES_HPP
#define TRACKSERVO_SIM_COMMANDS_OUTPUT_FILES_HPP

#include <CLI/CLI.hpp>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

namespace trackservo::sim {

// Adds --overwrite to a command, and the options that name what it writes. They are checked when the command line has
// been read, before the command runs: std::invalid_argument names the option, the file and the remedy. Devices and
// pipes may always be written.
class OutputFiles {
 public:
  explicit OutputFiles(CLI::App& command);

  CLI::Option *file(const std::string& option, std::filesystem::path& path, const std::string& help);

  // A folder, made if it does not exist, with the names of the `files` in it by which a result is known.
  CLI::Option *folder(const std::string& option, std::filesystem::path& path, const std::string& help,
                      const std::vector<std::string>& files);

  // For a name that the command derives from an option's value, before it writes any file.
  void check(const std::string& option, const std::filesystem::path& file) const;

 private:
  struct Names;
  std::shared_ptr<Names> names_;  // the command's callback keeps it, too
};

}  // namespace trackservo::sim

#endif
