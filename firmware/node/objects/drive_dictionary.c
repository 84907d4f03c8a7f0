/* SPDX-License-Identifier: Apache-2.0 */
#include "node/objects/drive_dictionary.h"

#include "canopen/object_dictionary_rows.h"
#include "drive/drive_objects.h"

#define POSITION "1e-7 rad"
#define VELOCITY "1e-6 rad/s"
#define ACCELERATION "1e-6 rad/s^2"
#define JERK "1e-6 rad/s^3"
#define TORQUE "0.1 % of rated"
#define U32_HIGHEST INT64_C(0xFFFFFFFF)

/* Read-only rows that may be sent, and writable rows that may be received. */
#define REPORTS(kind_, index_, member_, low_, high_, unit_, name_, help_) \
  kind_(index_, 0, OD_RO, OD_TPDO, drive_objects, member_, low_, high_, 0, unit_, name_, help_)
#define TAKES(kind_, index_, member_, low_, high_, preset_, unit_, name_, help_) \
  kind_(index_, 0, OD_RW, OD_RPDO, drive_objects, member_, low_, high_, preset_, unit_, name_, help_)
#define SETS(kind_, index_, sub_, member_, low_, high_, preset_, unit_, name_, help_) \
  kind_(index_, sub_, OD_RW, OD_STORED, drive_objects, member_, low_, high_, preset_, unit_, name_, help_)

