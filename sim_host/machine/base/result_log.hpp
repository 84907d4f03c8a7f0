// SPDX-License-Identifier: Apache-2.0
// A campaign's results in a CSV file, one line per seed: appended while it runs, and read when it is continued.
//
// Line 1 is a comment with the program and what its results depend on, line 2 names the columns.
#ifndef TRACKSERVO_SIM_BASE_RESULT_LOG_HPP
#define TRACKSERVO_SIM_BASE_RESULT_LOG_HPP

#include <charconv>
#include <filesystem>
#include <functional>
#include <string>
#include <string_view>

namespace trackservo::sim {

struct ResultLogFormat {
  std::string program;  // "sim_host attack"
  std::string origin;   // "commit 1234567, plant tracker.toml": results of another origin are not mixed with these
  std::string columns;

  std::string head() const;  // lines 1 and 2
};

// Takes a line without its end, and its number; false when it is no result.
using LineReader = std::function<bool(const std::string& line, int number)>;

struct ResultLogLines {
  std::string whole;  // the head and the complete lines, each with its end; empty: the text ends within its head
  int cut_off = 0;    // number of the line that a killed process has left unfinished; 0: none
};

// Returns the text of a file or pipe, in any form that read_text() takes. Throws std::runtime_error with file and line.
std::string read_log_text(const std::filesystem::path& file);

// Reads the complete lines of `text`, which is that of `file`; empty lines count as none. Throws std::runtime_error
// with file and line when the text is of another origin or a line is no result.
ResultLogLines read_result_log(const std::filesystem::path& file, std::string text, const ResultLogFormat& format,
                               const LineReader& each);

class ResultLog {
 public:
  // Creates the file, or reads it as read_result_log does and then removes an unfinished line; a file in another form
  // becomes UTF-8 with LF. Throws std::runtime_error when the file cannot be written, is of another origin or is not
  // such a file; it then stays as it is.
  ResultLog(const std::filesystem::path& file, const ResultLogFormat& format, const LineReader& each);

  // Writes the lines through to the file. Throws std::runtime_error.
  void append(const std::string& lines);

 private:
  std::filesystem::path file_;
};

// Values of a line, one after the other.
class LineFields {
 public:
  explicit LineFields(std::string_view line) : rest_(line) {}

  // Reads whole numbers, truth values (0 or 1) and numbers, also inf and nan.
  template <class Value>
  void read(Value& value) {
    const std::string_view text = next();
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    good_ = good_ && error == std::errc() && end == text.data() + text.size();
  }

  void read(bool& value) { read_choice(value, 2); }

  // Reads a choice among `count`, as its number.
  template <class Choice>
  void read_choice(Choice& value, int count) {
    int number = 0;
    read(number);
    good_ = good_ && number >= 0 && number < count;
    value = static_cast<Choice>(number);
  }

  // Returns everything after the last value that was read.
  std::string_view rest() const { return rest_; }

  bool good() const { return good_; }

  // Returns whether all values were read, and there are no more.
  bool complete() const { return good_ && !more_; }

 private:
  std::string_view next() {
    good_ = good_ && more_;
    const std::size_t comma = rest_.find(',');
    const std::string_view text = rest_.substr(0, comma);
    more_ = comma != std::string_view::npos;
    rest_ = more_ ? rest_.substr(comma + 1) : std::string_view();
    return text;
  }

  std::string_view rest_;
  bool more_ = true;
  bool good_ = true;
};

}  // namespace trackservo::sim

#endif
