// SPDX-License-Identifier: Apache-2.0
#include "board_program.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <stdexcept>

namespace trackservo::sim {

namespace fs = std::filesystem;

void hand_over_to_board(const std::vector<std::string>& arguments) {
  const fs::path program = fs::read_symlink("/proc/self/exe").parent_path() / "emulate_board";
  if (!fs::exists(program)) {
    throw std::invalid_argument(
        fmt::format("--image needs the emulated board, but {} is missing: a release has it in the archive "
                    "trackservo-emulator; in a checkout run ./tools/setup test, then cmake "
                    "--preset host, then cmake --build --preset host --target emulate_board",
                    program.string()));
  }
  std::vector<char *> raw;
  raw.reserve(arguments.size() + 1);
  for (const std::string& argument : arguments) {
    raw.push_back(const_cast<char *>(argument.c_str()));  // execv() changes nothing
  }
  raw.push_back(nullptr);
  (void)std::fflush(nullptr);
  execv(program.c_str(), raw.data());
  throw std::runtime_error(fmt::format("{}: cannot be started: {}", program.string(), std::strerror(errno)));
}

}  // namespace trackservo::sim
