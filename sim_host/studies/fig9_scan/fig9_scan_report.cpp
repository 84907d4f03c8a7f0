#include "studies/fig9_scan/fig9_scan_report.hpp"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "base/json_file.hpp"

namespace trackservo::sim {
namespace {

using Json = nlohmann::ordered_json;

const char *name_of(Fig9Disturbance disturbance) { return disturbance == Fig9Disturbance::kSpeed ? "speed" : "torque"; }

std::string words(const Fig9Outcome& outcome) {
  const Fig9Set& set = outcome.set;
  return fmt::format(
      "{:.1f} % with friction, {:.1f} % without: {:+.1f} points, x {:.2f}\n"
      "    Tc {:.2f} Nm, Ts {:.2f} Nm, Stribeck speed {:.2f} deg/s, PI of {:.2f} rad/s, damping {:.2f}, set-point "
      "weight "
      "{:g}, disturbance as {} from {:.0f} deg on; sine +-{:.3f} deg/s",
      outcome.overshoot, outcome.free_overshoot, outcome.points(), outcome.ratio(), set.coulomb_nm,
      set.breakaway_share * set.coulomb_nm, set.stribeck_speed_deg_s, set.natural_frequency_rad_s, set.damping,
      set.setpoint_weight, name_of(set.disturbance), set.disturbance_phase_rad * kDegPerRad, outcome.sine_error_deg_s);
}

Json json_of(const Fig9Outcome& outcome) {
  const Fig9Set& set = outcome.set;
  return {{"coulomb_nm", set.coulomb_nm},
          {"breakaway_nm", set.breakaway_share * set.coulomb_nm},
          {"stribeck_speed_deg_s", set.stribeck_speed_deg_s},
          {"natural_frequency_rad_s", set.natural_frequency_rad_s},
          {"damping", set.damping},
          {"setpoint_weight", set.setpoint_weight},
          {"disturbance", name_of(set.disturbance)},
          {"disturbance_phase_deg", set.disturbance_phase_rad * kDegPerRad},
          {"sine_error_deg_s", outcome.sine_error_deg_s},
          {"overshoot_percent", outcome.overshoot},
          {"free_overshoot_percent", outcome.free_overshoot}};
}

}  // namespace

void print(const Fig9Setup& setup, const Fig9Summary& summary) {
  fmt::print(
      "{} random sets with the published J, sigma0, sigma1, sigma2, seed {}; {} reproduce the sine of Fig. 7 ({:g} to "
      "{:g} deg/s)\n",
      setup.samples, setup.seed, summary.matching, kFig7Low_deg_s, kFig7High_deg_s);
  fmt::print(
      "Read as percentage points: {} of these overshoot by at least {:g} points more than without friction; the "
      "largest is\n  {}\n",
      summary.matching_points, setup.paper.points, words(summary.max_points));
  fmt::print(
      "Read as a ratio: {} of these overshoot at least {:g} times as far as without friction; the closest is\n  {}\n",
      summary.matching_ratio, setup.paper.ratio, words(summary.nearest_ratio));
  fmt::print("Without the condition of Fig. 7, {} of all sets reach {:g} points.\n", summary.any_points,
             setup.paper.points);
}

void write_fig9_scan(const Fig9Setup& setup, const std::vector<Fig9Outcome>& outcomes, const Fig9Summary& summary,
                     const std::string& git, const std::filesystem::path& folder) {
  Json json;
  json["generator"] = {
      {"program", "sim_host fig9-scan"}, {"git", git}, {"samples", setup.samples}, {"seed", setup.seed}};
  json["fig7_deg_s"] = {kFig7Low_deg_s, kFig7High_deg_s};
  json["paper"] = {{"points", setup.paper.points}, {"ratio", setup.paper.ratio}};
  json["least_free_overshoot_percent"] = kMinFreeOvershoot;
  json["matching"] = summary.matching;
  json["matching_points"] = summary.matching_points;
  json["matching_ratio"] = summary.matching_ratio;
  json["most_points"] = json_of(summary.max_points);
  json["nearest_ratio"] = json_of(summary.nearest_ratio);
  json["most_ratio"] = json_of(summary.max_ratio);
  json["any_points"] = summary.any_points;
  json["any_most_points"] = summary.any_most_points;
  json["sets"] = Json::array();
  for (const Fig9Outcome& outcome : outcomes) {
    if (outcome.matches_fig7()) {
      json["sets"].push_back(json_of(outcome));
    }
  }
  write_json(json, folder / "fig9_scan.json");
}

}  // namespace trackservo::sim
