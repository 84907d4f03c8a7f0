// SPDX-License-Identifier: Apache-2.0
// The sines of a spectrum of base motion: their power in every part of the band is that of the stated density.
#include "machine/plant/base_spectrum.hpp"

#include <cmath>

#include "support/bench.hpp"
#include "support/check.h"

extern "C" void setUp(void) {}
extern "C" void tearDown(void) {}

namespace {

using namespace bench;

BaseSpectrum ship() {
  BaseSpectrum band;
  band.axis = BaseAxis::kRoll;
  band.rms_rad = 0.03;
  band.low_hz = 0.1;
  band.high_hz = 10.0;
  band.slope = 4.0;
  band.sines = 60;
  return band;
}

double power_rad2(const std::vector<BaseMotionLine>& lines, double from_hz, double to_hz) {
  double power = 0.0;
  for (const BaseMotionLine& line : lines) {
    power +=
        line.frequency_hz >= from_hz && line.frequency_hz < to_hz ? 0.5 * line.amplitude_rad * line.amplitude_rad : 0.0;
  }
  return power;
}

void test_the_power_is_that_of_the_band_and_falls_with_the_slope() {
  const std::vector<BaseMotionLine> lines = lines_of(ship(), 0);
  TEST_ASSERT_EQUAL(60, lines.size());
  CHECK_NEAR("variance, rad2", 9e-4, power_rad2(lines, 0.1, 10.0), 1e-9);
  // f^-4 on [0.1, 10]: the share above f is (f^-3 - 10^-3) / (0.1^-3 - 10^-3); here within one sine of the sum.
  CHECK_NEAR("share above 0.2 Hz", 0.125, power_rad2(lines, 0.2, 10.0) / 9e-4, 0.04);
  CHECK_NEAR("share above 1 Hz", 1e-3, power_rad2(lines, 1.0, 10.0) / 9e-4, 3e-4);
}

void test_a_flat_band_and_the_slope_of_one_have_their_power_too() {
  for (const double slope : {0.0, 1.0}) {
    BaseSpectrum band = ship();
    band.slope = slope;
    CHECK_NEAR("variance, rad2", 9e-4, power_rad2(lines_of(band, 0), 0.1, 10.0), 1e-9);
  }
}

void test_the_seed_decides_frequencies_and_phases_and_nothing_else() {
  const std::vector<BaseMotionLine> lines = lines_of(ship(), 0);
  const std::vector<BaseMotionLine> again = lines_of(ship(), 0);
  BaseSpectrum other = ship();
  other.seed = 2;
  const std::vector<BaseMotionLine> others = lines_of(other, 0);
  for (std::size_t i = 0; i < lines.size(); ++i) {
    CHECK_SAME("phase", lines[i].phase_rad, again[i].phase_rad);
    CHECK_SAME("amplitude", lines[i].amplitude_rad, others[i].amplitude_rad);
    TEST_ASSERT_TRUE(lines[i].phase_rad != others[i].phase_rad && lines[i].frequency_hz != others[i].frequency_hz);
  }
}

// Of a plant file: bands and stated sines add up, and the moving base has their standard deviation.
void test_bands_of_a_plant_file_add_to_its_sines() {
  PlantConfig plant = shipped_plant("tracker");
  plant.base_motion = {{BaseAxis::kYaw, 0.3, 0.01, 0.0}};
  plant.base_spectrum = {ship(), ship()};
  const std::vector<BaseMotionLine> lines = base_motion_lines(plant);
  TEST_ASSERT_EQUAL(121, lines.size());
  TEST_ASSERT_TRUE(lines[1].phase_rad != lines[61].phase_rad);
  CHECK_NEAR("variance, rad2", 5e-5 + 18e-4, power_rad2(lines, 0.0, 100.0), 1e-9);
}

void test_the_fastest_rate_of_a_sine_is_its_amplitude() {
  PlantConfig plant = shipped_plant("tracker");
  CHECK_SAME("at rest", 0.0, fastest_base_rate_rad_s(plant));
  plant.base_motion = {{BaseAxis::kYaw, 0.5, 0.01, 0.0}};
  CHECK_NEAR("rad/s", 0.01 * kPi, fastest_base_rate_rad_s(plant), 1e-12);
}

}  // namespace

int main() {
  UNITY_BEGIN();
  RUN_TEST(test_the_power_is_that_of_the_band_and_falls_with_the_slope);
  RUN_TEST(test_a_flat_band_and_the_slope_of_one_have_their_power_too);
  RUN_TEST(test_the_seed_decides_frequencies_and_phases_and_nothing_else);
  RUN_TEST(test_bands_of_a_plant_file_add_to_its_sines);
  RUN_TEST(test_the_fastest_rate_of_a_sine_is_its_amplitude);
  return UNITY_END();
}
