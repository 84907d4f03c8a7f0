// SPDX-License-Identifier: Apache-2.0
// Progress of a long job, and an estimate of the time left.
//
// On a terminal one line is rewritten. Elsewhere (a file, a log of CI) each report is a new line: one when a part is
// finished, and at least one every ten seconds. The time left is the time of the completed work, scaled.
#ifndef TRACKSERVO_SIM_BASE_PROGRESS_HPP
#define TRACKSERVO_SIM_BASE_PROGRESS_HPP

#include <cstdio>
#include <functional>
#include <set>
#include <string>

namespace trackservo::sim {

// Returns "45 s", "3 min 20 s", "2 h 05 min"; rounded to the precision of an estimate.
std::string duration_words(double seconds);

class ProgressPrinter {
 public:
  // Takes the time from `now_s`: a clock in seconds, from any origin.
  ProgressPrinter(std::FILE *stream, bool is_terminal, std::function<double()> now_s);

  // Call after each finished job: `done` of `total` in units of cost, `what` names the part that the job belongs to. A
  // `done` that is not larger than the last one starts a new piece of work.
  void show(int done, int total, const std::string& what);

 private:
  void rewrite(int done, int total, const std::string& what, const std::string& left);
  void add_lines(int done, int total, const std::string& what, const std::string& left);
  void line(int percent, const std::string& text);

  std::FILE *stream_;
  bool is_terminal_;
  std::function<double()> now_s_;
  double started_s_;
  int last_done_ = 0;
  std::string part_;             // in progress
  std::set<std::string> begun_;  // parts: at a boundary two threads may finish jobs of both
  double last_line_s_;
};

}  // namespace trackservo::sim

#endif
