// SPDX-License-Identifier: Apache-2.0
#include "studies/random_plants/random_plants_report.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>
#include <numeric>
#include <stdexcept>

#include "judge/analysis/statistics.hpp"
#include "machine/base/json_file.hpp"
#include "studies/random_plants/random_plant.hpp"

namespace trackservo::sim {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::size_t kWorst = 10;
constexpr std::size_t kInfluences = 5;
constexpr std::size_t kPrintedFailed = 20;

// One value of every plant.
template <class Value>
std::vector<double> over_plants(const RandomPlants& tried, Value value) {
  std::vector<double> values;
  for (const TriedPlant& plant : tried.plants) {
    values.push_back(value(plant));
  }
  return values;
}

int count(const std::vector<double>& values, double limit) {
  return static_cast<int>(std::count_if(values.begin(), values.end(), [&](double v) { return v > limit; }));
}

ErrorDistribution distribution(const RandomPlants& tried, std::size_t axis, std::size_t speed) {
  const std::vector<double> errors =
      over_plants(tried, [&](const TriedPlant& plant) { return plant.axis[axis].peak_error_deg_s[speed]; });
  return {tried.cases[speed],     tried.paper_deg_s[speed], median(errors),
          quantile(errors, 0.95), quantile(errors, 1.0),    count(errors, tried.paper_deg_s[speed])};
}

std::vector<Deviation> deviations(const RandomPlants& tried, std::uint64_t seed) {
  return random_plant(tried.nominal, tried.share, seed).deviations;
}

// Correlation of every number of the plant with the ratios of both axes in one pass over the plants, because all their
// deviations take 10 kB per plant. The factors' mean is near 1, so their sums lose no digits.
class InfluenceSums {
 public:
  explicit InfluenceSums(const RandomPlants& tried) {
    for (std::size_t axis = 0; axis < kAxes; ++axis) {
      ratios_[axis] =
          over_plants(tried, [&](const TriedPlant& plant) { return worst_ratio(plant.axis[axis], tried.paper_deg_s); });
      mean_ratio_[axis] = mean(ratios_[axis]);
    }
    for (std::size_t i = 0; i < tried.plants.size(); ++i) {
      add(deviations(tried, tried.plants[i].seed), i);
    }
  }

  // The strongest first.
  std::vector<Influence> of(std::size_t axis) const {
    std::vector<Influence> all;
    for (const Sum& sum : sums_) {
      all.push_back({sum.key, correlation_of(sum, axis)});
    }
    std::sort(all.begin(), all.end(),
              [](const Influence& a, const Influence& b) { return std::abs(a.correlation) > std::abs(b.correlation); });
    all.resize(std::min(all.size(), kInfluences));
    return all;
  }

 private:
  // Over all plants, of the factor minus 1.
  struct Sum {
    std::string key;
    double deviation = 0;
    double square = 0;
    std::array<double, kAxes> product{};  // with the ratio minus its mean
  };

  void add(const std::vector<Deviation>& deviations, std::size_t plant) {
    sums_.resize(deviations.size());
    for (std::size_t i = 0; i < deviations.size(); ++i) {
      Sum& sum = sums_[i];
      sum.key = deviations[i].key;
      const double deviation = deviations[i].factor - 1.0;
      sum.deviation += deviation;
      sum.square += deviation * deviation;
      for (std::size_t axis = 0; axis < kAxes; ++axis) {
        sum.product[axis] += deviation * (ratios_[axis][plant] - mean_ratio_[axis]);
      }
    }
  }

  double correlation_of(const Sum& sum, std::size_t axis) const {
    const auto plants = static_cast<double>(ratios_[axis].size());
    const double spread = std::sqrt(std::max(0.0, sum.square - sum.deviation * sum.deviation / plants) * (plants - 1)) *
                          standard_deviation(ratios_[axis]);
    return spread > 0.0 ? sum.product[axis] / spread : 0.0;
  }

  std::array<std::vector<double>, kAxes> ratios_;
  std::array<double, kAxes> mean_ratio_{};
  std::vector<Sum> sums_;
};

AxisSummary summary_of(const RandomPlants& tried, std::size_t axis) {
  const auto of = [&](auto value) {
    return over_plants(tried, [&](const TriedPlant& plant) { return value(plant.axis[axis]); });
  };
  AxisSummary summary;
  for (std::size_t speed = 0; speed < tried.cases.size(); ++speed) {
    summary.errors.push_back(distribution(tried, axis, speed));
  }
  summary.above_paper = count(of([&](const TriedAxis& a) { return worst_ratio(a, tried.paper_deg_s); }), 1.0);
  summary.unstable = count(of([](const TriedAxis& a) { return a.stable ? 0.0 : 1.0; }), 0.5);
  summary.unstable_at_zenith = count(of([](const TriedAxis& a) { return a.stable_at_zenith ? 0.0 : 1.0; }), 0.5);
  summary.min_gain_margin_db = quantile(of([](const TriedAxis& a) { return a.gain_margin_db; }), 0.0);
  summary.min_phase_margin_deg = quantile(of([](const TriedAxis& a) { return a.phase_margin_deg; }), 0.0);
  summary.max_ripple_share = quantile(of([](const TriedAxis& a) { return a.max_ripple_share; }), 1.0);
  return summary;
}

std::vector<std::size_t> worst_of(const RandomPlants& tried) {
  const std::vector<double> ratios =
      over_plants(tried, [&](const TriedPlant& plant) { return worst_ratio(plant.axis[kAzimuth], tried.paper_deg_s); });
  std::vector<std::size_t> order(tried.plants.size());
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return ratios[a] > ratios[b]; });
  order.resize(std::min(order.size(), kWorst));
  return order;
}

