// The firmware's public headers, as C++ sees them: gains are designed for, and checked by, the code that will use them.
#ifndef TRACKSERVO_GAIN_DESIGN_FIRMWARE_HPP
#define TRACKSERVO_GAIN_DESIGN_FIRMWARE_HPP

extern "C" {
#include "app/servo_app.h"
#include "parameters/axis_parameters.h"
}

#endif
