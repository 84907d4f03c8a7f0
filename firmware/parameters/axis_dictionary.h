/* SPDX-License-Identifier: Apache-2.0 */
/* The rows of one axis' parameters in the object dictionary: index, limits, default, unit, text.
 *
 * The offsets point into `axis_tuning`: gains into its staged set, 0x2070 into its state. The table serves both axes,
 * the second shifted by AXIS_INDEX_SHIFT. EDS, parameters.json and the CAN reference page are printed from it. */
#ifndef TRACKSERVO_PARAMETERS_AXIS_DICTIONARY_H
#define TRACKSERVO_PARAMETERS_AXIS_DICTIONARY_H

#include "canopen/object_dictionary.h"

/* From an object of the first axis to the same object of the second. */
enum { AXIS_INDEX_SHIFT = 0x800 };

extern const od_table axis_parameters_table;

#endif