bool fails(const TriedPlant& plant, const std::vector<double>& paper_deg_s) {
  const auto stable = [](const TriedAxis& axis) { return axis.stable; };
  return !std::all_of(plant.axis.begin(), plant.axis.end(), stable) ||
         worst_ratio(plant.axis[kAzimuth], paper_deg_s) > 1.0;
}

bool is_above_paper(const TriedPlant& plant, const std::vector<double>& paper_deg_s) {
  return std::any_of(plant.axis.begin(), plant.axis.end(),
                     [&](const TriedAxis& axis) { return worst_ratio(axis, paper_deg_s) > 1.0; });
}

double factor_of(const std::vector<Deviation>& deviations, const std::string& key) {
  const auto found = std::find_if(deviations.begin(), deviations.end(),
                                  [&](const Deviation& deviation) { return deviation.key == key; });
  return found->factor;
}

void print(const AxisSummary& summary, int axis, std::size_t plants) {
  fmt::print("{}: unstable {} of {} (with the cabin at the zenith, computed: {})\n", axis_name(axis), summary.unstable,
             plants, summary.unstable_at_zenith);
  fmt::print("  smallest margins {:.1f} dB, {:.0f} deg; largest ripple {:.2g} % of the motor's torque\n",
             summary.min_gain_margin_db, summary.min_phase_margin_deg, 100 * summary.max_ripple_share);
  fmt::print("  peak error, deg/s      median   95 %      largest  paper    above the paper's\n");
  for (const ErrorDistribution& error : summary.errors) {
    fmt::print("  {:<22} {:<8.5f} {:<9.5f} {:<8.5f} {:<8g} {} of {}\n", error.case_name, error.median,
               error.percentile_95, error.largest, error.paper, error.above_paper, plants);
  }
  fmt::print("  correlation of the worst ratio to the paper with the parameters:");
  for (const Influence& influence : summary.influences) {
    fmt::print(" {} {:+.2f}", influence.key, influence.correlation);
  }
  fmt::print("\n");
}

void print_worst(const RandomPlants& tried, const RandomPlantsSummary& summary) {
  fmt::print("worst plants of azimuth: seed, largest ratio to the paper's error, factors\n");
  for (const std::size_t i : summary.worst) {
    const TriedPlant& plant = tried.plants[i];
    fmt::print("  {:<5} {:.3f}", plant.seed, worst_ratio(plant.axis[kAzimuth], tried.paper_deg_s));
    const std::vector<Deviation> all = deviations(tried, plant.seed);
    for (const Influence& influence : summary.axis[kAzimuth].influences) {
      fmt::print("  {} {:.2f}", influence.key, factor_of(all, influence.key));
    }
    fmt::print("\n");
  }
}

void print_failed(const RandomPlants& tried) {
  if (tried.failed.empty()) {
    return;
  }
  fmt::print("plants without result: {}, in no other line counted\n", tried.failed.size());
  for (std::size_t i = 0; i < std::min(tried.failed.size(), kPrintedFailed); ++i) {
    fmt::print("  {:<5} {}\n", tried.failed[i].seed, tried.failed[i].reason);
  }
}

Json number(double value) { return std::isfinite(value) ? Json(value) : Json(nullptr); }

Json json_of(const AxisSummary& summary) {
  Json json{{"above_paper", summary.above_paper},
            {"unstable", summary.unstable},
            {"unstable_at_zenith", summary.unstable_at_zenith},
            {"least_gain_margin_db", number(summary.min_gain_margin_db)},
            {"least_phase_margin_deg", number(summary.min_phase_margin_deg)},
            {"most_ripple_share", summary.max_ripple_share},
            {"errors", Json::array()},
            {"influences", Json::array()}};
  for (const ErrorDistribution& error : summary.errors) {
    json["errors"].push_back({{"case", error.case_name},
                              {"unit", "deg/s"},
                              {"paper", number(error.paper)},
                              {"median", error.median},
                              {"percentile_95", error.percentile_95},
                              {"largest", error.largest},
                              {"above_paper", error.above_paper}});
  }
  for (const Influence& influence : summary.influences) {
    json["influences"].push_back({{"key", influence.key}, {"correlation", influence.correlation}});
  }
  return json;
}

Json json_of(const TriedPlant& plant, const RandomPlants& tried, const RandomPlantsSummary& summary) {
  Json json{{"seed", plant.seed},
            {"ratio", worst_ratio(plant.axis[kAzimuth], tried.paper_deg_s)},
            {"factors", Json::object()}};
  const std::vector<Deviation> all = deviations(tried, plant.seed);
  for (const Influence& influence : summary.axis[kAzimuth].influences) {
    json["factors"][influence.key] = factor_of(all, influence.key);
  }
  return json;
}

