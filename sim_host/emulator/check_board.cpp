// sim_host check with the image of the board: the same command, on the board emulated register by register.
//
//   check_board check --image build/stm32g474/bin/trackservo.bin
//
// `sim_host check --image` starts it. The device is driven only over CAN, as a master would.
#include <fmt/format.h>

#include <cmath>
#include <fstream>
#include <iterator>
#include <limits>
#include <stdexcept>

#include "board/board_machine.hpp"
#include "can_client.hpp"
#include "commands/check_command.hpp"
#include "commands/command_line.hpp"

namespace {

namespace sim = trackservo::sim;
namespace target = trackservo::target;

constexpr int kCyclicVelocity = 9;
constexpr int kBoot_ms = 320;
constexpr double kCountsPerRad_s = 1e6;
// From the node's tick to the set-points: they need 0.13 ms, and have arrived before the tick that takes them.
constexpr double kSetPointPhase_s = 0.8e-3;

using Image = std::vector<std::uint8_t>;

class BoardDevice : public sim::CheckedDevice {
 public:
  BoardDevice(const Image& image, const sim::PlantConfig& plant, std::uint64_t seed,
              const std::array<double, sim::kAxes>& joint_angle_rad)
      : machine_(image, plant, bus_, {seed, joint_angle_rad}), client_(bus_, [this] { machine_.run(sim::kTick_s); }) {
    client_.pass(kBoot_ms);
    // A set-point that comes 0.9 ms later costs 1 mdeg/s of a sine's rms error.
    ticks_ = machine_.run_after_tick(kSetPointPhase_s);
    client_.start_node();
  }

  std::uint32_t write(std::uint16_t index, std::uint8_t sub, std::uint32_t bits, int bytes) override {
    constexpr std::uint32_t kGeneralError = 0x08000000;
    return client_.write(index, sub, bits, bytes) ? 0 : client_.abort_code().value_or(kGeneralError);
  }

  std::optional<std::uint32_t> read(std::uint16_t index, std::uint8_t sub) override { return client_.read(index, sub); }

  bool enable() override { return client_.enable(kCyclicVelocity); }

  void command(const std::array<double, sim::kAxes>& rate_rad_s) override {
    const auto counts = [](double rate) { return static_cast<std::int32_t>(std::lround(kCountsPerRad_s * rate)); };
    client_.set_speeds(counts(rate_rad_s[0]), counts(rate_rad_s[1]));
  }

  void disturb(int /*axis*/, double /*torque_nm*/) override {}
  bool can_disturb() const override { return false; }
  void pass_ms() override { client_.pass(1); }
  sim::TruthState truth() const override { return machine_.truth(); }
  // The tick that takes the frame, and one of interpolation.
  int set_point_delay_ms() const override { return 2; }
  double torque_command_nm(int /*axis*/) const override { return std::numeric_limits<double>::quiet_NaN(); }

  std::optional<std::string> failure() override {
    for (const bench::CanClient::Emergency& emergency : client_.emergencies()) {
      if (emergency.code != 0) {
        return fmt::format("EMCY {:04X}h", emergency.code);
      }
    }
    if (!ticks_) {
      return "the image does not run its control task";
    }
    if (machine_.chip().resets() > 0) {
      return "the board has reset";
    }
    const std::vector<std::string>& violations = machine_.chip().violations.list();
    return violations.empty() ? std::nullopt
                              : std::optional<std::string>("violation of the chip's rules: " + violations.front());
  }

 private:
  sim::VirtualBus bus_{1e6, sim::kPwmPeriod_s};
  target::BoardMachine machine_;
  bench::CanClient client_;
  bool ticks_ = false;
};

sim::DeviceMaker image_devices(const std::filesystem::path& file) {
  std::ifstream stream(file, std::ios::binary);
  const Image image((std::istreambuf_iterator<char>(stream)), std::istreambuf_iterator<char>());
  if (image.empty()) {
    throw std::runtime_error(
        fmt::format("{}: is empty or cannot be read; give the image trackservo.bin", file.string()));
  }
  return [image](const sim::PlantConfig& plant, std::uint64_t seed,
                 const std::array<double, sim::kAxes>& joint_angle_rad) {
    return std::make_unique<BoardDevice>(image, plant, seed, joint_angle_rad);
  };
}

}  // namespace

// Options that contradict each other throw here: an error of the program, which may end it.
// NOLINTNEXTLINE(bugprone-exception-escape)
int main(int argc, char **argv) {
  const std::vector<std::string> arguments(argv, argv + argc);
  const sim::ImageDevices devices = image_devices;
  int code = 0;
  CLI::App app{"Runs 'sim_host check' for images of the board."};
  app.require_subcommand(1);
  sim::add_check(app, code, arguments, devices);
  return sim::run_program("sim_host", app, argc, argv, code);  // which starts this program for its user
}
