#include "node/objects/tuning_objects.h"

#include "node/objects/protection_objects.h"

enum { TUNING_OBJECT = 0x2070, TUNING_COMMAND = 1 };
enum { COMMAND_APPLY = 1, COMMAND_REVERT = 2, COMMAND_UNDO = 3 };

static bool is_command(const od_object *object) {
  return object->entry->index == TUNING_OBJECT && object->entry->sub == TUNING_COMMAND;
}

static od_abort refresh(void *owner, const od_object *object) {
  const tuning_owner *tuned = owner;
  if (object->entry->index == TUNING_OBJECT) {
    axis_tuning_refresh(tuned->tuning);
  }
  return OD_OK;
}

static control_status obey(const tuning_owner *tuned, int64_t command) {
  servo_app *app = &tuned->board->app;
  servo_axis *axis = &app->axis[tuned->axis];
  servo_axis_params *in_force = &app->params.axis[tuned->axis];
  switch (command) {
    case COMMAND_APPLY:
      return axis_tuning_apply(tuned->tuning, axis, in_force, SERVO_TICK_S);
    case COMMAND_REVERT:
      axis_tuning_revert(tuned->tuning);
      return CONTROL_OK;
    case COMMAND_UNDO:
      return axis_tuning_undo(tuned->tuning, axis, in_force, SERVO_TICK_S);
    default:
      return CONTROL_OK;
  }
}

static od_abort accept(void *owner, const od_object *object, od_number value) {
  (void)value;
  return guarded_write(((const tuning_owner *)owner)->lock, object->entry);
}

/* Azimuth's indices become those of the axis. */
static void shift_refusal(parameter_refusal *refusal, uint16_t shift) {
  const uint32_t by = PARAMETER_OBJECT(shift, 0);
  refusal->object += refusal->object != 0 ? by : 0;
  refusal->bound_by += refusal->bound_by != 0 ? by : 0;
}

/* A set that is refused leaves its reason in 0x2070:3 and 0x2070:6 to 9, and nothing else. */
static od_abort execute(void *owner, const od_object *object, od_number value) {
  const tuning_owner *tuned = owner;
  if (!is_command(object) || obey(tuned, value.i) == CONTROL_OK) {
    return OD_OK;
  }
  shift_refusal(&tuned->tuning->refusal, object->part->shift);
  return OD_INCOMPATIBLE;
}

const od_hooks tuning_objects_hooks = {.refresh = refresh, .accept = accept, .execute = execute};
