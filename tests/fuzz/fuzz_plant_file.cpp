// SPDX-License-Identifier: Apache-2.0
// libFuzzer harness of the plant file's reader: any text is a plant within its limits, or is refused by a ConfigError.
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string_view>

#include "machine/config/config_error.hpp"
#include "machine/config/plant_config.hpp"

namespace sim = trackservo::sim;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t *data, std::size_t size) {
  try {
    const sim::PlantConfig plant =
        sim::parse_plant("fuzzed", std::string_view(reinterpret_cast<const char *>(data), size));
    for (int i = 0; i < sim::kAxes; ++i) {
      const double inertia_kg_m2 = sim::axis_inertia_kg_m2(plant, i, 0.5);
      const double friction_nm = sim::steady_friction_nm(plant.axis[static_cast<std::size_t>(i)].friction, -0.01);
      if (!std::isfinite(inertia_kg_m2) || inertia_kg_m2 <= 0.0 || !std::isfinite(friction_nm)) {
        std::abort();
      }
    }
  } catch (const sim::ConfigError&) {
  }
  return 0;
}
