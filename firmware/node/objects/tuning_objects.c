#include "node/objects/tuning_objects.h"

#include "node/objects/protection_objects.h"
#include "parameters/axis_dictionary.h"

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

_Static_assert(offsetof(axis_tuning, staged) == 0, "rows are read in an axis_parameters, too");

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

/* The set that a command puts into force; NULL: none. */
static const axis_parameters *next_of(const axis_tuning *tuning, int64_t command) {
  switch (command) {
    case COMMAND_APPLY:
      return &tuning->staged;
    case COMMAND_UNDO:
      return &tuning->previous;
    default:
      return NULL;
  }
}

/* A command that would change guarded values needs the lock as a write of them does: they may have been staged by
 * another client, or while the lock was open. */
static od_abort accept(void *owner, const od_object *object, od_number value) {
  const tuning_owner *tuned = owner;
  const axis_parameters *next = is_command(object) ? next_of(tuned->tuning, value.i) : NULL;
  if (next != NULL && !od_same_guarded(&axis_parameters_table, next, &tuned->tuning->active)) {
    return guarded_change(tuned->lock);
  }
  return guarded_write(tuned->lock, object->entry);
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
