/* SPDX-License-Identifier: Apache-2.0 */
/* Storing and restoring parameters by command: objects 0x1010 and 0x1011.
 *
 * Standard: CiA 301 v4.2.0, clauses 7.5.2.13 and 7.5.2.14: only the signatures "save" and "load" act. The application
 * defines what storing means: a callback that may take many ticks (OD_PENDING) and may fail (OD_HARDWARE). */
#ifndef TRACKSERVO_CANOPEN_STORAGE_H
#define TRACKSERVO_CANOPEN_STORAGE_H

#include "canopen/object_dictionary.h"

/* Sub-indices of both objects. */
enum { STORAGE_ALL = 1, STORAGE_COMMUNICATION = 2, STORAGE_APPLICATION = 3, STORAGE_GROUPS = 3 };

#define STORAGE_SAVE 0x65766173u /* "save", lowest byte first */
#define STORAGE_LOAD 0x64616F6Cu /* "load" */

/* The value of both objects: saves, or restores, on command and not autonomously. */
#define STORAGE_ON_COMMAND 1u

typedef struct {
  /* Each receives STORAGE_* and returns OD_OK, OD_PENDING (called again in the next tick) or an error. NULL: the device
   * does not support it, OD_HARDWARE. Restored values take effect after the next reset. */
  od_abort (*save)(void *context, uint8_t group);
  od_abort (*restore)(void *context, uint8_t group);
  void *context;
} storage_callbacks;

/* Checks that `value` is the signature for 0x1010 (saving) or 0x1011; refuses a wrong one with 0800 0020. */
od_abort storage_accept(bool saving, uint32_t value);

/* Saves or restores; returns the answer of the callback. */
od_abort storage_execute(const storage_callbacks *callbacks, bool saving, uint8_t group);

#endif
