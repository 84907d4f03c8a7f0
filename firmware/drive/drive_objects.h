/* SPDX-License-Identifier: Apache-2.0 */
/* The values of one axis that the bus can access, as plain integers in the units of CiA 402.
 *
 * Standard: CiA 402-2 v4.1 / IEC 61800-7-201, clauses 7 (modes) and 8 (objects); the index is beside each value. The
 * table of the object dictionary points into this struct; the drive reads the commands and writes the results once per
 * tick. Position counts 1e-7 rad, velocity 1e-6 rad/s, acceleration 1e-6 rad/s^2, jerk 1e-6 rad/s^3, torque 0.1 % of
 * the rated torque (6076), times ms. */
#ifndef TRACKSERVO_DRIVE_DRIVE_OBJECTS_H
#define TRACKSERVO_DRIVE_DRIVE_OBJECTS_H

#include <stdint.h>

/* 6060 and 6061. */
typedef enum {
  DRIVE_TRACKING = -1, /* of this manufacturer: the camera (3070) gives the set-point */
  DRIVE_NO_MODE = 0,
  DRIVE_PROFILE_POSITION = 1,
  DRIVE_PROFILE_VELOCITY = 3,
  DRIVE_HOMING = 6,
  DRIVE_CYCLIC_POSITION = 8,
  DRIVE_CYCLIC_VELOCITY = 9,
  DRIVE_CYCLIC_TORQUE = 10
} drive_mode;

/* 6502: bits pp 0, pv 2, hm 5, csp 7, csv 8, cst 9, tracking (mode -1) 16. */
#define DRIVE_SUPPORTED_MODES 0x000103A5u

/* 67FF: device profile 402, servo drive. */
#define DRIVE_DEVICE_TYPE 0x00020192u

/* 6086: the only supported type of ramp. */
enum { DRIVE_JERK_LIMITED_RAMP = 3 };

/* 6007: what an axis that turns does when the master is silent. */
enum { DRIVE_SILENT_GO_ON = 0, DRIVE_SILENT_FAULT = 1, DRIVE_SILENT_OFF = 2, DRIVE_SILENT_QUICK_STOP = 3 };

typedef struct {
  int16_t master_silent;  /* 6007: DRIVE_SILENT_* */
  int16_t quick_stop;     /* 605A: 0, 1, 2, 5, 6 */
  int16_t shutdown;       /* 605B: 0, 1 */
  int16_t disable;        /* 605C: 0, 1 */
  int16_t halt;           /* 605D: 1, 2 */
  int16_t fault_reaction; /* 605E: 0, 1, 2 */
} drive_options;

typedef struct {
  uint16_t error_code;  /* 603F, ro: 0 when there was no fault since the last reset */
  uint16_t controlword; /* 6040 */
  uint16_t statusword;  /* 6041, ro */
  int8_t mode;          /* 6060 */
  int8_t mode_display;  /* 6061, ro */
  drive_options option; /* 605A .. 605E */
} drive_state_objects;

typedef struct {
  int32_t demand;                  /* 6062, ro */
  int32_t actual;                  /* 6064, ro */
  uint32_t following_error_window; /* 6065; UINT32_MAX: not monitored */
  uint16_t following_error_ms;     /* 6066 */
  uint32_t window;                 /* 6067; UINT32_MAX: always inside */
  uint16_t window_ms;              /* 6068 */
  int32_t target;                  /* 607A */
  int32_t range_minimum;           /* 607B:01, ro; of positions that wrap */
  int32_t range_maximum;           /* 607B:02, ro; both 0: positions do not wrap */
  uint16_t option;                 /* 60F2 */
  int32_t following_error;         /* 60F4, ro */
} drive_position_objects;

typedef struct {
  int32_t demand;        /* 606B, ro */
  int32_t actual;        /* 606C, ro */
  uint16_t window;       /* 606D */
  uint16_t window_ms;    /* 606E */
  uint16_t threshold;    /* 606F */
  uint16_t threshold_ms; /* 6070 */
  int32_t offset;        /* 60B1 */
  int32_t target;        /* 60FF */
} drive_velocity_objects;

typedef struct {
  int16_t target;            /* 6071 */
  uint16_t maximum;          /* 6072 */
  int16_t demand;            /* 6074, ro */
  uint32_t rated_current_ma; /* 6075; for the client, not used here */
  uint32_t rated_mnm;        /* 6076; 0: no torque can be reported or commanded */
  int16_t actual;            /* 6077, ro */
  uint32_t slope_per_s;      /* 6087; 0: steps are passed on */
  int16_t offset;            /* 60B2 */
  uint16_t positive_limit;   /* 60E0 */
  uint16_t negative_limit;   /* 60E1, a magnitude */
} drive_torque_objects;

typedef struct {
  int32_t position_minimum;         /* 607D:01; not monitored unless minimum < maximum */
  int32_t position_maximum;         /* 607D:02 */
  uint32_t maximum_velocity;        /* 607F */
  uint32_t profile_velocity;        /* 6081 */
  uint32_t acceleration;            /* 6083; 0 counts as 1 here and below */
  uint32_t deceleration;            /* 6084 */
  uint32_t quick_stop_deceleration; /* 6085 */
  int16_t motion_profile_type;      /* 6086 */
  uint32_t jerk;                    /* 60A4:01 */
  uint8_t interpolation_period;     /* 60C2:01, times 10^60C2:02 s */
  int8_t interpolation_exponent;    /* 60C2:02 */
} drive_limit_objects;

typedef struct {
  int32_t offset;        /* 607C: where the operator has seen the axis */
  int8_t method;         /* 6098: HOMING_* */
  uint32_t first_speed;  /* 6099:01 */
  uint32_t second_speed; /* 6099:02, after a contact */
  uint32_t acceleration; /* 609A */
} drive_homing_objects;

typedef struct {
  drive_state_objects state;
  drive_position_objects position;
  drive_velocity_objects velocity;
  drive_torque_objects torque;
  drive_limit_objects limit;
  drive_homing_objects homing;
} drive_objects;

#endif
