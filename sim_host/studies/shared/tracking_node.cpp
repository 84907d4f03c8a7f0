#include "studies/shared/tracking_node.hpp"

#include <cmath>
#include <optional>

#include "design/control_design.hpp"

namespace trackservo::sim {
namespace {

constexpr std::int8_t kTracking = -1;
constexpr int kCameraRpdo = 4;
constexpr int kTicksToApply = 8;

void write_loop(DrivenNode& node, const target_tracker_params& loop) {
  for (int axis = 0; axis < kAxes; ++axis) {
    node.write(axis, 0x2011, 1, loop.kind);
    node.write_real(axis, 0x2011, 2, static_cast<double>(loop.proportional_per_s));
    node.write_real(axis, 0x2011, 3, static_cast<double>(loop.integral_per_s2));
    node.write_real(axis, 0x2011, 4, static_cast<double>(loop.estimator_rad_s));
    node.write_real(axis, 0x2011, 5, static_cast<double>(loop.coast_s));
    node.write(axis, 0x2070, 1, 1);
  }
}

}  // namespace

void ErrorSpread::add(const std::array<double, kAxes>& error_rad) {
  ++count_;
  for (std::size_t i = 0; i < kAxes; ++i) {
    const double change = error_rad[i] - mean_rad_[i];
    mean_rad_[i] += change / count_;
    squares_rad2_[i] += change * (error_rad[i] - mean_rad_[i]);
  }
}

std::array<double, kAxes> ErrorSpread::sigma_rad() const {
  std::array<double, kAxes> sigma{};
  for (std::size_t i = 0; i < kAxes && count_ > 0; ++i) {
    sigma[i] = std::sqrt(squares_rad2_[i] / count_);
  }
  return sigma;
}

target_tracker_params designed_tracking_loop(const PlantConfig& plant, tracker_kind kind) {
  DesignOptions design;
  design.tracker = kind;
  return design_controller(plant, controller_spec("pi_vob_ftc"), design).axis[0].tracker;
}

TrackingNode::TrackingNode(const NodeSetup& setup, const ScenarioConfig& scenario, std::uint64_t seed,
                           const target_tracker_params& loop)
    : camera_(scenario, seed), node_(setup, seed, camera_.first_angle_rad()) {
  for (const ObjectWrite& write : camera_mapping(kCameraRpdo, TargetCamera::kCobId)) {
    node_.write(kAzimuth, write.index, write.sub, write.value);
  }
  write_loop(node_, loop);
  node_.unlock();
  node_.write(kAzimuth, 0x2061, 5, 0);  // it stands in this turn: a start beyond 75 deg may be in two
  for (int i = 0; i < kTicksToApply; ++i) {
    node_.tick();
  }
  node_.receive(can_frame{0x000, 0, 2, {0x01, 0x00}});  // NMT start
  node_.enable(kTracking);
}

void TrackingNode::tick() {
  if (const std::optional<can_frame> frame = camera_.look(node_.machine().truth(), misstated_s_)) {
    node_.receive(*frame);
  }
  node_.tick();
}

}  // namespace trackservo::sim
