// SPDX-License-Identifier: Apache-2.0
#include "identification/resonances.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <optional>

#include "identification/least_squares.hpp"

namespace trackservo::identification {

namespace {

using Complex = std::complex<double>;
using gain_design::relative_height;
using gain_design::structural_factor;
using gain_design::StructuralMode;

constexpr int kMaxResonances = 3;
constexpr double kReach = 1.6;         // a mode is fitted from 1/kReach to kReach of its frequency
constexpr std::size_t kMinLines = 20;  // with good coherence in that band

// The response beyond the rigid body, where it is known.
struct Excess {
  std::vector<double> frequency_hz;
  std::vector<Complex> factor;  // R
  std::vector<double> weight;   // one over the relative deviation, up to a common factor
};

Excess excess_of(const AxisResponse& response, const RigidAxis& rigid) {
  constexpr double kMaxCoherence = 0.9999;  // higher values are limited by the model, not by noise
  Excess excess;
  for (std::size_t i = 0; i < response.frequency_hz.size(); ++i) {
    if (response.coherence[i] < kGoodCoherence) {
      continue;
    }
    const Complex s(0.0, 2.0 * M_PI * response.frequency_hz[i]);
    const Complex mobility = response.gain[i] * std::exp(s * rigid.delay_s);
    excess.frequency_hz.push_back(response.frequency_hz[i]);
    excess.factor.push_back(rigid.inertia_kg_m2 * s * mobility / (1.0 - rigid.viscous_nm_s_rad * mobility));
    const double coherence = std::min(response.coherence[i], kMaxCoherence);
    excess.weight.push_back(std::sqrt(coherence / (1.0 - coherence)));
  }
  return excess;
}

// Lines between two frequencies.
Excess cut(const Excess& excess, double from_hz, double to_hz) {
  Excess part;
  for (std::size_t i = 0; i < excess.frequency_hz.size(); ++i) {
    if (from_hz <= excess.frequency_hz[i] && excess.frequency_hz[i] <= to_hz) {
      part.frequency_hz.push_back(excess.frequency_hz[i]);
      part.factor.push_back(excess.factor[i]);
      part.weight.push_back(excess.weight[i]);
    }
  }
  return part;
}

double median_height(const Excess& excess) {
  std::vector<double> heights;
  for (const Complex& factor : excess.factor) {
    heights.push_back(std::abs(factor));
  }
  const auto middle = heights.begin() + static_cast<std::ptrdiff_t>(heights.size() / 2);
  std::nth_element(heights.begin(), middle, heights.end());
  return *middle;
}

// The line that exceeds its neighbourhood the most; nothing when none does by kMinHeight.
std::optional<double> highest_peak_hz(const Excess& excess) {
  std::optional<double> peak_hz;
  double most = kMinHeight;
  for (std::size_t i = 1; i + 1 < excess.frequency_hz.size(); ++i) {
    const double height = std::abs(excess.factor[i]);
    if (height < most || height < std::abs(excess.factor[i - 1]) || height < std::abs(excess.factor[i + 1])) {
      continue;
    }
    const double f_hz = excess.frequency_hz[i];
    const Excess around = cut(excess, f_hz / kReach, f_hz * kReach);
    // At the lower end of the excitation friction bends the response, so a peak must be well within.
    const bool within = around.frequency_hz.front() * 1.3 < f_hz && 1.05 * f_hz < around.frequency_hz.back();
    if (around.factor.size() < kMinLines || !within) {
      continue;
    }
    const double prominence = height / std::max(1.0, median_height(around));
    if (prominence > most) {
      most = prominence;
      peak_hz = f_hz;
    }
  }
  return peak_hz;
}

// Logarithm of gain, delay [ms], share, and logarithms of frequency and damping.
enum ModeParameter { kGain, kDelay_ms, kShare, kFrequency, kModeDamping, kModeParameters };

StructuralMode mode_of(const Eigen::VectorXd& x) {
  return {std::exp(x[kFrequency]), std::exp(x[kModeDamping]), x[kShare]};
}

// Differences of logarithms: resonance and antiresonance have equal weight.
void mode_residual(const Excess& excess, const Eigen::VectorXd& x, Eigen::VectorXd& residual) {
  for (std::size_t i = 0; i < excess.factor.size(); ++i) {
    const Complex s(0.0, 2.0 * M_PI * excess.frequency_hz[i]);
    const Complex model = structural_factor({mode_of(x)}, s) * std::exp(x[kGain] - s * 1e-3 * x[kDelay_ms]);
    const Complex difference = excess.weight[i] * std::log(excess.factor[i] / model);
    residual[static_cast<Eigen::Index>(2 * i)] = difference.real();
    residual[static_cast<Eigen::Index>(2 * i + 1)] = difference.imag();
  }
}

// The better of two fits: with the encoder before the spring, and behind it.
StructuralMode fit_mode(const Excess& part, double peak_hz) {
  const double height = std::abs(cut(part, peak_hz, peak_hz).factor.front());
  const auto evaluate = [&part](const Eigen::VectorXd& x, Eigen::VectorXd& residual) {
    mode_residual(part, x, residual);
    return true;
  };
  const LeastSquares problem = {static_cast<Eigen::Index>(2 * part.factor.size()), kModeParameters, evaluate, {}};
  StructuralMode best;
  double least = 0.0;
  for (const double share : {0.3, -1.0}) {
    Eigen::VectorXd x(static_cast<Eigen::Index>(kModeParameters));
    x << 0.0, 0.0, share, std::log(2.0 * M_PI * peak_hz), std::log(std::abs(share) / (2.0 * height));
    const double norm = minimize(problem, {}, x);
    if (share > 0.0 || norm < least) {
      least = norm;
      best = mode_of(x);
      best.share *= std::exp(x[kGain]);  // relative to the rigid body, not to the response with other modes
    }
  }
  return best;
}

bool is_plausible(const StructuralMode& mode, double peak_hz) {
  constexpr double kMinDamping = 1e-3;
  constexpr double kMaxDamping = 0.1;  // a broader peak is no spring of a structure
  const double ratio = mode.frequency_rad_s / (2.0 * M_PI * peak_hz);
  return kMinDamping <= mode.damping && mode.damping <= kMaxDamping && 0.8 < ratio && ratio < 1.25 &&
         relative_height(mode) >= kMinHeight;
}

// The remainder once a mode is known.
void take_out(const StructuralMode& mode, Excess& excess) {
  for (std::size_t i = 0; i < excess.factor.size(); ++i) {
    excess.factor[i] /= structural_factor({mode}, {0.0, 2.0 * M_PI * excess.frequency_hz[i]});
  }
}

}  // namespace

std::vector<StructuralMode> find_resonances(const AxisResponse& response, const RigidAxis& rigid) {
  if (response.windows < kMinWindows) {
    return {};
  }
  Excess excess = excess_of(response, rigid);
  std::vector<StructuralMode> modes;
  for (int i = 0; i < kMaxResonances; ++i) {
    const std::optional<double> peak_hz = highest_peak_hz(excess);
    if (!peak_hz) {
      break;
    }
    const StructuralMode mode = fit_mode(cut(excess, *peak_hz / kReach, *peak_hz * kReach), *peak_hz);
    if (!is_plausible(mode, *peak_hz)) {
      break;
    }
    modes.push_back(mode);
    take_out(mode, excess);
  }
  std::sort(modes.begin(), modes.end(),
            [](const StructuralMode& a, const StructuralMode& b) { return a.frequency_rad_s < b.frequency_rad_s; });
  return modes;
}

}  // namespace trackservo::identification
