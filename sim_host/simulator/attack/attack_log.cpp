#include "attack/attack_log.hpp"

#include <fmt/format.h>

#include <optional>

namespace trackservo::sim {
namespace {

constexpr const char *kAxisColumns[] = {"contacts",  "contact_rad_s",  "contact_j", "contact_nm",
                                        "contact_s", "max_rate_rad_s", "runaway",   "runaway_s"};

ResultLogFormat format_of(const AttackLogOrigin& origin) {
  ResultLogFormat format{"sim_host attack", fmt::format("commit {}, plant {}", origin.commit, origin.plant),
                         "seed,theme,narrow,writes,refused,answers,nan"};
  for (int axis = 0; axis < kAxes; ++axis) {
    for (const char *column : kAxisColumns) {
      format.columns += fmt::format(",{}_{}", axis_name(axis), column);
    }
  }
  return format;
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

std::optional<AttackResult> result_of(const std::string& line) {
  AttackResult result;
  LineFields fields(line);
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
    : log_(file, format_of(origin), [&](const std::string& line, int /*number*/) {
        const std::optional<AttackResult> result = result_of(line);
        if (result) {
          each(*result);
        }
        return result.has_value();
      }) {}

void AttackLog::append(const std::vector<AttackResult>& results) {
  std::string lines;
  for (const AttackResult& result : results) {
    lines += line_of(result);
  }
  log_.append(lines);
}

}  // namespace trackservo::sim
