// SPDX-License-Identifier: Apache-2.0
#include "checked_board.hpp"

#include <fmt/format.h>

#include <cmath>
#include <limits>
#include <memory>

#include "board/board_device.hpp"
#include "device/can_client.hpp"

namespace trackservo::target {
namespace {

constexpr int kCyclicVelocity = 9;
constexpr int kBoot_ms = 320;
constexpr double kCountsPerRad_s = 1e6;
// From the node's tick to the set-points: they need 0.13 ms, and have arrived before the tick that takes them.
constexpr double kSetPointPhase_s = 0.8e-3;

class CheckedBoard : public sim::CheckedDevice {
 public:
  CheckedBoard(const Image& image, const sim::PlantConfig& plant, std::uint64_t seed,
               const std::array<double, sim::kAxes>& joint_angle_rad)
      : device_(image, plant, bus_, {seed, joint_angle_rad}), client_(bus_, [this] { device_.pass_ms(); }) {
    client_.pass(kBoot_ms);
    // A set-point that comes 0.9 ms later costs 1 mdeg/s of a sine's rms error.
    ticks_ = device_.machine().run_after_tick(kSetPointPhase_s);
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
  sim::TruthState truth() const override { return device_.truth(); }
  // The tick that takes the frame, and one of interpolation.
  int set_point_delay_ms() const override { return 2; }
  double torque_command_nm(int /*axis*/) const override { return std::numeric_limits<double>::quiet_NaN(); }

  std::optional<std::string> failure() override {
    for (const sim::CanClient::Emergency& emergency : client_.emergencies()) {
      if (emergency.code != 0) {
        return fmt::format("EMCY {:04X}h", emergency.code);
      }
    }
    if (!ticks_) {
      return "the image does not run its control task";
    }
    if (device_.machine().chip().resets() > 0) {
      return "the board has reset";
    }
    const std::vector<std::string>& violations = device_.machine().chip().violations.list();
    return violations.empty() ? std::nullopt
                              : std::optional<std::string>("violation of the chip's rules: " + violations.front());
  }

 private:
  sim::VirtualBus bus_{1e6, sim::kPwmPeriod_s};
  BoardDevice device_;
  sim::CanClient client_;
  bool ticks_ = false;
};

}  // namespace

sim::DeviceMaker checked_boards(const std::filesystem::path& file) {
  return [image = read_image(file)](const sim::PlantConfig& plant, std::uint64_t seed,
                                    const std::array<double, sim::kAxes>& joint_angle_rad) {
    return std::make_unique<CheckedBoard>(image, plant, seed, joint_angle_rad);
  };
}

}  // namespace trackservo::target
