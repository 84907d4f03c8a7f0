// SPDX-License-Identifier: Apache-2.0
// The bus that feeds both bridges: the supply alone, or a supply that gives current but takes none, with a capacitor
// and an optional brake resistor.
//
//   stiff:            v = Vs - Rs i
//   with capacitor:   C dv/dt = max(Vs - v, 0)/Rs - i - (brake resistor on ? v/Rb : 0)
//
// i is what the bridges draw; a motor that brakes can return current. At three times Vs the bridges' transistors break
// down and take the rest: a capacitor that is far too small gives a high voltage, not an infinite one. The step is
// implicit in v, so it is stable for any C and Rs. Use: step() once per PWM period.
#ifndef TRACKSERVO_SIM_PLANT_DC_BUS_HPP
#define TRACKSERVO_SIM_PLANT_DC_BUS_HPP

#include <algorithm>

#include "machine/config/plant_config.hpp"

namespace trackservo::sim {

class DcBus {
 public:
  DcBus(const SupplyConfig& config, double dt_s) : config_(config), dt_s_(dt_s), voltage_v_(config.voltage_v) {}

  // Sets the share of the capacitance that an old capacitor has left. A larger share than before is a new capacitor,
  // which the supply has charged.
  void age_capacitor(double share) {
    if (share > share_) {
      settle(0.0);
    }
    share_ = share;
  }

  // Takes the current that both bridges draw [A]: at the start, and in each period.
  void settle(double drawn_a) { voltage_v_ = config_.voltage_v - config_.source_resistance_ohm * drawn_a; }
  void step(double drawn_a) {
    if (has_capacitor()) {
      charge(drawn_a);
    } else {
      settle(drawn_a);
    }
  }

  bool has_capacitor() const { return config_.capacitance_f > 0.0; }
  double voltage_v() const { return voltage_v_; }

 private:
  static constexpr double kMinResistance_ohm = 1e-3;  // of a supply that has none
  static constexpr double kHysteresis_v = 1.0;        // of the brake resistor's switch
  static constexpr double kBreakdown = 3.0;           // voltage of the transistors, over that of the supply

  void charge(double drawn_a) {
    const double per_farad_s = dt_s_ / (share_ * config_.capacitance_f);
    double conductance_s = 0.0;
    if (config_.brake_resistor_ohm > 0.0) {
      const double switch_v = config_.brake_resistor_v - (resistor_on_ ? kHysteresis_v : 0.0);
      resistor_on_ = voltage_v_ > switch_v;
      conductance_s = resistor_on_ ? 1.0 / config_.brake_resistor_ohm : 0.0;
    }
    const double free_v = (voltage_v_ - per_farad_s * drawn_a) / (1.0 + per_farad_s * conductance_s);
    voltage_v_ = std::clamp(free_v, 0.0, kBreakdown * config_.voltage_v);
    if (free_v < config_.voltage_v) {  // then the supply conducts
      const double source_s = 1.0 / (config_.source_resistance_ohm > kMinResistance_ohm ? config_.source_resistance_ohm
                                                                                        : kMinResistance_ohm);
      const double fed_v = (free_v + per_farad_s * source_s * config_.voltage_v) / (1.0 + per_farad_s * source_s);
      voltage_v_ = fed_v > 0.0 ? fed_v : 0.0;
    }
  }

  SupplyConfig config_;
  double dt_s_;
  double share_ = 1.0;
  double voltage_v_;
  bool resistor_on_ = false;
};

}  // namespace trackservo::sim

#endif
