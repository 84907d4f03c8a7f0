// SPDX-License-Identifier: Apache-2.0
// From an identified plant and requirements to all gains of an axis, with their predicted margins.
//
// A requirement is met exactly or lowered, never silently: the notes say from what to what, and why. First the
// observer's bandwidth is lowered, then the PI's natural frequency together with it, until the loop meets the required
// margins and torque noise, sliding and in pre-sliding. Values that are not required are chosen as high as these allow:
// of PI and observer the pair with the largest w^2 q, by which the loop divides slow disturbances (w: natural frequency
// of the PI, q: bandwidth of the observer). With `least_rate_error`, a known disturbance and neither PI nor observer
// required, PI with its damping, observer and fusion crossover are those with the least predicted rate error, and the
// margins hold also with 30 % less and more inertia. Where the search and not the requirement decides, half a decibel
// and 2 degrees are kept in reserve, because a measured margin scatters by as much.
//
// The inertia is taken as constant. Where it varies (azimuth towards the zenith), identify and design where it is
// largest and check the stability where it is smallest.
#ifndef TRACKSERVO_GAIN_DESIGN_GAIN_DESIGN_HPP
#define TRACKSERVO_GAIN_DESIGN_GAIN_DESIGN_HPP

#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "gain_design/identified_plant.hpp"
#include "gain_design/margins.hpp"
#include "gain_design/rate_error_bound.hpp"

namespace trackservo::gain_design {

// Ranges are those of wishes.json (gain_requirements_json.cpp); the design chooses what is absent.
struct GainRequirements {
  std::optional<double> speed_loop_bandwidth_hz;             // of PI alone with set-point weight 1, sliding
  std::optional<double> speed_loop_natural_frequency_rad_s;  // the same in another form; at most one of the two
  std::optional<double> speed_loop_damping;
  std::optional<double> setpoint_weight;    // absent: 1 with a set-point model, else 0.8
  std::optional<double> setpoint_model_hz;  // 0: none; absent: 64 Hz for the least rate error, else 0
  std::optional<double> observer_bandwidth_hz;
  std::optional<Disturbance> disturbance;  // absent: that of the identification
  bool least_rate_error = false;           // with this disturbance; otherwise as fast as possible
  MinMargins least;
  std::optional<double> max_torque_noise_nm;    // rms at standstill; absent: 1 % of the motor's peak torque
  std::optional<double> tracking_bandwidth_hz;  // PI kind: closed loop at -3 dB; predictive kind: crossover
  std::optional<double> position_bandwidth_hz;  // crossover
};

struct GainDesign {
  axis_parameters parameters{};
  Margins sliding;
  Margins pre_sliding;
  double speed_loop_bandwidth_hz = 0.0;  // of PI alone with set-point weight 1, sliding: the meaning of the requirement
  double bandwidth_hz = 0.0;             // of the whole speed loop, observer included, with set-point weight 1
  double torque_noise_nm = 0.0;          // rms, from the sensors, the larger one of sliding and standstill
  std::optional<RateError> rate_error;   // sliding; if the disturbance is known
  std::optional<RateErrorBound> bound;   // of any linear controller with no higher a sensitivity; likewise
  FrequencyResponse loop_gain;           // sliding
  std::vector<std::string> notes;        // what was lowered, chosen or omitted, and why
};

// No gains can meet the requirements; the message says what is missing and what would be possible.
class GainDesignError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

// Designs the gains. `present`: the parameters of the device; sensors, motor, limits of the outer loops and the
// tracker's kind are taken from them. Throws GainDesignError. Takes up to a few seconds for a long search.
GainDesign design_gains(const IdentifiedPlant& plant, const GainRequirements& requirements,
                        const axis_parameters& present);

}  // namespace trackservo::gain_design

#endif
