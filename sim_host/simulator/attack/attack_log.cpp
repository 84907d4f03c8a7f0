#include "attack/attack_log.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <fstream>
#include <optional>
#include <sstream>
#include <stdexcept>

namespace trackservo::sim {
namespace {

constexpr const char *kAxisColumns[] = {"contacts",  "contact_rad_s",  "contact_j", "contact_nm",
                                        "contact_s", "max_rate_rad_s", "runaway",   "runaway_s"};

std::string head_of(const AttackLogOrigin& origin) {
  std::string head = fmt::format("# sim_host attack, commit {}, plant {}\nseed,theme,narrow,writes,refused,answers,nan",
                                 origin.commit, origin.plant);
  for (int axis = 0; axis < kAxes; ++axis) {
    for (const char *column : kAxisColumns) {
      head += fmt::format(",{}_{}", axis_name(axis), column);
    }
  }
  return head + "\n";
}

// Numbers in the shortest form that reads back as the same number.
std::string line_of(const AttackResult& result) {
  std::string line = fmt::format("{},{},{},{},{},{},{}", result.seed, static_cast<int>(result.theme),
                                 static_cast<int>(result.narrow), result.writes, result.refusals,
                                 static_cast<int>(result.answers), static_cast<int>(result.harm.not_finite));
  for (const AxisHarm& axis : result.harm.axis) {
    const EndStopContacts& contacts = axis.contacts;
    line += fmt::format(",{},{},{},{},{},{},{},{}", contacts.count, contacts.speed_rad_s, contacts.energy_j,
                        contacts.torque_nm, contacts.first_time_s, axis.max_rate_rad_s, static_cast<int>(axis.runaway),
                        axis.runaway_time_s);
  }
  return line + "\n";
}

// Values of a line, one after the other.
class Fields {
 public:
  explicit Fields(const std::string& line) : stream_(line) {}

  template <class Value>
  void read(Value& value) {
    if (!first_ && stream_.get() != ',') {
      stream_.setstate(std::ios::failbit);
    }
    first_ = false;
    stream_ >> value;
  }

  template <class Choice>
  void read_choice(Choice& value, int count) {
    int number = 0;
    read(number);
    if (number < 0 || number >= count) {
      stream_.setstate(std::ios::failbit);
    }
    value = static_cast<Choice>(number);
  }

  bool complete() { return !stream_.fail() && stream_.peek() == std::istringstream::traits_type::eof(); }

 private:
  std::istringstream stream_;
  bool first_ = true;
};

std::optional<AttackResult> result_of(const std::string& line) {
  AttackResult result;
  Fields fields(line);
  fields.read(result.seed);
  fields.read_choice(result.theme, static_cast<int>(kThemes.size()));
  fields.read(result.narrow);
  fields.read(result.writes);
  fields.read(result.refusals);
  fields.read(result.answers);
  fields.read(result.harm.not_finite);
  for (AxisHarm& axis : result.harm.axis) {
    fields.read(axis.contacts.count);
    fields.read(axis.contacts.speed_rad_s);
    fields.read(axis.contacts.energy_j);
    fields.read(axis.contacts.torque_nm);
    fields.read(axis.contacts.first_time_s);
    fields.read(axis.max_rate_rad_s);
    fields.read_choice(axis.runaway, 3);
    fields.read(axis.runaway_time_s);
  }
  return fields.complete() ? std::optional<AttackResult>(result) : std::nullopt;
}

}  // namespace

AttackLog::AttackLog(const std::filesystem::path& file, const AttackLogOrigin& origin,
                     const std::function<void(const AttackResult&)>& each)
    : file_(file) {
  const std::string head = head_of(origin);
  std::ifstream stream(file, std::ios::binary);
  std::string read(head.size(), '\0');
  stream.read(read.data(), static_cast<std::streamsize>(read.size()));
  read.resize(static_cast<std::size_t>(stream.gcount()));
  if (head.compare(0, read.size(), read) != 0) {
    throw std::runtime_error(
        fmt::format("{}: line 1 is not \"{}\": the file is of another firmware, plant or program; "
                    "give another file",
                    file.string(), head.substr(0, head.find('\n'))));
  }
  if (read.size() < head.size()) {  // new, or cut off in its head
    stream.close();
    std::ofstream created(file, std::ios::binary | std::ios::trunc);
    if (!(created << head).flush()) {
      throw std::runtime_error(fmt::format("{}: cannot be written; is the disk full?", file.string()));
    }
    return;
  }
  std::uintmax_t whole = head.size();
  int number = static_cast<int>(std::count(head.begin(), head.end(), '\n'));
  for (std::string line; std::getline(stream, line) && !stream.eof();) {
    const std::optional<AttackResult> result = result_of(line);
    ++number;
    if (!result) {
      throw std::runtime_error(
          fmt::format("{}: line {} is not a result of sim_host attack; remove it", file.string(), number));
    }
    each(*result);
    whole += line.size() + 1;
  }
  stream.close();
  std::filesystem::resize_file(file, whole);
}

void AttackLog::append(const std::vector<AttackResult>& results) {
  std::string lines;
  for (const AttackResult& result : results) {
    lines += line_of(result);
  }
  std::ofstream stream(file_, std::ios::binary | std::ios::app);
  if (!(stream << lines).flush()) {
    throw std::runtime_error(fmt::format("{}: cannot be written; is the disk full?", file_.string()));
  }
}

}  // namespace trackservo::sim
