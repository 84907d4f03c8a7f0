// SPDX-License-Identifier: Apache-2.0
#include "data_folder.hpp"

#include <system_error>

namespace trackservo::sim {

namespace fs = std::filesystem;

fs::path data_folder() {
  std::error_code ignored;  // without /proc the folder is not found, and reading a file in it says so
  const fs::path program = fs::read_symlink("/proc/self/exe", ignored);
  const fs::path folder = program.parent_path().parent_path() / "share/trackservo/sim_host";
  const fs::path without_links = fs::weakly_canonical(folder, ignored);
  return without_links.empty() ? folder : without_links;
}

}  // namespace trackservo::sim
