// SPDX-License-Identifier: Apache-2.0
#include "studies/random_plants/random_plants.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <mutex>
#include <optional>
#include <stdexcept>
#include <utility>

#include "design/true_plant.hpp"
#include "machine/base/job_pool.hpp"
#include "machine/base/result_log.hpp"
#include "studies/random_plants/random_plant.hpp"
#include "studies/random_plants/random_plants_log.hpp"

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
  const Margins margins = gain_design::worst_margins(machines, loop);
  tried.gain_margin_db = margins.gain_margin_db;
  tried.phase_margin_deg = margins.phase_margin_deg;
  tried.stable = gain_design::is_stable(machines, loop);
  tried.stable_at_zenith =
      gain_design::is_stable(at_zenith(machines, plant, axis), loop_at_pitch(nominal, axis, loop, 0.5 * kPi));
}

void add_figure(const Figure& figure, double motor_nm, TriedAxis& tried) {
  if (figure.metric == "peak_error") {
    tried.peak_error_deg_s.push_back(figure.value);
    tried.stable = tried.stable && figure.value < kMaxError_deg_s;
  } else if (figure.metric == "torque_noise") {
    const double ripple_share = figure.value / motor_nm;
    tried.max_ripple_share = std::max(tried.max_ripple_share, ripple_share);
    tried.stable = tried.stable && ripple_share < kMaxRippleShare;
  }
}

double paper_of(const std::vector<PaperFigure>& paper, const std::string& case_name) {
  const PaperFigure *figure = paper_figure(paper, case_name, "peak_error");
  const std::optional<double> error = figure != nullptr ? figure->compensated : std::nullopt;
  return error.value_or(std::numeric_limits<double>::quiet_NaN());
}

RandomPlants none_of(const RandomPlantsSetup& setup) {
  RandomPlants none;
  none.nominal = setup.study.plant;
  none.share = setup.share;
  none.seed = setup.seed;
  for (const StudyCase& study_case : cases_of(setup.study)) {
    none.cases.push_back(study_case.name);
    none.paper_deg_s.push_back(paper_of(setup.paper, study_case.name));
  }
  return none;
}

void add(RandomPlants& all, PlantResult result) {
  if (std::holds_alternative<FailedPlant>(result)) {
    all.failed.push_back(std::get<FailedPlant>(std::move(result)));
  } else {
    all.plants.push_back(std::get<TriedPlant>(std::move(result)));
  }
}

// The order in which they were finished must not matter.
void sort(RandomPlants& all) {
  const auto by_seed = [](const auto& a, const auto& b) { return a.seed < b.seed; };
  std::sort(all.plants.begin(), all.plants.end(), by_seed);
  std::sort(all.failed.begin(), all.failed.end(), by_seed);
}

FailedPlant failed_plant(std::uint64_t seed, std::string reason) {
  std::replace(reason.begin(), reason.end(), '"', '\'');
  std::replace(reason.begin(), reason.end(), '\n', ' ');
  return {seed, std::move(reason)};
}

void refuse_cut_off(const std::filesystem::path& log, const ResultLogLines& lines) {
  if (lines.cut_off > 0) {
    throw std::runtime_error(fmt::format("{}:{}: the file ends within this line; continue its run with --log {}",
                                         log.string(), lines.cut_off, log.string()));
  }
}

// Whatever is wrong with one plant; without memory the campaign ends.
PlantResult try_or_reason(const RandomPlantsSetup& setup, const servo_params& params, std::uint64_t seed,
                          const TryPlant& try_one) {
  try {
    return try_one(setup, params, seed);
  } catch (const std::runtime_error& error) {
    return failed_plant(seed, error.what());
  } catch (const std::logic_error& error) {
    return failed_plant(seed, error.what());
  }
}

}  // namespace

TriedPlant try_plant(const RandomPlantsSetup& setup, const servo_params& params, std::uint64_t seed) {
  Study study = setup.study;
  study.plant = random_plant(setup.study.plant, setup.share, seed).config;
  TriedPlant tried;
  tried.seed = seed;
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

RandomPlants try_random_plants(const RandomPlantsSetup& setup, const Progress& progress, const TryPlant& try_one) {
  const servo_params params =
      design_controller(setup.study.plant, controller_spec("pi_vob_ftc"), design_options(setup.study));
  RandomPlants all = none_of(setup);
  all.plants.reserve(setup.count);
  std::vector<bool> done(setup.count);
  std::optional<ResultLog> log;
  if (!setup.log.empty()) {
    LoggedSeeds logged({setup.log});
    log.emplace(setup.log, log_format(setup.origin, setup.share, all.cases), [&](const std::string& line, int number) {
      std::optional<PlantResult> result = result_of(line, all.cases.size());
      if (result) {
        const std::uint64_t seed = seed_of(*result);
        logged.add(seed, 0, number);
        if (seed - setup.seed < setup.count) {  // unsigned: also not below
          done[seed - setup.seed] = true;
          add(all, std::move(*result));
        }
      }
      return result.has_value();
    });
    logged.refuse_repeated();
  }
  std::vector<std::uint64_t> left;
  for (std::uint64_t i = 0; i < setup.count; ++i) {
    if (!done[i]) {
      left.push_back(setup.seed + i);
    }
  }
  std::mutex mutex;
  JobPool pool(setup.threads, static_cast<int>(left.size()), progress);
  pool.run(left.size(), [&](std::size_t i) {
    PlantResult result = try_or_reason(setup, params, left[i], try_one);
    const std::lock_guard<std::mutex> lock(mutex);
    if (log) {
      log->append(line_of(result));
    }
    add(all, std::move(result));
    return std::string("random plants");
  });
  sort(all);
  return all;
}

RandomPlants merge_random_plants(const RandomPlantsSetup& setup, const std::vector<std::filesystem::path>& logs,
                                 bool all_of_setup) {
  RandomPlants all = none_of(setup);
  RandomPlantsOrigin origin = setup.origin;
  LoggedSeeds logged(logs);
  for (std::size_t file = 0; file < logs.size(); ++file) {
    std::string text = read_log_text(logs[file]);
    origin.identified = file == 0 ? identified_of(text) : origin.identified;
    const ResultLogFormat format = log_format(origin, setup.share, all.cases);
    refuse_cut_off(logs[file],
                   read_result_log(logs[file], std::move(text), format, [&](const std::string& line, int number) {
                     std::optional<PlantResult> result = result_of(line, all.cases.size());
                     if (result) {
                       logged.add(seed_of(*result), file, number);
                       add(all, std::move(*result));
                     }
                     return result.has_value();
                   }));
  }
  logged.refuse_repeated();
  if (all_of_setup) {
    logged.refuse_gaps(setup.seed, setup.count);
  } else {
    all.seed = logged.refuse_gaps();
  }
  sort(all);
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
