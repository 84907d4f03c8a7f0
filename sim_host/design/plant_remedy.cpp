// SPDX-License-Identifier: Apache-2.0
#include "design/plant_remedy.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "machine/config/plant_keys.hpp"

namespace trackservo::sim {
namespace {

constexpr double kStep = 3.1622776601683795;  // half a decade
constexpr int kMaxSteps = 24;                 // twelve decades: the widest range of a key
constexpr int kMoreSteps = 2;                 // a number that would have to change by another decade is no likely cause
constexpr std::size_t kMaxOfTheMachine = 3;

// A number of the file and access to it.
struct Number {
  std::string key;
  bool is_requirement;
  Unit unit;
  Range range;  // in the file's unit
  std::function<std::optional<double>(const PlantConfig&)> get;
  std::function<void(PlantConfig&, double)> set;
};

// The numbers of one table of the file; `owner` finds its struct in a plant.
template <class Owner, class Find>
void add(std::vector<Number>& numbers, const std::string& table, bool is_requirement, const Keys<Owner>& keys,
         Find owner) {
  for (const Key<Owner>& key : keys) {
    if (key.get && key.text.type == KeyType::kNumber) {
      numbers.push_back(
          {table + key.text.name, is_requirement, key.text.unit, key.text.range,
           [key, owner](const PlantConfig& plant) { return key.get(owner(const_cast<PlantConfig&>(plant))); },
           [key, owner](PlantConfig& plant, double value) { key.set(owner(plant), Value(value)); }});
    }
  }
}

// Everything that a design depends on.
std::vector<Number> numbers_of(const PlantConfig& plant, int axis) {
  const auto i = static_cast<std::size_t>(axis);
  const std::string name = axis_name(axis);
  std::vector<Number> numbers;
  const auto config = [i](PlantConfig& p) -> AxisConfig& { return p.axis[i]; };
  add(numbers, name + ".", false, axis_keys(), config);
  add(numbers, name + ".motor.", false, motor_keys(), [=](PlantConfig& p) -> MotorConfig& { return config(p).motor; });
  add(numbers, name + ".friction.", false, friction_keys(),
      [=](PlantConfig& p) -> FrictionConfig& { return config(p).friction; });
  add(numbers, name + ".friction.positive.", false, stribeck_keys(),
      [=](PlantConfig& p) -> StribeckConfig& { return config(p).friction.positive; });
  add(numbers, name + ".friction.negative.", false, stribeck_keys(),
      [=](PlantConfig& p) -> StribeckConfig& { return config(p).friction.negative; });
  if (plant.axis[i].structure) {
    add(numbers, name + ".structure.", false, structure_keys(),
        [=](PlantConfig& p) -> StructureConfig& { return *config(p).structure; });
  }
  add(numbers, name + ".encoder.", false, encoder_keys(),
      [=](PlantConfig& p) -> EncoderConfig& { return config(p).encoder; });
  add(numbers, name + ".gyro.", false, gyro_keys(), [=](PlantConfig& p) -> GyroConfig& { return config(p).gyro; });
  add(numbers, "design." + name + ".", true, design_keys(),
      [i](PlantConfig& p) -> DesignConfig& { return p.design[i]; });
  return numbers;
}

// One number, changed step by step in one direction.
class Trial {
 public:
  Trial(const PlantConfig& plant, const Number& number, double value, double direction, const IsPossible& is_possible)
      : number_(&number), plant_(plant), value_(value), direction_(direction), is_possible_(&is_possible) {}

  bool is_in_range(double factor) const {
    const double in_file = value_ * factor / number_->unit.in_si;
    return in_file >= number_->range.least && in_file <= number_->range.most;
  }

  bool is_possible_at(double factor) {
    if (!is_in_range(factor)) {
      return false;
    }
    number_->set(plant_, value_ * factor);
    return (*is_possible_)(plant_);
  }

  double factor_of(double steps) const { return std::pow(kStep, direction_ * steps); }

