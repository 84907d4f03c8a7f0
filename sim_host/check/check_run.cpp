// SPDX-License-Identifier: Apache-2.0
#include "check/check_run.hpp"

#include <fmt/format.h>

#include <cmath>
#include <limits>
#include <map>

#include "check/drive_case.hpp"
#include "check/loop_figures.hpp"
#include "device/simulated_device.hpp"
#include "device/tracking_run.hpp"
#include "machine/base/job_pool.hpp"
#include "machine/run/scenario_run.hpp"
#include "studies/shared/study.hpp"

namespace trackservo::sim {
namespace {

// Result of one job: figures of one seed, NaN after a failure.
struct Outcome {
  std::string scenario;
  std::string case_name;
  std::size_t seed = 0;  // its place in the plan
  std::vector<Figure> figures;
  std::optional<std::string> failure;
};

using Job = std::function<Outcome()>;

// What a device has in force with the gains of the plan.
struct InForce {
  servo_params params;
  std::array<axis_parameters, kAxes> parameters;
};

InForce in_force(const CheckPlan& plan) {
  const SimulatedDevice *made = nullptr;
  const DeviceMaker make = [&made](const auto& plant, auto& bus, std::uint64_t seed, const auto& joint_angle_rad) {
    std::unique_ptr<Device> device = make_simulated_device(plant, bus, seed, joint_angle_rad);
    made = static_cast<const SimulatedDevice *>(device.get());
    return device;
  };
  CheckedDevice device(make, plan.plant, 1, {0.0, 0.0});
  apply_gains(device, plan.gains);
  const servo_node& node = made->node();
  return {node.board.app.params, {node.axis[kAzimuth].tuning.active, node.axis[kPitch].tuning.active}};
}

Study study_of(const CheckPlan& plan, const ScenarioConfig& scenario, const InForce& gains) {
  Study study;
  study.experiment = scenario.name;
  study.plant = plan.plant;
  study.scenario = scenario;
  study.tracker = gains.params.axis[kAzimuth].tracker.kind;
  return study;
}

Outcome tracking_outcome(const CheckPlan& plan, const Study& study, const StudyCase& study_case, const InForce& gains,
                         std::size_t seed) {
  const Trace trace = run_tracking(NodeSetup(plan.plant, gains.parameters), study.scenario, plan.seeds[seed]);
  return {study.scenario.name, study_case.name, seed, measure(study, study_case, trace), std::nullopt};
}

// The torque command of a device cannot be observed.
std::vector<Figure> figures_of_trace(const CheckPlan& plan, const Study& study, const StudyCase& study_case,
                                     const Trace& trace) {
  std::vector<Figure> figures;
  for (const Figure& figure : measure(study, study_case, trace)) {
    if (!plan.only_device || figure.metric != "torque_noise") {
      figures.push_back(figure);
    }
  }
  return figures;
}

Outcome driven_outcome(const CheckPlan& plan, const Study& study, const StudyCase& study_case, std::size_t seed) {
  Trace trace;
  for (const ScenarioConfig& run : runs_of(study.scenario)) {
    CheckedDevice device(plan.make_device, plan.plant, plan.seeds[seed], run.initial_joint_angle_rad);
    DrivenCase driven = drive_case(device, plan.plant, run, study_case.speed_rad_s, plan.gains);
    if (driven.failure) {
      return {study.scenario.name, study_case.name, seed, figures_of_trace(plan, study, study_case, {}),
              driven.failure};
    }
    add_run(trace, run, std::move(driven.trace));
  }
  return {study.scenario.name, study_case.name, seed, figures_of_trace(plan, study, study_case, trace), std::nullopt};
}

void add_scenario_jobs(std::vector<Job>& jobs, const CheckPlan& plan, const Study& study, const InForce& gains) {
  for (const StudyCase& study_case : cases_of(study)) {
    for (std::size_t seed = 0; seed < plan.seeds.size(); ++seed) {
      if (study.scenario.kind == ScenarioKind::kTracking) {
        jobs.emplace_back(
            [=, &plan, &study, &gains] { return tracking_outcome(plan, study, study_case, gains, seed); });
      } else {
        jobs.emplace_back([=, &plan, &study] { return driven_outcome(plan, study, study_case, seed); });
      }
    }
  }
}

void add_loop_jobs(std::vector<Job>& jobs, const CheckPlan& plan, const servo_params& params) {
  for (const LoopCase& loop : loop_cases()) {
    for (std::size_t seed = 0; seed < plan.seeds.size(); ++seed) {
      jobs.emplace_back([=, &plan, &params] {
        const LoopFigures found = loop_figures(plan.plant, params, loop, plan.seeds[seed]);
        return Outcome{kLoopScenario, loop.name, seed, found.figures, found.failure};
      });
    }
  }
}

// Figures in the order in which they first appear.
class FigureTable {
 public:
  explicit FigureTable(std::size_t seeds) : seeds_(seeds) {}

