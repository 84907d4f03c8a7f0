/* SPDX-License-Identifier: Apache-2.0 */
/* The power state machine of one axis.
 *
 * Standard: CiA 402-2 v4.1 / IEC 61800-7-201, clauses 6.2 (states and transitions 0 .. 16), 8.4.1 (controlword 6040),
 * 8.4.2 (statusword 6041) and 8.5 (option codes 605A .. 605E). At most one transition per tick. The controlword is
 * evaluated in every tick, so a command that comes too early waits for the state that it needs. The machine commands an
 * action (run, slow down, quick stop, off) and is notified when a stop has ended. */
#ifndef TRACKSERVO_DRIVE_DRIVE_STATE_H
#define TRACKSERVO_DRIVE_DRIVE_STATE_H

#include <stdbool.h>
#include <stdint.h>

#include "drive/drive_objects.h"

typedef enum {
  DRIVE_NOT_READY = 0,
  DRIVE_SWITCH_ON_DISABLED,
  DRIVE_READY_TO_SWITCH_ON,
  DRIVE_SWITCHED_ON,
  DRIVE_OPERATION_ENABLED,
  DRIVE_QUICK_STOP_ACTIVE,
  DRIVE_FAULT_REACTION_ACTIVE,
  DRIVE_FAULT
} drive_power_state;

typedef enum {
  DRIVE_OFF = 0,        /* no torque */
  DRIVE_RUN,            /* the mode of operation decides */
  DRIVE_SLOW_DOWN,      /* to standstill with 6084, then hold it */
  DRIVE_QUICK_STOP,     /* to standstill with 6085, then hold it */
  DRIVE_BRAKE,          /* the motor is shorted: needs no loop and no sensor */
  DRIVE_PROTECTIVE_STOP /* the torque of the envelope brakes: needs encoder and current loop */
} drive_action;

/* In ascending order of severity. */
typedef enum {
  DRIVE_NO_FAULT = 0,
  DRIVE_FAULT_STOPS,    /* the speed loop can be trusted: 605E decides */
  DRIVE_FAULT_PROTECTS, /* it cannot be trusted, the encoder can: the envelope brakes, then off, regardless of 605E */
  DRIVE_FAULT_BRAKES,   /* neither can the encoder: the shorted motor brakes, then off, regardless of 605E */
  DRIVE_FAULT_CUTS      /* nor can the bridge: off at once */
} drive_fault;

/* Bits of the controlword. */
enum {
  DRIVE_CONTROL_SWITCH_ON = 0x0001,
  DRIVE_CONTROL_ENABLE_VOLTAGE = 0x0002,
  DRIVE_CONTROL_NO_QUICK_STOP = 0x0004,
  DRIVE_CONTROL_ENABLE_OPERATION = 0x0008,
  DRIVE_CONTROL_NEW_SETPOINT = 0x0010,       /* pp; hm: start */
  DRIVE_CONTROL_CHANGE_IMMEDIATELY = 0x0020, /* pp */
  DRIVE_CONTROL_RELATIVE = 0x0040,           /* pp */
  DRIVE_CONTROL_FAULT_RESET = 0x0080,
  DRIVE_CONTROL_HALT = 0x0100
};

/* Bits of the statusword that do not depend on the state. */
enum {
  DRIVE_STATUS_VOLTAGE_ENABLED = 0x0010,
  DRIVE_STATUS_WARNING = 0x0080,
  DRIVE_STATUS_REMOTE = 0x0200,
  DRIVE_STATUS_TARGET_REACHED = 0x0400,
  DRIVE_STATUS_INTERNAL_LIMIT = 0x0800,
  DRIVE_STATUS_MODE_12 =
      0x1000, /* pp: set-point acknowledged; pv: speed is 0; hm: attained; csp, csv, cst: target followed */
  DRIVE_STATUS_MODE_13 = 0x2000, /* pp, csp: following error; hm: homing error */
  DRIVE_STATUS_WRAPPED = 0x4000  /* the angle is outside 607B, and 6064 differs from it by whole ranges */
};

typedef struct {
  drive_power_state power;
  drive_action action;   /* of the last tick */
  bool reset_bit_before; /* bit 7 of the last controlword: only its rising edge resets a fault */
  drive_fault reaction;  /* to the worst fault since the last reset */
  uint32_t reaction_ticks;
  bool ends_off;   /* the stop of the last action ends without torque */
  bool shuts_down; /* in operation, the last command was shutdown; */
  bool disables;   /* or disable operation */
} drive_state;

typedef struct {
  uint16_t controlword;
  drive_fault fault;
  bool ready;           /* self-test done: leaves Not ready to switch on */
  bool voltage_present; /* needed for Switched on */
  bool stopped;         /* the stop of the last action has ended */
  bool may_enable;      /* needed for Switched on and Operation enabled: protection knows the end of the travel */
  bool turns;           /* the axis has power, or turns since it had */
} drive_state_inputs;

/* Time limit of a fault reaction; then the torque is cut. A brake ramp set close to zero must not keep the power on. */
#define DRIVE_LONGEST_REACTION_TICKS 10000u

/* How long the shorted motor brakes. */
#define DRIVE_BRAKE_TICKS 2000u

/* Time limit of a protective stop. */
#define DRIVE_LONGEST_PROTECTIVE_STOP_TICKS 3000u

void drive_state_reset(drive_state *state);

/* Computes one tick. An unsupported option code counts as the standard's default. */
drive_action drive_state_step(drive_state *state, const drive_options *options, const drive_state_inputs *in);

/* Returns the state's bits of the statusword; bit 5 is 0 in Quick stop active only. */
uint16_t drive_state_statusword(drive_power_state power);

/* Returns whether the option code object `index` (0x605A .. 0x605E) may have this value: a dictionary refuses other
 * values with 0609 0030. Stops on the current or voltage limit (3, 4, 7, 8) are not supported. */
bool drive_option_supported(uint16_t index, int16_t code);

/* Returns the defaults: 6007 3; of the standard: 605A 2, 605B 0, 605C 1, 605D 1, 605E 2. */
drive_options drive_options_default(void);

#endif
