#include "parameters/axis_dictionary.h"

#include "canopen/object_dictionary_rows.h"
#include "parameters/axis_tuning.h"

#define F(index_, sub_, member_, low_, high_, default_, unit_, name_, help_) \
  OD_F32(index_, sub_, OD_RW, OD_STORED, axis_tuning, staged.member_, low_, high_, default_, unit_, name_, help_)
/* Guarded: a wrong value can cause damage. */
#define G(index_, sub_, member_, low_, high_, default_, unit_, name_, help_)                                     \
  OD_F32(index_, sub_, OD_RW, OD_STORED | OD_GUARDED, axis_tuning, staged.member_, low_, high_, default_, unit_, \
         name_, help_)
#define U(index_, sub_, member_, low_, high_, default_, name_, help_) \
  OD_U32(index_, sub_, OD_RW, OD_STORED, axis_tuning, staged.member_, low_, high_, default_, "", name_, help_)

/* One direction of the seal: sub-indices `sub_` .. `sub_ + 3` of 0x2030. */
#define DIRECTION(sub_, member_, title_)                                                                          \
  F(0x2030, (sub_), friction.member_.coulomb_nm, 1e-6f, 1e4f, 6.0f, "N m", "Coulomb torque " title_,              \
    "Tc of eq. (5): sliding friction at high speed, without its viscous part"),                                   \
      F(0x2030, (sub_) + 1, friction.member_.breakaway_nm, 1e-6f, 1e4f, 9.0f, "N m", "Break-away torque " title_, \
        "Ts of eq. (5): not less than Tc"),                                                                       \
      F(0x2030, (sub_) + 2, friction.member_.stribeck_speed_rad_s, 1e-6f, 1e2f, 5.2e-3f, "rad/s",                 \
        "Stribeck speed " title_, "Speed at which Ts - Tc has decayed to 37 %"),                                  \
      F(0x2030, (sub_) + 3, friction.member_.viscous_nm_s_rad, 0.0f, 1e4f, 8.0f, "N m s/rad",                     \
        "Viscous coefficient " title_, "sigma2: friction torque per speed")

