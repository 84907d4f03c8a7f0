/* SPDX-License-Identifier: Apache-2.0 */
/* The parameters of one axis as users set them: plain numbers in SI units, members of one struct.
 *
 * `axis_parameter_list.h` has a row for every member: from it comes this struct, and its dictionary, index, limits,
 * default, unit and text. From here to the blocks there is one path: `axis_parameters_build` copies what the list says,
 * designs the filters and the current loop, and checks everything together. So a set of gains is either applied
 * completely or refused completely. */
#ifndef TRACKSERVO_PARAMETERS_AXIS_PARAMETERS_H
#define TRACKSERVO_PARAMETERS_AXIS_PARAMETERS_H

#include <stdbool.h>
#include <stdint.h>

#include "base/refusal.h"
#include "canopen/object_dictionary.h"
#include "parameters/axis_parameter_list.h"
#include "servo/servo_axis.h"

/* NOLINTBEGIN(bugprone-macro-parentheses): member names cannot be put in parentheses. */
#define AXIS_GROUP(index_, highest_, group_, name_, help_) struct {
#define AXIS_REAL(index_, sub_, flags_, group_, member_, low_, high_, default_, unit_, name_, help_, to_) float member_;
#define AXIS_DESIGNED(index_, sub_, flags_, group_, member_, low_, high_, default_, unit_, name_, help_) float member_;
#define AXIS_WHOLE(index_, sub_, flags_, group_, member_, low_, high_, default_, name_, help_, to_, type_) \
  uint32_t member_;
#define AXIS_DIRECTION(sub_, side_, title_) lugre_direction side_;
/* clang-format off */
#define AXIS_END(group_) } group_;
/* clang-format on */
/* NOLINTEND(bugprone-macro-parentheses) */

/* speed_loop.proportional_nm_s_rad and so on. Only 4-byte members, so that the struct has no padding and its bytes can
 * be compared and summed (CRC). */
typedef struct {
  AXIS_PARAMETERS(AXIS_GROUP, AXIS_REAL, AXIS_DESIGNED, AXIS_WHOLE, AXIS_DIRECTION, AXIS_END)
} axis_parameters;

/* The anti-windup rate (2000:4) counts up to so many times ki/kp. */
#define ANTI_WINDUP_FACTOR 2.0f

/* Designs filters and gains and checks them. Writes `*built` only if it returns CONTROL_OK. Not for the tick: about 100
 * us on a board. */
control_status axis_parameters_build(const axis_parameters *parameters, servo_axis_params *built);

/* Returns why axis_parameters_build refuses these parameters: the value that is wrong and what would be right; status
 * CONTROL_OK if it accepts them. Checks first each value by itself, by the ranges of the list, then what must hold
 * between two. Cost: that of axis_parameters_build, and the search for a row when something is wrong. */
parameter_refusal axis_parameters_check(const axis_parameters *parameters);

/* Return whether a row of axis_parameters_table is a member of axis_parameters, and the value of this member. */
bool axis_parameters_has(const od_entry *entry);
float axis_parameters_value(const axis_parameters *parameters, const od_entry *entry);

/* Returns the CRC-32 (IEEE 802.3) over the values, to distinguish sets. */
uint32_t axis_parameters_crc(const axis_parameters *parameters);

#endif
