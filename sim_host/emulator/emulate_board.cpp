// SPDX-License-Identifier: Apache-2.0
// The commands of sim_host whose device is the board: emulated register by register, it runs the image to be flashed,
// before there is a board.
//
//   emulate_board IMAGE.bin --plant sim_host/plants/tracker.toml --bus slcan-tcp:29536
//   emulate_board serve --image IMAGE.bin ...    # the same
//   emulate_board check --image IMAGE.bin
//
// `sim_host serve --image` and `sim_host check --image` start it. Violations of the chip's rules by the image are
// printed at the end, and make the exit code 1.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "board/board_device.hpp"
#include "board/flash_file.hpp"
#include "commands/check_command.hpp"
#include "commands/command_line.hpp"
#include "commands/serve_command.hpp"

namespace {

namespace sim = trackservo::sim;
namespace target = trackservo::target;

void unplug(target::BoardMachine& machine, const std::vector<std::string>& missing) {
  for (const std::string& sensor : missing) {
    const int axis = sensor.rfind("azimuth", 0) == 0 ? sim::kAzimuth : sim::kPitch;
    if (sensor.find("encoder") != std::string::npos) {
      machine.encoder(axis).is_connected = false;
    } else {
      machine.gyro(axis).is_connected = false;
    }
  }
}

int report_violations(const target::Violations& violations) {
  for (const std::string& violation : violations.list()) {
    fmt::print(stderr, "violation of the chip's rules: {}\n", violation);
  }
  return violations.list().empty() ? 0 : 1;
}

int serve_board(const sim::BoardOptions& given, const sim::PlantConfig& plant, const sim::ServeOptions& options,
                const sim::ServeReports& reports) {
  sim::VirtualBus bus{static_cast<double>(options.bit_rate), sim::kPwmPeriod_s};
  target::BoardMachine::Options fitted;
  fitted.seed = options.seed;
  fitted.joint_angle_rad = sim::kServedStart_rad;
  fitted.holding_brakes = true;
  target::BoardDevice board(target::read_image(given.image), plant, bus, fitted);
  target::Stm32g474& chip = board.machine().chip();
  std::optional<sim::FlashMemory> flash;
  if (!options.flash.empty()) {
    flash.emplace(options.flash);
    target::load_parameter_pages(chip, *flash);
  }
  if (!given.option_bytes.empty()) {
    chip.flash.set_options(given.option_bytes[0], given.option_bytes[1]);
  }
  unplug(board.machine(), given.missing);
  sim::serve({&board}, bus, options, reports);
  if (flash) {
    target::keep_parameter_pages(chip, *flash);
  }
  return report_violations(chip.violations);
}

// The flash image on the emulated board, for a check.
sim::DeviceMaker boards_with(const std::filesystem::path& file) {
  return [image = target::read_image(file)](const sim::PlantConfig& plant, sim::VirtualBus& bus, std::uint64_t seed,
                                            const std::array<double, sim::kAxes>& joint_angle_rad) {
    target::BoardMachine::Options options;
    options.seed = seed;
    options.joint_angle_rad = joint_angle_rad;
    return std::make_unique<target::BoardDevice>(image, plant, bus, options);
  };
}

// With an image in place of a command it serves, as it did before it had commands.
std::vector<std::string> with_command(int argc, char **argv) {
  std::vector<std::string> arguments(argv, argv + argc);
  const std::string first = argc > 1 ? argv[1] : "--help";
  if (first != "serve" && first != "check" && first != "--help" && first != "-h" && first != "--version") {
    arguments.insert(arguments.begin() + 1, "serve");
  }
  return arguments;
}

}  // namespace

// Options that contradict each other throw here: an error of the program, which may end it.
// NOLINTNEXTLINE(bugprone-exception-escape)
int main(int argc, char **argv) {
  std::vector<std::string> arguments = with_command(argc, argv);
  std::vector<char *> raw;
  raw.reserve(arguments.size());
  for (std::string& argument : arguments) {
    raw.push_back(argument.data());
  }
  const sim::ImageDevices devices = boards_with;
  const sim::ServeBoard server = serve_board;
  int code = 0;
  CLI::App app{"Runs the image of the servo board on an emulated board with the simulated machine."};
  app.require_subcommand(1);
  sim::add_serve(app, code, arguments, server);
  sim::add_check(app, code, arguments, devices);
  const std::string name = std::filesystem::path(arguments[0]).filename().string();  // sim_host, if it has started it
  return sim::run_program(name.c_str(), app, static_cast<int>(raw.size()), raw.data(), code);
}
