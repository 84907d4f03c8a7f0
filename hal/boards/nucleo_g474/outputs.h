/* SPDX-License-Identifier: Apache-2.0 */
/* The pins that must be off in a reset and after a fault. */
#ifndef TRACKSERVO_NUCLEO_G474_OUTPUTS_H
#define TRACKSERVO_NUCLEO_G474_OUTPUTS_H

enum { AZIMUTH_ENABLE_PIN = 8, PITCH_ENABLE_PIN = 9 }; /* of port C */
enum { AZIMUTH_BRAKE_PIN = 15, PITCH_BRAKE_PIN = 9 };  /* of port B */

#endif
