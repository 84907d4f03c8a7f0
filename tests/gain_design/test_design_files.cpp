// SPDX-License-Identifier: Apache-2.0
// The files of identify design: an error in one is named, with its remedy.
#include <functional>

#include "dictionary/device_description.hpp"
#include "gain_design/design_bench.hpp"
#include "gain_design/design_json.hpp"
#include "gain_design/device_parameters.hpp"
#include "gain_design/gain_requirements_json.hpp"
#include "gain_design/identified_plant_json.hpp"

extern "C" {
#include "parameters/axis_dictionary.h"
}

extern "C" void setUp(void) {}
extern "C" void tearDown(void) {}

namespace {

using namespace design_bench;
using Json = nlohmann::json;

std::string error_of(const std::function<void()>& read) {
  try {
    read();
  } catch (const InputFileError& error) {
    return error.what();
  }
  return "";
}

void check_says(const std::string& text, const std::string& part) {
  TEST_ASSERT_TRUE_MESSAGE(text.find(part) != std::string::npos, (part + " in: " + text).c_str());
}

// As servoctl reads them from a device with its defaults.
InputFile device_file() {
  InputFile file{"parameters.json", Json::object()};
  for (std::uint32_t i = 0; i < axis_parameters_table.count; ++i) {
    const od_entry& entry = axis_parameters_table.entries[i];
    if (entry.index <= 0x205F && entry.access == OD_RW) {
      char key[16];
      (void)std::snprintf(key, sizeof key, "0x%04X:%d", entry.index, entry.sub);
      file.json[key] = trackservo::dictionary::json_number(entry, entry.preset);
    }
  }
  return file;
}

void test_parameters_are_read_by_index_and_written_with_before_and_value() {
  const InputFile file = device_file();
  const axis_parameters before = read_device_parameters(file);
  CHECK_SAME("kp", 720.0, before.speed_loop.proportional_nm_s_rad);
  CHECK_SAME("source", 2, before.sensors.source);
  CHECK_SAME("current limit", 16.0, before.motor.current_limit_a);
  axis_parameters after = before;
  after.observer.bandwidth_rad_s = 0.1F;
  const auto rows = parameter_rows(before, after);
  int changed = 0;
  for (const auto& row : rows) {
    if (row["before"] != row["value"]) {
      TEST_ASSERT_EQUAL_STRING("0x2020", row["index"].get<std::string>().c_str());
      TEST_ASSERT_EQUAL(4, row["sub"].get<int>());
      TEST_ASSERT_EQUAL_STRING("rad/s", row["unit"].get<std::string>().c_str());
      TEST_ASSERT_EQUAL_STRING("0.1", row["value"].dump().c_str());
      ++changed;
    }
  }
  TEST_ASSERT_EQUAL(1, changed);
  TEST_ASSERT_EQUAL(6 + 3 + 6 + 5 + 14 + 5 + 9, rows.size());
}

void test_wrong_parameters_are_named() {
  const auto said = [](const std::string& key, const Json& value) {
    InputFile file = device_file();
    file.json[key] = value;
    return error_of([&] { read_device_parameters(file); });
  };
  check_says(said("0x2050:3", 17),
             "parameters.json: \"0x2050:3\" (Rate estimator window) is 17; give a number from 2 to 16");
  check_says(said("0x2050:3", 2.5), "is 2.5; give a number from 2 to 16");
  check_says(said("0x2000:1", "720"), "(Speed loop proportional gain) is \"720\"; give a number from 0.0 to 1000000.0");
  check_says(said("0x2000:1", -1.0), "is -1.0; give");
  check_says(said("0x2060:1", 1.0), "\"0x2060:1\" is not a parameter of an axis");
  TEST_ASSERT_EQUAL_STRING("", said("0x2000:0", 5).c_str());
  InputFile file = device_file();
  file.json.erase("0x2055:6");
  check_says(error_of([&] { read_device_parameters(file); }), "\"0x2055:6\" (Current limit) is missing");
}

InputFile result_file() {
  InputFile file{"result.json", {{"format", "trackservo-identification"}, {"version", 1}, {"refused", Json::array()}}};
  for (const char *direction : {"positive", "negative"}) {
    const std::string end = direction;
    file.json["parameters"]["coulomb_" + end]["value"] = 6.0;
    file.json["parameters"]["breakaway_" + end]["value"] = 9.0;
    file.json["parameters"]["stribeck_speed_" + end]["value"] = 5e-3;
    file.json["parameters"]["viscous_" + end]["value"] = 8.0;
  }
  file.json["parameters"]["stiffness"]["value"] = 30000.0;
  file.json["parameters"]["damping"]["value"] = 300.0;
  file.json["parameters"]["inertia"]["value"] = 6.0;
  file.json["checks"] = {{"delay_s", 70e-6},
                         {"encoder_noise_rad", 5e-8},
                         {"gyro", {{"used", true}, {"delay_s", 466e-6}, {"noise_rad_s", 8e-5}}}};
  return file;
}

void test_numbers_that_no_float_can_hold_are_named() {
  check_says(error_of([] { parse_input_file("wishes.json", "{\"setpoint_weight\": 9E339}"); }),
             "wishes.json:1: [json.exception.out_of_range.406] number overflow");
  InputFile device = device_file();
  device.json["0x2000:1"] = 1e300;
  check_says(error_of([&] { read_device_parameters(device); }), "is 1e+300; give a number from 0.0 to 1000000.0");
  InputFile result = result_file();
  result.json["parameters"]["viscous_negative"]["value"] = -1e300;
  check_says(error_of([&] { read_identified_plant(result); }),
             "\"parameters/viscous_negative/value\" is -1e+300, outside the range of all machines");
}

void test_a_result_of_another_shape_is_refused() {
  const auto said = [](const char *text) {
    return error_of([&] { read_identified_plant(parse_input_file("result.json", text)); });
  };
  check_says(said("{\"format\": 1}"), "result.json: [json.exception.type_error.302]");
  for (const char *version : {"[]", "2", "1.5", "6e119", "\"1\""}) {  // the fourth once became an int, undefined
    const std::string text = std::string("{\"format\": \"trackservo-identification\", \"version\": ") + version + "}";
    check_says(said(text.c_str()), "is not a trackservo-identification of version 1");
  }
  InputFile file = result_file();
  file.json["parameters"]["inertia"]["value"] = nullptr;
  file.json["refused"] = 7;
  check_says(error_of([&] { read_identified_plant(file); }), "result.json: [json.exception.type_error");
}

void test_wrong_requirements_are_named() {
  const auto said = [](const Json& json) { return error_of([&] { read_gain_requirements({"wishes.json", json}); }); };
  check_says(said({{"bandwidth_hz", 30}}),
             "wishes.json: unknown requirement \"bandwidth_hz\"; choose one of speed_loop_bandwidth_hz,");
  check_says(said({{"setpoint_weight", 1.5}}), "\"setpoint_weight\" is 1.5; give a number from 0 to 1");
  check_says(said({{"observer_bandwidth_hz", "30"}}), "\"observer_bandwidth_hz\" is \"30\"; give a number");
  check_says(said({{"speed_loop_damping", nullptr}}), "\"speed_loop_damping\" is null; give a number");
  check_says(said({{"disturbance_rms_nm", 3.6}}),
             "wishes.json: a disturbance needs both \"disturbance_rms_nm\" and \"disturbance_corner_hz\"");
  check_says(said({{"least_rate_error", 1}}), "\"least_rate_error\" is 1; give true or false");
  const GainRequirements requirements =
      read_gain_requirements({"w", {{"least_phase_margin_deg", 55}, {"position_bandwidth_hz", 2.5}}});
  CHECK_SAME("phase margin", 55.0, requirements.least.phase_margin_deg);
  CHECK_SAME("gain margin", 6.0, requirements.least.gain_margin_db);
  CHECK_SAME("position", 2.5, requirements.position_bandwidth_hz.value());
  TEST_ASSERT_FALSE(requirements.speed_loop_bandwidth_hz.has_value());
}

void test_measured_delays_decide() {
  InputFile file = result_file();
  const IdentifiedPlant plant = read_identified_plant(file);
  CHECK_NEAR("encoder", 95e-6, plant.encoder.latency_s, 1e-9);
  CHECK_NEAR("gyro: latency and low-pass", 95e-6 + 466e-6, plant.gyro.latency_s + 0.5 / M_PI / plant.gyro.bandwidth_hz,
             1e-9);
  CHECK_SAME("gyro's assumed low-pass", kAssumedGyroBandwidth_hz, plant.gyro.bandwidth_hz);
  file.json["checks"]["gyro"]["delay_s"] = 100e-6;  // faster than the assumed low-pass alone
  const IdentifiedPlant fast = read_identified_plant(file);
  CHECK_SAME("latency", 0.0, fast.gyro.latency_s);
  CHECK_NEAR("low-pass", 195e-6, 0.5 / M_PI / fast.gyro.bandwidth_hz, 1e-9);
}

void test_resonances_are_taken_over() {
  InputFile file = result_file();
  file.json["resonances"] = {{{"frequency_hz", 90.0}, {"damping", 0.02}, {"relative_height", 10.8}, {"share", 0.43}}};
  const IdentifiedPlant plant = read_identified_plant(file);
  TEST_ASSERT_EQUAL(1, plant.modes.size());
  CHECK_NEAR("height", 10.8, relative_height(plant.modes.front()), 0.05);
}

void test_a_refused_parameter_names_the_missing_run() {
  InputFile file = result_file();
  file.json["parameters"]["stiffness"]["value"] = nullptr;
  file.json["refused"] = {{{"parameter", "stiffness"}, {"message", "stiffness: add hysteresis loops (kind 3)"}}};
  const std::string text = error_of([&] { read_identified_plant(file); });
  check_says(text, "result.json: the gain design needs parameters that the identification refused");
  check_says(text, "stiffness: add hysteresis loops (kind 3)");
}

void test_another_file_is_refused() {
  check_says(error_of([] {
               read_identified_plant({"result.json", Json::object()});
             }),
             "result.json: is not a trackservo-identification of version 1");
  InputFile file = result_file();
  file.json["checks"].erase("delay_s");
  check_says(error_of([&] { read_identified_plant(file); }), "\"checks/delay_s\" is missing or not a number");
  check_says(error_of([] { load_input_file("nowhere/wishes.json"); }), "nowhere/wishes.json:1: cannot be read");
}

void test_the_design_says_all_that_servoctl_reads() {
  const axis_parameters before = read_device_parameters(device_file());
  const GainDesign design = design_gains(read_identified_plant(result_file()), {}, before);
  const auto json = to_json(design, before);
  TEST_ASSERT_EQUAL_STRING("trackservo-design", json.at("format").get<std::string>().c_str());
  TEST_ASSERT_EQUAL(1, json.at("version").get<int>());
  for (const char *key : {"gain_margin_db", "phase_margin_deg", "crossover_hz", "bandwidth_hz", "torque_noise_nm"}) {
    CHECK_AT_LEAST(key, 1e-6, json.at("predicted").at(key).get<double>());
  }
  CHECK_NEAR("at rest", design.pre_sliding.phase_margin_deg,
             json.at("predicted").at("pre_sliding").at("phase_margin_deg").get<double>(), 1e-9);
  const std::size_t points = json.at("loop_gain").at("frequency_hz").size();
  CHECK_AT_LEAST("points of the loop gain", 100, points);
  TEST_ASSERT_EQUAL(points, json.at("loop_gain").at("real").size());
  TEST_ASSERT_EQUAL(points, json.at("loop_gain").at("imag").size());
  TEST_ASSERT_EQUAL(design.notes.size(), json.at("notes").size());
}

}  // namespace

int main() {
  UNITY_BEGIN();
  RUN_TEST(test_parameters_are_read_by_index_and_written_with_before_and_value);
  RUN_TEST(test_wrong_parameters_are_named);
  RUN_TEST(test_numbers_that_no_float_can_hold_are_named);
  RUN_TEST(test_a_result_of_another_shape_is_refused);
  RUN_TEST(test_wrong_requirements_are_named);
  RUN_TEST(test_measured_delays_decide);
  RUN_TEST(test_resonances_are_taken_over);
  RUN_TEST(test_a_refused_parameter_names_the_missing_run);
  RUN_TEST(test_another_file_is_refused);
  RUN_TEST(test_the_design_says_all_that_servoctl_reads);
  return UNITY_END();
}
