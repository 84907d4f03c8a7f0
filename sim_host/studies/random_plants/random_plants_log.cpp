// SPDX-License-Identifier: Apache-2.0
#include "studies/random_plants/random_plants_log.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <stdexcept>
#include <tuple>

namespace trackservo::sim {
namespace {

constexpr const char *kIdentified = "identified ";
constexpr std::size_t kPrintedGaps = 5;

// The line of a plant without result has the reason in double quotes behind its seed.
constexpr const char *kFailed = "\"failed: ";

std::string line_of(const TriedPlant& plant) {
  std::string line = fmt::format("{}", plant.seed);
  for (const TriedAxis& axis : plant.axis) {
    for (const double error : axis.peak_error_deg_s) {
      line += fmt::format(",{}", error);  // the shortest form that reads back as the same number
    }
    line += fmt::format(",{},{},{},{:d},{:d}", axis.max_ripple_share, axis.gain_margin_db, axis.phase_margin_deg,
                        axis.stable, axis.stable_at_zenith);
  }
  return line + "\n";
}

std::optional<std::string> reason_of(std::string_view rest) {
  const std::string_view begin = kFailed;
  const bool is_reason = rest.size() > begin.size() && rest.substr(0, begin.size()) == begin && rest.back() == '"';
  return is_reason ? std::optional<std::string>(rest.substr(begin.size(), rest.size() - begin.size() - 1))
                   : std::nullopt;
}

}  // namespace

ResultLogFormat log_format(const RandomPlantsOrigin& origin, double share, const std::vector<std::string>& cases) {
  ResultLogFormat format{"sim_host random-plants",
                         fmt::format("commit {}, plant {}, inputs {}, share {}, {}{}", origin.commit, origin.plant,
                                     origin.inputs, share, kIdentified, origin.identified),
                         "seed"};
  for (int axis = 0; axis < kAxes; ++axis) {
    for (const std::string& case_name : cases) {
      format.columns += fmt::format(",{} peak_error at {} [deg/s]", axis_name(axis), case_name);
    }
    format.columns += fmt::format(
        ",{0} ripple_share,{0} gain_margin_db,{0} phase_margin_deg,{0} stable,{0} stable at "
        "zenith",
        axis_name(axis));
  }
  return format;
}

std::string identified_of(std::string_view text) {
  const std::string_view line = text.substr(0, text.find('\n'));
  const std::size_t found = line.rfind(kIdentified);
  return std::string(found == std::string_view::npos ? "" : line.substr(found + std::string_view(kIdentified).size()));
}

std::string line_of(const PlantResult& result) {
  const auto *failed = std::get_if<FailedPlant>(&result);
  return failed == nullptr ? line_of(std::get<TriedPlant>(result))
                           : fmt::format("{},{}{}\"\n", failed->seed, kFailed, failed->reason);
}

std::optional<PlantResult> result_of(const std::string& line, std::size_t cases) {
  TriedPlant plant;
  LineFields fields(line);
  fields.read(plant.seed);
  if (std::optional<std::string> reason = reason_of(fields.rest()); reason && fields.good()) {
    return FailedPlant{plant.seed, *std::move(reason)};
  }
  for (TriedAxis& axis : plant.axis) {
    axis.peak_error_deg_s.resize(cases);
    for (double& error : axis.peak_error_deg_s) {
      fields.read(error);
    }
    fields.read(axis.max_ripple_share);
    fields.read(axis.gain_margin_db);
    fields.read(axis.phase_margin_deg);
    fields.read(axis.stable);
    fields.read(axis.stable_at_zenith);
  }
  return fields.complete() ? std::optional<PlantResult>(std::move(plant)) : std::nullopt;
}

std::uint64_t seed_of(const PlantResult& result) {
  return std::visit([](const auto& plant) { return plant.seed; }, result);
}

void LoggedSeeds::add(std::uint64_t seed, std::size_t log, int line) {
  places_.push_back({seed, static_cast<std::uint32_t>(log), static_cast<std::uint32_t>(line)});
}

std::string LoggedSeeds::text(const Place& place) const {
  return fmt::format("{}:{}", logs_[place.log].string(), place.line);
}

void LoggedSeeds::refuse_repeated() {
  std::sort(places_.begin(), places_.end(), [](const Place& a, const Place& b) {
    return std::tie(a.seed, a.log, a.line) < std::tie(b.seed, b.log, b.line);
  });
  const auto twice = std::adjacent_find(places_.begin(), places_.end(),
                                        [](const Place& a, const Place& b) { return a.seed == b.seed; });
  if (twice != places_.end()) {
    throw std::runtime_error(fmt::format("{}: has seed {}, which {} has already; remove one of these lines",
                                         text(twice[1]), twice->seed, text(twice[0])));
  }
}

void LoggedSeeds::refuse_gaps(std::uint64_t first, std::uint64_t count) const {
  const auto outside = std::find_if(places_.begin(), places_.end(), [&](const Place& place) {
    return place.seed - first >= count;  // unsigned: also below
  });
  if (outside != places_.end()) {
    throw std::runtime_error(fmt::format("{}: has seed {}; the seeds are {} to {}", text(*outside), outside->seed,
                                         first, first + (count - 1)));
  }
  std::vector<std::string> gaps;
  std::uint64_t next = first;
  const auto close_gap = [&](std::uint64_t end) {
    if (next != end) {
      gaps.push_back(next + 1 == end ? fmt::format("{}", next) : fmt::format("{}-{}", next, end - 1));
    }
  };
  for (const Place& place : places_) {
    close_gap(place.seed);
    next = place.seed + 1;
  }
  close_gap(first + count);
  if (gaps.empty()) {
    return;
  }
  std::string message = fmt::format("{}: no line for the seeds", fmt::join(names(), ", "));
  for (std::size_t i = 0; i < std::min(gaps.size(), kPrintedGaps); ++i) {
    message += (i > 0 ? ", " : " ") + gaps[i];
  }
  message += gaps.size() > kPrintedGaps ? fmt::format(" and {} more gaps", gaps.size() - kPrintedGaps) : "";
  throw std::runtime_error(message + "; run them with --seeds and --log");
}

std::uint64_t LoggedSeeds::refuse_gaps() const {
  if (places_.empty()) {
    throw std::runtime_error(fmt::format("{}: no results", fmt::join(names(), ", ")));
  }
  refuse_gaps(places_.front().seed, places_.back().seed - places_.front().seed + 1);
  return places_.front().seed;
}

std::vector<std::string> LoggedSeeds::names() const {
  std::vector<std::string> names;
  for (const std::filesystem::path& log : logs_) {
    names.push_back(log.string());
  }
  return names;
}

}  // namespace trackservo::sim
