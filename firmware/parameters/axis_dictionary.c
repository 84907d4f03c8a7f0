/* SPDX-License-Identifier: Apache-2.0 */
#include "parameters/axis_dictionary.h"

#include "canopen/object_dictionary_rows.h"
#include "parameters/axis_tuning.h"

/* No limit of a parameter is larger. */
#define LARGEST 1e9f

#define ROW_GROUP(index_, highest_, group_, name_, help_) OD_RECORD_HEAD(index_, highest_, name_, help_),
#define ROW_REAL(index_, sub_, flags_, group_, member_, low_, high_, default_, unit_, name_, help_, to_)         \
  OD_F32(index_, sub_, OD_RW, OD_STORED | ((flags_)&DICTIONARY_FLAGS), axis_tuning, staged.group_.member_, low_, \
         high_, default_, unit_, name_, help_),
#define ROW_DESIGNED(...) ROW_REAL(__VA_ARGS__, by_hand)
#define ROW_WHOLE(index_, sub_, flags_, group_, member_, low_, high_, default_, name_, help_, to_, type_)        \
  OD_U32(index_, sub_, OD_RW, OD_STORED | ((flags_)&DICTIONARY_FLAGS), axis_tuning, staged.group_.member_, low_, \
         high_, default_, "", name_, help_),
#define ROW_DIRECTION(sub_, side_, title_) FRICTION_DIRECTION_ROWS(ROW_REAL, sub_, side_, title_)
#define ROW_END(group_)

static const od_entry kEntries[] = {
    /* clang-format off */
    AXIS_PARAMETERS(ROW_GROUP, ROW_REAL, ROW_DESIGNED, ROW_WHOLE, ROW_DIRECTION, ROW_END)
    /* clang-format on */

    OD_RECORD_HEAD(0x2070, 9, "Parameter set", "All staged values become active together, or none does"),
    OD_U8(0x2070, 1, OD_RW, 0, axis_tuning, command, 0, 4, 0, "", "Parameter set command",
          "1: apply the staged set; 2: copy the active set to the staged set; 3: undo the last apply; 4: apply without "
          "the check of stability (open 0x3040 first)"),
    OD_U32(0x2070, 2, OD_RO, 0, axis_tuning, flags, 0, 3, 0, "", "Parameter set flags",
           "Bit 0: staged set differs from active set; bit 1: active set differs from the one in flash"),
    OD_U32(0x2070, 3, OD_RO, 0, axis_tuning, last_result, 0, 4, 0, "", "Parameter set result",
           "Result of the last apply: 0: applied; 1: not finite; 2: out of range; 3: inconsistent; "
           "4: unstable on the identified plant 0x2056, or a feedforward beyond plant or motor"),
    OD_U32(0x2070, 4, OD_RO, 0, axis_tuning, active_crc, 0, INT64_C(0xFFFFFFFF), 0, "", "Active set CRC",
           "CRC-32 of the active set"),
    OD_U32(0x2070, 5, OD_RO, 0, axis_tuning, stored_crc, 0, INT64_C(0xFFFFFFFF), 0, "", "Stored set CRC",
           "CRC-32 of the parameter set that 0x1010 saved last"),
    OD_U32(0x2070, 6, OD_RO, 0, axis_tuning, refusal.object, 0, INT64_C(0xFFFFFFFF), 0, "", "Refused parameter",
           "Value that made the last apply fail, as index << 16 | sub-index << 8; 0: none"),
    OD_F32(0x2070, 7, OD_RO, 0, axis_tuning, refusal.low, -LARGEST, LARGEST, 0.0f, "", "Refused parameter low limit",
           "Smallest value that 2070:6 may have, in its unit, while all other values stay"),
    OD_F32(0x2070, 8, OD_RO, 0, axis_tuning, refusal.high, -LARGEST, LARGEST, 0.0f, "", "Refused parameter high limit",
           "Largest value that 2070:6 may have, likewise"),
    OD_U32(0x2070, 9, OD_RO, 0, axis_tuning, refusal.bound_by, 0, INT64_C(0xFFFFFFFF), 0, "", "Refused parameter bound",
           "Parameter that sets one of these limits, coded as 2070:6; 0: both limits are fixed"),
};

const od_table axis_parameters_table = {kEntries, sizeof kEntries / sizeof kEntries[0]};
