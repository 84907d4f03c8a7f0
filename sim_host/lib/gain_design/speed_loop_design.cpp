// SPDX-License-Identifier: Apache-2.0
#include "gain_design/speed_loop_design.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "dictionary/device_description.hpp"
#include "dictionary/refusal_text.hpp"
#include "gain_design/notch.hpp"
#include "gain_design/speed_loop_pi.hpp"

namespace trackservo::gain_design {
namespace {

struct FilterChoice {
  const StructuralMode *notched = nullptr;
  double lowpass_hz = 0.0;  // 0: none
};

struct SpeedLoopChoice {
  FilterChoice filters;
  SpeedLoopRequirement requirement;  // with these filters a requirement in Hz is another natural frequency
  SpeedLoopGains gains;
  double merit = 0.0;  // SpeedLoopSearch::merit
};

axis_parameters with_filters(axis_parameters parameters, const FilterChoice& filters) {
  parameters.filters = dictionary::listed_defaults().filters;
  parameters.filters.lowpass_hz = static_cast<float>(filters.lowpass_hz);
  if (filters.notched != nullptr) {
    const NotchFilter notch = notch_for(*filters.notched);
    parameters.filters.notch_hz = static_cast<float>(notch.frequency_hz);
    parameters.filters.notch_width_hz = static_cast<float>(notch.width_hz);
    parameters.filters.notch_depth = static_cast<float>(notch.depth);
  }
  return parameters;
}

SpeedLoopRequirement requirement_with(const GainRequirements& requirements, const LinearMachine& sliding,
                                      const speed_loop_params& loop) {
  SpeedLoopRequirement requirement;
  requirement.natural_rad_s = requirements.speed_loop_natural_frequency_rad_s;
  if (requirements.speed_loop_bandwidth_hz) {
    requirement.natural_rad_s = natural_frequency_rad_s(sliding, loop, *requirements.speed_loop_bandwidth_hz,
                                                        requirements.speed_loop_damping.value_or(1.0));
  }
  if (requirements.observer_bandwidth_hz) {
    requirement.observer_rad_s = *requirements.observer_bandwidth_hz / kHzPerRad_s;
  }
  requirement.damping = requirements.speed_loop_damping;
  return requirement;
}

bool is_required(const SpeedLoopChoice& choice) {
  const auto kept = [](const std::optional<double>& required, double got) { return !required || *required == got; };
  return kept(choice.requirement.natural_rad_s, choice.gains.natural_rad_s) &&
         kept(choice.requirement.observer_rad_s, choice.gains.observer_rad_s);
}

// Tries filters from none to many; more filters must bring a tenth more rejection.
class FilterSearch {
 public:
  FilterSearch(const GainRequirements& requirements, const SpeedLoopDemand& demand, const axis_parameters& parameters)
      : requirements_(requirements), demand_(demand), parameters_(parameters) {}

  std::optional<SpeedLoopChoice> run(const StructuralMode *mode) {
    constexpr double kLowpasses_hz[] = {400.0, 300.0, 200.0, 150.0, 100.0};
    attempt({nullptr, 0.0});
    if (mode != nullptr) {
      attempt({mode, 0.0});
    }
    for (const double lowpass_hz : kLowpasses_hz) {
      if (noise_refused_) {
        attempt({nullptr, lowpass_hz});
      }
      if (noise_refused_ && mode != nullptr) {
        attempt({mode, lowpass_hz});
      }
    }
    return best_;
  }

  // A faster loop was good except for its torque noise.
  bool noise_refused() const { return noise_refused_; }