  // The values around `step`, where a design is possible and one step before it is not.
  Remedy remedy(int step) {
    const double near_steps = edge(step - 1.0, step);
    double far_steps = step;
    while (far_steps < kMaxSteps && is_possible_at(factor_of(far_steps + 1.0))) {
      far_steps += 1.0;
    }
    const bool has_far_end = far_steps < kMaxSteps && is_in_range(factor_of(far_steps + 1.0));
    far_steps = has_far_end ? edge(far_steps + 1.0, far_steps) : far_steps;
    const double near = value_ * factor_of(near_steps) / number_->unit.in_si;
    const double far = value_ * factor_of(far_steps) / number_->unit.in_si;
    return {number_->key,           value_ / number_->unit.in_si, std::min(near, far),
            std::max(near, far),    std::pow(kStep, near_steps),  has_far_end,
            number_->is_requirement};
  }

  const std::string& key() const { return number_->key; }

 private:
  // Halves the step between the impossible and the possible value.
  double edge(double not_possible, double possible) {
    for (int halving = 0; halving < 6; ++halving) {
      const double middle = 0.5 * (not_possible + possible);
      (is_possible_at(factor_of(middle)) ? possible : not_possible) = middle;
    }
    return possible;
  }

  const Number *number_;
  PlantConfig plant_;
  double value_;
  double direction_;
  const IsPossible *is_possible_;
};

bool is_enough(const std::vector<Remedy>& found) {
  const auto requirements =
      std::count_if(found.begin(), found.end(), [](const Remedy& remedy) { return remedy.is_requirement; });
  return requirements > 0 && found.size() - static_cast<std::size_t>(requirements) >= kMaxOfTheMachine;
}

// Three digits, towards the inside of the range.
double inwards(double value, bool up) {
  const double digit = std::pow(10.0, std::floor(std::log10(value)) - 2.0);
  return digit * (up ? std::ceil(value / digit - 1e-9) : std::floor(value / digit + 1e-9));
}

std::string range_text(const Remedy& remedy) {
  const double lowest = inwards(remedy.lowest, true);
  const double highest = inwards(remedy.highest, false);
  if (remedy.has_far_end) {
    return fmt::format("{:.4g} to {:.4g}", lowest, highest);
  }
  return remedy.lowest > remedy.value ? fmt::format("at least {:.4g}", lowest) : fmt::format("at most {:.4g}", highest);
}

}  // namespace

std::vector<Remedy> plant_remedies(const PlantConfig& plant, int axis, const IsPossible& is_possible) {
  const std::vector<Number> numbers = numbers_of(plant, axis);
  std::vector<Trial> trials;
  for (const Number& number : numbers) {
    const double value = number.get(plant).value_or(0.0);
    if (value > 0.0) {
      trials.emplace_back(plant, number, value, 1.0, is_possible);
      trials.emplace_back(plant, number, value, -1.0, is_possible);
    }
  }
  std::vector<Remedy> found;
  int last_step = kMaxSteps;
  for (int step = 1; step <= last_step && !is_enough(found); ++step) {
    for (Trial& trial : trials) {
      const auto same = [&](const Remedy& remedy) { return remedy.key == trial.key(); };
      if (std::none_of(found.begin(), found.end(), same) && trial.is_possible_at(trial.factor_of(step))) {
        found.push_back(trial.remedy(step));
        last_step = std::min(last_step, step + kMoreSteps);
      }
    }
  }
  std::stable_sort(found.begin(), found.end(), [](const Remedy& a, const Remedy& b) { return a.change < b.change; });
  return found;
}

std::string other_text(const Remedy& remedy) {
  return fmt::format("{} (now {:.4g}) {}", remedy.key, remedy.value, range_text(remedy));
}

ConfigError design_error(const PlantConfig& plant, int axis, const std::string& reason, const IsPossible& is_possible,
                         const std::string& more) {
  const std::vector<Remedy> remedies = plant_remedies(plant, axis, is_possible);
  if (remedies.empty()) {
    return plant.lines.error(axis_name(axis), reason,
                             "changing a single parameter of the file does not make a controller possible: compare "
                             "inertia, friction, motor and latencies with those of a shipped plant");
  }
  const Remedy& first = remedies.front();
  std::string advice = "give " + range_text(first);
  for (std::size_t i = 1; i < remedies.size(); ++i) {
    advice += ", or " + other_text(remedies[i]);
  }
  return plant.lines.error(first.key, fmt::format("{:.4g} {}", first.value, reason), advice + more);
}

}  // namespace trackservo::sim
