#include "node/tuning_objects.h"

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

/* A refused apply leaves its reason in 0x2070:3 and nothing else; the command cannot be mapped into a PDO. */
static od_abort accept(void *owner, const od_object *object, od_number value) {
  const tuning_owner *tuned = owner;
  if (!is_command(object) || value.i != COMMAND_APPLY) {
    return OD_OK;
  }
  servo_axis_params built;
  tuned->tuning->last_result = (uint32_t)axis_parameters_build(&tuned->tuning->staged, &built);
  return tuned->tuning->last_result == CONTROL_OK ? OD_OK : OD_INCOMPATIBLE;
}

static void changed(void *owner, const od_object *object) {
  const tuning_owner *tuned = owner;
  if (!is_command(object)) {
    return;
  }
  servo_app *app = &tuned->board->app;
  servo_axis *axis = &app->axis[tuned->axis];
  servo_axis_params *in_force = &app->params.axis[tuned->axis];
  switch (tuned->tuning->command) {
    case COMMAND_APPLY:
      (void)axis_tuning_apply(tuned->tuning, axis, in_force, SERVO_TICK_S); /* accept() has checked it */
      break;
    case COMMAND_REVERT:
      axis_tuning_revert(tuned->tuning);
      break;
    case COMMAND_UNDO:
      (void)axis_tuning_undo(tuned->tuning, axis, in_force, SERVO_TICK_S); /* was in force before */
      break;
    default:
      break;
  }
}

const od_hooks tuning_objects_hooks = {.refresh = refresh, .accept = accept, .changed = changed};
