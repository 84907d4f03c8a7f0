/* SPDX-License-Identifier: Apache-2.0 */
/* Tracking in the node: camera frames from the bus to the targets of the drives in mode -1.
 *
 *     one axis in mode -1     the tracking loop of this axis (2011) on the error of its joint (servo/joint_tracking.h)
 *     both, 2011:1 = 1        one estimate of the target for the line of sight, up to the zenith (servo/pointing.h)
 *
 * In each tick: tracking_take after the samples; the drives follow `joint`. Then tracking_report and tracking_prepare,
 * before the next tick. When a frame arrives, between two ticks, the hooks find the age of its exposure. */
#ifndef TRACKSERVO_NODE_TRACKING_H
#define TRACKSERVO_NODE_TRACKING_H

#include "drive/drive_axis.h"
#include "node/objects/camera_objects.h"
#include "node/return_prediction.h"
#include "node/turn_back.h"
#include "servo/exposure_clock.h"
#include "servo/frozen_picture.h"
#include "servo/joint_tracking.h"
#include "servo/jumping_picture.h"
#include "servo/picture_check.h"
#include "servo/pointing.h"
#include "servo/servo_board.h"
#include "servo/stray_frame.h"

/* From each joint by itself to both together and back. What one way knows of the target is handed to the other in the
 * deferred task, because the tick of a new mode is long enough. */
typedef enum {
  TRACKING_APART = 0,
  TRACKING_JOINS,    /* in this tick both axes may track together; each still goes by itself */
  TRACKING_JOINED,   /* the line of sight has been told of the target */
  TRACKING_TOGETHER, /* both axes track the line of sight */
  TRACKING_PARTS     /* until the last tick they did */
} tracking_phase;

typedef struct {
  camera_objects objects; /* 0x3070 .. 0x3075 */
  hal *machine;           /* whose clock and strobe these are */
  exposure_clock clock;   /* 0x1013 */
  strobe_log strobe;
  bool arrived;         /* a frame waits for the tick */
  uint8_t messages;     /* since tracking_report */
  int32_t exposure_age; /* its age then, 10 us */
  image_vector error;   /* its error */
  camera_message message;
  camera_message counted; /* the last one that did */
  camera_input frames;
  frozen_picture picture;
  jumping_picture jumps;
  stray_frames strays;
  picture_check orientation;
  bool tracked;          /* an axis, since `orientation` was reset */
  uint16_t silent_ticks; /* without a message while no axis tracks */
  uint16_t drops;        /* of frames while an axis tracked, weighted: rises while too many do not count */
  uint16_t quiet_ticks;  /* since the last one that did not */
  bool stale;            /* so many of them that it is told */
  camera_delay delay;
  joint_tracking joints;
  bool held_back[SERVO_AXES]; /* its rate is limited because the picture is not judged; by itself */
  pointing line_of_sight;
  pointing_motion motion;         /* of this tick, while they track together */
  pointing_output target;         /* likewise */
  servo_target joint[SERVO_AXES]; /* for the drives */
  return_prediction back;
  uint32_t locked_ticks;             /* for so long both axes have had a target */
  float coast_s;                     /* 2011:5 of the azimuth */
  joint_vector rate_rad_s;           /* 2010:2 of both */
  float dither_rad_s;                /* of the next tick, on the elevation */
  bool predicts[SERVO_AXES];         /* 2011:1 */
  float estimator_rad_s[SERVO_AXES]; /* 2011:4 */
  bool prepared;                     /* `line_of_sight` has valid gains, and knows no target until they track */
  uint32_t prepared_changes;         /* those gains */
  tracking_phase phase;
  turn_back turn;
} target_tracking;

/* Initialises tracking. Call before the first frame. */
void tracking_start(target_tracking *self, hal *machine);

/* Forgets all frames, and what was counted and found with them: a reset of the node. */
void tracking_forget(target_tracking *self);

/* Of the part of the camera's objects; its owner is the `target_tracking`. */
extern const od_hooks tracking_hooks;

/* Takes the frame that has arrived before tick `tick`, if one has, and estimates the target. `tracking_axes`: number of
 * drives in mode -1. `changes`: a drive takes a new mode in this tick, which is long enough: each joint waits for the
 * next frame. */
void tracking_take(target_tracking *self, const servo_board *board, uint32_t tick, int tracking_axes, bool changes);

/* Writes what the bus can read, and judges the pictures. */
void tracking_report(target_tracking *self, const drive_axis *azimuth, const drive_axis *pitch, uint32_t tick);

/* Returns whether frames come to an axis that tracks, but do not count; until none has been dropped for a second. */
bool tracking_is_stale(const target_tracking *self);

/* Prepares tracking with these gains, so that the tick in which it begins need not. Call while the axes do not track
 * together; gains that change while they do take effect the next time. `azimuth_swing_kg_m2`: what the pitch body adds
 * to the azimuth's inertia at pitch 0. `changes`: differs when any of these has changed. */
void tracking_prepare(target_tracking *self, const servo_params *servo, float azimuth_swing_kg_m2, uint32_t changes);

#endif
