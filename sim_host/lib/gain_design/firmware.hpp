// SPDX-License-Identifier: Apache-2.0
// The firmware's public headers, as C++ sees them: gains are designed for, and checked by, the code that will use them.
#ifndef TRACKSERVO_GAIN_DESIGN_FIRMWARE_HPP
#define TRACKSERVO_GAIN_DESIGN_FIRMWARE_HPP

extern "C" {
#include "parameters/axis_parameters.h"
#include "servo/servo_app.h"
}

#endif
