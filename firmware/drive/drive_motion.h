/* What a mode of operation wants in this tick: from CiA 402 targets to a set-point of the servo axis.
 *
 * Standard: CiA 402-2 / IEC 61800-7-201 clauses 7.2 (pp), 7.3 (pv), 7.11 (csp), 7.12 (csv), 7.13 (cst) and the stops
 * of 8.5. All modes move one ramp state and one position demand, so that another mode, a halt or a stop goes on from
 * what was asked for in the last tick: no bump. The rate and position given out are those of now, the acceleration
 * is the mean of the coming tick: as torque over an inertia it brings exactly the next rate. */
#ifndef TRACKSERVO_DRIVE_DRIVE_MOTION_H
#define TRACKSERVO_DRIVE_DRIVE_MOTION_H

#include <stdbool.h>

#include "app/servo_axis.h"
#include "drive/drive_objects.h"
#include "drive/drive_state.h"
#include "drive/drive_travel.h"
#include "drive/drive_units.h"
#include "drive/interpolation.h"
#include "drive/profile_ramp.h"
#include "drive/setpoint_queue.h"

/* What the axis does; finite. */
typedef struct {
  drive_angle position;
  float rate_rad_s;                   /* the rate that the speed loop controls */
  float reference_rad_s;              /* the set-point that it had in the last tick */
  float torque_demand_nm;             /* commanded in the last tick */
  bool setpoint_arrived;              /* 607A, 60FF or 6071 was written since the last tick, the same value included */
  const servo_axis_command *stimulus; /* of an experiment: obeyed in place of a mode while none is chosen; or NULL */
} drive_feedback;

/* What 60C2 meant when it was looked at last. */
typedef struct {
  uint8_t mantissa;
  int8_t exponent;
  int ticks; /* 0: not looked at yet */
} setpoint_period;

/* A tick of pp or pv: what its ramp comes to. */
typedef struct {
  bool ready;
  profile_ramp ramp;
  drive_angle demand;
  float demand_rest;
  float travel_rad;
  float mean_acceleration_rad_s2;
  int32_t target; /* that it leads to: of pp in the units of 607A */
  bool arrived;   /* there */
  bool limited;   /* a limit changed what was asked for */
  bool held;      /* of pv: a limit of the travel stops it, and holds the position */
} drive_profile_step;

typedef struct {
  int8_t mode;     /* drive_mode in force */
  servo_mode loop; /* of the last tick */
  profile_ramp ramp;
  drive_angle demand;
  float demand_rest;       /* what its last digit cannot hold, in 2^-32 turn */
  drive_angle position;    /* of the axis in the last tick */
  float travel_rad;        /* of the ramp since then: pp, pv and stops */
  drive_profile_step next; /* prepared for the coming tick */
  setpoint_queue setpoints;
  rate_interpolation rates;
  position_interpolation positions;
  int setpoint_age_ticks;
  setpoint_period period;
  drive_bounds bounds;     /* in force */
  float blocked_direction; /* -1 or 1: stopped before the end of the travel on that side; 0: free */
  float torque_nm;         /* cst: on its way along the torque slope */
} drive_motion;

typedef struct {
  servo_axis_command command;
  drive_angle position; /* demand; of the axis when no position is controlled */
  bool limited;         /* a limit changed what was asked for */
  bool followed;        /* the target is obeyed: no stop, set-points are fresh */
  bool stopped;         /* a stop has ended */
} drive_setpoint;

bool drive_mode_supported(int8_t mode);

/* The whole ramp limits of this tick: profile velocity and deceleration depend on what is done. */
profile_limits drive_profile_limits(const drive_limit_objects *limit, float rate_rad_s, uint32_t deceleration);

void drive_motion_reset(drive_motion *motion, drive_angle position);

/* One tick. A mode that is not supported leaves the one in force. In pp and pv it takes the step that was prepared; in
 * the first tick there is none, and the ramp goes on with the acceleration that it has. */
drive_setpoint drive_motion_step(drive_motion *motion, const drive_objects *objects, drive_action action,
                                 const drive_feedback *feedback, float dt_s);

/* Between two ticks: where the ramp of pp or pv goes in the coming one. To find the moment at which a stop has to begin
 * takes time, which is not the tick's; so targets and limits of these two modes count a tick later, and
 * the bounds of the travel and of the rate in every mode. */
void drive_motion_prepare(drive_motion *motion, const drive_objects *objects, const drive_machine *machine, float dt_s);

#endif
