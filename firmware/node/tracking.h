/* Tracking in the node: camera frames from the bus to what the drives and servo axes of mode -1 get.
 *
 *     one axis in mode -1     the tracking loop of this axis (2011) on the error of its joint
 *     both, 2011:1 = 1        one estimate of the target for the line of sight (servo/pointing.h): exact up to the
 * zenith
 *
 * In each tick: tracking_take after the samples, tracking_command after each drive. Then tracking_report, before the
 * next tick. */
#ifndef TRACKSERVO_NODE_TRACKING_H
#define TRACKSERVO_NODE_TRACKING_H

#include "drive/drive_axis.h"
#include "node/objects/camera_objects.h"
#include "servo/pointing.h"
#include "servo/servo_board.h"

typedef struct {
  camera_objects objects; /* 0x3070 .. 0x3073 */
  camera_input frames;
  camera_delay delay;
  pointing line_of_sight;
  pointing_output target; /* of this tick, while `together` */
  float dither_rad_s;     /* of this tick, on the elevation */
  bool together;          /* the line of sight is tracked by both axes */
} target_tracking;

/* Takes the frame that has arrived, if one has, and estimates the target. `both_track`: both drives are in mode -1.
 * `azimuth_swing_kg_m2`: what the pitch body adds to the azimuth's inertia at pitch 0. */
void tracking_take(target_tracking *self, servo_board *board, bool both_track, float azimuth_swing_kg_m2,
                   uint32_t tick);

/* Completes the command of a drive that tracks, and its limits. */
void tracking_command(const target_tracking *self, int axis, drive_axis *drive, servo_axis_command *command);

/* Writes what the bus can read. */
void tracking_report(target_tracking *self, const drive_axis *azimuth, const drive_axis *pitch, uint32_t tick);

#endif
