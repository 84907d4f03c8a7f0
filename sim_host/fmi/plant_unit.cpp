// SPDX-License-Identifier: Apache-2.0
// The machine without firmware: motors, seals, loads, base and sensors. Its inputs are the duties of both bridges.
#include <memory>
#include <optional>

#include "machine/plant/tracker.hpp"
#include "machine_variables.hpp"
#include "unit.hpp"

namespace trackservo::fmi {
namespace {

class PlantUnit : public Unit {
 public:
  explicit PlantUnit(std::filesystem::path resources) : resources_(std::move(resources)) {
    choice_.add_to(variables_);
    for (std::size_t i = 0; i < sim::kAxes; ++i) {
      Axis& axis = axis_[i];
      const auto input = [this, i](const char *name, const char *unit, const char *description, auto *value,
                                   double bound = 0) {
        variables_.push_back({of_axis(i, name), Causality::kInput, unit, description, value, bound});
      };
      input("duty", "", "Duty of the bridge, clipped to -1 to 1: the share of the bus voltage at the motor",
            &axis.duty);
      input("bridge_on", "", "Whether the bridge drives the motor; its terminals are open otherwise", &axis.bridge_on);
      input("external_torque_nm", "N.m", "Torque on the joint from outside, positive forward", &axis.external_torque_nm,
            kTorqueBound_nm);
      axis.readings.add_to(variables_, sim::axis_name(static_cast<int>(i)));
      variables_.push_back({of_axis(i, "current_reading_a"), Causality::kOutput, "A",
                            "Reading of the motor current; new each 50 us", &axis.current_reading_a});
    }
    variables_.push_back({"bus_voltage_reading_v", Causality::kOutput, "V", "Reading of the DC bus; new each 50 us",
                          &bus_voltage_reading_v_});
    truth_.add_to(variables_);
  }

  void start() override {
    tracker_.emplace(choice_.plant(resources_), choice_.seed);
    tracker_->place(choice_.start_angle_rad);
    period_ = 0;
    read_sensors();
    read_converters();
    truth_.renew(tracker_->truth());
  }

  void step() override {
    std::array<double, sim::kAxes> duty{};
    for (std::size_t i = 0; i < sim::kAxes; ++i) {
      const int axis = static_cast<int>(i);
      duty[i] = axis_[i].duty;
      tracker_->open_terminals(axis, !axis_[i].bridge_on);
      tracker_->push(axis, axis_[i].external_torque_nm);
    }
    tracker_->step_pwm(duty);
    period_ = (period_ + 1) % sim::kPwmPerTick;
    if (period_ == 0) {
      read_sensors();
    }
    read_converters();
    truth_.renew(tracker_->truth());
  }

 private:
  struct Axis {
    double duty = 0;
    bool bridge_on = true;
    double external_torque_nm = 0;
    AxisReadings readings;
    double current_reading_a = 0;
  };

  void read_sensors() {
    const sim::TickSamples samples = tracker_->sample_tick();
    for (std::size_t i = 0; i < sim::kAxes; ++i) {
      axis_[i].readings.renew(samples.axis[i]);
    }
  }

  void read_converters() {
    for (std::size_t i = 0; i < sim::kAxes; ++i) {
      const sim::PwmSample sample = tracker_->sample_pwm(static_cast<int>(i));
      axis_[i].current_reading_a = sample.current_a;
      bus_voltage_reading_v_ = sample.bus_voltage_v;
    }
  }

  std::filesystem::path resources_;
  MachineChoice choice_;
  MachineTruth truth_;
  std::array<Axis, sim::kAxes> axis_;
  double bus_voltage_reading_v_ = 0;
  std::optional<sim::Tracker> tracker_;
  int period_ = 0;  // of the tick
};

}  // namespace

UnitKind unit_kind() {
  return {"trackservo_plant", "Two-axis tracker: motors, seals with LuGre friction, loads, base and sensors"};
}

std::unique_ptr<Unit> make_unit(const std::filesystem::path& resources) {
  return std::make_unique<PlantUnit>(resources);
}

}  // namespace trackservo::fmi