std::string csv_head(const RandomPlants& tried) {
  std::string head = "seed";
  for (int axis = 0; axis < kAxes; ++axis) {
    for (const std::string& case_name : tried.cases) {
      head += fmt::format(",{} peak_error at {} [deg/s]", axis_name(axis), case_name);
    }
    head += fmt::format(",{0} stable,{0} gain_margin_db,{0} phase_margin_deg,{0} stable at zenith", axis_name(axis));
  }
  for (const Deviation& deviation : deviations(tried, tried.seed)) {
    head += "," + deviation.key;
  }
  return head;
}

std::string csv_line(const TriedPlant& plant, const std::vector<Deviation>& deviations) {
  std::string line = fmt::format("{}", plant.seed);
  for (const TriedAxis& axis : plant.axis) {
    for (const double error : axis.peak_error_deg_s) {
      line += fmt::format(",{:.6g}", error);
    }
    line += fmt::format(",{:d},{:.4g},{:.4g},{:d}", axis.stable, axis.gain_margin_db, axis.phase_margin_deg,
                        axis.stable_at_zenith);
  }
  for (const Deviation& deviation : deviations) {
    line += fmt::format(",{:.4f}", deviation.factor);
  }
  return line;
}

}  // namespace

RandomPlantsSummary summary_of(const RandomPlants& tried) {
  if (tried.plants.empty()) {
    throw std::runtime_error(
        fmt::format("no plant has a result; seed {}: {}", tried.failed.front().seed, tried.failed.front().reason));
  }
  RandomPlantsSummary summary;
  const InfluenceSums influences(tried);
  for (std::size_t axis = 0; axis < kAxes; ++axis) {
    summary.axis[axis] = summary_of(tried, axis);
    summary.axis[axis].influences = influences.of(axis);
  }
  summary.failing =
      static_cast<int>(std::count_if(tried.plants.begin(), tried.plants.end(),
                                     [&](const TriedPlant& plant) { return fails(plant, tried.paper_deg_s); }));
  summary.above_paper =
      static_cast<int>(std::count_if(tried.plants.begin(), tried.plants.end(), [&](const TriedPlant& plant) {
        return is_above_paper(plant, tried.paper_deg_s);
      }));
  summary.worst = worst_of(tried);
  return summary;
}

void print(const RandomPlants& tried, const RandomPlantsSummary& summary) {
  fmt::print(
      "{} plants like {}, {} parameters off by up to {:g} %, seeds {} to {}; PI + VOB + FTC as for the nominal plant\n",
      tried.plants.size(), tried.nominal.name, deviations(tried, tried.seed).size(), 100 * tried.share, tried.seed,
      tried.seed + (tried.plants.size() + tried.failed.size() - 1));
  for (int axis = 0; axis < kAxes; ++axis) {
    print(summary.axis[static_cast<std::size_t>(axis)], axis, tried.plants.size());
  }
  print_worst(tried, summary);
  print_failed(tried);
  fmt::print("failing (an axis unstable, or azimuth above the paper's error at any speed): {} of {}\n", summary.failing,
             tried.plants.size());
  fmt::print("above the paper's error at any speed: azimuth {}, pitch {}, one of them {}\n",
             summary.axis[kAzimuth].above_paper, summary.axis[kPitch].above_paper, summary.above_paper);
}

void write_random_plants(const RandomPlants& tried, const RandomPlantsSummary& summary, const std::string& git,
                         const std::filesystem::path& folder) {
  Json json;
  json["generator"] = {{"program", "sim_host random-plants"},
                       {"git", git},
                       {"plant", tried.nominal.name},
                       {"plants", tried.plants.size()},
                       {"seed", tried.seed},
                       {"share", tried.share},
                       {"numbers", deviations(tried, tried.seed).size()}};
  json["failing"] = summary.failing;
  json["above_paper"] = summary.above_paper;
  for (std::size_t axis = 0; axis < kAxes; ++axis) {
    json[axis_name(static_cast<int>(axis))] = json_of(summary.axis[axis]);
  }
  json["worst"] = Json::array();
  for (const std::size_t i : summary.worst) {
    json["worst"].push_back(json_of(tried.plants[i], tried, summary));
  }
  json["without_result"] = Json::array();
  for (const FailedPlant& plant : tried.failed) {
    json["without_result"].push_back({{"seed", plant.seed}, {"reason", plant.reason}});
  }
  write_json(json, folder / "random_plants.json");

  const std::filesystem::path csv = folder / "random_plants.csv";
  std::ofstream stream(csv);
  stream << csv_head(tried) << '\n';
  for (const TriedPlant& plant : tried.plants) {
    stream << csv_line(plant, deviations(tried, plant.seed)) << '\n';
  }
  if (!stream.flush()) {
    throw std::runtime_error(fmt::format("{}: cannot be written; is the disk full?", csv.string()));
  }
}

}  // namespace trackservo::sim