static const od_entry kEntries[] = {
    OD_RECORD_HEAD(0x2000, 5, "Speed loop", "PI with set-point weight and acceleration feedforward"),
    F(0x2000, 1, speed_loop.proportional_nm_s_rad, 0.0f, 1e6f, 720.0f, "N m s/rad", "Speed loop proportional gain",
      "2 zeta w J for damping ratio zeta and natural frequency w"),
    F(0x2000, 2, speed_loop.integral_nm_rad, 0.0f, 1e8f, 21600.0f, "N m/rad", "Speed loop integral gain",
      "w^2 J for natural frequency w"),
    F(0x2000, 3, speed_loop.setpoint_weight, 0.0f, 1.0f, 0.7f, "", "Speed loop set-point weight",
      "Lower it to reduce overshoot on steps; disturbance rejection does not change"),
    F(0x2000, 4, speed_loop.tracking_rate_per_s, 0.0f, 1e3f, 60.0f, "1/s", "Speed loop anti-windup rate",
      "How fast the integral follows the torque limit in saturation"),
    F(0x2000, 5, speed_loop.acceleration_inertia_kg_m2, 0.0f, 1e5f, 6.0f, "kg m^2", "Acceleration feedforward inertia",
      "Torque per commanded acceleration; 0: off"),

    OD_RECORD_HEAD(0x2010, 3, "Position loop", "Computes the rate set-point from the angle error"),
    F(0x2010, 1, position_loop.proportional_per_s, 0.01f, 1e3f, 10.0f, "1/s", "Position loop gain",
      "Bandwidth of the position loop"),
    F(0x2010, 2, position_loop.rate_limit_rad_s, 1e-5f, 1e2f, 1.0f, "rad/s", "Rate limit of the outer loops",
      "Largest rate set-point that the position and tracking loops may request"),
    F(0x2010, 3, position_loop.deceleration_rad_s2, 1e-4f, 1e4f, 1.0f, "rad/s^2", "Position loop deceleration",
      "Deceleration when approaching a distant target"),

    OD_RECORD_HEAD(0x2011, 5, "Tracking loop", "Computes the rate set-point from the camera error"),
    U(0x2011, 1, tracking_loop.kind, 0, 1, 1, "Tracking loop kind", "0: PI on the camera error; 1: predictive"),
    F(0x2011, 2, tracking_loop.proportional_per_s, 0.0f, 1e2f, 20.0f, "1/s", "Tracking loop proportional gain",
      "Rate per camera error (kind 1: predicted error)"),
    F(0x2011, 3, tracking_loop.integral_per_s2, 0.0f, 1e3f, 0.0f, "1/s^2", "Tracking loop integral gain",
      "Used by kind 0 only"),
    F(0x2011, 4, tracking_loop.estimator_rad_s, 0.1f, 50.0f, 4.0f, "rad/s", "Target estimator bandwidth",
      "Used by kind 1 only: how fast target rate and acceleration are estimated"),
    F(0x2011, 5, tracking_loop.coast_s, 0.0f, 10.0f, 0.5f, "s", "Coasting time",
      "How long the loop continues without camera frames"),

    OD_RECORD_HEAD(0x2020, 5, "Disturbance observer", "Velocity disturbance observer with first-order Q filter"),
    U(0x2020, 1, observer.on, 0, 1, 1, "Observer on", "0: off; 1: the estimated disturbance is compensated"),
    F(0x2020, 2, observer.inertia_kg_m2, 1e-9f, 1e5f, 6.0f, "kg m^2", "Observer inertia",
      "Nominal inertia J of the axis"),
    F(0x2020, 3, observer.viscous_nm_s_rad, 0.0f, 1e4f, 0.0f, "N m s/rad", "Observer viscous coefficient",
      "0: the observer or the friction feedforward compensates viscous torque"),
    F(0x2020, 4, observer.bandwidth_rad_s, 0.01f, 1e3f, 220.0f, "rad/s", "Observer bandwidth",
      "Higher: less phase margin, more torque noise; adds J w to the proportional gain"),
    F(0x2020, 5, observer.limit_nm, 0.0f, 1e4f, 40.0f, "N m", "Observer limit",
      "Largest torque that the observer may add"),

    OD_RECORD_HEAD(0x2030, 14, "Friction feedforward",
                   "LuGre model of the seal, with separate values for each direction"),
    U(0x2030, 1, friction.model, 0, 3, 3, "Friction model", "0: off; 1: Coulomb and viscous; 2: eq. (5); 3: LuGre"),
    F(0x2030, 2, friction.gain, 0.0f, 1.5f, 1.0f, "", "Friction feedforward gain",
      "Factor on the model's torque; 1: full compensation"),
    F(0x2030, 3, friction.lead_limit_rad_s, 1e-6f, 1e2f, 0.087f, "rad/s", "Friction lead limit",
      "Largest difference between the model's rate and the measured rate"),
    F(0x2030, 4, friction.sign_width_rad_s, 1e-6f, 1.0f, 1.7e-4f, "rad/s", "Friction sign width",
      "Models 1 and 2: below this speed sign(v) is replaced by a linear slope"),
    F(0x2030, 5, friction.stiffness_nm_rad, 1e-3f, 1e9f, 30000.0f, "N m/rad", "Bristle stiffness",
      "sigma0: torque per angle in pre-sliding"),
    F(0x2030, 6, friction.damping_nm_s_rad, 0.0f, 1e6f, 300.0f, "N m s/rad", "Bristle damping",
      "sigma1: damping of the bristles"),
    DIRECTION(7, positive, "positive"),
    DIRECTION(11, negative, "negative"),

    OD_RECORD_HEAD(0x2040, 5, "Filters", "Filters of the measured rate"),
    F(0x2040, 1, filters.notch_hz, 0.0f, 490.0f, 0.0f, "Hz", "Notch frequency", "0: off"),
    F(0x2040, 2, filters.notch_width_hz, 0.001f, 980.0f, 10.0f, "Hz", "Notch width",
      "Width between the -3 dB frequencies"),
    F(0x2040, 3, filters.notch_depth, 0.0f, 1.0f, 0.1f, "", "Notch depth", "Gain at the notch frequency"),
    F(0x2040, 4, filters.lowpass_hz, 0.0f, 490.0f, 0.0f, "Hz", "Low-pass frequency", "0: off"),
    F(0x2040, 5, filters.lowpass_damping, 0.1f, 2.0f, 0.7f, "", "Low-pass damping", "0.7 gives the flattest pass band"),

    OD_RECORD_HEAD(0x2050, 3, "Rate sensors", "Sensors that measure the rate"),
    U(0x2050, 1, sensors.source, 0, 2, 2, "Rate source", "0: encoder; 1: gyro; 2: fused"),
    F(0x2050, 2, sensors.crossover_rad_s, 0.01f, 2e3f, 62.8f, "rad/s", "Fusion crossover",
      "Below it the gyro is used (sees base motion), above it the encoder (less noise)"),
    U(0x2050, 3, sensors.window_ticks, 2, 16, 2, "Rate estimator window",
      "Number of angles used for the slope; 2 for high-resolution encoders"),

    OD_RECORD_HEAD(0x2055, 6, "Motor", "DC torque motor and current loop"),
    G(0x2055, 1, motor.torque_constant_nm_a, 1e-6f, 1e4f, 2.5f, "N m/A", "Torque constant", "Kt: torque per current"),
    G(0x2055, 2, motor.resistance_ohm, 1e-4f, 1e3f, 1.2f, "ohm", "Winding resistance", "R at operating temperature"),
    G(0x2055, 3, motor.inductance_h, 1e-7f, 10.0f, 3e-3f, "H", "Winding inductance", "L of the winding"),
    G(0x2055, 4, motor.back_emf_v_s_rad, 0.0f, 1e3f, 2.5f, "V s/rad", "Back-EMF constant", "Ke: voltage per speed"),
    G(0x2055, 5, motor.bandwidth_rad_s, 2.0f, 16000.0f, 6283.0f, "rad/s", "Current loop bandwidth",
      "Bandwidth of the first-order closed loop"),
    G(0x2055, 6, motor.current_limit_a, 0.0f, 1e4f, 16.0f, "A", "Current limit", "In both directions"),

    OD_RECORD_HEAD(0x2070, 5, "Parameter set", "All staged values become active together, or none does"),
    OD_U8(0x2070, 1, OD_RW, 0, axis_tuning, command, 0, 3, 0, "", "Parameter set command",
          "1: apply the staged set; 2: copy the active set to the staged set; 3: undo the last apply"),
    OD_U32(0x2070, 2, OD_RO, 0, axis_tuning, flags, 0, 3, 0, "", "Parameter set flags",
           "Bit 0: staged set differs from active set; bit 1: active set differs from stored set"),
    OD_U32(0x2070, 3, OD_RO, 0, axis_tuning, last_result, 0, 3, 0, "", "Parameter set result",
           "Result of the last apply: 0: applied; 1: not finite; 2: out of range; 3: inconsistent"),
    OD_U32(0x2070, 4, OD_RO, 0, axis_tuning, active_crc, 0, INT64_C(0xFFFFFFFF), 0, "", "Active set CRC",
           "CRC-32 of the active set"),
    OD_U32(0x2070, 5, OD_RO, 0, axis_tuning, stored_crc, 0, INT64_C(0xFFFFFFFF), 0, "", "Stored set CRC",
           "CRC-32 of the set that 0x1010 saved last"),
};

const od_table axis_parameters_table = {kEntries, sizeof kEntries / sizeof kEntries[0]};
