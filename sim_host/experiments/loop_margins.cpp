#include "experiments/loop_margins.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

namespace trackservo::sim {

LinearMachine linear_machine(const PlantConfig& plant, int axis, bool pre_sliding) {
  const AxisConfig& a = plant.axis[static_cast<std::size_t>(axis)];
  const DesignConfig& design = plant.design[static_cast<std::size_t>(axis)];
  LinearMachine m;
  m.inertia_kg_m2 = axis_inertia_kg_m2(plant, axis, 0.0);
  m.viscous_nm_s_rad = a.friction.positive.viscous_nm_s_rad;
  m.bristle_stiffness_nm_rad = pre_sliding ? a.friction.stiffness_nm_rad : 0.0;
  m.bristle_damping_nm_s_rad = pre_sliding ? a.friction.damping_nm_s_rad : 0.0;
  m.actuation_delay_s = 2.0 * kPwmPeriod_s;
  m.current_loop_rad_s = 2.0 * kPi * design.current_loop_bandwidth_hz;
  m.encoder_latency_s = a.encoder.latency_s + 0.5 * (a.encoder.reads_per_tick - 1) * kPwmPeriod_s;
  m.gyro_latency_s = a.gyro.latency_s;
  m.gyro_bandwidth_rad_s = 2.0 * kPi * a.gyro.bandwidth_hz;
  return m;
}

Margins worst_margins(const PlantConfig& plant, int axis, const speed_loop_params& speed_loop) {
  const std::vector<double> frequency_hz = log_space(0.05, 450.0, 1200);
  Margins worst{};
  for (const bool pre_sliding : {false, true}) {
    const Margins m =
        margins_of(computed_loop_gain(linear_machine(plant, axis, pre_sliding), speed_loop, frequency_hz));
    if (!pre_sliding) {
      worst = m;
    }
    worst.gain_margin_db = std::min(worst.gain_margin_db, m.gain_margin_db);
    worst.phase_margin_deg = std::min(worst.phase_margin_deg, m.phase_margin_deg);
  }
  return worst;
}

bool keeps_margins(const Margins& margins) {
  return margins.gain_margin_db >= kLeastGainMargin_db && margins.phase_margin_deg >= kLeastPhaseMargin_deg;
}

bool is_stable_in_closed_loop(const FrequencyResponse& response) {
  const std::vector<std::complex<double>>& gain = response.loop_gain;
  if (std::abs(gain.back()) >= 1.0) {
    return false;  // still in command at half the tick's rate: nothing bounds the phase there
  }
  // n integrators begin at -90 n degrees, which atan2 alone would fold into one turn; the slope of |L| tells n.
  const double slope =
      gain.front() == 0.0 || std::abs(gain.front()) < 1.0
          ? 0.0
          : std::log(std::abs(gain[1] / gain[0])) / std::log(response.frequency_hz[1] / response.frequency_hz[0]);
  const double expected = 0.5 * kPi * slope;
  const double folded = std::arg(1.0 + gain.front());
  double phase = folded + 2.0 * kPi * std::round((expected - folded) / (2.0 * kPi));
  for (std::size_t i = 1; i < gain.size(); ++i) {
    phase += std::arg((1.0 + gain[i]) / (1.0 + gain[i - 1]));
  }
  return std::abs(phase) < 0.5 * kPi;
}

double least_inertia_kg_m2(const PlantConfig& plant, int axis) {
  const std::optional<EndStopConfig>& stops = plant.axis[kPitch].end_stops;
  const auto within = [&](double pitch_rad) {
    return !stops || (stops->lower_rad <= pitch_rad && pitch_rad <= stops->upper_rad);
  };
  if (within(0.5 * kPi) || within(-0.5 * kPi)) {
    return axis_inertia_kg_m2(plant, axis, 0.5 * kPi);
  }
  return std::min(axis_inertia_kg_m2(plant, axis, stops->lower_rad), axis_inertia_kg_m2(plant, axis, stops->upper_rad));
}

bool speed_loop_is_stable(const PlantConfig& plant, int axis, const speed_loop_params& speed_loop) {
  // From below any bandwidth that a plant file may ask for, up to half the tick's rate.
  const std::vector<double> frequency_hz = log_space(1e-4, 499.0, 1000);
  const auto stable = [&](bool pre_sliding, double inertia_kg_m2) {
    LinearMachine machine = linear_machine(plant, axis, pre_sliding);
    machine.inertia_kg_m2 = inertia_kg_m2;
    return is_stable_in_closed_loop(computed_loop_gain(machine, speed_loop, frequency_hz));
  };
  const double design_kg_m2 = axis_inertia_kg_m2(plant, axis, 0.0);
  const double least_kg_m2 = least_inertia_kg_m2(plant, axis);
  return stable(false, least_kg_m2) && stable(true, least_kg_m2) &&
         (least_kg_m2 == design_kg_m2 || (stable(false, design_kg_m2) && stable(true, design_kg_m2)));
}

}  // namespace trackservo::sim
