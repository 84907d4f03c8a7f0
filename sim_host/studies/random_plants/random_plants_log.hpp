// SPDX-License-Identifier: Apache-2.0
// Results of random plants as lines of a log, and the seeds that one or several logs have.
#ifndef TRACKSERVO_SIM_STUDIES_RANDOM_PLANTS_RANDOM_PLANTS_LOG_HPP
#define TRACKSERVO_SIM_STUDIES_RANDOM_PLANTS_RANDOM_PLANTS_LOG_HPP

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "machine/base/result_log.hpp"
#include "studies/random_plants/random_plants.hpp"

namespace trackservo::sim {

ResultLogFormat log_format(const RandomPlantsOrigin& origin, double share, const std::vector<std::string>& cases);

// Returns what line 1 of a log's text has as RandomPlantsOrigin::identified; empty when it is not such a log.
std::string identified_of(std::string_view text);

// Returns the line of a result, with its end.
std::string line_of(const PlantResult& result);

// Returns the result in a line; nothing when the line is no result with so many speeds.
std::optional<PlantResult> result_of(const std::string& line, std::size_t cases);

std::uint64_t seed_of(const PlantResult& result);

// 16 bytes per seed.
class LoggedSeeds {
 public:
  explicit LoggedSeeds(std::vector<std::filesystem::path> logs) : logs_(std::move(logs)) {}

  void add(std::uint64_t seed, std::size_t log, int line);

  // Throws std::runtime_error with both lines of the first seed that is there twice.
  void refuse_repeated();

  // Throws std::runtime_error when seeds are missing or are not among the required ones. Call after refuse_repeated().
  void refuse_gaps(std::uint64_t first, std::uint64_t count) const;

  // Does the same from the smallest to the largest seed. Returns the smallest.
  std::uint64_t refuse_gaps() const;

 private:
  struct Place {
    std::uint64_t seed;
    std::uint32_t log;
    std::uint32_t line;
  };

  std::string text(const Place& place) const;
  std::vector<std::string> names() const;

  std::vector<std::filesystem::path> logs_;
  std::vector<Place> places_;
};

}  // namespace trackservo::sim

#endif
