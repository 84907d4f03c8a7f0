/* SPDX-License-Identifier: Apache-2.0 */
/* Start values of the board: the parameters of the example machine, sim_host/plants/tracker.toml, as `sim_host serve`
 * designs them. Gains of another machine are sent over CAN (docs/identification.md, docs/gain-design.md). */
#ifndef TRACKSERVO_PRODUCTS_BRUSHED_TRACKER_DEFAULT_PARAMETERS_H
#define TRACKSERVO_PRODUCTS_BRUSHED_TRACKER_DEFAULT_PARAMETERS_H

#include "parameters/axis_parameters.h"
#include "protection/axis_protection.h"
#include "servo/servo_app.h"

extern const axis_parameters default_parameters[SERVO_AXES];
extern const protection_limits default_limits[SERVO_AXES];

#endif
