// The board on a CAN bus for clients, emulated register by register: it runs the image to be flashed, before there is a
// board.
//
//   emulate_board IMAGE.bin --plant sim_host/plants/tracker.toml --bus slcan-tcp:29536
//
// Prints the bus' addresses, then "ready" when the image has booted. Ends with Ctrl-C or SIGTERM. Violations of the
// chip's rules by the image are printed at the end, and make the exit code 1.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <fstream>
#include <iterator>
#include <optional>
#include <string>
#include <vector>

#include "board/board_machine.hpp"
#include "board/flash_file.hpp"
#include "commands/target_arguments.hpp"
#include "config/arguments.hpp"
#include "serve/flash_memory.hpp"
#include "serve/server.hpp"
#include "serve/tracking_on_bus.hpp"

namespace {

namespace sim = trackservo::sim;
namespace target = trackservo::target;

// Few: set-points of a client come between them, which the drive misses after 20 ticks. A computer that is too busy
// makes the board slower than real time instead of irregular.
constexpr int kCatchUp_ticks = 4;

class EmulatedBoard : public sim::ServedDevice {
 public:
  EmulatedBoard(target::BoardMachine& board, const sim::ServeOptions& options, sim::VirtualBus& bus)
      : board_(board), tracking_(bus) {
    if (options.target.scenario) {
      target_.emplace(options.target, options.seed, bus, [&board] { board.strobe(); });
    }
  }

  void tick() override {
    board_.run(sim::kTick_s);
    if (target_) {
      target_->tick(board_.truth(), tracking_.states());
    }
  }

  // Of the pictures; empty without them.
  std::string video_address() const { return target_ ? target_->video_address() : ""; }

  // The board does, every PWM period.
  void pass_bus_time(sim::VirtualBus& /*bus*/, double /*seconds*/) override {}

 private:
  target::BoardMachine& board_;
  sim::TrackingOnBus tracking_;
  std::optional<sim::ServedTarget> target_;
};

sim::ServeReports reports_of(const EmulatedBoard& board, const sim::TargetOptions& target) {
  sim::ServeReports reports = sim::reports_on_stdout();
  reports.open = [open = reports.open, &board, &target](std::vector<std::string> addresses) {
    if (!board.video_address().empty()) {
      addresses.push_back(board.video_address());
    }
    open(addresses);
    sim::print_start(target);
  };
  return reports;
}

std::vector<std::uint8_t> read_image(const std::string& name) {
  std::ifstream file(name, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

// Sensors that may be missing on a test board, by name.
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

struct Arguments {
  std::string image;
  std::string plant = TRACKSERVO_DATA_DIR "/plants/tracker.toml";
  std::vector<std::string> missing;
  std::vector<std::uint32_t> option_bytes;  // OPTR and WRP1AR, or none
  sim::TargetArguments target;
  sim::ServeOptions options;
  double speed = 1.0;
};

sim::ServeOptions options_of(const Arguments& given, const sim::PlantConfig& plant) {
  sim::ServeOptions options = given.options;
  options.target = sim::load_target(given.target, plant);
  options.pace = given.speed > 0.0 ? std::optional<double>(given.speed) : std::nullopt;
  if (given.speed <= 1.0) {
    options.catch_up_ticks = kCatchUp_ticks;
  }
  return options;
}

int report_violations(const target::Violations& violations) {
  for (const std::string& violation : violations.list()) {
    fmt::print(stderr, "violation of the chip's rules: {}\n", violation);
  }
  return violations.list().empty() ? 0 : 1;
}

int run(const Arguments& given) {
  const sim::PlantConfig plant = sim::load_plant(given.plant);
  const sim::ServeOptions options = options_of(given, plant);
  sim::VirtualBus bus{static_cast<double>(options.bit_rate), sim::kPwmPeriod_s};
  target::BoardMachine::Options fitted;
  fitted.seed = options.seed;
  fitted.joint_angle_rad = sim::kServedStart_rad;
  fitted.holding_brakes = true;
  target::BoardMachine machine(read_image(given.image), plant, bus, fitted);
  std::optional<sim::FlashMemory> flash;
  if (!options.flash.empty()) {
    flash.emplace(options.flash);
    target::load_parameter_pages(machine.chip(), *flash);
  }
  if (!given.option_bytes.empty()) {
    machine.chip().flash.set_options(given.option_bytes[0], given.option_bytes[1]);
  }
  unplug(machine, given.missing);
  EmulatedBoard board(machine, options, bus);
  sim::serve(board, bus, options, reports_of(board, options.target));
  if (flash) {
    target::keep_parameter_pages(machine.chip(), *flash);
  }
  return report_violations(machine.chip().violations);
}

void add_options(CLI::App& app, Arguments& given) {
  app.add_option("image", given.image, "image to flash (trackservo.bin)")->required()->check(CLI::ExistingFile);
  app.add_option("--plant", given.plant, "plant file (TOML)")->check(CLI::ExistingFile);
  app.add_option("--without", given.missing, "sensors that are not connected, e.g. --without pitch-encoder,pitch-gyro")
      ->delimiter(',')
      ->check(CLI::IsMember({"azimuth-encoder", "azimuth-gyro", "pitch-encoder", "pitch-gyro"}));
  app.add_option("--option-bytes", given.option_bytes,
                 "OPTR and WRP1AR of the chip; the default is what tools/image/board sets")
      ->expected(2);
  app.add_option("--flash", given.options.flash,
                 "file for the parameter pages, as of `sim_host serve`; created if missing, written at the end")
      ->check(CLI::Validator([](const std::string& file) { return sim::output_file_problem(file); }, "FILE"));
  app.add_option("--bus", given.options.buses, "bus: slcan-tcp:PORT, slcan-pty or socketcan:INTERFACE");
  app.add_option("--bit-rate", given.options.bit_rate,
                 "bit rate of the bus in bit/s; the board uses its own, 1000000 as delivered")
      ->check(CLI::IsMember({125000, 250000, 500000, 1000000}));
  app.add_option("--seed", given.options.seed, "seed of all noise");
  app.add_option("--speed", given.speed, "simulated time per real time; 0: as fast as possible");
  sim::add_target(app, given.target);
  app.add_flag("--until-stdin-ends", given.options.until_stdin_ends, sim::kUntilStdinEndsHelp);
}

}  // namespace

// Options that contradict each other throw here: an error of the program, which may end it.
// NOLINTNEXTLINE(bugprone-exception-escape)
int main(int argc, char **argv) {
  CLI::App app("Runs the image of the servo board on an emulated board with the simulated machine.");
  Arguments given;
  add_options(app, given);
  try {
    app.parse(argc, argv);
    return run(given);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 2;
  } catch (const std::exception& error) {
    fmt::print(stderr, "emulate_board: {}\n", error.what());
    return 2;
  }
}
