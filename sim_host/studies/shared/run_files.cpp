// SPDX-License-Identifier: Apache-2.0
#include "studies/shared/run_files.hpp"

#include <algorithm>
#include <string_view>

namespace trackservo::sim {
namespace {

constexpr std::size_t kDrawnRows = 6000;
constexpr std::size_t kOtherRows = 400;
constexpr std::string_view kDisliked = " /,()";

}  // namespace

std::string file_name(const std::vector<std::string>& words) {
  std::string name;
  for (const std::string& word : words) {
    name += (name.empty() || word.empty() ? "" : "-") + word;
  }
  std::replace_if(
      name.begin(), name.end(), [](char letter) { return kDisliked.find(letter) != std::string_view::npos; }, '_');
  return name + ".csv";
}

std::string write_run(const Trace& trace, const std::filesystem::path& folder, const std::vector<std::string>& words,
                      bool drawn) {
  std::string name = file_name(words);
  const std::size_t rows = drawn ? kDrawnRows : kOtherRows;
  write_csv(trace, folder / name, {static_cast<int>((trace.size() + rows - 1) / rows), 7});
  return name;
}

}  // namespace trackservo::sim
