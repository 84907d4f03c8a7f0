/* SPDX-License-Identifier: Apache-2.0 */
#include "node/objects/camera_objects.h"

#include "base/scalar.h"
#include "canopen/object_dictionary_rows.h"

enum { FRAME_OBJECT = 0x3070, FRAME_COUNTER = 5 };
enum { LONGEST_AGE = CAMERA_LONGEST_AGE_TICKS * CAMERA_TIMES_PER_TICK };

#define U32_HIGHEST INT64_C(0xFFFFFFFF)

#define TAKES(kind_, sub_, member_, low_, high_, unit_, name_, help_) \
  kind_(0x3070, sub_, OD_RW, OD_RPDO, camera_objects, message.member_, low_, high_, 0, unit_, name_, help_)
#define SETS(kind_, sub_, member_, low_, high_, preset_, unit_, name_, help_) \
  kind_(0x3071, sub_, OD_RW, OD_STORED, camera_objects, member_, low_, high_, preset_, unit_, name_, help_)
#define REPORTS(kind_, sub_, member_, high_, unit_, name_, help_) \
  kind_(0x3072, sub_, OD_RO, OD_TPDO, camera_objects, member_, 0, high_, 0, unit_, name_, help_)
#define DELAYS(kind_, sub_, member_, low_, high_, preset_, unit_, name_, help_) \
  kind_(0x3073, sub_, OD_RW, OD_STORED, camera_objects, member_, low_, high_, preset_, unit_, name_, help_)
#define FINDS(kind_, sub_, member_, low_, high_, preset_, unit_, name_, help_) \
  kind_(0x3073, sub_, OD_RO, OD_TPDO, camera_objects, member_, low_, high_, preset_, unit_, name_, help_)
#define STROBES(kind_, sub_, member_, low_, high_, preset_, unit_, name_, help_) \
  kind_(0x3074, sub_, OD_RW, OD_STORED, camera_objects, strobe.member_, low_, high_, preset_, unit_, name_, help_)
#define SEES(kind_, sub_, member_, high_, unit_, name_, help_) \
  kind_(0x3074, sub_, OD_RO, OD_TPDO, camera_objects, member_, 0, high_, 0, unit_, name_, help_)

