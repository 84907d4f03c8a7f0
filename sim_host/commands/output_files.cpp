#include "output_files.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <stdexcept>

#include "config/arguments.hpp"

namespace trackservo::sim {
namespace fs = std::filesystem;

namespace {

bool are_same(const fs::path& one, const fs::path& other) {
  std::error_code ignored;
  return fs::equivalent(one, other, ignored) || fs::weakly_canonical(one) == fs::weakly_canonical(other);
}

[[noreturn]] void refuse(const std::string& option, const std::string& reason) {
  throw std::invalid_argument(fmt::format("{}: {}", option, reason));
}

}  // namespace

struct OutputFiles::Names {
  struct Output {
    CLI::Option *option;
    std::vector<std::string> files;  // in the folder that the option names; none: it names a file
  };

  CLI::App *command;
  bool overwrite = false;
  std::vector<Output> outputs;

  bool is_output(const CLI::Option *option) const {
    return std::any_of(outputs.begin(), outputs.end(), [=](const Output& one) { return one.option == option; });
  }

  std::vector<fs::path> files_of(const Output& output) const {
    const fs::path given = output.option->results().front();
    std::vector<fs::path> files;
    for (const std::string& name : output.files) {
      files.push_back(given / name);
    }
    return output.files.empty() ? std::vector<fs::path>{given} : files;
  }

  void check(const std::string& option, const fs::path& file) const {
    std::error_code ignored;
    if (!fs::is_regular_file(file, ignored)) {
      return;
    }
    for (const CLI::Option *other : command->get_options()) {
      if (is_output(other)) {
        continue;
      }
      for (const std::string& value : other->results()) {
        if (fs::is_regular_file(value, ignored) && are_same(value, file)) {
          refuse(option,
                 fmt::format("\"{}\" would be replaced, but this command reads it; give another name", file.string()));
        }
      }
    }
    if (!overwrite) {
      refuse(option,
             fmt::format("\"{}\" exists already; give another name, or add --overwrite to replace it", file.string()));
    }
  }

  void check_all() const {
    std::vector<fs::path> written;
    for (const Output& output : outputs) {
      if (output.option->count() == 0) {
        continue;
      }
      for (const fs::path& file : files_of(output)) {
        check(output.option->get_name(), file);
        if (std::any_of(written.begin(), written.end(), [&](const fs::path& other) { return are_same(other, file); })) {
          refuse(output.option->get_name(),
                 fmt::format("\"{}\" is also what another option writes; give another name", file.string()));
        }
        written.push_back(file);
      }
    }
  }
};

OutputFiles::OutputFiles(CLI::App& command) : names_(std::make_shared<Names>()) {
  names_->command = &command;
  command.add_flag("--overwrite", names_->overwrite, "replace files that exist already");
  command.parse_complete_callback([names = names_] { names->check_all(); });
}

CLI::Option *OutputFiles::file(const std::string& option, fs::path& path, const std::string& help) {
  CLI::Option *added = names_->command->add_option(option, path, help);
  added->check(CLI::Validator([](const std::string& file) { return output_file_problem(file); }, "FILE"));
  names_->outputs.push_back({added, {}});
  return added;
}

CLI::Option *OutputFiles::folder(const std::string& option, fs::path& path, const std::string& help,
                                 const std::vector<std::string>& files) {
  CLI::Option *added = names_->command->add_option(option, path, help);
  added->check(CLI::Validator([](const std::string& folder) { return output_folder_problem(folder); }, "FOLDER"));
  names_->outputs.push_back({added, files});
  return added;
}

void OutputFiles::check(const std::string& option, const fs::path& file) const {
  const std::string problem = output_file_problem(file);
  if (!problem.empty()) {
    refuse(option, problem);
  }
  names_->check(option, file);
}

}  // namespace trackservo::sim
