// SPDX-License-Identifier: Apache-2.0
#include "serve_command.hpp"

#include <fmt/format.h>

#include <memory>
#include <optional>

#include "board_program.hpp"
#include "command_line.hpp"
#include "design/design_check.hpp"
#include "machine/config/arguments.hpp"
#include "machine/config/data_folder.hpp"
#include "output_files.hpp"
#include "target_arguments.hpp"

namespace trackservo::sim {
namespace {

constexpr double kSlowest = 0.1;
constexpr double kFastest = 1000.0;

// Few: set-points of a client come between them, which the drive misses after 20 ticks. A computer that is too busy
// makes the board slower than real time instead of irregular.
constexpr int kBoardCatchUp_ticks = 4;

struct ServeCommand {
  std::filesystem::path plant = data_folder() / "plants/tracker.toml";
  BoardOptions board;
  ServeOptions options;
  std::string speed = "realtime";
  TargetArguments target;
};

// Simulated time per real time; none for "max", or 0, as emulate_board has always called it.
std::optional<double> pace_of(const std::string& speed) {
  double pace = 1.0;
  if (speed == "max" || speed == "0") {
    return std::nullopt;
  }
  if (speed != "realtime") {
    (void)CLI::detail::lexical_cast(speed, pace);  // checked when it was parsed
  }
  return pace;
}

CLI::Validator speed(bool zero_is_max) {
  return {[zero_is_max](std::string& text) -> std::string {
            double pace = 0.0;
            const bool good = text == "realtime" || text == "max" || (zero_is_max && text == "0") ||
                              (CLI::detail::lexical_cast(text, pace) && pace >= kSlowest && pace <= kFastest);
            return good ? ""
                        : fmt::format("Invalid pace \"{}\": expected realtime, max or a number from {} to {}", text,
                                      kSlowest, kFastest);
          },
          "realtime, max or TIMES"};
}

int serve_device(const ServeCommand& command, const ServeBoard& serve_board) {
  ServeOptions options = command.options;
  ServeReports reports = reports_on_stdout();
  options.pace = pace_of(command.speed);
  const PlantConfig plant = load_plant(command.plant);
  options.target = load_target(command.target, plant);
  reports.open = [open = reports.open, &options,
                  sees_only_the_bus = !command.board.image.empty()](const std::vector<std::string>& addresses) {
    open(addresses);
    print_start(options.target, sees_only_the_bus);
  };
  if (!command.board.image.empty()) {
    options.catch_up_ticks = options.pace && *options.pace <= 1.0 ? kBoardCatchUp_ticks : options.catch_up_ticks;
    return serve_board(command.board, plant, options, reports);
  }
  warn(margin_warnings(plant, design_controller(plant, controller_spec("pi_vob_ftc"), {})));
  serve(plant, options, reports);
  return 0;
}

// Options of the device.
void add_device(CLI::App& command, OutputFiles& outputs, ServeCommand& serving, bool has_board) {
  CLI::Option *image =
      command
          .add_option(has_board ? "--image,image" : "--image", serving.board.image,
                      "image of the board (trackservo.bin), which the emulated board runs, instead of the firmware of "
                      "this build")
          ->check(CLI::ExistingFile);
  command
      .add_option("--without", serving.board.missing,
                  "sensors that are not connected to the board, e.g. --without pitch-encoder,pitch-gyro")
      ->delimiter(',')
      ->check(CLI::IsMember(std::vector<std::string>(std::begin(kSensors), std::end(kSensors))))
      ->needs(image);
  command
      .add_option("--option-bytes", serving.board.option_bytes,
                  "OPTR and WRP1AR of the board's chip; the default is what tools/image/board sets")
      ->expected(2)
      ->needs(image);
  outputs.input("--plant", serving.plant, "plant file (TOML)");
  command
      .add_option(
          "--node-id,--node", serving.options.node_id,
          "node id, unless LSS has stored another one in the flash file; 255: no node id, the node answers LSS only")
      ->check(CLI::Range(1, 127) | CLI::Range(255, 255))
      ->capture_default_str()
      ->excludes(image);
  command.add_option("--serial", serving.options.serial_number, "serial number (object 1018:4)")
      ->capture_default_str()
      ->excludes(image);
  command
      .add_option("--nodes", serving.options.nodes,
                  "number of nodes; node ids and serial numbers count up, the files of --flash and --truth get the "
                  "endings .2, .3 ...")
      ->check(CLI::Range(1, 16))
      ->capture_default_str()
      ->excludes(image);
  command.add_option("--seed", serving.options.seed, "seed of all noise")->check(seed())->capture_default_str();
  CLI::Option *flash = command.add_option("--flash", serving.options.flash,
                                          "file for the contents of the flash, kept between runs; created if missing");
  outputs.kept(flash)->check(CLI::Validator([](const std::string& file) { return output_file_problem(file); }, "FILE"));
}

}  // namespace

void add_serve(CLI::App& app, int& code, const std::vector<std::string>& arguments, const ServeBoard& serve_board) {
  auto serving = std::make_shared<ServeCommand>();
  CLI::App *command =
      app.add_subcommand("serve", "run the simulated drive as a CANopen node; exits on Ctrl-C or SIGTERM");
  OutputFiles outputs(*command);
  add_device(*command, outputs, *serving, serve_board != nullptr);
  command
      ->add_option("--bus", serving->options.buses,
                   "bus: slcan-tcp:PORT, slcan-pty or socketcan:INTERFACE; may be repeated")
      ->capture_default_str();
  command
      ->add_option("--bit-rate", serving->options.bit_rate,
                   "bit rate of the bus in bit/s, and of the node unless LSS has stored another one in the flash file")
      ->check(CLI::IsMember({125000, 250000, 500000, 1000000}))
      ->capture_default_str();
  command->add_option("--speed", serving->speed, "speed of simulated time: realtime, max, or a multiple of real time")
      ->check(speed(serve_board != nullptr))
      ->capture_default_str();
  add_target(*command, outputs, serving->target);
  command
      ->add_option(
          "--base-sensor", serving->options.base_sensor_cob_id,
          "identifier of the messages of an inertial sensor on the plant's base (3076), 100 a second; counts up "
          "from node to node")
      ->check(CLI::Range(0x181, 0x57F));
  command->add_flag("--until-stdin-ends", serving->options.until_stdin_ends, kUntilStdinEndsHelp);
  command->callback([serving, outputs, &code, &arguments, &serve_board] {
    for (int i = 1; i < serving->options.nodes; ++i) {
      const std::filesystem::path truth = file_of_device(serving->target.options.truth_csv, i);
      outputs.check("--truth", truth);
      outputs.apart("--truth", truth);
      outputs.apart("--flash", file_of_device(serving->options.flash, i));
    }
    if (!serving->board.image.empty() && !serve_board) {
      hand_over_to_board(arguments);
    }
    code = serve_device(*serving, serve_board);
  });
}

}  // namespace trackservo::sim
