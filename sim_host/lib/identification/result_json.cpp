// SPDX-License-Identifier: Apache-2.0
#include "identification/result_json.hpp"

#include <fmt/format.h>

#include <cmath>

#include "identification/resonances.hpp"
#include "identification/window.hpp"

namespace trackservo::identification {

namespace {

using Json = nlohmann::ordered_json;

// A refused value is null, so that nobody uses it by mistake. Its interval shows how little is known.
Json json_of(const Parameter& parameter) {
  Json json;
  json["value"] = parameter.refused.empty() ? Json(parameter.value) : Json(nullptr);
  json["unit"] = parameter.unit;
  json["interval_95"] = {parameter.interval.low, parameter.interval.high};
  json["paper_method"] = parameter.paper;
  json["start"] = parameter.start;
  return json;
}

Json coefficient(const std::string& term, const JointFit& fit, Eigen::Index index) {
  const double reach = kInterval_deviations * fit.deviation(index);
  return {{"term", term},
          {"value", fit.parameters[index]},
          {"interval_95", {fit.parameters[index] - reach, fit.parameters[index] + reach}}};
}

const char *basis_name(PositionBasis basis) {
  switch (basis) {
    case PositionBasis::kTurn:
      return "turn";
    case PositionBasis::kTravel:
      return "travel";
    case PositionBasis::kNone:
      break;
  }
  return "none";
}

Json rough_json(const RoughMachine& rough) {
  return {{"coulomb_nm", rough.coulomb_nm},
          {"bristle_rad", rough.bristle_rad},
          {"stribeck_rad_s", rough.stribeck_rad_s},
          {"inertia_kg_m2", rough.inertia_kg_m2}};
}

Json position_json(const Identification& result) {
  const PositionTerms& terms = result.position_terms;
  Json json;
  json["basis"] = basis_name(terms.basis());
  json["travel_rad"] = {terms.lowest_rad(), terms.highest_rad()};
  Json map = Json::array();
  Json load = Json::array();
  const Eigen::Index first_load = kFixedParameters + terms.count();
  load.push_back(coefficient("1", result.fit, first_load));
  for (int term = 0; term < terms.count(); ++term) {
    map.push_back(coefficient(terms.name(term), result.fit, kFixedParameters + term));
    load.push_back(coefficient(terms.name(term), result.fit, first_load + 1 + term));
  }
  json["friction_level"] = map;
  json["load_nm"] = load;
  return json;
}

Json harmonics_json(const Identification& result) {
  Json json = Json::array();
  Eigen::Index index = kFixedParameters + 2 * result.position_terms.count() + 1;
  for (const MotorHarmonic& harmonic : result.harmonics) {
    json.push_back({{"per_turn", harmonic.per_turn},
                    {"kind", harmonic.ripple ? "ripple" : "cogging_nm"},
                    {"cosine", result.fit.parameters[index]},
                    {"sine", result.fit.parameters[index + 1]}});
    index += 2;
  }
  return json;
}

Json noise_json(const Identification& result) {
  const NoiseModel& noise = result.fit.noise;
  return {{"residual_rms_nm", result.residual_rms_nm},
          {"innovation_nm", noise.innovation_nm()},
          {"step_s", kHalfWindow_s},
          {"autoregression", std::vector<double>(noise.coefficients().begin(), noise.coefficients().end())},
          {"weighed_down_percent", 100.0 * (result.fit.weights.array() < 1.0).cast<double>().mean()}};
}

Json checks_json(const Identification& result) {
  return {{"converged", result.fit.converged},
          {"rounds", result.fit.rounds},
          {"largest_correlation_of_whitened", result.largest_correlation},
          {"widening_by_clusters", result.fit.widening},
          {"damping_ratio", result.damping_ratio},
          {"damping_ratio_of_the_paper", kPaperDampingRatio},
          {"damping_by_eq_15_nm_s_rad", result.eq15_damping_nm_s_rad},
          {"motion_cutoff_hz", result.motion_cutoff_hz},
          {"angle_noise_rad", result.motion.angle_noise_rad},
          {"encoder_noise_rad", result.motion.encoder_noise_rad},
          {"delay_s", result.fit.parameters[kDelay]},
          {"spread_s2", result.fit.parameters[kSpread]},
          {"gyro",
           {{"used", result.motion.gyro.fitted},
            {"quick_motion", result.motion.fused},
            {"scale_error", result.motion.gyro.scale_error},
            {"delay_s", result.motion.gyro.delay_s},
            {"noise_rad_s", result.motion.gyro.noise_rad_s}}},
          {"octaves_of_speed", {result.evidence.speeds[0], result.evidence.speeds[1]}},
          {"turns", result.evidence.turns},
          {"inertial_torque_beside_coulomb", result.evidence.inertial_share}};
}

Json response_json(const AxisResponse& response) {
  Json magnitude = Json::array();
  Json phase_rad = Json::array();
  for (const std::complex<double>& gain : response.gain) {
    magnitude.push_back(std::abs(gain));
    phase_rad.push_back(std::arg(gain));
  }
  return {{"frequency_hz", response.frequency_hz},
          {"magnitude", magnitude},
          {"phase_rad", phase_rad},
          {"coherence", response.coherence}};
}

// None when the inertia is not known: there is no rigid body to compare with.
std::vector<gain_design::StructuralMode> resonances(const Identification& result, const AxisResponse& response) {
  const Parameter& inertia = result.parameter("inertia");
  if (!inertia.refused.empty()) {
    return {};
  }
  const double viscous_nm_s_rad =
      0.5 * (result.parameter("viscous_positive").value + result.parameter("viscous_negative").value);
  return find_resonances(response, {inertia.value, viscous_nm_s_rad, result.fit.parameters[kDelay]});
}

Json resonances_json(const std::vector<gain_design::StructuralMode>& modes) {
  Json json = Json::array();
  for (const gain_design::StructuralMode& mode : modes) {
    json.push_back({{"frequency_hz", mode.frequency_rad_s / (2.0 * M_PI)},
                    {"damping", mode.damping},
                    {"relative_height", gain_design::relative_height(mode)},
                    {"share", mode.share}});
  }
  return json;
}

Json warnings_json(const std::vector<gain_design::StructuralMode>& modes) {
  Json json = Json::array();
  for (const gain_design::StructuralMode& mode : modes) {
    json.push_back(
        fmt::format("There is a resonance at {:.1f} Hz, but friction was fitted to a rigid axis: the errors of "
                    "break-away torque, Stribeck speed and viscous friction may exceed their intervals.",
                    mode.frequency_rad_s / (2.0 * M_PI)));
  }
  return json;
}

}  // namespace

Json to_json(const Identification& result, const Recording& recording, const Recording& structure) {
  Json json;
  json["format"] = "trackservo-identification";
  json["version"] = 1;
  json["recorded_s"] = static_cast<double>(recording.ticks()) * kTick_s;
  json["runs"] = recording.run.back() - recording.run.front() + 1;
  json["complete"] = result.complete();
  for (const Parameter& parameter : result.parameters) {
    json["parameters"][parameter.name] = json_of(parameter);
  }
  json["coulomb_mean"] = json_of(result.coulomb_mean);
  json["refused"] = Json::array();
  for (const Parameter& parameter : result.parameters) {
    if (!parameter.refused.empty()) {
      json["refused"].push_back({{"parameter", parameter.name}, {"message", parameter.refused}});
    }
  }
  json["rough"] = rough_json(result.rough);
  json["position"] = position_json(result);
  json["motor_harmonics"] = harmonics_json(result);
  json["noise"] = noise_json(result);
  json["checks"] = checks_json(result);
  const AxisResponse response = axis_response(structure.ticks() > 0 ? structure : recording);
  json["frequency_response"] = response_json(response);
  const std::vector<gain_design::StructuralMode> modes = resonances(result, response);
  json["resonances"] = resonances_json(modes);
  json["warnings"] = warnings_json(modes);
  json["paper_method_missing"] = result.paper.missing;
  return json;
}

void write_residuals(std::ostream& out, const Identification& result, const Recording& recording) {
  out << "time_s,run,kind,joint_angle_rad,joint_rate_rad_s,torque_nm,residual_nm,whitened,weight\n";
  for (const Span& span : result.fit.spans) {
    for (Eigen::Index node = span.first; node < span.last; ++node) {
      const std::size_t i = result.node_ticks[static_cast<std::size_t>(node)];
      out << fmt::format("{:.3f},{},{},{:.9g},{:.6g},{:.6g},{:.6g},{:.6g},{:.4g}\n", recording.time_s[i],
                         recording.run[i], static_cast<int>(recording.kind[i]), recording.joint_angle_rad[i],
                         result.motion.joint_rate_rad_s[i], recording.torque_nm[i], result.fit.residual_nm[node],
                         result.fit.whitened[node], result.fit.weights[node]);
    }
  }
}

}  // namespace trackservo::identification
