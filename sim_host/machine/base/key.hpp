// SPDX-License-Identifier: Apache-2.0
// Description of one key of a configuration file: name, unit, range, default, meaning, and the destination of its
// value.
//
// The tables made of these (beside each sensor model, in plant_keys.cpp and in load_scenario.cpp) are the only
// description of the keys. The reader takes types and ranges from them; the reference pages are printed from them.
#ifndef TRACKSERVO_SIM_BASE_KEY_HPP
#define TRACKSERVO_SIM_BASE_KEY_HPP

#include <algorithm>
#include <array>
#include <functional>
#include <optional>
#include <string>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>

#include "machine/base/axis.hpp"

namespace trackservo::sim {

// A unit as used in key names, and its size in SI.
struct Unit {
  const char *text;
  double in_si;
};

namespace unit {
constexpr Unit kNone{"-", 1.0};
constexpr Unit kPercent{"%", 0.01};
constexpr Unit kPpm{"ppm", 1e-6};
constexpr Unit kDegree{"deg", kRadPerDeg};
constexpr Unit kDegreePerSecond{"deg/s", kRadPerDeg};
constexpr Unit kDegreePerSecondRootHertz{"deg/s/sqrt(Hz)", kRadPerDeg};
constexpr Unit kMicroradian{"urad", 1e-6};
constexpr Unit kKilogramSquareMetre{"kg m2", 1.0};
constexpr Unit kNewtonMetre{"Nm", 1.0};
constexpr Unit kNewtonMetrePerRadian{"Nm/rad", 1.0};
constexpr Unit kNewtonMetreSecondPerRadian{"Nm s/rad", 1.0};
constexpr Unit kNewtonMetrePerAmpere{"Nm/A", 1.0};
constexpr Unit kVoltSecondPerRadian{"V s/rad", 1.0};
constexpr Unit kPerNewtonMetre{"1/Nm", 1.0};
constexpr Unit kPerKelvin{"1/K", 1.0};
constexpr Unit kPerSecond{"1/s", 1.0};
constexpr Unit kRadianPerSecond{"rad/s", 1.0};
constexpr Unit kKelvin{"K", 1.0};
constexpr Unit kHertz{"Hz", 1.0};
constexpr Unit kSecond{"s", 1.0};
constexpr Unit kMillisecond{"ms", 1e-3};
constexpr Unit kMicrosecond{"us", 1e-6};
constexpr Unit kOhm{"ohm", 1.0};
constexpr Unit kMillihenry{"mH", 1e-3};
constexpr Unit kMillifarad{"mF", 1e-3};
constexpr Unit kAmpere{"A", 1.0};
constexpr Unit kVolt{"V", 1.0};
constexpr Unit kMetre{"m", 1.0};
constexpr Unit kMetrePerSecond{"m/s", 1.0};
constexpr Unit kMetrePerSecondSquared{"m/s2", 1.0};
constexpr Unit kPixel{"px", 1.0};
}  // namespace unit

// Inclusive, in the file's unit.
struct Range {
  double least;
  double most;
};

enum class KeyType { kNumber, kInteger, kText, kChoice, kList, kThreeNumbers };

// A value as read and checked: numbers in SI, a choice as its index.
using Value = std::variant<double, int, std::string, std::vector<double>>;

// A key without its destination; enough for the reader's checks and the reference page.
struct KeyText {
  std::string name;
  KeyType type = KeyType::kNumber;
  Unit unit = unit::kNone;
  Range range{0, 0};
  std::string meaning;
  std::vector<std::string> choices;  // in the order of the enumeration
  std::optional<double> fallback;    // in the file's unit, or a choice's index; without it the key is required ...
  bool optional = false;             // ... unless this says that it may be absent
};

// A key and how its value is stored in an `Owner`.
template <class Owner>
struct Key {
  KeyText text;
  std::function<void(Owner&, const Value&)> set;
  std::function<std::optional<double>(const Owner&)> get;  // of a number, in SI; none where it is absent

