// SPDX-License-Identifier: Apache-2.0
// Prints the descriptions of the node: describe_node FOLDER writes trackservo.eds, trackservo.dbc, parameters.json,
// can-objects.md, default_schema.h, faults.json and faults.md there, of a node with the product's default_parameters.c,
// and a new default_parameters.c as sim_host/plants/tracker.toml gives it. --defaults: that alone. --check: writes
// nothing and compares the printed texts with the committed files.
#include <cstdio>
#include <exception>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "device/simulated_node.hpp"
#include "dictionary/device_description.hpp"
#include "fault_description.hpp"
#include "machine/config/data_folder.hpp"

namespace {

namespace sim = trackservo::sim;
namespace dictionary = trackservo::dictionary;

constexpr std::uint8_t kNodeId = 1;  // of the DBC; the others are for any node

void write(const std::filesystem::path& file, const std::string& text) {
  std::ofstream stream(file, std::ios::binary);
  stream << text;
  if (!stream.flush()) {
    throw std::runtime_error(file.string() + ": cannot be written; give a writable folder");
  }
}

// File names and their texts.
using Texts = std::vector<std::pair<std::string, std::string>>;

Texts describe_defaults(const sim::PlantConfig& plant) {
  return {{"default_parameters.c",
           dictionary::print_default_parameters(
               {sim::node_parameters(plant, sim::kAzimuth), sim::node_parameters(plant, sim::kPitch)},
               {sim::node_limits(plant, sim::kAzimuth), sim::node_limits(plant, sim::kPitch)})}};
}

// Of the node of the product, as its image starts it.
Texts describe_node(const sim::PlantConfig& plant) {
  sim::NodeSetup setup = sim::product_setup(plant);
  setup.scales.reset();
  sim::NodeFittings fittings;
  fittings.node_id = kNodeId;
  fittings.hardware_version = nullptr;
  sim::SimulatedNode simulated(setup, 1, {0.0, 0.0}, fittings);
  servo_node *node = &simulated.node();
  const object_dictionary& objects = *servo_node_dictionary(node);
  const dictionary::DeviceInfo info{"trackservo.eds", "trackservo", "trackservo", "Two-axis tracker servo, CiA 402"};
  nlohmann::ordered_json parameters = {{"schema_hash", node->objects.schema_hash}};
  parameters.update(dictionary::describe_parameters(objects, info));
  return {{"trackservo.eds", dictionary::print_eds(objects, info)},
          {"parameters.json", dictionary::print_by_rows(parameters)},
          {"version.txt", TRACKSERVO_VERSION "\n"},
          {"trackservo.dbc", dictionary::print_dbc(objects, info, kNodeId)},
          {"default_schema.h", dictionary::print_default_schema(node->objects.schema_hash)},
          {"can-objects.md", dictionary::print_can_reference(objects, info)},
          {"faults.json", dictionary::print_by_rows(dictionary::describe_faults())},
          {"faults.md", dictionary::print_fault_page()}};
}

// The committed copies that are the same on every machine; trackservo.eds and trackservo.dbc have none.
constexpr std::string_view kCommitted[] = {"docs/can-objects.md",
                                           "docs/faults.md",
                                           "firmware/products/brushed_tracker/default_schema.h",
                                           "tools/servoctl/servoctl/descriptions/faults.json",
                                           "tools/servoctl/servoctl/descriptions/parameters.json",
                                           "tools/servoctl/servoctl/descriptions/version.txt",
                                           "tools/identify/trackservo_identify/version.txt",
                                           "tools/imager/imager/version.txt"};

// How many committed files differ from the printed texts; names each.
int compare_with_committed(const Texts& texts) {
  int differing = 0;
  for (const std::string_view name : kCommitted) {
    const std::filesystem::path file = sim::data_folder().parent_path() / name;
    std::ifstream stream(file, std::ios::binary);
    const std::string committed((std::istreambuf_iterator<char>(stream)), std::istreambuf_iterator<char>());
    for (const auto& [printed_name, text] : texts) {
      if (file.filename() == printed_name && committed != text) {
        (void)std::fprintf(stderr, "%s differs from what the build prints: run tools/update-docs dictionary\n",
                           std::string(name).c_str());
        ++differing;
      }
    }
  }
  return differing;
}

}  // namespace

int main(int argc, char **argv) {
  const bool only_defaults = argc == 3 && std::string_view(argv[1]) == "--defaults";
  const bool check = argc == 2 && std::string_view(argv[1]) == "--check";
  const bool is_option = argc >= 2 && argv[1][0] == '-' && !only_defaults && !check;
  if ((argc != 2 && !only_defaults) || is_option) {
    (void)std::fprintf(stderr, "Usage: describe_node [--defaults] FOLDER\n       describe_node --check\n");
    return 2;
  }
  try {
    const sim::PlantConfig plant = sim::load_plant(sim::data_folder() / "plants/tracker.toml");
    Texts texts = describe_defaults(plant);
    if (!only_defaults) {
      const Texts described = describe_node(plant);
      texts.insert(texts.end(), described.begin(), described.end());
    }
    if (check) {
      return compare_with_committed(texts) == 0 ? 0 : 1;
    }
    const std::filesystem::path folder = argv[argc - 1];
    std::filesystem::create_directories(folder);
    for (const auto& [name, text] : texts) {
      write(folder / name, text);
    }
  } catch (const std::exception& error) {
    (void)std::fprintf(stderr, "describe_node: %s\n", error.what());
    return 2;
  }
  return 0;
}
