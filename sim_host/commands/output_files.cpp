// SPDX-License-Identifier: Apache-2.0
#include "output_files.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <stdexcept>

#include "machine/config/arguments.hpp"

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

bool is_result(const fs::path& file) { return file.extension() == ".csv" || file.extension() == ".json"; }

std::vector<fs::path> results_below(const fs::path& folder) {
  std::vector<fs::path> files;
  std::error_code ignored;
  for (auto entry = fs::recursive_directory_iterator(folder, ignored); entry != fs::recursive_directory_iterator();
       entry.increment(ignored)) {
    if (is_result(entry->path())) {
      files.push_back(entry->path());
    }
  }
  std::sort(files.begin(), files.end());  // the sentence names the first one
  return files;
}

// The names of OutputFiles::folder() as files; without names, what is given is a file itself.
std::vector<fs::path> files_of(const fs::path& given, const std::vector<std::string>& names) {
  std::vector<fs::path> files;
  for (const std::string& name : names) {
    const std::vector<fs::path> more =
        name.back() == '/' ? results_below(given / name) : std::vector<fs::path>{given / name};
    files.insert(files.end(), more.begin(), more.end());
  }
  return names.empty() ? std::vector<fs::path>{given} : files;
}

CLI::Validator file_check() {
  return {[](const std::string& file) { return output_file_problem(file); }, "FILE"};
}

}  // namespace

struct OutputFiles::Names {
  struct Output {
    CLI::Option *option;
    std::vector<std::string> files;  // in the folder that the option names; none: it names a file
    bool is_kept;
  };

  CLI::App *command;
  bool overwrite = false;
  std::vector<Output> outputs;
  std::vector<fs::path> written;
  std::vector<std::function<std::vector<fs::path>()>> inputs;

  bool is_only_written(const CLI::Option *option) const {
    return std::any_of(outputs.begin(), outputs.end(),
                       [=](const Output& one) { return one.option == option && !one.is_kept; });
  }

  bool is_read(const fs::path& file) const {
    std::vector<fs::path> read;
    for (const CLI::Option *option : command->get_options()) {
      if (!is_only_written(option)) {
        read.insert(read.end(), option->results().begin(), option->results().end());
      }
    }
    for (const auto& files : inputs) {
      const std::vector<fs::path> more = files();
      read.insert(read.end(), more.begin(), more.end());
    }
    std::error_code ignored;
    return std::any_of(read.begin(), read.end(),
                       [&](const fs::path& one) { return fs::is_regular_file(one, ignored) && are_same(one, file); });
  }

  void check(const std::string& option, const fs::path& file) const {
    std::error_code ignored;
    if (!fs::is_regular_file(file, ignored)) {
      return;
    }
    if (is_read(file)) {
      refuse(option,
             fmt::format("\"{}\" would be replaced, but this command reads it; give another name", file.string()));
    }
    if (!overwrite) {
      refuse(option,
             fmt::format("\"{}\" exists already; give another name, or add --overwrite to replace it", file.string()));
    }
  }

  void set_apart(const std::string& option, const fs::path& file) {
    if (std::any_of(written.begin(), written.end(), [&](const fs::path& other) { return are_same(other, file); })) {
      refuse(option, fmt::format("\"{}\" is also what another option writes; give another name", file.string()));
    }
    written.push_back(file);
  }

  void check_all() {
    for (const Output& output : outputs) {
      if (output.option->count() == 0) {
        continue;
      }
      for (const fs::path& file : files_of(output.option->results().front(), output.files)) {
        if (!output.is_kept) {
          check(output.option->get_name(), file);
        }
        set_apart(output.option->get_name(), file);
      }
    }
  }
};

OutputFiles::OutputFiles(CLI::App& command) : names_(std::make_shared<Names>()) {
  names_->command = &command;
  command.parse_complete_callback([names = names_] { names->check_all(); });
}

CLI::Option *OutputFiles::written(CLI::Option *option, const std::vector<std::string>& files, bool is_kept) {
  if (!is_kept && names_->command->get_option_no_throw("--overwrite") == nullptr) {
    names_->command->add_flag("--overwrite", names_->overwrite, "replace files that exist already");
  }
  names_->outputs.push_back({option, files, is_kept});
  return option;
}

CLI::Option *OutputFiles::file(const std::string& option, fs::path& path, const std::string& help) {
  return written(names_->command->add_option(option, path, help)->check(file_check()), {}, false);
}

CLI::Option *OutputFiles::folder(const std::string& option, fs::path& path, const std::string& help,
                                 const std::vector<std::string>& files) {
  CLI::Option *added = names_->command->add_option(option, path, help);
  added->check(CLI::Validator([](const std::string& folder) { return output_folder_problem(folder); }, "FOLDER"));
  return written(added, files, false);
}

CLI::Option *OutputFiles::kept(CLI::Option *option) { return written(option, {}, true); }

CLI::Option *OutputFiles::input(const std::string& option, fs::path& path, const std::string& help) {
  reads([&path] { return std::vector<fs::path>{path}; });
  return names_->command->add_option(option, path, help)->check(CLI::ExistingFile);
}

void OutputFiles::reads(const std::function<std::vector<fs::path>()>& files) { names_->inputs.push_back(files); }

void OutputFiles::apart(const std::string& option, const fs::path& file) const {
  if (file.has_filename()) {
    names_->set_apart(option, file);
  }
}

void OutputFiles::check(const std::string& option, const fs::path& file) const {
  const std::string problem = file.has_filename() ? output_file_problem(file) : "";
  if (!problem.empty()) {
    refuse(option, problem);
  }
  for (const fs::path& one : file.has_filename() ? std::vector<fs::path>{file} : results_below(file)) {
    names_->check(option, one);
  }
}

}  // namespace trackservo::sim