  // Makes the key optional, with this value [file's unit; of a choice its index].
  Key or_else(double value) const {
    Key copy = *this;
    copy.text.fallback = value;
    copy.text.optional = true;
    return copy;
  }

  // Makes the key optional; when absent the member is unchanged.
  Key or_absent() const {
    Key copy = *this;
    copy.text.optional = true;
    return copy;
  }
};

template <class Owner>
using Keys = std::vector<Key<Owner>>;

// Returns the key of a number or numbers; the member's type (double, int, list, three numbers) says which.
template <class Owner, class Member>
Key<Owner> number(std::string name, Unit unit, Range range, Member Owner::*member, std::string meaning) {
  KeyText text{std::move(name), KeyType::kNumber, unit, range, std::move(meaning), {}, std::nullopt, false};
  if constexpr (std::is_same_v<Member, int>) {
    text.type = KeyType::kInteger;
    return {text, [member](Owner& owner, const Value& value) { owner.*member = std::get<int>(value); },
            [member](const Owner& owner) { return std::optional<double>(owner.*member); }};
  } else if constexpr (std::is_same_v<Member, std::vector<double>>) {
    text.type = KeyType::kList;
    return {
        text, [member](Owner& owner, const Value& value) { owner.*member = std::get<std::vector<double>>(value); }, {}};
  } else if constexpr (std::is_same_v<Member, std::array<double, 3>>) {
    text.type = KeyType::kThreeNumbers;
    return {text,
            [member](Owner& owner, const Value& value) {
              const auto& list = std::get<std::vector<double>>(value);
              owner.*member = {list.at(0), list.at(1), list.at(2)};
            },
            {}};
  } else {
    return {text, [member](Owner& owner, const Value& value) { owner.*member = std::get<double>(value); },
            [member](const Owner& owner) { return std::optional<double>(owner.*member); }};
  }
}

template <class Owner>
Key<Owner> words(std::string name, std::string Owner::*member, std::string meaning) {
  return {KeyText{std::move(name), KeyType::kText, unit::kNone, {0, 0}, std::move(meaning), {}, std::nullopt, false},
          [member](Owner& owner, const Value& value) { owner.*member = std::get<std::string>(value); },
          {}};
}

// Returns the key of one of several words; the member is an enumeration in the same order, from 0.
template <class Owner, class Enum>
Key<Owner> choice(std::string name, std::vector<std::string> choices, Enum Owner::*member, std::string meaning) {
  return {KeyText{std::move(name),
                  KeyType::kChoice,
                  unit::kNone,
                  {0, 0},
                  std::move(meaning),
                  std::move(choices),
                  std::nullopt,
                  false},
          [member](Owner& owner, const Value& value) { owner.*member = static_cast<Enum>(std::get<int>(value)); },
          {}};
}

// Returns whether a table of these keys may be absent.
template <class Owner>
bool all_optional(const Keys<Owner>& keys) {
  return std::all_of(keys.begin(), keys.end(), [](const Key<Owner>& key) { return key.text.optional; });
}

// One table of a file, for the reference page.
struct Section {
  std::string heading;  // "[azimuth.motor], [pitch.motor]"
  std::string note;
  std::vector<KeyText> keys;
};

template <class Owner>
std::vector<KeyText> texts_of(const Keys<Owner>& keys) {
  std::vector<KeyText> texts;
  for (const Key<Owner>& key : keys) {
    texts.push_back(key.text);
  }
  return texts;
}

// Returns a page: title, what the reader gets, contents, and for each section a heading, the note, and a row per key.
std::string sections_markdown(const std::string& title, const std::string& opening,
                              const std::vector<Section>& sections);

// Returns "0.1 .. 20 A", "one of `a`, `b`", ...: the allowed values.
std::string allowed_text(const KeyText& key);

}  // namespace trackservo::sim

#endif
