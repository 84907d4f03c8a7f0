// SPDX-License-Identifier: Apache-2.0
// sim_host with only its check command: for builds of a faulty firmware.
#include "commands/check_command.hpp"
#include "commands/command_line.hpp"

int main(int argc, char **argv) {
  const std::vector<std::string> arguments(argv, argv + argc);
  const trackservo::sim::ImageDevices no_images;
  int code = 0;
  CLI::App app{"The check of sim_host."};
  trackservo::sim::add_check(app, code, arguments, no_images);
  return trackservo::sim::run_program("sim_host", app, argc, argv, code);
}
