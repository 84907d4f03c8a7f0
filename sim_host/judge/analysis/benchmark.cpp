// SPDX-License-Identifier: Apache-2.0
#include "judge/analysis/benchmark.hpp"

#include <algorithm>
#include <ctime>
#include <limits>

#include "design/control_design.hpp"
#include "machine/plant/tracker.hpp"
#include "machine/run/scenario_run.hpp"

namespace trackservo::sim {
namespace {

// Processor time of this thread: other load on the machine does not count.
double cpu_seconds() {
  timespec time{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

template <typename Work>
double best_seconds(int repeats, Work work) {
  double best = std::numeric_limits<double>::infinity();
  for (int i = 0; i < repeats; ++i) {
    const double start_s = cpu_seconds();
    work();
    best = std::min(best, cpu_seconds() - start_s);
  }
  return best;
}

// Samples of a slowly turning axis with a little noise, so that no branch is always taken.
servo_samples samples_at(int tick) {
  servo_samples samples{};
  for (servo_axis_samples& axis : samples.axis) {
    axis.sensors.joint_angle_turn32 = static_cast<angle_turn32>(tick) * 2386U + static_cast<angle_turn32>(tick % 7);
    axis.sensors.gyro_rad_s = 0.0035F + 1e-5F * static_cast<float>(tick % 5);
    axis.sensors.gyro_valid = true;
  }
  servo_samples_complete(&samples);
  return samples;
}

}  // namespace

BenchmarkFigures run_benchmark(const PlantConfig& plant, const ScenarioConfig& scenario, int repeats) {
  const servo_params params = design_controller(plant, controller_spec("pi_vob_ftc"), {});
  BenchmarkFigures figures{};
  const double speed_rad_s = scenario.speeds_rad_s.empty() ? 0.0 : scenario.speeds_rad_s.front();
  const double run_s = best_seconds(repeats, [&] { run_scenario({&plant, &scenario, speed_rad_s, params, 1}); });
  figures.real_time_factor = scenario.duration_s / run_s;

  constexpr int kTicks = 200000;
  servo_app app{};
  const servo_samples start = samples_at(0);
  servo_app_configure(&app, &params, &start);
  servo_command command{};
  for (servo_axis_command& axis : command.axis) {
    axis.mode = SERVO_SPEED;
    axis.speed.rate_rad_s = 0.0035F;
  }
  figures.tick_ns = 1e9 / kTicks * best_seconds(repeats, [&] {
                      for (int tick = 0; tick < kTicks; ++tick) {
                        const servo_samples samples = samples_at(tick);
                        servo_app_tick(&app, &command, &samples);
                      }
                    });
  motor_stage motor{};
  motor_stage_reset(&motor);
  motor_stage_hand_over(&motor, {true, 1.0F, 0.0035F}, &params.axis[SERVO_AZIMUTH].current);
  volatile float duty = 0.0F;
  figures.pwm_ns =
      1e9 / kTicks * best_seconds(repeats, [&] {
        for (int period = 0; period < kTicks; ++period) {
          duty = motor_stage_step(&motor, SERVO_TICK_LATENCY_PERIODS, 0.01F * static_cast<float>(period % 9), 48.0F);
        }
      });
  Tracker tracker(plant, 1);
  figures.plant_pwm_ns = 1e9 / kTicks * best_seconds(repeats, [&] {
                           for (int period = 0; period < kTicks; ++period) {
                             if (period % kPwmPerTick == 0) {
                               tracker.sample_tick();
                             }
                             tracker.sample_pwm(kAzimuth);
                             tracker.sample_pwm(kPitch);
                             tracker.step_pwm({0.05, 0.05});
                           }
                         });
  return figures;
}

}  // namespace trackservo::sim
