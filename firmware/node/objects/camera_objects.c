#include "node/objects/camera_objects.h"

#include "base/scalar.h"
#include "canopen/object_dictionary_rows.h"

enum { FRAME_OBJECT = 0x3070, FRAME_COUNTER = 5 };

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
    OD_RECORD_HEAD(0x3071, 6, "Camera", "How the numbers of the camera frames are meant"),
    SETS(OD_F32, 1, params.scale_rad, 1e-9f, 1e-3f, 1e-6f, "rad", "Camera image scale",
         "Error of one count of 3070:1 and :2"),
    SETS(OD_F32, 2, params.mounting.roll_rad, -SCALAR_PI, SCALAR_PI, 0.0f, "rad", "Camera roll",
         "Of the sensor about the line of sight, counter-clockwise in the image"),
    SETS(OD_F32, 3, params.mounting.boresight.x, -0.5f, 0.5f, 0.0f, "rad", "Camera boresight x",
         "Image point at which the target is held, along the azimuth"),
    SETS(OD_F32, 4, params.mounting.boresight.y, -0.5f, 0.5f, 0.0f, "rad", "Camera boresight y",
         "Image point at which the target is held, along the pitch"),
    SETS(OD_U8, 5, params.time, 0, 1, 0, "", "Camera time",
         "What 3070:3 holds: 0: age when the frame arrives; 1: 3072:8 at the exposure"),
    SETS(OD_U8, 6, params.min_quality, 1, 100, 1, "%", "Camera minimum quality",
         "A target of less counts as not found"),
    OD_RECORD_HEAD(0x3072, 8, "Camera state", "What became of the camera frames, and of tracking"),
    REPORTS(OD_U32, 1, taken, U32_HIGHEST, "", "Camera frames taken", "Frames that counted"),
    REPORTS(OD_U32, 2, missed, U32_HIGHEST, "", "Camera frames missed", "Counters that were skipped"),
    REPORTS(OD_U32, 3, dropped, U32_HIGHEST, "", "Camera frames dropped", "Frames that did not count, see 3072:4"),
    REPORTS(OD_U8, 4, last_drop, 4, "", "Camera last drop",
            "Why: 0: none dropped; 1: not newer than the last one; 2: older than 127 ms; 3: exposed later than now; "
            "4: quality above 100"),
    REPORTS(OD_U8, 5, azimuth_tracking, 5, "", "Azimuth tracking state",
            "0: not tracking; 1: searching; 2: acquiring; 3: on target; 4: coasting; 5: target lost"),
    REPORTS(OD_U8, 6, pitch_tracking, 5, "", "Pitch tracking state", "As 3072:5"),
    REPORTS(OD_U8, 7, age_ms, 127, "ms", "Camera frame age", "From exposure to the tick that took the newest frame"),
    REPORTS(OD_U16, 8, clock, 65535, "1e-5 s", "Camera clock", "The node's clock at this tick, for 3070:3"),
    OD_RECORD_HEAD(0x3073, 7, "Camera delay", "How old the frames are, measured while both axes track"),
    DELAYS(OD_U8, 1, delay.use, 0, 2, 1, "", "Camera delay use",
           "0: not measured, and forgotten; 1: measured and reported; 2: also corrected"),
    DELAYS(OD_F32, 2, delay.dither_rad, 0.0f, 2e-4f, 2e-5f, "rad", "Camera dither amplitude", "Of the elevation"),
    DELAYS(OD_F32, 3, delay.dither_hz, 1.0f, 10.0f, 5.0f, "Hz", "Camera dither frequency", "Of the elevation"),
    OD_U8(0x3073, 4, OD_RW, 0, camera_objects, dither_s, 0, 60, 0, "s", "Camera dither time",
          "Writing it starts the dither while both axes track; counts down to 0"),
    FINDS(OD_I16, 5, delay_error, INT16_MIN, INT16_MAX, 0, "1e-5 s", "Camera delay error", "True age minus stated age"),
    FINDS(OD_U16, 6, delay_half_width, 0, 65535, CAMERA_DELAY_UNKNOWN, "1e-5 s", "Camera delay half width",
          "Half the 95 % interval of 3073:5; 65535: not known"),
    FINDS(OD_I8, 7, correction_ms, -50, 50, 0, "ms", "Camera delay correction", "Added to the stated age"),
};

const od_table camera_objects_table = {kEntries, sizeof kEntries / sizeof kEntries[0]};

static void changed(void *owner, const od_object *object) {
  camera_objects *objects = owner;
  objects->arrived = objects->arrived || (object->entry->index == FRAME_OBJECT && object->entry->sub == FRAME_COUNTER);
}

static unsigned needed(const od_object *object) {
  return object->entry->index == FRAME_OBJECT && object->entry->sub == FRAME_COUNTER ? OD_HOOK_CHANGED : 0u;
}

const od_hooks camera_objects_hooks = {.changed = changed, .needed = needed};
