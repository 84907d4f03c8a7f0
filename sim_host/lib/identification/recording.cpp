// SPDX-License-Identifier: Apache-2.0
#include "identification/recording.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <fstream>
#include <limits>
#include <sstream>
#include <string_view>

#include "text_file.hpp"

namespace trackservo::identification {

const char *const kRecordingHeader =
    "time_s,run,kind,joint_angle_rad,joint_rate_rad_s,inertial_rate_rad_s,torque_nm,reference";

namespace {

constexpr std::size_t kFileColumns = 8;
constexpr std::size_t kInertialRate = 5;
constexpr std::array<const char *, kFileColumns> kNames{
    "time_s", "run", "kind", "joint_angle_rad", "joint_rate_rad_s", "inertial_rate_rad_s", "torque_nm", "reference"};

constexpr double kTickTolerance_s = 0.1 * kTick_s;

// Reads one file and keeps the position, for the messages.
class Reader {
 public:
  Reader(std::istream& input, const std::string& name) : input_(input), name_(name) {}

  Recording read() {
    std::string line;
    if (!next(line) || line != kRecordingHeader) {
      line_ = std::max(line_, std::size_t{1});
      fail(fmt::format("the first line is '{}'", line.substr(0, 120)),
           fmt::format("it must be '{}'", kRecordingHeader));
    }
    while (next(line)) {
      add(values_of(line));
    }
    if (recording_.ticks() == 0) {
      fail("there is no row below the header", "it needs one row per tick of 1 ms");
    }
    check_rate_unit();
    return std::move(recording_);
  }

 private:
  using Values = std::array<double, kFileColumns>;

  [[noreturn]] void fail(const std::string& what, const std::string& right) const {
    throw RecordingError(fmt::format("{}:{}: {}; {}.", name_, line_, what, right));
  }

  // Empty lines are skipped, as spreadsheets and editors leave them at the end.
  bool next(std::string& line) {
    do {
      if (!std::getline(input_, line)) {
        return false;
      }
      ++line_;
    } while (line.empty());
    return true;
  }

  Values values_of(std::string_view line) const {
    Values values{};
    std::size_t column = 0;
    for (;; ++column) {
      const std::size_t comma = line.find(',');
      if (column < kFileColumns) {
        values[column] = number(line.substr(0, comma), column);
      }
      if (comma == std::string_view::npos) {
        break;
      }
      line.remove_prefix(comma + 1);
    }
    if (column + 1 != kFileColumns) {
      fail(fmt::format("this row has {} values", column + 1), fmt::format("it must have {}", kFileColumns));
    }
    return values;
  }

  double number(std::string_view text, std::size_t column) const {
    if (column == kInertialRate && (text.empty() || text == "nan" || text == "NaN")) {
      return std::numeric_limits<double>::quiet_NaN();
    }
    double value = 0;
    const char *end = text.data() + text.size();
    const std::from_chars_result result = std::from_chars(text.data(), end, value);
    if (result.ec != std::errc() || result.ptr != end || !std::isfinite(value)) {
      fail(fmt::format("{} is '{}'", kNames[column], text.substr(0, 40)),
           "it must be a finite decimal number like -1.5e-3");
    }
    return value;
  }

  int whole(double value, std::size_t column, double low, double high) const {
    if (!(value >= low && value <= high) || value != std::floor(value)) {
      fail(fmt::format("{} is {}", kNames[column], value), fmt::format("it must be a whole number {}..{}", low, high));
    }
    return static_cast<int>(value);
  }

  void add(const Values& values) {
    const int run = whole(values[1], 1, 0, 1e9);
    const int kind = whole(values[2], 2, 1, 5);
    if (recording_.ticks() > 0) {
      const double step_s = values[0] - recording_.time_s.back();
      if (!(step_s > kTick_s - kTickTolerance_s)) {
        fail(fmt::format("time_s advances by {:.6g} s", step_s), "rows must be 0.001 s apart, or separated by a gap");
      }
      if (run < recording_.run.back()) {
        fail(fmt::format("run decreases from {} to {}", recording_.run.back(), run), "it must increase");
      }
    }
    recording_.time_s.push_back(values[0]);
    recording_.run.push_back(run);
    recording_.kind.push_back(static_cast<RunKind>(kind));
    recording_.joint_angle_rad.push_back(values[3]);
    recording_.joint_rate_rad_s.push_back(values[4]);
    recording_.inertial_rate_rad_s.push_back(values[kInertialRate]);
    recording_.torque_nm.push_back(values[6]);
    recording_.reference.push_back(values[7]);
  }