  void add(const Outcome& outcome) {
    for (const Figure& figure : outcome.figures) {
      CheckFigure& row = row_of(outcome, figure);
      if (seeds_ == 0) {
        continue;
      }
      row.values[outcome.seed] = figure.value;
      if (!std::isfinite(figure.value) && !row.failure) {
        row.failure = outcome.failure.value_or("the run returned no value");
      }
    }
  }

  std::vector<CheckFigure> take() { return std::move(figures_); }

 private:
  CheckFigure& row_of(const Outcome& outcome, const Figure& figure) {
    const FigureKey key{outcome.scenario, outcome.case_name, axis_name(figure.axis),
                        name_with_unit(figure.metric, figure.unit)};
    const auto [place, is_new] = place_.emplace(key, figures_.size());
    if (is_new) {
      figures_.push_back({key, figure.unit, better_of(key.name),
                          std::vector<double>(seeds_, std::numeric_limits<double>::quiet_NaN()), std::nullopt});
    }
    return figures_[place->second];
  }

  std::size_t seeds_;
  std::vector<CheckFigure> figures_;
  std::map<FigureKey, std::size_t> place_;
};

}  // namespace

void refuse_impossible(const CheckPlan& plan) {
  (void)in_force(plan);
  for (const ScenarioConfig& scenario : plan.scenarios) {
    if (!plan.only_device) {
      continue;
    }
    if (scenario.kind == ScenarioKind::kTracking) {
      throw scenario.lines.error("kind", "tracking needs camera results, which no CiA 402 mode transmits",
                                 "omit the scenario with --image");
    }
    if (scenario.disturbance_amplitude_rad_s > 0.0) {
      throw scenario.lines.error("disturbance_amplitude_deg_s", "the emulated board cannot apply a disturbance torque",
                                 "omit the scenario with --image");
    }
  }
}

std::vector<CheckFigure> figures_of(const CheckPlan& plan) {
  FigureTable table(0);
  for (const LoopCase& loop : plan.only_device ? std::vector<LoopCase>{} : loop_cases()) {
    table.add({kLoopScenario, loop.name, 0, unknown_loop_figures(loop), std::nullopt});
  }
  const InForce gains = in_force(plan);
  for (const ScenarioConfig& scenario : plan.scenarios) {
    const Study study = study_of(plan, scenario, gains);
    for (const StudyCase& study_case : cases_of(study)) {
      table.add({scenario.name, study_case.name, 0, figures_of_trace(plan, study, study_case, {}), std::nullopt});
    }
  }
  return table.take();
}

std::vector<CheckFigure> run_check(const CheckPlan& plan,
                                   const std::function<void(int, int, const std::string&)>& progress) {
  const InForce gains = in_force(plan);
  std::vector<Study> studies;
  for (const ScenarioConfig& scenario : plan.scenarios) {
    studies.push_back(study_of(plan, scenario, gains));
  }
  std::vector<Job> jobs;
  if (!plan.only_device) {
    add_loop_jobs(jobs, plan, gains.params);
  }
  for (const Study& study : studies) {
    add_scenario_jobs(jobs, plan, study, gains);
  }
  std::vector<Outcome> outcomes(jobs.size());
  JobPool pool(plan.threads, static_cast<int>(jobs.size()), progress);
  pool.run(jobs.size(), [&](std::size_t job) {
    outcomes[job] = jobs[job]();
    return fmt::format("{}, {}", outcomes[job].scenario, outcomes[job].case_name);
  });
  FigureTable table(plan.seeds.size());
  for (const Outcome& outcome : outcomes) {
    table.add(outcome);
  }
  return table.take();
}

}  // namespace trackservo::sim
