// SPDX-License-Identifier: Apache-2.0
#include "progress.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace trackservo::sim {
namespace {

constexpr double kLongestSilence_s = 10.0;
constexpr double kMinShare = 0.02;  // of the work, before its pace is meaningful

}  // namespace

std::string duration_words(double seconds) {
  if (seconds < 90.0) {
    const double step = seconds < 10.0 ? 1.0 : 5.0;
    return fmt::format("{:.0f} s", step * std::max(1.0, std::round(seconds / step)));
  }
  const auto tens = static_cast<int>(std::lround(seconds / 10.0));
  if (tens < 60 * 6) {
    return tens % 6 == 0 ? fmt::format("{} min", tens / 6) : fmt::format("{} min {} s", tens / 6, tens % 6 * 10);
  }
  return fmt::format("{} h {:02d} min", tens / 360, tens % 360 / 6);
}

ProgressPrinter::ProgressPrinter(std::FILE *stream, bool is_terminal, std::function<double()> now_s)
    : stream_(stream),
      is_terminal_(is_terminal),
      now_s_(std::move(now_s)),
      started_s_(now_s_()),
      last_line_s_(started_s_) {}

void ProgressPrinter::show(int done, int total, const std::string& what) {
  if (done <= last_done_) {
    started_s_ = last_line_s_ = now_s_();
    part_.clear();
    begun_.clear();
  }
  last_done_ = done;
  const double share = static_cast<double>(done) / total;
  const double spent_s = now_s_() - started_s_;
  std::string left;
  if (done >= total) {
    left = "took " + duration_words(spent_s);
  } else if (share >= kMinShare) {
    left = "about " + duration_words(spent_s * (1.0 - share) / share) + " left";
  }
  if (is_terminal_) {
    rewrite(done, total, what, left);
  } else {
    add_lines(done, total, what, left);
  }
  (void)std::fflush(stream_);
}

void ProgressPrinter::rewrite(int done, int total, const std::string& what, const std::string& left) {
  const std::string text = left.empty() ? what : what + ", " + left;
  fmt::print(stream_, "\r[{:3.0f} %] {:<72.72}{}", 100.0 * done / total, text, done >= total ? "\n" : "");
}

void ProgressPrinter::add_lines(int done, int total, const std::string& what, const std::string& left) {
  const std::string after = left.empty() ? "" : "; " + left;
  const int percent = static_cast<int>(100.0 * done / total);
  const bool begins = begun_.insert(what).second;
  if (done >= total) {
    line(percent, what + ": done" + after);
  } else if (begins && !part_.empty()) {
    line(percent, part_ + ": done" + after);
  } else if (now_s_() - last_line_s_ >= kLongestSilence_s) {
    line(percent, what + after);
  }
  if (begins) {
    part_ = what;
  }
}

void ProgressPrinter::line(int percent, const std::string& text) {
  fmt::print(stream_, "[{:3d} %] {}\n", percent, text);
  last_line_s_ = now_s_();
}

}  // namespace trackservo::sim