  // Why nothing was found, or not the required values.
  std::string error(const FilterChoice& filters, bool slowest) const {
    const speed_loop_params loop = built(with_filters(parameters_, filters)).speed;
    const SpeedLoopRequirement requirement = requirement_with(requirements_, demand_.machines.front(), loop);
    const SpeedLoopSearch search(demand_, loop, requirement);
    SpeedLoopGains gains = search.slowest();
    if (!slowest) {
      gains.natural_rad_s = *requirement.natural_rad_s;
      gains.observer_rad_s = *requirement.observer_rad_s;
    }
    const SpeedLoopVerdict verdict = search.judge(gains);
    if (!verdict.stable) {
      return "the loop is unstable";
    }
    return fmt::format(
        "the loop has {:.1f} dB, {:.0f} deg and a torque noise of {:.2g} Nm, but {:g} dB, {:g} deg and at most {:.2g} "
        "Nm are required",
        verdict.margins.gain_margin_db, verdict.margins.phase_margin_deg, verdict.torque_noise_nm,
        demand_.least.gain_margin_db, demand_.least.phase_margin_deg, demand_.max_torque_noise_nm);
  }

 private:
  void attempt(const FilterChoice& filters) {
    const double kWorthwhile = std::log(1.1);
    if (best_ && requirements_are_complete() && is_required(*best_)) {
      return;
    }
    servo_axis_params device{};
    const axis_parameters parameters = with_filters(parameters_, filters);
    if (axis_parameters_build(&parameters, &device) != CONTROL_OK) {
      return;  // the resonance is outside the range of the firmware's notch
    }
    SpeedLoopChoice choice{filters, requirement_with(requirements_, demand_.machines.front(), device.speed), {}, 0.0};
    SpeedLoopSearch search(demand_, device.speed, choice.requirement);
    const std::optional<SpeedLoopGains> gains = search.best();
    noise_refused_ = noise_refused_ || search.noise_refused();
    if (!gains) {
      return;
    }
    choice.gains = *gains;
    choice.merit = search.merit(*gains);
    if (!best_ || is_required(choice) > is_required(*best_) ||
        (is_required(choice) == is_required(*best_) && choice.merit > best_->merit + kWorthwhile)) {
      best_ = choice;
    }
  }

  bool requirements_are_complete() const {
    return requirements_.observer_bandwidth_hz &&
           (requirements_.speed_loop_bandwidth_hz || requirements_.speed_loop_natural_frequency_rad_s);
  }