  // Angle and rate must be in the same unit: the angle increased while the integral of the rate is this many rad.
  void check_rate_unit() const {
    double product = 0;
    double square = 0;
    for (const Stretch& stretch : stretches(recording_)) {
      for (std::size_t i = stretch.first + 1; i < stretch.last; ++i) {
        const double gained_rad = recording_.joint_angle_rad[i] - recording_.joint_angle_rad[i - 1];
        const double said_rad = 0.5 * kTick_s * (recording_.joint_rate_rad_s[i] + recording_.joint_rate_rad_s[i - 1]);
        product += gained_rad * said_rad;
        square += gained_rad * gained_rad;
      }
    }
    const double ratio = square > 0 ? product / square : 0;
    if (!(ratio > 0.5 && ratio < 2.0)) {
      throw RecordingError(
          fmt::format("{}: joint_rate_rad_s is {:.3g} times the change of joint_angle_rad per second; "
                      "the angle must be unwrapped, and both must be in rad.",
                      name_, ratio));
    }
  }

  std::istream& input_;
  const std::string& name_;
  std::size_t line_ = 0;
  Recording recording_;
};

}  // namespace

const char *run_kind_name(RunKind kind) {
  switch (kind) {
    case RunKind::kSpeedSweep:
      return "speed sweep (kind 1)";
    case RunKind::kTorqueRamps:
      return "torque ramps (kind 2)";
    case RunKind::kHysteresis:
      return "hysteresis loops (kind 3)";
    case RunKind::kTorqueExcitation:
      return "torque multisine or chirp (kind 4)";
    case RunKind::kBreakaway:
      return "break-away (kind 5)";
  }
  return "?";
}

bool Recording::has_gyro() const {
  return !inertial_rate_rad_s.empty() && std::none_of(inertial_rate_rad_s.begin(), inertial_rate_rad_s.end(),
                                                      [](double rate) { return std::isnan(rate); });
}

bool Recording::has(RunKind wanted) const { return std::find(kind.begin(), kind.end(), wanted) != kind.end(); }

std::vector<Stretch> stretches(const Recording& recording) {
  std::vector<Stretch> found;
  for (std::size_t i = 0; i < recording.ticks(); ++i) {
    const bool follows = i > 0 && recording.time_s[i] - recording.time_s[i - 1] < kTick_s + kTickTolerance_s;
    if (!follows) {
      found.push_back({i, i});
    }
    found.back().last = i + 1;
  }
  return found;
}

std::vector<Stretch> excerpt(const std::vector<Stretch>& stretches, double max_s) {
  constexpr std::size_t kPart_ticks = 20000;  // long enough that the unknown start of the bristles does not matter
  std::size_t ticks = 0;
  for (const Stretch& stretch : stretches) {
    ticks += stretch.ticks();
  }
  const double share = max_s / (static_cast<double>(ticks) * kTick_s);
  if (share >= 1.0) {
    return stretches;
  }
  const auto period = static_cast<std::size_t>(static_cast<double>(kPart_ticks) / share);
  std::vector<Stretch> parts;
  for (const Stretch& stretch : stretches) {
    for (std::size_t first = stretch.first; first < stretch.last; first += period) {
      parts.push_back({first, std::min(first + kPart_ticks, stretch.last)});
    }
  }
  return parts;
}

Recording read_recording(std::istream& input, const std::string& name) { return Reader(input, name).read(); }

Recording load_recording(const std::string& path) {
  try {
    std::istringstream text(read_text(path));
    return read_recording(text, path);
  } catch (const TextFileError& error) {
    throw RecordingError(fmt::format("{}:{}: {}.", path, error.line(), error.what()));
  }
}

void write_recording(const Recording& recording, const std::string& path) {
  std::ofstream file(path);
  file << kRecordingHeader << '\n';
  for (std::size_t i = 0; i < recording.ticks(); ++i) {
    const double inertial_rad_s = recording.inertial_rate_rad_s[i];
    file << fmt::format("{:.3f},{},{},{:.10g},{:.7g},{},{:.7g},{:.8g}\n", recording.time_s[i], recording.run[i],
                        static_cast<int>(recording.kind[i]), recording.joint_angle_rad[i],
                        recording.joint_rate_rad_s[i],
                        std::isnan(inertial_rad_s) ? std::string() : fmt::format("{:.7g}", inertial_rad_s),
                        recording.torque_nm[i], recording.reference[i]);
  }
  if (!file.flush()) {
    throw RecordingError(fmt::format("{}: cannot be written; give a path in a folder that exists.", path));
  }
}

}  // namespace trackservo::identification
