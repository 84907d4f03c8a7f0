// SPDX-License-Identifier: Apache-2.0
// Accuracy of the identification on machines with known parameters, seed by seed, and on machines outside its model. On
// request, minutes long: `identification_study [--case NAME]... [--seeds 5] [--details]` prints a table of markdown.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <functional>

#include "commissioning_bench.hpp"
#include "design/commissioning/commissioning.hpp"

namespace identification = trackservo::identification;
namespace sim = trackservo::sim;
using commissioning_bench::BenchSetup;
using commissioning_bench::kRadPerDeg;
using trackservo::commissioning::TestPlan;

namespace {

struct Case {
  const char *name;
  const char *plant;
  int axis;
  std::function<void(BenchSetup&)> change;
  std::function<void(TestPlan&)> reprogramme = nullptr;
};

void scale_friction(BenchSetup& setup, double factor) {
  sim::FrictionConfig& friction = setup.plant.axis[static_cast<std::size_t>(setup.axis)].friction;
  friction.stiffness_nm_rad *= factor;
  friction.damping_nm_s_rad *= std::sqrt(factor);
  for (sim::StribeckConfig *direction : {&friction.positive, &friction.negative}) {
    direction->coulomb_nm *= factor;
    direction->breakaway_nm *= factor;
    direction->viscous_nm_s_rad *= factor;
  }
}

sim::AxisConfig& axis_of(BenchSetup& setup) { return setup.plant.axis[static_cast<std::size_t>(setup.axis)]; }

void make_asymmetric(BenchSetup& setup) {
  sim::StribeckConfig& negative = axis_of(setup).friction.negative;
  negative.coulomb_nm *= 1.4;
  negative.breakaway_nm *= 1.3;
  negative.viscous_nm_s_rad *= 1.5;
  negative.stribeck_speed_rad_s *= 1.5;
}

void limit_travel(BenchSetup& setup) {
  axis_of(setup).end_stops->lower_rad = -60 * kRadPerDeg;
  axis_of(setup).end_stops->upper_rad = 60 * kRadPerDeg;
}

// As if the machine had been assumed to have half of Tc, bristle length and Stribeck speed, or twice.
void misjudge(TestPlan& test_plan, double factor) {
  const BenchSetup setup = commissioning_bench::setup_of("tracker");
  trackservo::commissioning::RoughMachine machine = commissioning_bench::rough_truth(setup);
  machine.coulomb_nm *= factor;
  machine.bristle_rad *= factor;
  machine.stribeck_rad_s *= factor;
  test_plan = trackservo::commissioning::test_plan_for(sim::motion_limits(setup.plant, setup.axis), machine);
}

void keep_sweeps(trackservo::commissioning::Place& place) {
  std::vector<stimulus_setup>& experiments = place.experiments;
  const auto other = [](const stimulus_setup& experiment) { return experiment.kind != STIMULUS_SWEEP; };
  experiments.erase(std::remove_if(experiments.begin(), experiments.end(), other), experiments.end());
}

const std::vector<Case>& cases() {
  static const std::vector<Case> all{
      {"tracker azimuth", "tracker", sim::kAzimuth, [](BenchSetup&) {}},
      {"tracker pitch", "tracker", sim::kPitch, [](BenchSetup&) {}},
      {"paper simulation", "paper_simulation", sim::kAzimuth, [](BenchSetup&) {}},
      {"observer on", "tracker", sim::kAzimuth, [](BenchSetup& setup) { setup.controller = "pi_vob"; }},
      {"friction a tenth", "tracker", sim::kAzimuth, [](BenchSetup& setup) { scale_friction(setup, 0.1); }},
      {"friction three times", "tracker", sim::kAzimuth, [](BenchSetup& setup) { scale_friction(setup, 3.0); }},
      {"friction ten times, motor too", "tracker", sim::kAzimuth,
       [](BenchSetup& setup) {
         scale_friction(setup, 10.0);
         axis_of(setup).motor.torque_constant_nm_a *= 5.0;
         axis_of(setup).motor.back_emf_constant_v_s_rad *= 5.0;
       }},
      {"directions 40 % apart", "tracker", sim::kAzimuth, make_asymmetric},
      {"travel of +-60 deg", "tracker", sim::kAzimuth, limit_travel},
      {"encoder only", "tracker", sim::kAzimuth, [](BenchSetup& setup) { setup.gyro_recorded = false; }},
      {"encoder of 20 bits", "tracker", sim::kAzimuth,
       [](BenchSetup& setup) { axis_of(setup).encoder.resolution_bits = 20; }},
      {"test plan for half the machine", "tracker", sim::kAzimuth, [](BenchSetup&) {},
       [](TestPlan& test_plan) { misjudge(test_plan, 0.5); }},
      {"test plan for twice the machine", "tracker", sim::kAzimuth, [](BenchSetup&) {},
       [](TestPlan& test_plan) { misjudge(test_plan, 2.0); }},
      {"no loops, no chirp", "tracker", sim::kAzimuth, [](BenchSetup&) {},
       [](TestPlan& test_plan) {
         for (trackservo::commissioning::Place& place : test_plan.places) {
           keep_sweeps(place);
         }
       }},
  };
  return all;
}

struct Tally {
  std::map<std::string, double> worst;  // error by parameter
  int values = 0;
  int covered = 0;
  int within = 0;
  int refused = 0;
};

void count(const identification::Identification& result, const std::map<std::string, double>& truth, bool details,
           Tally& tally) {
  for (const identification::Parameter& parameter : result.parameters) {
    if (!parameter.refused.empty()) {
      ++tally.refused;
      if (details) {
        fmt::print("    refused {}\n", parameter.refused);
      }
      continue;
    }
    const double right = truth.at(parameter.name);
    const double error = std::log(parameter.value / right);
    double& worst = tally.worst[parameter.name];
    worst = std::abs(error) > std::abs(worst) ? error : worst;
    tally.values += 1;
    tally.covered += parameter.interval.low <= right && right <= parameter.interval.high ? 1 : 0;
    tally.within += std::abs(error) <= commissioning_bench::allowed_error(parameter.name) ? 1 : 0;
    if (details) {
      fmt::print("    {:<24} true {:10.5g} paper {:10.5g} found {:10.5g} ({:+.2f} %), {:.5g} .. {:.5g}\n",
                 parameter.name, right, parameter.paper, parameter.value, 100 * error, parameter.interval.low,
                 parameter.interval.high);
    }
  }
}

void run(const Case& which, int seeds, std::uint64_t first_seed, bool details, const std::string& csv) {
  BenchSetup setup = commissioning_bench::setup_of(which.plant, which.axis);
  which.change(setup);
  TestPlan test_plan = commissioning_bench::test_plan_of(setup);
  if (which.reprogramme) {
    which.reprogramme(test_plan);
  }
  Tally tally;
  double recorded_s = 0;
  const auto begin = std::chrono::steady_clock::now();
  for (int i = 0; i < seeds; ++i) {
    setup.seed = first_seed + static_cast<std::uint64_t>(i);
    const identification::Recording recording = commissioning_bench::record(setup, test_plan);
    recorded_s = recording.time_s.back();
    if (!csv.empty()) {
      identification::write_recording(recording, csv);
    }
    const identification::Identification result = identification::identify(recording);
    count(result, commissioning_bench::truth_of(setup, result), details, tally);
  }
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  std::pair<std::string, double> worst;
  for (const auto& [name, error] : tally.worst) {
    if (std::abs(error) / commissioning_bench::allowed_error(name) >
        std::abs(worst.second) / (worst.first.empty() ? 1.0 : commissioning_bench::allowed_error(worst.first))) {
      worst = {name, error};
    }
  }
  fmt::print("| {} | {:.0f} | {} | {} of {} | {} of {} | {} {:+.1f} % | {:.0f} |\n", which.name, recorded_s,
             tally.refused, tally.within, tally.values, tally.covered, tally.values, worst.first, 100 * worst.second,
             seconds / seeds);
  (void)std::fflush(stdout);
}

}  // namespace

int main(int argc, char **argv) {
  CLI::App app{"Identification on machines of known truth"};
  std::vector<std::string> wanted;
  int seeds = 5;
  std::uint64_t first_seed = 11;
  bool details = false;
  app.add_option("--case", wanted, "only the cases whose name contains one of these");
  app.add_option("--seeds", seeds);
  app.add_option("--first-seed", first_seed);
  std::string csv;
  app.add_option("--csv", csv, "keep the last recording here, for identify fit");
  app.add_flag("--details", details, "every parameter of every seed");
  CLI11_PARSE(app, argc, argv);
  fmt::print("| machine | recorded, s | refused | within the limits | in the 95 % interval | worst | s per fit |\n");
  fmt::print("|---|---|---|---|---|---|---|\n");
  for (const Case& which : cases()) {
    const bool chosen = wanted.empty() || std::any_of(wanted.begin(), wanted.end(), [&](const std::string& part) {
                          return std::string(which.name).find(part) != std::string::npos;
                        });
    if (!chosen) {
      continue;
    }
    try {
      run(which, seeds, first_seed, details, csv);
    } catch (const std::exception& error) {
      fmt::print("| {} | {} | | | | | |\n", which.name, error.what());
    }
  }
}
