/* SPDX-License-Identifier: Apache-2.0 */
/* Every fault of the servo: its number, its code on the bus, its detection time, the reaction.
 *
 * One table for all: detection (axis_protection, the node, the board) uses these numbers, the drive takes the reaction
 * from here, EMCY and 603F take the code, `fault_texts.h` has the texts, and docs/faults.md is printed from both.
 * Codes: CiA 301 table 26, CiA 402-2 table of error codes; byte 3 of the EMCY is the fault's
 * number. */
#ifndef TRACKSERVO_PROTECTION_FAULT_TABLE_H
#define TRACKSERVO_PROTECTION_FAULT_TABLE_H

#include <stdint.h>

/* The numbers are sent on the bus and stored in fault logs: never change the meaning of one. Of several faults with the
 * same reaction in one tick, the lowest number is reported first. */
typedef enum {
  FAULT_NONE = 0,
  /* sensors of motion */
  FAULT_ENCODER_LOST = 1,
  FAULT_ENCODER_JUMP = 2,
  FAULT_ENCODER_STUCK = 3,
  FAULT_SENSORS_DISAGREE = 4,
  FAULT_GYRO_LOST = 5,
  FAULT_GYRO_STUCK = 6,
  FAULT_GYRO_SATURATED = 7,
  FAULT_IMPLAUSIBLE = 8,
  /* current, voltage, heat */
  FAULT_CURRENT_OFFSET = 9,
  FAULT_CURRENT_SENSOR = 10,
  FAULT_OVER_CURRENT_TRIP = 11,
  FAULT_OVER_CURRENT = 12,
  FAULT_OVERLOAD = 13,
  FAULT_UNDER_VOLTAGE = 14,
  FAULT_OVER_VOLTAGE = 15,
  FAULT_POWER_STAGE = 16,
  FAULT_OVER_TEMPERATURE = 17,
  /* motion */
  FAULT_OVER_SPEED = 18,
  FAULT_RUNAWAY = 19,
  FAULT_BEYOND_TRAVEL = 20,
  FAULT_STALL = 21,
  FAULT_SPEED_ERROR = 22,
  FAULT_FOLLOWING_ERROR = 23,
  /* bus */
  FAULT_HEARTBEAT_LOST = 24,
  FAULT_RPDO_LATE = 25,
  FAULT_NODE_STOPPED = 26,
  FAULT_BUS_OFF = 27,
  /* the node itself; not of one axis */
  FAULT_TICK_LATE = 28,
  FAULT_SELF_TEST = 29,
  FAULT_WATCHDOG_RESET = 30,
  FAULT_EXCEPTION_RESET = 31,
  FAULT_BROWN_OUT_RESET = 32,
  FAULT_IMAGE_DAMAGED = 33,
  FAULT_STACK_OVERFLOW = 34,
  FAULT_PARAMETERS_LOST = 35,
  FAULT_RAM_PARITY = 36,
  /* what no single sensor shows */
  FAULT_MOTOR_CONTRADICTS = 37,
  FAULT_MOTOR_WEAK = 38,
  /* bus, continued */
  FAULT_MASTER_SILENT = 39,
  /* the loops of an axis */
  FAULT_OSCILLATION = 40,
  FAULT_GAINS_TAKEN_BACK = 41,
  /* the board's safety path */
  FAULT_HOLDING_BRAKE = 42,
  FAULT_SAFE_TORQUE_OFF = 43,
  FAULT_SAFE_TORQUE_FAULT = 44,
  FAULT_CLOCK = 45,
  FAULT_OPTION_BYTES = 46,
  /* what no single sensor shows, continued */
  FAULT_SENSORS_DRIFT = 47,
  FAULT_ENCODER_ERRATIC = 48,
  FAULT_STANDSTILL_LEFT = 49,
  FAULT_REDUCED_SPEED = 50,
  FAULT_ACTIVE_SET = 51,
  /* motion, in the envelope's view */
  FAULT_TOO_FAST = 52,
  FAULT_STOP_IGNORED = 53,
  FAULT_BRAKING_FAILS = 54,
  /* the camera */
  FAULT_CAMERA_STALE = 55,
  /* what no single sensor shows, continued */
  FAULT_NO_ANSWER = 56,
  FAULT_COUNT
} fault_id;

typedef enum {
  REACTION_REPORT = 0, /* EMCY and log only */
  REACTION_STOP,       /* braked by the speed loop, as 605E says */
  REACTION_PROTECT,    /* braked by the envelope's own torque, then off: where the speed loop cannot be trusted */
  REACTION_BRAKE, /* braked by the shorted motor, then off: where encoder, current loop or supply cannot be trusted */
  REACTION_CUT    /* off at once: where the bridge cannot be trusted */
} fault_reaction;

typedef struct {
  uint16_t code;
  uint8_t register_bits; /* of 0x1001, besides the generic one */
  uint8_t reaction;      /* fault_reaction */
  uint16_t latency_ms;   /* maximum time from the first possible detection to the tick that reacts; timers of 0x2060 are
                            added */
} fault_row;

/* `fault` below FAULT_COUNT. */
extern const fault_row fault_table[FAULT_COUNT];

/* Faults as bits, bit n for fault n. */
typedef uint64_t fault_set;

static inline fault_set fault_bit(fault_id fault) { return UINT64_C(1) << fault; }

/* Returns the fault of a set with the worst reaction, and of these the one with the lowest number; FAULT_NONE for an
 * empty set. */
fault_id fault_worst(fault_set set);

#endif
