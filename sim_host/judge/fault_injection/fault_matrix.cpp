// SPDX-License-Identifier: Apache-2.0
#include "judge/fault_injection/fault_matrix.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <mutex>

#include "machine/base/job_pool.hpp"

namespace trackservo::sim {
namespace {

constexpr double kCapacitance_f = 4.7e-3;  // of the bus, when the plant file has none

std::vector<InjectionRunSetup> injection_runs_of(const FaultInjection& fault_injection, const MatrixOptions& options) {
  std::vector<InjectionRunSetup> injection_runs;
  for (const Motion motion : kMotions) {
    for (int axis = 0; axis < kAxes; ++axis) {
      for (int moment = 0; moment < options.moments; ++moment) {
        const std::uint64_t number = injection_runs.size() + 1;
        injection_runs.push_back({&fault_injection, motion, axis, options.seed * 1000000 + number, moment % 2 == 1});
      }
    }
  }
  return injection_runs;
}

std::string broken_promise(const InjectionRunSetup& injection_run, const InjectionRunResult& result) {
  const FaultInjection& fault_injection = *injection_run.fault_injection;
  if (fault_injection.detection == Detection::kTolerated && result.seen == FAULT_NONE) {
    return result.deviation_rad > fault_injection.max_deviation_rad ? "leads the axis away from its set-point" : "";
  }
  const bool long_enough = !fault_injection.lasting || result.visible_ms >= allowed_latency_ms(fault_injection);
  if (result.showed && result.seen == FAULT_NONE && long_enough) {
    return "is not detected";
  }
  if (result.deviation_rad > fault_injection.max_deviation_rad) {
    return fmt::format("is {:.3f} rad away from its set-point", result.deviation_rad);
  }
  const double speed_limit_rad_s = result.speed_before_rad_s + promised_overshoot_rad_s(fault_injection);
  if (result.seen == FAULT_NONE) {
    const bool bounded = fault_injection.max_overshoot_rad_s == 0.0 || result.speed_most_rad_s <= speed_limit_rad_s;
    return bounded ? "" : fmt::format("is not detected at {:.3f} rad/s", result.speed_most_rad_s);
  }
  if (!fault_injection.any_fault && (right_faults(fault_injection) >> result.seen & 1U) == 0) {
    return fmt::format("is detected as fault {}", static_cast<int>(result.seen));
  }
  if (result.latency_ms > allowed_latency_ms(fault_injection)) {
    return fmt::format("is detected after {} ms", result.latency_ms);
  }
  if (!result.reaction_right) {
    return "has a reaction that differs from the table's";
  }
  if (!result.other_axis_right) {
    return "affects the other axis";
  }
  if (result.speed_most_rad_s > speed_limit_rad_s) {
    return fmt::format("reaches {:.3f} rad/s from {:.3f}", result.speed_most_rad_s, result.speed_before_rad_s);
  }
  const auto reaction = static_cast<fault_reaction>(fault_table[result.seen].reaction);
  const double promised_rad = promised_travel_rad(reaction, result.speed_most_rad_s);
  if (injection_run.calm && (result.travel_rad > promised_rad || !result.came_to_rest)) {
    return fmt::format("travels {:.4f} rad from {:.3f} rad/s, but the limit is {:.4f}", result.travel_rad,
                       result.speed_most_rad_s, promised_rad);
  }
  return "";
}

// Of the faults that came after a fault reset.
std::string later_error(const InjectionRunSetup& injection_run, const InjectionRunResult& result, int& good) {
  int number = 2;
  for (const LaterFault& later : result.later) {
    if (later.result == nullptr) {
      return fmt::format("cannot be enabled again before fault {}", number);
    }
    InjectionRunSetup again = injection_run;
    again.fault_injection = later.fault_injection;
    const std::string error =
        later.result->seen == FAULT_NONE ? "is not detected" : broken_promise(again, *later.result);
    if (!error.empty()) {
      return fmt::format("as fault {} of the run, {} {}", number, later.fault_injection->name, error);
    }
    good++;
    number++;
  }
  return static_cast<int>(result.later.size()) == kLaterFaults ? "" : "has no further fault";
}

void add(MatrixRow& row, const InjectionRunSetup& injection_run, const InjectionRunResult& result) {
  row.injection_runs++;
  row.showed += result.showed ? 1 : 0;
  std::string error = broken_promise(injection_run, result);
  if (error.empty()) {
    error = later_error(injection_run, result, row.later_faults);
  }
  if (!error.empty()) {
    row.errors.push_back(fmt::format("{} {}, axis {}, seed {}: {}", row.fault_injection->name,
                                     motion_name(injection_run.motion), injection_run.axis, injection_run.seed, error));
  }
  row.worst_deviation_rad = std::max(row.worst_deviation_rad, result.deviation_rad);
  row.worst_speed_rad_s = std::max(row.worst_speed_rad_s, result.speed_most_rad_s);
  if (result.seen == FAULT_NONE) {
    if (!result.showed) {
      row.hidden[injection_run.motion]++;
    }
    return;
  }
  row.seen++;
  row.taken_for[result.seen]++;
  row.worst_latency_ms = std::max(row.worst_latency_ms, result.latency_ms);
  row.worst_overshoot_rad_s = std::max(row.worst_overshoot_rad_s, result.speed_most_rad_s - result.speed_before_rad_s);
  double& worst_travel_rad = injection_run.calm ? row.worst_travel_rad : row.worst_travel_in_wind_rad;
  worst_travel_rad = std::max(worst_travel_rad, result.travel_rad);
  if (injection_run.calm) {
    const auto reaction = static_cast<fault_reaction>(fault_table[result.seen].reaction);
    row.worst_travel_share =
        std::max(row.worst_travel_share, result.travel_rad / promised_travel_rad(reaction, result.speed_most_rad_s));
  }
}

}  // namespace

double promised_travel_rad(fault_reaction reaction, double speed_rad_s) {
  if (reaction == REACTION_PROTECT) {  // 2060:19 of the tracker's azimuth, and the time in which the current reverses
    return speed_rad_s * 0.01 + speed_rad_s * speed_rad_s / (2.0 * 4.6) + 0.003;
  }
  // Braked by the loop: 6085 = 3 rad/s^2 with its jerk; by friction and the shorted motor, or by friction alone.
  const double deceleration_rad_s2 = reaction == REACTION_STOP ? 2.5 : 0.9;
  const double delay_s = reaction == REACTION_STOP ? 0.06 : 0.01;
  return speed_rad_s * delay_s + speed_rad_s * speed_rad_s / (2.0 * deceleration_rad_s2) + 0.003;
}

double promised_overshoot_rad_s(const FaultInjection& fault_injection) {
  if (fault_injection.max_overshoot_rad_s > 0.0) {
    return fault_injection.max_overshoot_rad_s;
  }
  if (fault_injection.expected == FAULT_OVER_SPEED) {
    return 2.0;  // to 0x2060:1, plus the effect of 300 Nm in three ticks
  }
  return fault_injection.expected == FAULT_RUNAWAY ? 0.5 : 0.25;
}

std::vector<MatrixRow> run_fault_matrix(const PlantConfig& plant, const MatrixOptions& options) {
  PlantConfig machine = plant;
  if (machine.supply.capacitance_f == 0.0) {
    machine.supply.capacitance_f = kCapacitance_f;
  }
  const NodeSetup in_wind(machine);
  NodeSetup calm = in_wind;
  for (AxisConfig& axis : calm.plant.axis) {
    axis.load.wind_mean_nm = 0.0;
    axis.load.wind_gust_rms_nm = 0.0;
  }
  std::vector<const FaultInjection *> injections;
  for (const FaultInjection& one : fault_injections()) {
    const auto wanted = std::find(options.only.begin(), options.only.end(), one.name);
    if (options.only.empty() || wanted != options.only.end()) {
      injections.push_back(&one);
    }
  }
  for (const std::string& name : options.only) {
    (void)fault_injection(name);  // throws if it is unknown
  }
  std::vector<MatrixRow> rows(injections.size());
  JobPool pool(options.threads, static_cast<int>(rows.size()), [](int, int, const std::string&) {});
  pool.run(rows.size(), [&](std::size_t i) {
    rows[i].fault_injection = injections[i];
    for (const InjectionRunSetup& injection_run : injection_runs_of(*injections[i], options)) {
      add(rows[i], injection_run, run_injection_run(injection_run.calm ? calm : in_wind, injection_run));
    }
    return rows[i].fault_injection->name;
  });
  return rows;
}

bool is_as_stated(const MatrixRow& row) {
  return row.errors.empty() == (row.fault_injection->detection != Detection::kNotAlways);
}

bool all_promises_kept(const std::vector<MatrixRow>& rows) {
  return std::all_of(rows.begin(), rows.end(), is_as_stated);
}

namespace {

std::string verdict(const MatrixRow& row) {
  if (row.fault_injection->detection != Detection::kNotAlways) {
    return row.fault_injection->detection == Detection::kTolerated ? "  tolerated" : "";
  }
  return row.errors.empty() ? "  now detected as required: change its row"
                            : fmt::format("  NOT DETECTED AS REQUIRED in {} runs", row.errors.size());
}

}  // namespace

std::string print_fault_matrix(const std::vector<MatrixRow>& rows) {
  std::string text = fmt::format("{:<42} {:>6} {:>7} {:>6} {:>6} {:>5} {:>7} {:>9} {:>7} {:>9} {:>7} {:>8} {:>7}  {}\n",
                                 "fault injection", "runs", "visible", "found", "later", "ms", "allowed", "faster by",
                                 "travel", "of limit", "in wind", "off path", "fastest", "detected as");
  std::string below;
  for (const MatrixRow& row : rows) {
    std::string taken_for;
    for (const auto& [fault, count] : row.taken_for) {
      taken_for += fmt::format("{}{}: {}", taken_for.empty() ? "" : ", ", static_cast<int>(fault), count);
    }
    text += fmt::format(
        "{:<42} {:>6} {:>7} {:>6} {:>6} {:>5} {:>7} {:>9.1f} {:>7.2f} {:>8.0f}% {:>7.2f} {:>8.2f} {:>7.1f}  {}{}\n",
        row.fault_injection->name, row.injection_runs, row.showed, row.seen, row.later_faults, row.worst_latency_ms,
        allowed_latency_ms(*row.fault_injection), row.worst_overshoot_rad_s * kDegPerRad,
        row.worst_travel_rad * kDegPerRad, 100.0 * row.worst_travel_share, row.worst_travel_in_wind_rad * kDegPerRad,
        row.worst_deviation_rad * kDegPerRad, row.worst_speed_rad_s * kDegPerRad, taken_for, verdict(row));
    for (const auto& [motion, count] : row.hidden) {
      below += row.fault_injection->hidden_because.empty()
                   ? ""
                   : fmt::format("{}: no effect in {} injection runs of {}: {}\n", row.fault_injection->name, count,
                                 motion_name(motion), row.fault_injection->hidden_because);
    }
    for (const std::string& error : row.errors) {
      below += error + "\n";
    }
  }
  return text + below;
}

}  // namespace trackservo::sim
