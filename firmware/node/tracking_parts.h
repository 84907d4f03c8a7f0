/* SPDX-License-Identifier: Apache-2.0 */
/* What the files of tracking share; other rooms use tracking.h.
 *
 *     tracking.c          from the frames to what the drives follow
 *     tracking_picture.c  judges the picture by the motion of the axes: frozen, turned, mirrored, stray frames */
#ifndef TRACKSERVO_NODE_TRACKING_PARTS_H
#define TRACKSERVO_NODE_TRACKING_PARTS_H

#include "node/tracking.h"

enum { PICTURE_IS_WRONG = 6 /* of 3072:5, beside drive_tracking */ };

static inline bool tracking_is_together(const target_tracking *self) { return self->phase == TRACKING_TOGETHER; }

/* Takes the frame of this tick back if it has nothing to do with those around it. Call before the objects have the
 * counts of this tick; `tracks`: an axis does. */
void tracking_drop_stray_frame(target_tracking *self, const drive_axis *azimuth, const drive_axis *pitch, bool tracks);

/* Judges the frame of this tick. Call both before the objects have the counts of this tick; `tracks`: an axis does. */
void tracking_check_picture(target_tracking *self, const drive_axis *azimuth, const drive_axis *pitch, bool tracks);
void tracking_look_for_a_frozen_picture(target_tracking *self, const drive_axis *azimuth, const drive_axis *pitch,
                                        uint32_t tick);

/* Writes states, verdict and roll into 3072. */
void tracking_report_picture(target_tracking *self, const drive_axis *azimuth, const drive_axis *pitch);

#endif
