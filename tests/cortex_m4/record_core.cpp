// SPDX-License-Identifier: Apache-2.0
// record_core FOLDER: runs 20 s of each experiment with speeds, both axes with everything on, and writes inputs and
// outputs of the servo core as FOLDER/EXPERIMENT.trace, for replay_core on another machine.
//
// The linker redirects four functions to this program (--wrap), so the simulator runs unchanged.
#include <array>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <fstream>
#include <stdexcept>
#include <string>
#include <vector>

#include "cortex_m4/core_trace.h"
#include "studies/shared/study.hpp"

namespace sim = trackservo::sim;

namespace {

constexpr double kDuration_s = 20.0;

std::vector<std::uint32_t> words;
std::array<float, SERVO_AXES> duties;  // that were set last

std::uint32_t append(void *, const char *, std::uint32_t value) {
  words.push_back(value);
  return value;
}

const trace_visitor kWriter = {append, nullptr};

void begin(trace_event event) { trace_visit_event(&kWriter, &event); }

}  // namespace

extern "C" {

control_status __real_servo_app_configure(servo_app *app, const servo_params *params, const servo_samples *samples);
void __real_servo_app_tick(servo_app *app, const servo_command *command, const servo_samples *samples);
void __real_servo_board_pwm_period(servo_board *board, uint32_t period);
void __real_hal_set_duty(hal *machine, int axis, float duty);

control_status __wrap_servo_app_configure(servo_app *app, const servo_params *params, const servo_samples *samples) {
  servo_params copy = *params;
  servo_samples start = *samples;
  begin(TRACE_CONFIGURE);
  trace_visit_params(&kWriter, &copy);
  trace_visit_samples(&kWriter, &start);
  return __real_servo_app_configure(app, params, samples);
}

void __wrap_servo_app_tick(servo_app *app, const servo_command *command, const servo_samples *samples) {
  servo_command wanted = *command;
  servo_samples seen = *samples;
  begin(TRACE_TICK);
  trace_visit_command(&kWriter, &wanted);
  trace_visit_samples(&kWriter, &seen);
  __real_servo_app_tick(app, command, samples);
  for (int i = 0; i < SERVO_AXES; ++i) {
    trace_visit_tick_results(&kWriter, &seen.axis[i], &app->axis[i]);
  }
}

void __wrap_hal_set_duty(hal *machine, int axis, float duty) {
  duties[static_cast<std::size_t>(axis)] = duty;
  __real_hal_set_duty(machine, axis, duty);
}

void __wrap_servo_board_pwm_period(servo_board *board, uint32_t period) {
  trace_period read = {
      period, {hal_current_a(board->machine, 0), hal_current_a(board->machine, 1)}, hal_bus_voltage_v(board->machine)};
  begin(TRACE_PWM);
  trace_visit_period(&kWriter, &read);
  __real_servo_board_pwm_period(board, period);
  for (float& duty : duties) {
    trace_visit_duty(&kWriter, &duty);
  }
}
}

namespace {

void record(sim::Study study, const std::filesystem::path& folder) {
  study.scenario.duration_s = kDuration_s;
  words.clear();
  sim::RunChoice choice;
  choice.controller = &sim::controller_spec("pi_vob_ftc");
  sim::run_case(study, sim::cases_of(study).front(), choice);
  begin(TRACE_END);
  const std::filesystem::path file = folder / (study.experiment + ".trace");
  std::ofstream out(file, std::ios::binary);
  out.write(reinterpret_cast<const char *>(words.data()), static_cast<std::streamsize>(4 * words.size()));
  if (!out.flush()) {
    throw std::runtime_error("cannot write " + file.string());
  }
  std::printf("%s: %zu words\n", file.string().c_str(), words.size());
}

sim::Study study_of(const std::string& experiment) {
  sim::Study study;
  study.experiment = experiment;
  study.plant = sim::load_plant("sim_host/plants/tracker.toml");
  study.scenario = sim::load_scenario("sim_host/scenarios/" + experiment + ".toml");
  return study;
}

}  // namespace

int main(int argc, char **argv) {
  if (argc != 2) {
    std::fprintf(stderr, "Usage: record_core FOLDER\n");
    return 2;
  }
  try {
    std::filesystem::create_directories(argv[1]);
    for (const char *experiment : {"sine", "steady_speed", "low_speed_start", "step_disturbed"}) {
      record(study_of(experiment), argv[1]);
    }
  } catch (const std::exception& error) {
    std::fprintf(stderr, "record_core: %s\n", error.what());
    return 1;
  }
  return 0;
}
