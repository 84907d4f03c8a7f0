// SPDX-License-Identifier: Apache-2.0
// The servo's recording of the commissioning experiments: one row per 1 ms tick.
//
// A recording is columns of equal length. Rows are one tick apart. Where they are not, a new stretch begins, because
// the bristles are unknown after a gap. read_recording() accepts nothing else.
#ifndef TRACKSERVO_IDENTIFICATION_RECORDING_HPP
#define TRACKSERVO_IDENTIFICATION_RECORDING_HPP

#include <cstddef>
#include <istream>
#include <stdexcept>
#include <string>
#include <vector>

#include "units.hpp"

namespace trackservo::identification {

enum class RunKind { kSpeedSweep = 1, kTorqueRamps, kHysteresis, kTorqueExcitation, kBreakaway };

// Returns the name of a kind in messages, with its number in the file.
const char *run_kind_name(RunKind kind);

struct Recording {
  std::vector<double> time_s;
  std::vector<int> run;
  std::vector<RunKind> kind;
  std::vector<double> joint_angle_rad;      // unwrapped
  std::vector<double> joint_rate_rad_s;     // as estimated by the servo
  std::vector<double> inertial_rate_rad_s;  // the gyro's; NaN in ticks without
  std::vector<double> torque_nm;            // Kt times the mean current since the last tick
  std::vector<double> reference;            // rad/s, Nm or rad, by the kind

  std::size_t ticks() const { return time_s.size(); }
  bool has_gyro() const;
  bool has(RunKind wanted) const;
};

// Consecutive ticks [first, last).
struct Stretch {
  std::size_t first = 0;
  std::size_t last = 0;

  std::size_t ticks() const { return last - first; }
};

std::vector<Stretch> stretches(const Recording& recording);

// Returns parts of them, spread evenly over the whole and of equal length, `max_s` together at most: enough for a first
// estimate, in a fraction of the time. Returns all of it if there is no more than that.
std::vector<Stretch> excerpt(const std::vector<Stretch>& stretches, double max_s);

// A file that cannot be read as a recording; the message has file, line, error and remedy.
class RecordingError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

// Reads CSV with the header of kRecordingHeader. `name` is the file's name in messages. Throws RecordingError.
Recording read_recording(std::istream& input, const std::string& name);
Recording load_recording(const std::string& path);

// Writes what load_recording reads. Throws RecordingError when the file cannot be written.
void write_recording(const Recording& recording, const std::string& path);

extern const char *const kRecordingHeader;

}  // namespace trackservo::identification

#endif
