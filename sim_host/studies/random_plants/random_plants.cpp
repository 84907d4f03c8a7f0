#include "studies/random_plants/random_plants.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/job_pool.hpp"
#include "design/true_plant.hpp"

namespace trackservo::sim {
namespace {

// The machine as the loop sees it: the torque is the current times the true torque constant, so a weaker motor acts
// like a heavier axis; the current loop was designed for another inductance.
std::vector<LinearMachine> machines_of(const PlantConfig& plant, int axis, const PlantConfig& nominal) {
  const auto i = static_cast<std::size_t>(axis);
  const MotorConfig& motor = plant.axis[i].motor;
  const MotorConfig& believed = nominal.axis[i].motor;
  const double current_loop_rad_s =
      2.0 * kPi * nominal.design[i].current_loop_bandwidth_hz * believed.inductance_h / motor.inductance_h;
  const double strength = motor.torque_constant_nm_a / believed.torque_constant_nm_a;
  std::vector<LinearMachine> machines = gain_design::operating_points(true_plant(plant, axis), current_loop_rad_s);
  for (LinearMachine& machine : machines) {
    machine.inertia_kg_m2 /= strength;
    machine.viscous_nm_s_rad /= strength;
    machine.bristle_stiffness_nm_rad /= strength;
    machine.bristle_damping_nm_s_rad /= strength;
  }
  return machines;
}

std::vector<LinearMachine> at_zenith(std::vector<LinearMachine> machines, const PlantConfig& plant, int axis) {
  const double share = min_inertia_kg_m2(plant, axis) / axis_inertia_kg_m2(plant, axis, 0.0);
  for (LinearMachine& machine : machines) {
    machine.inertia_kg_m2 *= share;
  }
  return machines;
}

void compute_margins(const PlantConfig& plant, const PlantConfig& nominal, const servo_params& params, int axis,
                     TriedAxis& tried) {
  const speed_loop_params& loop = params.axis[axis].speed;
  const std::vector<LinearMachine> machines = machines_of(plant, axis, nominal);
  tried.margins = gain_design::worst_margins(machines, loop);
  tried.stable = gain_design::is_stable(machines, loop);
  tried.stable_at_zenith = gain_design::is_stable(at_zenith(machines, plant, axis), loop);
}

void add_figure(const Figure& figure, double motor_nm, TriedAxis& tried) {
  if (figure.metric == "peak_error") {
    tried.peak_error_deg_s.push_back(figure.value);
    tried.stable = tried.stable && figure.value < kMaxError_deg_s;
  } else if (figure.metric == "torque_noise") {
    tried.ripple_share.push_back(figure.value / motor_nm);
    tried.stable = tried.stable && tried.ripple_share.back() < kMaxRippleShare;
  }
}

double paper_of(const std::vector<PaperFigure>& paper, const std::string& case_name) {
  const PaperFigure *figure = paper_figure(paper, case_name, "peak_error");
  const std::optional<double> error = figure != nullptr ? figure->compensated : std::nullopt;
  return error.value_or(std::numeric_limits<double>::quiet_NaN());
}

}  // namespace

TriedPlant try_plant(const RandomPlantsSetup& setup, const servo_params& params, std::uint64_t seed) {
  Study study = setup.study;
  RandomPlant plant = random_plant(setup.study.plant, setup.share, seed);
  study.plant = plant.config;
  TriedPlant tried;
  tried.seed = seed;
  tried.deviations = std::move(plant.deviations);
  for (int axis = 0; axis < kAxes; ++axis) {
    compute_margins(study.plant, setup.study.plant, params, axis, tried.axis[static_cast<std::size_t>(axis)]);
  }
  for (const StudyCase& study_case : cases_of(study)) {
    const Trace trace = run_scenario({&study.plant, &study.scenario, study_case.speed_rad_s, params, seed});
    for (const Figure& figure : measure(study, study_case, trace)) {
      const auto axis = static_cast<std::size_t>(figure.axis);
      const MotorConfig& motor =
          setup.study.plant.axis[axis].motor;  // commands use the assumed motor's torque constant
      add_figure(figure, motor.torque_constant_nm_a * motor.current_limit_a, tried.axis[axis]);
    }
  }
  return tried;
}

RandomPlants try_random_plants(const RandomPlantsSetup& setup, const Progress& progress) {
  const servo_params params =
      design_controller(setup.study.plant, controller_spec("pi_vob_ftc"), design_options(setup.study));
  RandomPlants all;
  for (const StudyCase& study_case : cases_of(setup.study)) {
    all.cases.push_back(study_case.name);
    all.paper_deg_s.push_back(paper_of(setup.paper, study_case.name));
  }
  all.plants.resize(static_cast<std::size_t>(setup.count));
  JobPool pool(setup.threads, setup.count, progress);
  pool.run(all.plants.size(), [&](std::size_t i) {
    all.plants[i] = try_plant(setup, params, setup.seed + i);
    return std::string("random plants");
  });
  return all;
}

double worst_ratio(const TriedAxis& axis, const std::vector<double>& paper_deg_s) {
  double worst = 0.0;
  for (std::size_t i = 0; i < paper_deg_s.size(); ++i) {
    const double ratio = axis.peak_error_deg_s[i] / paper_deg_s[i];
    worst = ratio > worst ? ratio : worst;  // false where the paper has none
  }
  return worst;
}

}  // namespace trackservo::sim
