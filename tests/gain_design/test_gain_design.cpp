// From an identified plant and wishes to gains: shipped gains come out again, and what is predicted is measured.
#include <cmath>

#include "gain_design/design_bench.hpp"

extern "C" void setUp(void) {}
extern "C" void tearDown(void) {}

namespace {

using namespace design_bench;

void test_wishes_of_the_shipped_plants_give_the_shipped_gains() {
  for (const char *name : {"tracker", "paper_simulation"}) {
    const sim::PlantConfig plant = bench::shipped_plant(name);
    for (int axis = 0; axis < sim::kAxes; ++axis) {
      const axis_parameters before = present(plant, axis);
      const GainDesign design =
          design_gains(sim::true_plant(plant, axis), sim::gain_wishes(plant, axis, TRACKER_PI), before);
      const axis_parameters& now = design.parameters;
      CHECK_RELATIVE("kp", before.speed_loop.proportional_nm_s_rad, now.speed_loop.proportional_nm_s_rad, 1e-6);
      CHECK_RELATIVE("ki", before.speed_loop.integral_nm_rad, now.speed_loop.integral_nm_rad, 1e-6);
      CHECK_RELATIVE("anti-windup", before.speed_loop.tracking_rate_per_s, now.speed_loop.tracking_rate_per_s, 1e-6);
      CHECK_RELATIVE("observer", before.observer.bandwidth_rad_s, now.observer.bandwidth_rad_s, 1e-6);
      CHECK_RELATIVE("position", before.position_loop.proportional_per_s, now.position_loop.proportional_per_s, 1e-6);
      CHECK_RELATIVE("stiffness", before.friction.stiffness_nm_rad, now.friction.stiffness_nm_rad, 1e-6);
      CHECK_SAME("notch", 0.0, now.filters.notch_hz);
      CHECK_SAME("low-pass", 0.0, now.filters.lowpass_hz);
      if (plant.name == "tracker") {
        CHECK_RELATIVE("tracking", before.tracking_loop.integral_per_s2, now.tracking_loop.integral_per_s2, 1e-6);
        TEST_ASSERT_EQUAL(0, design.notes.size());
      } else {  // its speed loop of 2.6 Hz is too slow for a tracking loop of 2 Hz
        TEST_ASSERT_EQUAL(1, design.notes.size());
        TEST_ASSERT_TRUE(mentions(design.notes, "Tracking loop lowered from 2 Hz to "));
      }
    }
  }
}

void expect_as_predicted(const sim::PlantConfig& plant, int axis, const GainDesign& design) {
  for (const bool pre_sliding : {false, true}) {
    const Margins& predicted = pre_sliding ? design.pre_sliding : design.sliding;
    const Margins found = margins_of(measured(plant, axis, design.parameters, predicted, pre_sliding));
    CHECK_NEAR(pre_sliding ? "gain margin at rest" : "gain margin sliding", predicted.gain_margin_db,
               found.gain_margin_db, 1.0);
    CHECK_NEAR(pre_sliding ? "phase margin at rest" : "phase margin sliding", predicted.phase_margin_deg,
               found.phase_margin_deg, 4.0);
  }
}

void show(const GainDesign& design) {
  for (const std::string& note : design.notes) {
    TEST_MESSAGE(note.c_str());
  }
  LOG_VALUE("gain margin sliding", design.sliding.gain_margin_db);
  LOG_VALUE("phase margin sliding", design.sliding.phase_margin_deg);
  LOG_VALUE("gain margin at rest", design.pre_sliding.gain_margin_db);
  LOG_VALUE("phase margin at rest", design.pre_sliding.phase_margin_deg);
  LOG_VALUE("PI alone, Hz", design.speed_loop_bandwidth_hz);
  LOG_VALUE("whole loop, Hz", design.bandwidth_hz);
  LOG_VALUE("observer, Hz", static_cast<double>(design.parameters.observer.bandwidth_rad_s) / (2 * M_PI));
  LOG_VALUE("torque noise, Nm", design.torque_noise_nm);
  LOG_VALUE("position 1/s", design.parameters.position_loop.proportional_per_s);
  LOG_VALUE("tracking 1/s", design.parameters.tracking_loop.proportional_per_s);
  LOG_VALUE("tracking 1/s2", design.parameters.tracking_loop.integral_per_s2);
}

void test_without_wishes_the_margins_are_used_up_and_measured() {
  for (const char *name : {"tracker", "paper_simulation"}) {
    const sim::PlantConfig plant = bench::shipped_plant(name);
    const GainDesign design = design_gains(sim::true_plant(plant, 0), {}, present(plant, 0));
    show(design);
    expect_as_predicted(plant, 0, design);
  }
}

void test_wishes_that_are_too_high_are_lowered() {
  const sim::PlantConfig plant = bench::shipped_plant("tracker");
  GainWishes wishes;
  wishes.speed_loop_bandwidth_hz = 120.0;
  wishes.observer_bandwidth_hz = 80.0;
  const GainDesign design = design_gains(sim::true_plant(plant, 1), wishes, present(plant, 1));
  show(design);
  expect_as_predicted(plant, 1, design);
}

}  // namespace

int main() {
  UNITY_BEGIN();
  RUN_TEST(test_wishes_of_the_shipped_plants_give_the_shipped_gains);
  RUN_TEST(test_without_wishes_the_margins_are_used_up_and_measured);
  RUN_TEST(test_wishes_that_are_too_high_are_lowered);
  return UNITY_END();
}
