// SPDX-License-Identifier: Apache-2.0
// libFuzzer harness of the design's input files: any text is read, or is refused by an InputFileError.
//
// Input: a byte that selects the reader (requirements, parameters of a device, result of an identification), then the
// text.
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string_view>

#include "gain_design/device_parameters.hpp"
#include "gain_design/gain_requirements_json.hpp"
#include "gain_design/identified_plant_json.hpp"

namespace design = trackservo::gain_design;

namespace {

void require(bool good) {
  if (!good) {
    std::abort();
  }
}

void read_as(int kind, const design::InputFile& file) {
  switch (kind) {
    case 0: {
      const design::GainRequirements requirements = design::read_gain_requirements(file);
      require(requirements.least.gain_margin_db >= 1.0 && requirements.least.gain_margin_db <= 40.0);
      break;
    }
    case 1: {
      const axis_parameters parameters = design::read_device_parameters(file);
      require(std::isfinite(parameters.speed_loop.proportional_nm_s_rad));
      break;
    }
    default: {
      const design::IdentifiedPlant plant = design::read_identified_plant(file);
      require(plant.encoder.latency_s >= 0.0);
      break;
    }
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t *data, std::size_t size) {
  if (size == 0) {
    return 0;
  }
  try {
    const std::string_view text(reinterpret_cast<const char *>(data) + 1, size - 1);
    read_as(data[0] % 3, design::parse_input_file("fuzzed", text));
  } catch (const design::InputFileError&) {
  }
  return 0;
}
