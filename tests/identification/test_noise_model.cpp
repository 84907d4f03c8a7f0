// SPDX-License-Identifier: Apache-2.0
// The noise model and the comparison windows of torque and motion, on known signals.
#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <vector>

#include "identification/low_pass.hpp"
#include "identification/noise_model.hpp"
#include "identification/window.hpp"
#include "machine/base/random.hpp"
#include "support/check.h"

namespace identification = trackservo::identification;
using identification::NoiseModel;
using identification::Span;

extern "C" void setUp() {}
extern "C" void tearDown() {}

namespace {

// Two slow poles and an innovation of 0.1 Nm.
Eigen::VectorXd slow_noise(Eigen::Index count, double pole) {
  trackservo::sim::RandomStream random(3, "test.noise");
  Eigen::VectorXd noise = Eigen::VectorXd::Zero(count);
  for (Eigen::Index k = 2; k < count; ++k) {
    noise[k] = 2 * pole * noise[k - 1] - pole * pole * noise[k - 2] + 0.1 * random.normal();
  }
  return noise;
}

void test_an_autoregression_is_found_and_whitened() {
  const Eigen::VectorXd noise = slow_noise(20000, 0.95);
  const std::vector<Span> spans{{0, 9000}, {9500, 20000}};
  const NoiseModel model = NoiseModel::fit(noise, Eigen::VectorXd::Ones(noise.size()), spans, 12);
  CHECK_NEAR("order", 2, model.order(), 1);
  CHECK_RELATIVE("innovation", 0.1, model.innovation_nm(), 0.02);
  CHECK_NEAR("first coefficient", -1.9, model.coefficients()[0], 0.03);
  Eigen::VectorXd white = noise;
  model.whiten(spans, white);
  CHECK_RELATIVE("variance", 1.0, white.segment(100, 8000).squaredNorm() / 8000, 0.05);
  CHECK_AT_MOST("correlation", 0.03, identification::autocorrelation(white, spans, 20).cwiseAbs().maxCoeff());
  TEST_ASSERT_EQUAL_DOUBLE(0.0, white.segment(9000, 500).cwiseAbs().maxCoeff());
}

// J theta'' = u under the window, with a torque that changes within the ticks: only means since the previous tick are
// recorded of it. Taken as held over each tick, 40 Hz would be wrong by 5e-3.
void test_the_window_balances_torque_and_motion_of_quick_turns() {
  const double inertia = 3.0;
  for (const double frequency_hz : {2.0, 10.0, 40.0}) {
    const double pulse_rad_s = 2 * 3.14159265358979 * frequency_hz;
    const auto integral = [pulse_rad_s](double tick) { return std::sin(pulse_rad_s * 1e-3 * tick) / pulse_rad_s; };
    std::vector<double> torque;
    std::vector<double> angle;
    for (int tick = 0; tick < 600; ++tick) {
      torque.push_back((integral(tick) - integral(tick - 1)) / trackservo::kTick_s);
      angle.push_back(-std::cos(pulse_rad_s * 1e-3 * tick) / (inertia * pulse_rad_s * pulse_rad_s));
    }
    double worst = 0;
    for (std::size_t i = 10; i < 590; ++i) {
      worst = std::max(worst, std::abs(inertia * identification::triangle_second_derivative(angle, i) -
                                       identification::triangle_mean(torque, i)));
    }
    CHECK_AT_MOST("unbalanced share of the torque", 1e-4, worst);
  }
}

// The window's weights are a mean: a constant stays constant.
void test_the_window_is_a_mean() {
  const std::vector<double> constant(40, 2.5);
  CHECK_NEAR("mean", 2.5, identification::triangle_mean(constant, 20), 1e-12);
}

double gain_at(const identification::LowPass& filter, double frequency_hz) {
  std::vector<double> wave(4000);
  for (std::size_t i = 0; i < wave.size(); ++i) {
    wave[i] = std::cos(2 * 3.14159265358979 * frequency_hz * static_cast<double>(i) * 1e-3);
  }
  std::vector<double> smooth(wave.size());
  filter.smooth(wave, 0, wave.size(), smooth);
  double product = 0;
  double square = 0;
  for (std::size_t i = 1000; i < 3000; ++i) {
    product += smooth[i] * wave[i];
    square += wave[i] * wave[i];
  }
  return product / square;
}

void test_the_low_pass_leaves_slow_motion_and_straight_lines_alone() {
  const identification::LowPass filter(80.0);
  CHECK_NEAR("10 Hz", 1.0, gain_at(filter, 10.0), 2e-3);
  CHECK_NEAR("the cutoff", 0.5, gain_at(filter, 80.0), 0.02);
  CHECK_NEAR("200 Hz", 0.0, gain_at(filter, 200.0), 5e-3);
  std::vector<double> line;
  for (int i = 0; i < 200; ++i) {
    line.push_back(0.3 + 0.01 * i);
  }
  std::vector<double> smooth(line.size());
  filter.smooth(line, 0, line.size(), smooth);
  for (std::size_t i = 0; i < line.size(); ++i) {
    CHECK_NEAR("line", line[i], smooth[i], 1e-12);
  }
}

}  // namespace

int main() {
  UNITY_BEGIN();
  RUN_TEST(test_an_autoregression_is_found_and_whitened);
  RUN_TEST(test_the_window_balances_torque_and_motion_of_quick_turns);
  RUN_TEST(test_the_window_is_a_mean);
  RUN_TEST(test_the_low_pass_leaves_slow_motion_and_straight_lines_alone);
  return UNITY_END();
}
