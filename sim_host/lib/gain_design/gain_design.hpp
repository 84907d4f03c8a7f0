// From an identified plant and wishes to all gains of an axis, with the margins that they will have.
//
// A wish is kept exactly or lowered, never silently: the notes say from what to what, and why. First the observer's
// bandwidth is lowered, then the PI's natural frequency together with it, until the loop keeps the margins and the
// torque noise that are asked, sliding and in pre-sliding. What is not wished is chosen as high as these allow; of
// PI and observer the pair with the largest w^2 q, by which the loop divides slow disturbances (w: natural frequency of
// the PI, q: bandwidth of the observer). Where search and not the wish decides, half a decibel and 2 degrees are kept
// in reserve, because a measured margin spreads by as much.
//
// The inertia is taken as constant. Where it varies (azimuth towards the zenith), identify and design where it is
// largest and look at the stability where it is least.
#ifndef TRACKSERVO_GAIN_DESIGN_GAIN_DESIGN_HPP
#define TRACKSERVO_GAIN_DESIGN_GAIN_DESIGN_HPP

#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "gain_design/identified_plant.hpp"
#include "gain_design/margins.hpp"

namespace trackservo::gain_design {

// Ranges are those of wishes.json (gain_wishes_json.cpp); what is absent is chosen by the design.
struct GainWishes {
  std::optional<double> speed_loop_bandwidth_hz;             // of PI alone with set-point weight 1, sliding
  std::optional<double> speed_loop_natural_frequency_rad_s;  // the same in other words; at most one of the two
  double speed_loop_damping = 1.0;
  double setpoint_weight = 0.8;
  std::optional<double> observer_bandwidth_hz;
  LeastMargins least;
  std::optional<double> most_torque_noise_nm;   // rms at standstill; absent: 1 % of the motor's peak torque
  std::optional<double> tracking_bandwidth_hz;  // PI kind: closed loop at -3 dB; predictive kind: crossover
  std::optional<double> position_bandwidth_hz;  // crossover
};

struct GainDesign {
  axis_parameters parameters{};
  Margins sliding;
  Margins pre_sliding;
  double speed_loop_bandwidth_hz = 0.0;  // of PI alone with set-point weight 1, sliding: what the wish means
  double bandwidth_hz = 0.0;             // of the whole speed loop, observer included, with set-point weight 1
  double torque_noise_nm = 0.0;          // rms, from the sensors, the larger one of sliding and standstill
  FrequencyResponse loop_gain;           // sliding
  std::vector<std::string> notes;        // what was lowered, chosen or left, and why
};

// No gains can keep what is asked; the message says what is missing and what would be possible.
class GainDesignError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

// `present`: the parameters of the device, of which sensors, motor, limits of the outer loops and the tracker's kind
// are kept. Throws GainDesignError. Up to a few seconds where much has to be searched.
GainDesign design_gains(const IdentifiedPlant& plant, const GainWishes& wishes, const axis_parameters& present);

}  // namespace trackservo::gain_design

#endif
