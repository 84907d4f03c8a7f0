// SPDX-License-Identifier: Apache-2.0
// Shipped plants, the device's previous gains, and loops measured on the simulated machine.
#ifndef TRACKSERVO_TESTS_GAIN_DESIGN_DESIGN_BENCH_HPP
#define TRACKSERVO_TESTS_GAIN_DESIGN_DESIGN_BENCH_HPP

#include <algorithm>
#include <string>

#include "design/control_design.hpp"
#include "design/frequency_measurement.hpp"
#include "design/true_plant.hpp"
#include "gain_design/gain_design.hpp"
#include "support/bench.hpp"
#include "support/check.h"

namespace design_bench {

namespace sim = trackservo::sim;
using namespace trackservo::gain_design;

inline axis_parameters present(const sim::PlantConfig& plant, int axis) {
  return sim::design_axis(plant, axis, sim::controller_spec("pi_vob_ftc"), {1, 0.0, TRACKER_PI, {}});
}

// Both axes of the device have their present parameters, except `axis`.
inline servo_params params_with(const sim::PlantConfig& plant, int axis, const axis_parameters& designed) {
  servo_params params{};
  for (int i = 0; i < sim::kAxes; ++i) {
    const axis_parameters parameters = i == axis ? designed : present(plant, i);
    CHECK_STATUS(CONTROL_OK, axis_parameters_build(&parameters, &params.axis[i]));
  }
  return params;
}

// As on the machine: a multisine while the axis turns at 2 deg/s, or rests, from a quarter of the crossover to beyond
// the frequency of the gain margin.
inline FrequencyResponse measured(const sim::PlantConfig& plant, int axis, const axis_parameters& designed,
                                  const Margins& predicted, bool pre_sliding) {
  const double coulomb_nm = plant.axis[static_cast<std::size_t>(axis)].friction.positive.coulomb_nm;
  sim::MeasurementRequest request;
  request.plant = &plant;
  request.params = params_with(plant, axis, designed);
  request.axis = axis;
  request.bias_rate_rad_s = pre_sliding ? 0.0 : 2.0 * bench::kRadPerDeg;
  request.torque_rms_nm = (pre_sliding ? 0.2 : 1.0) * coulomb_nm;
  request.first_hz = 0.25 * predicted.crossover_hz;
  request.last_hz = std::min(450.0, std::max(10.0 * predicted.crossover_hz, 1.3 * predicted.phase_crossover_hz));
  return sim::measured_loop_gain(request);
}

// The machine's measurement matches the prediction, sliding and at rest.
inline void expect_as_predicted(const sim::PlantConfig& plant, int axis, const GainDesign& design) {
  for (const bool pre_sliding : {false, true}) {
    const Margins& predicted = pre_sliding ? design.pre_sliding : design.sliding;
    const Margins found = margins_of(measured(plant, axis, design.parameters, predicted, pre_sliding));
    CHECK_NEAR(pre_sliding ? "gain margin at rest" : "gain margin sliding", predicted.gain_margin_db,
               found.gain_margin_db, 1.0);
    CHECK_NEAR(pre_sliding ? "phase margin at rest" : "phase margin sliding", predicted.phase_margin_deg,
               found.phase_margin_deg, 4.0);
  }
}

inline bool mentions(const std::vector<std::string>& notes, const std::string& part) {
  return std::any_of(notes.begin(), notes.end(),
                     [&](const std::string& note) { return note.find(part) != std::string::npos; });
}

}  // namespace design_bench

#endif