  const GainRequirements& requirements_;
  const SpeedLoopDemand& demand_;
  const axis_parameters& parameters_;
  std::optional<SpeedLoopChoice> best_;
  bool noise_refused_ = false;
};

// A natural frequency in the form of a requirement: the bandwidth of PI alone.
double bandwidth_of(const SpeedLoopDemand& demand, speed_loop_params loop, double natural_rad_s, double damping) {
  loop.pi = pi_params({natural_rad_s, damping, 1.0}, demand.machines.front().inertia_kg_m2);
  return closed_loop_bandwidth_hz(demand.machines.front(), pi_alone(loop));
}

void note_filters(const IdentifiedPlant& plant, const SpeedLoopChoice& choice, std::vector<std::string>& notes) {
  if (choice.filters.notched != nullptr) {
    const NotchFilter notch = notch_for(*choice.filters.notched);
    notes.push_back(fmt::format(
        "Notch at {:.1f} Hz, {:.1f} Hz wide, depth {:.2g}: a resonance is {:.3g} times above the rigid body there.",
        notch.frequency_hz, notch.width_hz, notch.depth, relative_height(*choice.filters.notched)));
  }
  for (const StructuralMode& mode : plant.modes) {
    if (&mode != choice.filters.notched) {
      notes.push_back(fmt::format("No notch for the resonance at {:.1f} Hz: {}.", mode.frequency_rad_s * kHzPerRad_s,
                                  choice.filters.notched == nullptr
                                      ? "the loop keeps its margins without a notch"
                                      : "the device has one notch, and another resonance needs it more"));
    }
  }
  if (choice.filters.lowpass_hz > 0.0) {
    notes.push_back(
        fmt::format("Low-pass at {:g} Hz, for the torque noise of the sensors.", choice.filters.lowpass_hz));
  }
}

void note_observer(const SpeedLoopDemand& demand, const SpeedLoopChoice& choice, std::vector<std::string>& notes) {
  const double got_hz = choice.gains.observer_rad_s * kHzPerRad_s;
  if (!choice.requirement.observer_rad_s && demand.for_least_error) {
    notes.push_back(fmt::format("Observer: {:.3g} Hz.", got_hz));
  } else if (!choice.requirement.observer_rad_s) {
    notes.push_back(fmt::format("Observer: {:.3g} Hz, the highest that margins and torque noise allow.", got_hz));
  } else if (*choice.requirement.observer_rad_s != choice.gains.observer_rad_s) {
    notes.push_back(fmt::format("Observer lowered from {:.3g} Hz to {:.3g} Hz.",
                                *choice.requirement.observer_rad_s * kHzPerRad_s, got_hz));
  }
}

void note_pi(const SpeedLoopDemand& demand, const speed_loop_params& loop, const SpeedLoopChoice& choice,
             const GainRequirements& requirements, std::vector<std::string>& notes) {
  const double got_hz = bandwidth_of(demand, loop, choice.gains.natural_rad_s, choice.gains.damping);
  if (!choice.requirement.natural_rad_s && !choice.requirement.observer_rad_s && demand.for_least_error) {
    notes.push_back(fmt::format(
        "Speed loop with PI alone: {:.3g} Hz with damping {:.2g}; fusion crossover {:.3g} Hz. PI, observer and "
        "crossover "
        "have the least rate error that margins and torque noise allow, also with 30 % less and more inertia.",
        got_hz, choice.gains.damping, choice.gains.crossover_rad_s * kHzPerRad_s));
  } else if (!choice.requirement.natural_rad_s) {
    notes.push_back(
        fmt::format("Speed loop with PI alone: {:.3g} Hz, the highest that margins and torque noise allow.", got_hz));
  } else if (*choice.requirement.natural_rad_s != choice.gains.natural_rad_s) {
    const double required_hz = requirements.speed_loop_bandwidth_hz.value_or(
        bandwidth_of(demand, loop, *choice.requirement.natural_rad_s, choice.gains.damping));
    notes.push_back(fmt::format("Speed loop with PI alone lowered from {:.3g} Hz to {:.3g} Hz.", required_hz, got_hz));
  }
}

}  // namespace

servo_axis_params built(const axis_parameters& parameters) {
  servo_axis_params device{};
  if (axis_parameters_build(&parameters, &device) != CONTROL_OK) {
    throw GainDesignError(fmt::format("the firmware refuses the designed parameters: {}",
                                      dictionary::refusal_of(parameters).value_or("")));
  }
  return device;
}

void design_speed_loop(const IdentifiedPlant& plant, const GainRequirements& requirements,
                       const SpeedLoopDemand& demand, axis_parameters& parameters, std::vector<std::string>& notes) {
  FilterSearch search(requirements, demand, parameters);
  const std::optional<SpeedLoopChoice> choice = search.run(dominant_mode(plant.modes));
  if (!choice) {
    throw GainDesignError(
        fmt::format("no gains meet the requirements: even with the slowest ones tried {}; require less margin or allow "
                    "more torque noise",
                    search.error({}, true)));
  }
  parameters = with_filters(parameters, choice->filters);
  const PiRequirement pi{choice->gains.natural_rad_s, choice->gains.damping,
                         static_cast<double>(parameters.speed_loop.setpoint_weight)};
  set_pi(parameters, pi_params(pi, plant.inertia_kg_m2));
  parameters.observer.bandwidth_rad_s = static_cast<float>(choice->gains.observer_rad_s);
  parameters.sensors.crossover_rad_s = static_cast<float>(choice->gains.crossover_rad_s);
  note_filters(plant, *choice, notes);
  const speed_loop_params loop = built(parameters).speed;
  note_pi(demand, loop, *choice, requirements, notes);
  note_observer(demand, *choice, notes);
  if (search.noise_refused()) {
    notes.push_back(
        fmt::format("A faster loop, or one with fewer filters, keeps the margins but has more torque noise "
                    "than {:.2g} Nm.",
                    demand.max_torque_noise_nm));
  }
  if (!is_required(*choice) && choice->requirement.natural_rad_s && choice->requirement.observer_rad_s) {
    notes.push_back("With the required values, " + search.error(choice->filters, false) + ".");
  }
}

}  // namespace trackservo::gain_design
