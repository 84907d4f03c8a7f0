// SPDX-License-Identifier: Apache-2.0
#include "commissioning_bench.hpp"

#include <algorithm>
#include <limits>

#include "design/commissioning/commissioning.hpp"
#include "design/commissioning/true_parameters.hpp"
#include "design/control_design.hpp"

namespace commissioning_bench {

BenchSetup setup_of(const std::string& plant, int axis, std::uint64_t seed) {
  BenchSetup setup;
  setup.plant = sim::load_plant("sim_host/plants/" + plant + ".toml");
  setup.axis = axis;
  setup.seed = seed;
  return setup;
}

commissioning::RoughMachine rough_truth(const BenchSetup& setup) {
  const sim::FrictionConfig& friction = setup.plant.axis[static_cast<std::size_t>(setup.axis)].friction;
  commissioning::RoughMachine machine;
  machine.coulomb_nm = friction.positive.coulomb_nm;
  machine.bristle_rad = machine.coulomb_nm / friction.stiffness_nm_rad;
  machine.stribeck_rad_s = friction.positive.stribeck_speed_rad_s;
  machine.inertia_kg_m2 = sim::axis_inertia_kg_m2(setup.plant, setup.axis, setup.pitch_rad);
  return machine;
}

commissioning::TestPlan test_plan_of(const BenchSetup& setup) {
  return commissioning::test_plan_for(sim::motion_limits(setup.plant, setup.axis), rough_truth(setup));
}

identification::Recording record(const BenchSetup& setup, const commissioning::TestPlan& test_plan) {
  sim::AcquisitionSetup acquisition;
  acquisition.plant = &setup.plant;
  acquisition.params =
      sim::design_controller(setup.plant, sim::controller_spec(setup.controller), {setup.seed, 0.15, TRACKER_PI, {}});
  acquisition.axis = setup.axis;
  acquisition.start_angle_rad = {0.0, setup.pitch_rad};
  acquisition.seed = setup.seed;
  identification::Recording recording = sim::acquire(acquisition, test_plan).recording;
  if (!setup.gyro_recorded) {
    std::fill(recording.inertial_rate_rad_s.begin(), recording.inertial_rate_rad_s.end(),
              std::numeric_limits<double>::quiet_NaN());
  }
  return recording;
}

std::map<std::string, double> truth_of(const BenchSetup& setup, const identification::Identification& result) {
  return sim::true_parameters(setup.plant, setup.axis, setup.pitch_rad, result.position_terms);
}

double allowed_error(const std::string& parameter) {
  if (parameter == "damping") {
    return 0.20;
  }
  if (parameter == "stiffness" || parameter.rfind("stribeck_speed", 0) == 0) {
    return 0.10;
  }
  return 0.05;
}

}  // namespace commissioning_bench
