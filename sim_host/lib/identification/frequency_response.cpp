// SPDX-License-Identifier: Apache-2.0
#include "identification/frequency_response.hpp"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <unsupported/Eigen/FFT>

namespace trackservo::identification {

namespace {

constexpr Eigen::Index kWindow = 4096;  // ticks: 0.24 Hz, so that a resonance of 1 % damping at 20 Hz is still visible
constexpr double kHighest_hz = 400.0;

using Spectrum = Eigen::VectorXcd;

Eigen::VectorXd hann() {
  const Eigen::ArrayXd phase = Eigen::ArrayXd::LinSpaced(kWindow, 0.5, static_cast<double>(kWindow) - 0.5);
  return (0.5 - 0.5 * (2.0 * M_PI / static_cast<double>(kWindow) * phase).cos()).matrix();
}

// Sums over all windows.
class CrossSpectra {
 public:
  CrossSpectra()
      : lines_(static_cast<Eigen::Index>(kHighest_hz * kTick_s * static_cast<double>(kWindow))),
        uu_(Eigen::VectorXd::Zero(lines_)),
        rr_(Eigen::VectorXd::Zero(lines_)),
        ur_(Spectrum::Zero(lines_)) {}

  void add(const Eigen::VectorXd& torque_nm, const Eigen::VectorXd& rate_rad_s) {
    const Spectrum u = transformed(torque_nm);
    const Spectrum r = transformed(rate_rad_s);
    uu_ += u.cwiseAbs2();
    rr_ += r.cwiseAbs2();
    ur_ += u.conjugate().cwiseProduct(r);
    ++windows_;
  }

  AxisResponse response() const {
    AxisResponse response;
    response.windows = windows_;
    const double min_uu = windows_ > 0 ? min_excitation() : 0.0;
    for (Eigen::Index line = 1; line < lines_ && windows_ > 0; ++line) {
      response.frequency_hz.push_back(static_cast<double>(line) / (kTick_s * static_cast<double>(kWindow)));
      const double power = uu_[line] * rr_[line];
      response.gain.push_back(uu_[line] > 0.0 ? ur_[line] / uu_[line] : 0.0);
      response.coherence.push_back(power > 0.0 && uu_[line] >= min_uu ? std::norm(ur_[line]) / power : 0.0);
    }
    return response;
  }

 private:
  // A chirp's power, which distinguishes it from noise, is that of most of the strong lines: wind has a few, stronger
  // ones.
  double min_excitation() const {
    constexpr double kStrong = 0.95;  // of all lines, this share is weaker
    constexpr double kMin = 0.02;
    Eigen::VectorXd sorted = uu_.tail(lines_ - 1);
    const Eigen::Index strong = static_cast<Eigen::Index>(kStrong * static_cast<double>(sorted.size()));
    std::nth_element(sorted.begin(), sorted.begin() + strong, sorted.end());
    return kMin * sorted[strong];
  }

  Spectrum transformed(const Eigen::VectorXd& values) {
    const Eigen::VectorXd windowed = window_.cwiseProduct((values.array() - values.mean()).matrix());
    Spectrum spectrum;
    fft_.fwd(spectrum, windowed);
    return spectrum.head(lines_);
  }

  Eigen::Index lines_;
  Eigen::VectorXd window_ = hann();
  Eigen::FFT<double> fft_;
  Eigen::VectorXd uu_;
  Eigen::VectorXd rr_;
  Spectrum ur_;
  int windows_ = 0;
};

// Consecutive ticks of one run.
std::vector<Stretch> excited_stretches(const Recording& recording) {
  std::vector<Stretch> excited;
  for (const Stretch& stretch : stretches(recording)) {
    for (std::size_t i = stretch.first; i < stretch.last; ++i) {
      if (recording.kind[i] != RunKind::kTorqueExcitation) {
        continue;
      }
      const bool goes_on =
          !excited.empty() && excited.back().last == i && i > stretch.first && recording.run[i] == recording.run[i - 1];
      if (!goes_on) {
        excited.push_back({i, i});
      }
      excited.back().last = i + 1;
    }
  }
  return excited;
}

}  // namespace

AxisResponse axis_response(const Recording& recording) {
  CrossSpectra spectra;
  Eigen::VectorXd torque_nm(kWindow);
  Eigen::VectorXd rate_rad_s(kWindow);
  constexpr auto kTicks = static_cast<std::size_t>(kWindow);
  for (const Stretch& stretch : excited_stretches(recording)) {
    // The rate of a tick needs the angle of the previous one.
    for (std::size_t first = stretch.first + 1; first + kTicks <= stretch.last; first += kTicks / 2) {
      for (std::size_t i = 0; i < kTicks; ++i) {
        const auto row = static_cast<Eigen::Index>(i);
        torque_nm[row] = recording.torque_nm[first + i];
        rate_rad_s[row] = (recording.joint_angle_rad[first + i] - recording.joint_angle_rad[first + i - 1]) / kTick_s;
      }
      spectra.add(torque_nm, rate_rad_s);
    }
  }
  return spectra.response();
}

}  // namespace trackservo::identification
