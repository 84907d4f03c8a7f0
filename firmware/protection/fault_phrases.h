/* SPDX-License-Identifier: Apache-2.0 */
/* What the two tables of fault texts share: phrases that occur in many rows, and the tables for `fault_text_of`. */
#ifndef TRACKSERVO_PROTECTION_FAULT_PHRASES_H
#define TRACKSERVO_PROTECTION_FAULT_PHRASES_H

#include "protection/fault_texts.h"

#define LIMIT(sub_) (UINT64_C(1) << (sub_))
#define ALWAYS "Always."
#define RESET "Fault reset after the condition has ended."
#define NOTHING "Nothing to clear: it is reported once."

/* Rows without a name are in the other table. */
extern const fault_text fault_texts_of_axis[FAULT_COUNT];
extern const fault_text fault_texts_of_node[FAULT_COUNT];

#endif
