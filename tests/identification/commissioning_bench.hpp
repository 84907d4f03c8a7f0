// Records the experiments of commissioning on the simulated machine, the way servoctl will do it on a real one: the
// firmware's own experiments, one after the other at several places of the travel, in one consecutive recording.
#ifndef TRACKSERVO_TESTS_COMMISSIONING_BENCH_HPP
#define TRACKSERVO_TESTS_COMMISSIONING_BENCH_HPP

#include <string>
#include <vector>

#include "config/plant_config.hpp"
#include "identification/recording.hpp"
#include "run/machine.hpp"

extern "C" {
#include "commissioning/experiment.h"
}

namespace commissioning {

namespace sim = trackservo::sim;
namespace identification = trackservo::identification;

constexpr double kRadPerDeg = sim::kPi / 180.0;

// What is done, and where.
struct Place {
  double angle_rad = 0;
  std::vector<stimulus_setup> experiments;
};

struct Programme {
  std::vector<Place> places;
  double moving_rad_s = 0;  // between the places
  experiment_limits limits{};
};

// For a machine of this friction, inertia and travel, known roughly (a factor of two does not matter).
struct RoughMachine {
  double coulomb_nm = 0;
  double bristle_rad = 0;  // Tc / sigma0
  double stribeck_rad_s = 0;
  double inertia_kg_m2 = 0;
  double torque_nm = 0;  // that the drive can give
  double lowest_rad = 0;
  double highest_rad = 0;
};

RoughMachine rough_machine(const sim::PlantConfig& plant, int axis, double pitch_rad);
Programme programme_for(const RoughMachine& machine);

struct BenchSetup {
  sim::PlantConfig plant;
  int axis = sim::kAzimuth;
  std::uint64_t seed = 1;
  double pitch_rad = 0.3;  // held while azimuth moves
  std::string controller = "pi";
  bool gyro_recorded = true;
};

identification::Recording record(const BenchSetup& setup, const Programme& programme);

void write_csv(const identification::Recording& recording, const std::string& path);

}  // namespace commissioning

#endif
