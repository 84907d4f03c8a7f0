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
#include "config/arguments.hpp"
#include "serve/flash_memory.hpp"
#include "serve/server.hpp"

namespace {

namespace sim = trackservo::sim;
namespace target = trackservo::target;

// Few: set-points of a client come between them, which the drive misses after 20 ticks. A computer that is too busy
// makes the board slower than real time instead of irregular.
constexpr int kCatchUp_ticks = 4;

class EmulatedBoard : public sim::ServedDevice {
 public:
  explicit EmulatedBoard(target::BoardMachine& board) : board_(board) {}

  void tick() override { board_.run(sim::kTick_s); }

  // The board does, every PWM period.
  void pass_bus_time(sim::VirtualBus& /*bus*/, double /*seconds*/) override {}

 private:
  target::BoardMachine& board_;
};

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

struct OptionBytes {
  std::uint32_t optr;
  std::uint32_t wrp1ar;
};

int run(const std::string& image, const std::string& plant, const std::vector<std::string>& missing,
        const std::optional<OptionBytes>& bytes, const sim::ServeOptions& options) {
  sim::VirtualBus bus{static_cast<double>(options.bit_rate), sim::kPwmPeriod_s};
  target::BoardMachine::Options fitted;
  fitted.seed = options.seed;
  fitted.joint_angle_rad = sim::kServedStart_rad;
  fitted.holding_brakes = true;
  target::BoardMachine machine(read_image(image), sim::load_plant(plant), bus, fitted);
  std::optional<sim::FlashMemory> flash;
  if (!options.flash.empty()) {
    flash.emplace(options.flash);
    target::load_parameter_pages(machine.chip(), *flash);
  }
  if (bytes) {
    machine.chip().flash.set_options(bytes->optr, bytes->wrp1ar);
  }
  unplug(machine, missing);
  EmulatedBoard board(machine);
  sim::serve(board, bus, options, sim::reports_on_stdout());
  if (flash) {
    target::keep_parameter_pages(machine.chip(), *flash);
  }
  for (const std::string& violation : machine.chip().violations.list()) {
    fmt::print(stderr, "violation of the chip's rules: {}\n", violation);
  }
  return machine.chip().violations.list().empty() ? 0 : 1;
}

}  // namespace

// Options that contradict each other throw here: an error of the program, which may end it.
// NOLINTNEXTLINE(bugprone-exception-escape)
int main(int argc, char **argv) {
  CLI::App app("Runs the image of the servo board on an emulated board with the simulated machine.");
  std::string image;
  std::string plant = TRACKSERVO_DATA_DIR "/plants/tracker.toml";
  std::vector<std::string> missing;
  std::vector<std::uint32_t> bytes;
  sim::ServeOptions options;
  double speed = 1.0;
  app.add_option("image", image, "image to flash (trackservo.bin)")->required()->check(CLI::ExistingFile);
  app.add_option("--plant", plant, "plant file (TOML)")->check(CLI::ExistingFile);
  app.add_option("--without", missing, "sensors that are not connected, e.g. --without pitch-encoder,pitch-gyro")
      ->delimiter(',')
      ->check(CLI::IsMember({"azimuth-encoder", "azimuth-gyro", "pitch-encoder", "pitch-gyro"}));
  app.add_option("--option-bytes", bytes, "OPTR and WRP1AR of the chip; the default is what tools/image/board sets")
      ->expected(2);
  app.add_option("--flash", options.flash,
                 "file for the parameter pages, as of `sim_host serve`; created if missing, written at the end")
      ->check(CLI::Validator([](const std::string& file) { return sim::output_file_problem(file); }, "FILE"));
  app.add_option("--bus", options.buses, "bus: slcan-tcp:PORT, slcan-pty or socketcan:INTERFACE");
  app.add_option("--bit-rate", options.bit_rate,
                 "bit rate of the bus in bit/s; the board uses its own, 1000000 as delivered")
      ->check(CLI::IsMember({125000, 250000, 500000, 1000000}));
  app.add_option("--seed", options.seed, "seed of all noise");
  app.add_option("--speed", speed, "simulated time per real time; 0: as fast as possible");
  app.add_flag("--until-stdin-ends", options.until_stdin_ends, sim::kUntilStdinEndsHelp);
  CLI11_PARSE(app, argc, argv);
  options.pace = speed > 0.0 ? std::optional<double>(speed) : std::nullopt;
  if (speed <= 1.0) {
    options.catch_up_ticks = kCatchUp_ticks;
  }
  try {
    const auto fitted = bytes.empty() ? std::nullopt : std::optional<OptionBytes>({bytes[0], bytes[1]});
    return run(image, plant, missing, fitted, options);
  } catch (const std::exception& error) {
    fmt::print(stderr, "emulate_board: {}\n", error.what());
    return 2;
  }
}