static const od_entry kEntries[] = {
    SETS(
        OD_I16, 0x6007, 0, state.option.master_silent, 0, 3, 3, "", "Abort connection option code",
        "When the axis turns and the master is silent for 3041:1: 0: no action; 1: fault, then as 605E; 2: switch off; "
        "3: quick stop as 605A, no fault"),
    REPORTS(OD_U16, 0x603F, state.error_code, 0, 0xFFFF, "", "Error code", "CiA 402 code of the last fault; 0: none"),
    TAKES(OD_U16, 0x6040, state.controlword, 0, 0xFFFF, 0, "", "Controlword", "Commands of the power state machine"),
    OD_U16(0x6041, 0, OD_RO, OD_TPDO | OD_EVENT, drive_objects, state.statusword, 0, 0xFFFF, 0, "", "Statusword",
           "State of the power state machine; bit 14: the angle is outside 607B, 6064 has wrapped"),
    SETS(OD_I16, 0x605A, 0, state.option.quick_stop, 0, 6, 2, "", "Quick stop option code",
         "0: switch off; 1: ramp 6084, then off; 2: ramp 6085, then off; 5: ramp 6084, then hold; 6: ramp 6085, then "
         "hold"),
    SETS(OD_I16, 0x605B, 0, state.option.shutdown, 0, 1, 0, "", "Shutdown option code",
         "0: switch off; 1: ramp 6084, then off"),
    SETS(OD_I16, 0x605C, 0, state.option.disable, 0, 1, 1, "", "Disable operation option code",
         "0: switch off; 1: ramp 6084, then off"),
    SETS(OD_I16, 0x605D, 0, state.option.halt, 1, 2, 1, "", "Halt option code",
         "1: ramp 6084, then hold; 2: ramp 6085, then hold"),
    SETS(OD_I16, 0x605E, 0, state.option.fault_reaction, 0, 2, 2, "", "Fault reaction option code",
         "0: switch off; 1: ramp 6084, then off; 2: ramp 6085, then off"),
    TAKES(OD_I8, 0x6060, state.mode, -1, 10, 0, "", "Modes of operation",
          "-1: tracking; 0: none; 1: pp; 3: pv; 6: homing; 8: csp; 9: csv; 10: cst"),
    OD_I8(0x6061, 0, OD_RO, OD_TPDO | OD_EVENT, drive_objects, state.mode_display, -1, 10, 0, "",
          "Modes of operation display", "Active mode"),
    REPORTS(OD_I32, 0x6062, position.demand, INT32_MIN, INT32_MAX, POSITION, "Position demand value",
            "Set-point of the ramp"),
    REPORTS(OD_I32, 0x6064, position.actual, INT32_MIN, INT32_MAX, POSITION, "Position actual value", "Joint angle"),
    SETS(OD_U32, 0x6065, 0, position.following_error_window, 0, U32_HIGHEST, U32_HIGHEST, POSITION,
         "Following error window", "Largest permitted following error; FFFFFFFF: not monitored"),
    SETS(OD_U16, 0x6066, 0, position.following_error_ms, 0, 65535, 100, "ms", "Following error time out",
         "How long the following error may exceed 6065"),
    SETS(OD_U32, 0x6067, 0, position.window, 0, U32_HIGHEST, 1000, POSITION, "Position window",
         "Target reached within this position error; FFFFFFFF: always"),
    SETS(OD_U16, 0x6068, 0, position.window_ms, 0, 65535, 50, "ms", "Position window time",
         "Target reached after this time in the window"),
    REPORTS(OD_I32, 0x606B, velocity.demand, INT32_MIN, INT32_MAX, VELOCITY, "Velocity demand value",
            "Set-point of the ramp"),
    REPORTS(OD_I32, 0x606C, velocity.actual, INT32_MIN, INT32_MAX, VELOCITY, "Velocity actual value",
            "Inertial rate used by the speed loop"),
    SETS(OD_U16, 0x606D, 0, velocity.window, 0, 65535, 500, VELOCITY, "Velocity window",
         "Target reached within this velocity error"),
    SETS(OD_U16, 0x606E, 0, velocity.window_ms, 0, 65535, 50, "ms", "Velocity window time",
         "Target reached after this time in the window"),
    SETS(OD_U16, 0x606F, 0, velocity.threshold, 0, 65535, 500, VELOCITY, "Velocity threshold",
         "Below this the axis counts as standing still"),
    SETS(OD_U16, 0x6070, 0, velocity.threshold_ms, 0, 65535, 50, "ms", "Velocity threshold time",
         "The axis counts as moving after this time above 606F"),
    TAKES(OD_I16, 0x6071, torque.target, INT16_MIN, INT16_MAX, 0, TORQUE, "Target torque", "Set-point in mode cst"),
    SETS(OD_U16, 0x6072, 0, torque.maximum, 0, 65535, 1000, TORQUE, "Max torque", "In all modes"),
    REPORTS(OD_I16, 0x6074, torque.demand, INT16_MIN, INT16_MAX, TORQUE, "Torque demand",
            "Torque command of the last tick"),
    SETS(OD_U32, 0x6075, 0, torque.rated_current_ma, 0, U32_HIGHEST, 16000, "mA", "Motor rated current",
         "For information only"),
    SETS(OD_U32, 0x6076, 0, torque.rated_mnm, 0, U32_HIGHEST, 40000, "mN m", "Motor rated torque",
         "Unit of all torque objects"),
    REPORTS(OD_I16, 0x6077, torque.actual, INT16_MIN, INT16_MAX, TORQUE, "Torque actual value", "From motor current"),
    TAKES(OD_I32, 0x607A, position.target, INT32_MIN, INT32_MAX, 0, POSITION, "Target position",
          "Set-point in modes pp and csp"),
    OD_RECORD_HEAD(0x607B, 2, "Position range limit",
                   "64 turns: positions beyond wrap by whole turns; 0 and 0 within a limited travel: they do not"),
    OD_I32(0x607B, 1, OD_RO, 0, drive_objects, position.range_minimum, INT32_MIN, INT32_MAX, 0, POSITION,
           "Min position range limit", "-32 turns, or 0"),
    OD_I32(0x607B, 2, OD_RO, 0, drive_objects, position.range_maximum, INT32_MIN, INT32_MAX, 0, POSITION,
           "Max position range limit", "32 turns, or 0"),
    OD_I32(0x607C, 0, OD_RW, OD_GUARDED, drive_objects, homing.offset, INT32_MIN, INT32_MAX, 0, POSITION, "Home offset",
           "Write where you have seen the axis, within a quarter turn, while it is off; homing with 6098 = 35 or 37 "
           "then confirms the turn"),
    OD_RECORD_HEAD(
        0x607D, 2, "Software position limit",
        "Equal: not monitored; min above max: not applied, see 2060:18; default: 1 degree inside 2060:9 and 2060:10"),
    SETS(OD_I32, 0x607D, 1, limit.position_minimum, INT32_MIN, INT32_MAX, 0, POSITION, "Min position limit",
         "Lowest joint angle that a ramp may reach"),
    SETS(OD_I32, 0x607D, 2, limit.position_maximum, INT32_MIN, INT32_MAX, 0, POSITION, "Max position limit",
         "Highest joint angle that a ramp may reach"),
    SETS(OD_U32, 0x607F, 0, limit.maximum_velocity, 0, U32_HIGHEST, 1000000, VELOCITY, "Max profile velocity",
         "In all modes; at most 80 % of 2060:1 is used; FFFFFFFF: 80 % of 2060:1"),
    SETS(OD_U32, 0x6081, 0, limit.profile_velocity, 0, U32_HIGHEST, 350000, VELOCITY, "Profile velocity",
         "Speed of the ramp in mode pp"),
    SETS(OD_U32, 0x6083, 0, limit.acceleration, 1, U32_HIGHEST, 1000000, ACCELERATION, "Profile acceleration",
         "For all ramps, while speed increases"),
    SETS(OD_U32, 0x6084, 0, limit.deceleration, 1, U32_HIGHEST, 1000000, ACCELERATION, "Profile deceleration",
         "For all ramps, while speed decreases"),
    SETS(OD_U32, 0x6085, 0, limit.quick_stop_deceleration, 1, U32_HIGHEST, 3000000, ACCELERATION,
         "Quick stop deceleration", "For quick stop and fault reactions"),
    OD_I16(0x6086, 0, OD_RW, 0, drive_objects, limit.motion_profile_type, DRIVE_JERK_LIMITED_RAMP,
           DRIVE_JERK_LIMITED_RAMP, DRIVE_JERK_LIMITED_RAMP, "", "Motion profile type",
           "3: jerk-limited ramp (60A4), the only supported type"),
    SETS(OD_U32, 0x6087, 0, torque.slope_per_s, 0, U32_HIGHEST, 0, "0.1 % of rated/s", "Torque slope",
         "Slope of torque set-points; 0: not limited"),
    SETS(
        OD_I8, 0x6098, 0, homing.method, -2, 37, 0, "", "Homing method",
        "0: none; -1, -2: moves down, up until the turn is known, and turns round at an end stop; 35, 37: confirms the "
        "turn of 607C, without motion"),
    OD_RECORD_HEAD(0x6099, 2, "Homing speeds", "While the turn is not known, 4 deg/s at most"),
    SETS(OD_U32, 0x6099, 1, homing.first_speed, 1, U32_HIGHEST, 34907, VELOCITY, "Homing speed",
         "Of the first path, which may end at an end stop; above a tenth of 2060:6 the contact is a fault"),
    SETS(OD_U32, 0x6099, 2, homing.second_speed, 1, U32_HIGHEST, 69813, VELOCITY, "Homing return speed",
         "Of the path away from the end stop"),
    SETS(OD_U32, 0x609A, 0, homing.acceleration, 1, U32_HIGHEST, 1000000, ACCELERATION, "Homing acceleration",
         "While speed increases and decreases in homing"),
    OD_RECORD_HEAD(0x60A4, 1, "Profile jerk", "For all ramps"),
    SETS(OD_U32, 0x60A4, 1, limit.jerk, 1, U32_HIGHEST, 50000000, JERK, "Profile jerk 1",
         "Largest change of a ramp's acceleration per time"),
    OD_FIXED(OD_UNSIGNED32, 4, 0x60A8, 0, 0, 0xF9100000, "SI unit position", "1e-7 rad"),
    OD_FIXED(OD_UNSIGNED32, 4, 0x60A9, 0, 0, 0xFA100300, "SI unit velocity", "1e-6 rad/s"),
    TAKES(OD_I32, 0x60B1, velocity.offset, INT32_MIN, INT32_MAX, 0, VELOCITY, "Velocity offset",
          "Added in csp and csv"),
    TAKES(OD_I16, 0x60B2, torque.offset, INT16_MIN, INT16_MAX, 0, TORQUE, "Torque offset", "Added in csp, csv and cst"),
    OD_RECORD_HEAD(0x60C2, 2, "Interpolation time period", "Time between set-points in csp and csv"),
    SETS(OD_U8, 0x60C2, 1, limit.interpolation_period, 1, 255, 1, "", "Interpolation time period value",
         "Period = this value times 10 to the power of 60C2:2, in s"),
    SETS(OD_I8, 0x60C2, 2, limit.interpolation_exponent, -6, 0, -3, "", "Interpolation time index",
         "Power of ten in seconds, see 60C2:1"),
    SETS(OD_U16, 0x60E0, 0, torque.positive_limit, 0, 65535, 1000, TORQUE, "Positive torque limit value",
         "In all modes"),
    SETS(OD_U16, 0x60E1, 0, torque.negative_limit, 0, 65535, 1000, TORQUE, "Negative torque limit value",
         "In all modes; a magnitude"),
    SETS(OD_U16, 0x60F2, 0, position.option, 0, 0xC2, 0, "", "Positioning option code",
         "Bits 0, 1: relative moves in pp count from 0: the last target, 1: 6062, 2: 6064. Bits 6, 7: absolute moves "
         "without a limited travel go 0: straight, 1: down, 2: up, 3: the shorter way"),
    REPORTS(OD_I32, 0x60F4, position.following_error, INT32_MIN, INT32_MAX, POSITION, "Following error actual value",
            "Demand position minus actual position; in tracking: target minus line of sight"),
    TAKES(OD_I32, 0x60FF, velocity.target, INT32_MIN, INT32_MAX, 0, VELOCITY, "Target velocity",
          "Set-point in modes pv and csv"),
    OD_FIXED(OD_UNSIGNED32, 4, 0x6502, 0, 0, DRIVE_SUPPORTED_MODES, "Supported drive modes",
             "pp, pv, hm, csp, csv, cst; tracking (mode -1) is bit 16"),
    OD_FIXED(OD_UNSIGNED32, 4, 0x67FF, 0, 0, DRIVE_DEVICE_TYPE, "Single device type", "Servo drive, CiA 402"),
};

const od_table drive_objects_table = {kEntries, sizeof kEntries / sizeof kEntries[0]};