static const od_entry kEntries[] = {
    OD_RECORD_HEAD(0x3070, 5, "Camera frame", "Errors that the image processor measured; map all five into one RPDO"),
    TAKES(OD_I16, 1, x, INT16_MIN, INT16_MAX, "3071:1", "Camera error x",
          "Target minus line of sight along the sensor's rows, positive in the direction in which the azimuth grows"),
    TAKES(OD_I16, 2, y, INT16_MIN, INT16_MAX, "3071:1", "Camera error y",
          "Target minus line of sight along the sensor's columns, positive in the direction in which the pitch grows"),
    TAKES(OD_U16, 3, time, 0, 65535, "1e-5 s", "Camera exposure",
          "Middle of the exposure, as 3071:5 says: its age, or the node's clock"),
    TAKES(OD_U8, 4, quality, 0, 255, "%", "Camera quality", "0: no target found; 1 .. 100: how sure; see 3071:6"),
    TAKES(OD_U8, 5, counter, 0, 255, "", "Camera frame counter",
          "One more with each frame, 255 is followed by 0; writing it hands the frame over"),
    OD_RECORD_HEAD(0x3071, 8, "Camera", "How the numbers of the camera frames are meant"),
    SETS(OD_F32, 1, params.scale_rad, 1e-9f, 1e-3f, 1e-6f, "rad", "Camera image scale",
         "Error of one count of 3070:1 and :2"),
    SETS(OD_F32, 2, params.mounting.roll_rad, -SCALAR_PI, SCALAR_PI, 0.0f, "rad", "Camera roll",
         "Of the sensor about the line of sight, counter-clockwise in the image"),
    SETS(OD_F32, 3, params.mounting.boresight.x, -0.5f, 0.5f, 0.0f, "rad", "Camera boresight x",
         "Image point at which the target is held, along the azimuth"),
    SETS(OD_F32, 4, params.mounting.boresight.y, -0.5f, 0.5f, 0.0f, "rad", "Camera boresight y",
         "Image point at which the target is held, along the pitch"),
    SETS(
        OD_U8, 5, params.time, 0, 3, 0, "", "Camera time",
        "Where the exposure's time comes from: 0: 3070:3 is its age when the frame arrives; 1: 3070:3 is 3072:8 at the "
        "exposure; 2, 3: the strobe (3074), and 3070:3 as with 0, 1 for a frame without one"),
    SETS(OD_U8, 6, params.min_quality, 1, 100, 1, "%", "Camera minimum quality",
         "A target of less counts as not found"),
    SETS(OD_U8, 7, params.mirrored, 0, 1, 0, "", "Camera mirrored", "1: 3070:1 counts against the sensor's rows"),
    SETS(OD_U16, 8, stated_delay, 0, LONGEST_AGE, 0, "1e-5 s", "Camera stated delay",
         "Added to the age that 3070:3 gives, not to that of the strobe; writing it forgets 3073:5"),
    OD_RECORD_HEAD(0x3072, 10, "Camera state", "What became of the camera frames, and of tracking"),
    REPORTS(OD_U32, 1, taken, U32_HIGHEST, "", "Camera frames taken", "Frames that counted"),
    REPORTS(OD_U32, 2, missed, U32_HIGHEST, "", "Camera frames missed", "Counters that were skipped"),
    REPORTS(OD_U32, 3, dropped, U32_HIGHEST, "", "Camera frames dropped", "Frames that did not count, see 3072:4"),
    REPORTS(
        OD_U8, 4, last_drop, 10, "", "Camera last drop",
        "Why: 0: none dropped; 1: not newer than the last one; 2: older than 127 ms; 3: exposed later than now; "
        "4: quality above 100; 5: 1013 has just been set, and 3070:3 can be meant in both ways; 6: a frozen picture; "
        "7: 3072:9 is 3, 4 or 5; 8: an error of 32767 counts, or above 3.14, a target 72 degrees off; "
        "9: errors that jump to and fro from frame to frame; 10: one far from those around it"),
    REPORTS(
        OD_U8, 5, azimuth_tracking, 6, "", "Azimuth tracking state",
        "0: not tracking; 1: searching; 2: acquiring; 3: on target; 4: coasting; 5: target lost; 6: stopped by 3072:9"),
    REPORTS(OD_U8, 6, pitch_tracking, 6, "", "Pitch tracking state", "As 3072:5"),
    REPORTS(OD_U8, 7, age_ms, 127, "ms", "Camera frame age", "From exposure to the tick that took the newest frame"),
    REPORTS(OD_U16, 8, clock, 65535, "1e-5 s", "Camera clock", "1013 at this tick, for 3070:3"),
    REPORTS(OD_U8, 9, picture_verdict, 5, "", "Camera picture",
            "By the motion of the axes that track: 0: not judged yet, rates are limited to 0.005 to 0.1 rad/s; "
            "1: right; 2: turned by 45 to 60 degrees; 3: turned by more; 4: mirrored; 5: it does not answer; "
            "3 to 5 stop the axes until tracking is ended, or 3071 is written"),
    OD_I16(0x3072, 10, OD_RO, OD_TPDO, camera_objects, picture_roll, -31416, 31416, 0, "1e-4 rad",
           "Camera roll missing", "What 3071:2 lacks, by 3072:9; of a mirrored picture 3071:7 is to be changed, too"),
    OD_RECORD_HEAD(0x3073, 8, "Camera delay", "How old the frames are, measured while both axes track"),
    DELAYS(OD_U8, 1, delay.use, 0, 2, 1, "", "Camera delay use",
           "0: not measured, and forgotten; 1: measured and reported; 2: also corrected"),
    DELAYS(OD_F32, 2, delay.dither_rad, 0.0f, 2e-4f, 1.1e-5f, "rad", "Camera dither amplitude", "Of the elevation"),
    DELAYS(OD_F32, 3, delay.dither_hz, 1.0f, 10.0f, 9.0f, "Hz", "Camera dither frequency", "Of the elevation"),
    OD_U8(0x3073, 4, OD_RW, 0, camera_objects, dither_s, 0, 60, 0, "s", "Camera dither time",
          "Writing it starts the dither while both axes track; counts down to 0"),
    FINDS(OD_I16, 5, delay_error, INT16_MIN, INT16_MAX, 0, "1e-5 s", "Camera delay error", "True age minus stated age"),
    FINDS(OD_U16, 6, delay_half_width, 0, 65535, CAMERA_DELAY_UNKNOWN, "1e-5 s", "Camera delay half width",
          "Half the 95 % interval of 3073:5; 65535: not known"),
    FINDS(OD_I8, 7, correction_ms, -50, 50, 0, "ms", "Camera delay correction", "Added to the stated age"),
    DELAYS(OD_F32, 8, delay.first_dither_rad, 0.0f, 2e-5f, 2.2e-6f, "rad", "Camera first dither amplitude",
           "Runs by itself from when both axes track until 3073:6 is 2.5 ms, for 30 s at most; 0: none"),
    OD_RECORD_HEAD(0x3074, 13, "Camera strobe", "Exposures that the camera's strobe output shows, see 3071:5"),
    STROBES(OD_U16, 1, youngest, 0, LONGEST_AGE, 1100, "1e-5 s", "Strobe youngest age",
            "Of an exposure when its frame arrives"),
    STROBES(OD_U16, 2, oldest, 0, LONGEST_AGE, 2900, "1e-5 s", "Strobe oldest age",
            "3074:2 minus 3074:1 must be less than the time between two frames"),
    STROBES(OD_U16, 3, half_exposure_us, 0, 50000, 0, "us", "Strobe half exposure",
            "From the strobe's rising edge to the middle of the exposure"),
    SEES(OD_U32, 4, strobe_time_us, U32_HIGHEST, "us", "Strobe time", "1013 at the newest edge"),
    SEES(OD_U32, 5, strobe_edges, U32_HIGHEST, "", "Strobe edges", "Rising edges"),
    SEES(OD_U32, 6, strobe_paired, U32_HIGHEST, "", "Strobe frames paired", "Frames whose exposure is known by strobe"),
    SEES(OD_U32, 7, strobe_unpaired, U32_HIGHEST, "", "Strobe frames unpaired",
         "Frames for which the strobe gave no exposure, see 3074:8; 3070:3 counted"),
    SEES(
        OD_U8, 8, strobe_refusal, 3, "", "Strobe last reason",
        "Of 3074:7: 0: none yet; 1: no edge within 3074:1 and :2; 2: several; 3: edges and frame counters out of step"),
    SEES(OD_U32, 9, strobe_missing, U32_HIGHEST, "", "Strobe edges missing", "Edges less than frames"),
    SEES(OD_U32, 10, strobe_additional, U32_HIGHEST, "", "Strobe edges additional", "Edges more than frames"),
    SEES(OD_U32, 11, strobe_floods, U32_HIGHEST, "ms", "Strobe noise",
         "Times with more than 16 edges, which are dropped"),
    SEES(OD_U8, 12, time_source, 2, "", "Camera time in use",
         "By which the newest frame counted: 0: age; 1: 1013; 2: strobe"),
    SEES(OD_U16, 13, strobe_age, 65535, "1e-5 s", "Strobe age", "Of the newest frame that was paired"),
    OD_RECORD_HEAD(0x3075, 3, "Target return", "Of a target that the axes cannot follow within their limits"),
    OD_U16(0x3075, 1, OD_RO, OD_TPDO, camera_objects, back_in_ms, 0, 65535, 0, "ms", "Target back in",
           "Until the line of sight is back on the target; 0: the axes follow it, or nothing is tracked; 65535: not "
           "known, or not within 15 s"),
    OD_U8(0x3075, 2, OD_RW, OD_STORED, camera_objects, turn_back, 0, 1, 0, "", "Turn back",
          "1: the azimuth turns back by one revolution, by itself, when its target leaves the travel"),
    OD_U8(0x3075, 3, OD_RO, OD_TPDO, camera_objects, wrap_state, 0, 2, 0, "", "Cable wrap state",
          "0: the target is within the azimuth's travel, or not known; 1: outside; 2: the azimuth turns back"),
};

const od_table camera_objects_table = {kEntries, sizeof kEntries / sizeof kEntries[0]};

bool camera_objects_hand_over(const od_object *object) {
  return object->entry->index == FRAME_OBJECT && object->entry->sub == FRAME_COUNTER;
}
