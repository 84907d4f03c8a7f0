/* SPDX-License-Identifier: Apache-2.0 */
#include "node/objects/tuning_objects.h"

#include "node/objects/protection_objects.h"
#include "parameters/axis_dictionary.h"

enum { TUNING_OBJECT = 0x2070, TUNING_COMMAND = 1, TUNING_FLAGS = 2 };
enum { COMMAND_APPLY = 1, COMMAND_REVERT = 2, COMMAND_UNDO = 3, COMMAND_OVERRIDE = 4 };

static bool is_command(const od_object *object) {
  return object->entry->index == TUNING_OBJECT && object->entry->sub == TUNING_COMMAND;
}

static od_abort refresh(void *owner, const od_object *object) {
  const tuning_owner *tuned = owner;
  if (object->entry->index == TUNING_OBJECT && object->entry->sub == TUNING_FLAGS) {
    axis_tuning_refresh(tuned->tuning);
  }
  return OD_OK;
}

_Static_assert(offsetof(axis_tuning, staged) == 0, "rows are read in an axis_parameters, too");

static control_status apply(const tuning_owner *tuned) {
  servo_app *app = &tuned->board->app;
  return axis_tuning_apply(tuned->tuning, &app->axis[tuned->axis], &app->params.axis[tuned->axis], SERVO_TICK_S);
}

/* The staged set becomes active when it is stable; OD_PENDING: the check goes on in the next ms. */
static od_abort apply_stable(const tuning_owner *tuned) {
  switch (axis_tuning_judge(tuned->tuning)) {
    case LOOP_RUNNING:
      return OD_PENDING;
    case LOOP_STABLE:
      if (apply(tuned) == CONTROL_OK) {
        tuned->tuning->overridden = false;
        return OD_OK;
      }
      return OD_INCOMPATIBLE;
    case LOOP_REFUSED:
    default:
      return OD_INCOMPATIBLE;
  }
}

static od_abort obey(const tuning_owner *tuned, int64_t command) {
  switch (command) {
    case COMMAND_APPLY:
      return apply_stable(tuned);
    case COMMAND_REVERT:
      axis_tuning_revert(tuned->tuning);
      return OD_OK;
    case COMMAND_UNDO:
      axis_tuning_stage_previous(tuned->tuning);
      return apply_stable(tuned);
    case COMMAND_OVERRIDE:
      if (apply(tuned) != CONTROL_OK) {
        return OD_INCOMPATIBLE;
      }
      tuned->tuning->overridden = true;
      return OD_OK;
    default:
      return OD_OK;
  }
}

/* The set that a command puts into force; NULL: none. */
static const axis_parameters *next_of(const axis_tuning *tuning, int64_t command) {
  switch (command) {
    case COMMAND_APPLY:
    case COMMAND_OVERRIDE:
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
  if (is_command(object) && value.i == COMMAND_OVERRIDE && !access_lock_is_open(tuned->lock)) {
    return OD_DEVICE_STATE;
  }
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
  if (!is_command(object)) {
    return OD_OK;
  }
  const od_abort answer = obey(tuned, value.i);
  if (answer == OD_INCOMPATIBLE) {
    shift_refusal(&tuned->tuning->refusal, object->part->shift);
  }
  return answer;
}

const od_hooks tuning_objects_hooks = {.refresh = refresh, .accept = accept, .execute = execute};
