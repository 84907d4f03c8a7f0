// SPDX-License-Identifier: Apache-2.0
#include "studies/shared/assumed_plant_file.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include "gain_design/identified_plant_json.hpp"
#include "machine/base/checksum.hpp"
#include "machine/base/json_file.hpp"
#include "studies/shared/identified_axis.hpp"

namespace trackservo::sim {
namespace {

using Json = nlohmann::ordered_json;

constexpr const char *kFormat = "trackservo-assumed-plant";
constexpr int kVersion = 1;

Json head_of(const IdentifiedBy& by) {
  return {{"commit", by.commit},
          {"plant", by.plant.filename().string()},
          {"plant_checksum", checksum_of(std::vector<std::filesystem::path>{by.plant})}};
}

std::string text_of(const Json& head) {
  std::string text = "commit";
  for (const char *key : {"commit", "plant", "plant_checksum"}) {
    const Json found = head.is_object() ? head.value(key, Json()) : Json();
    text += " " + (found.is_string() ? found.get<std::string>() : "?");
  }
  return text;
}

AssumedPlantRecord record_of(const gain_design::InputFile& file) {
  AssumedPlantRecord record;
  std::string identified;
  for (int axis = 0; axis < kAxes; ++axis) {
    const Json found = file.json.value(axis_name(axis), Json());
    if (!found.is_object()) {
      throw file.error(fmt::format("\"{}\" is missing; give another file, or delete this one", axis_name(axis)));
    }
    record.plant[static_cast<std::size_t>(axis)] =
        gain_design::read_identified_plant({fmt::format("{}: {}", file.name, axis_name(axis)), found});
    identified += found.dump();
  }
  record.checksum = checksum_of(identified);
  return record;
}

// Another process may read or write the file at the same time: it is there whole or not at all.
void write_whole(const Json& json, const std::filesystem::path& file) {
  const std::filesystem::path part = fmt::format("{}.{}", file.string(), getpid());
  write_json(json, part);
  std::filesystem::rename(part, file);
}

}  // namespace

AssumedPlantRecord identify_assumed_plant(const PlantConfig& plant, const IdentifiedBy& by,
                                          const std::filesystem::path& out_dir, const std::filesystem::path& file,
                                          JobPool& pool) {
  Json json{{"format", kFormat}, {"version", kVersion}, {"generator", head_of(by)}};
  for (const IdentifiedAxis& axis : identify_plants({plant}, out_dir, pool)) {
    json[axis_name(axis.axis)] = gain_design::load_input_file(out_dir / axis.folder / "result.json").json;
  }
  if (!file.empty()) {
    write_whole(json, file);
  }
  return record_of({(file.empty() ? out_dir : file).string(), json});
}

AssumedPlantRecord read_assumed_plant(const std::filesystem::path& file, const IdentifiedBy& by) {
  const gain_design::InputFile read = gain_design::load_input_file(file.string());
  if (read.json.value("format", Json()) != kFormat || read.json.value("version", Json()) != kVersion) {
    throw read.error(fmt::format("is not a {} of version {}; give another file", kFormat, kVersion));
  }
  const Json expected = head_of(by);
  const Json found = read.json.value("generator", Json());
  if (found != expected) {
    throw read.error(
        fmt::format("was identified with {}, but this program and plant are {}; give another file, or delete this one",
                    text_of(found), text_of(expected)));
  }
  return record_of(read);
}

}  // namespace trackservo::sim
