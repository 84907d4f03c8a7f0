/* SPDX-License-Identifier: Apache-2.0 */
/* Whether the feedforwards of a set fit the axis: they act without a rate error, so the check of the loops says nothing
 * about them, and a value that is much too large takes the whole torque of the motor from the loop.
 *
 *     acceleration feedforward (2000:5)             at most 3 times the plant's inertia (2056:1)
 *     Coulomb and break-away torque (2030:7 to 12)  at most half of the motor's torque (2055:1 times 2055:6)
 *     viscous coefficient (2030:10, 14)             at most 3 times the plant's (2056:3)
 *     bristle damping (2030:6), LuGre only          at most 3 times the plant's (2056:5)
 *
 * The values of 2030 count times the feedforward's gain (2030:2), and only while a model is on (2030:1). Both
 * coefficients per rate may always be as large as half of the motor's torque at 1 rad/s: where the plant's is next to
 * nothing, a factor on it says little. The plant's own Coulomb torque is not in 2056. Half of the motor's torque leaves
 * the loop as much as the feedforward may take, so that it holds the axis against any feedforward. A motor without
 * twice the torque of its seal would have none left to accelerate. */
#ifndef TRACKSERVO_PARAMETERS_FEEDFORWARD_CHECK_H
#define TRACKSERVO_PARAMETERS_FEEDFORWARD_CHECK_H

#include "parameters/axis_parameters.h"

#define FEEDFORWARD_PLANT_FACTOR 3.0f
#define FEEDFORWARD_MOTOR_SHARE 0.5f

/* Returns status CONTROL_UNSTABLE with the first value that is too large, its permitted range and the value that sets
 * the limit, else CONTROL_OK. The set must be one that axis_parameters_build accepts. */
parameter_refusal feedforward_check(const axis_parameters *set);

#endif
