/* SPDX-License-Identifier: Apache-2.0 */
/* Macros that write the rows of an object dictionary table.
 *
 * Each is one initialiser of `od_entry` (object_dictionary.h); the size of the member is compared with that of the type
 * at compile time. Include this only where a table is written. */
#ifndef TRACKSERVO_CANOPEN_OBJECT_DICTIONARY_ROWS_H
#define TRACKSERVO_CANOPEN_OBJECT_DICTIONARY_ROWS_H

#include "canopen/object_dictionary.h"

/* The last members of a row: texts for people. */
#ifdef OD_WITHOUT_TEXTS
#define OD_TEXTS(name_, unit_, help_)
#else
#define OD_TEXTS(name_, unit_, help_) .name = (name_), .unit = (unit_), .help = (help_)
#endif

/* offsetof, or a compile error about a negative array size when the member's size does not match the type. */
#define OD_OFFSET(struct_, member_, bytes_) \
  ((uint32_t)(offsetof(struct_, member_) + 0 * sizeof(char[sizeof(((struct_ *)0)->member_) == (bytes_) ? 1 : -1])))

#define OD_ROW_I(type_, bytes_, index_, sub_, access_, flags_, struct_, member_, low_, high_, preset_, unit_, name_, \
                 help_)                                                                                              \
  {                                                                                                                  \
    .index = (index_), .sub = (sub_), .type = (type_), .access = (access_), .flags = (flags_), .bytes = (bytes_),    \
    .offset = OD_OFFSET(struct_, member_, bytes_), .low = {.i = (low_)}, .high = {.i = (high_)},                     \
    .preset = {.i = (preset_)}, OD_TEXTS(name_, unit_, help_)                                                        \
  }

/* (index, sub, access, flags, struct, member, low, high, default, unit, name, help) */
#define OD_BOOL(...) OD_ROW_I(OD_BOOLEAN, 1, __VA_ARGS__)
#define OD_I8(...) OD_ROW_I(OD_INTEGER8, 1, __VA_ARGS__)
#define OD_I16(...) OD_ROW_I(OD_INTEGER16, 2, __VA_ARGS__)
#define OD_I32(...) OD_ROW_I(OD_INTEGER32, 4, __VA_ARGS__)
#define OD_U8(...) OD_ROW_I(OD_UNSIGNED8, 1, __VA_ARGS__)
#define OD_U16(...) OD_ROW_I(OD_UNSIGNED16, 2, __VA_ARGS__)
#define OD_U32(...) OD_ROW_I(OD_UNSIGNED32, 4, __VA_ARGS__)
#define OD_U64(...) OD_ROW_I(OD_UNSIGNED64, 8, __VA_ARGS__)

/* The same, with float limits and default. */
#define OD_F32(index_, sub_, access_, flags_, struct_, member_, low_, high_, preset_, unit_, name_, help_)   \
  {                                                                                                          \
    .index = (index_), .sub = (sub_), .type = OD_REAL32, .access = (access_), .flags = (flags_), .bytes = 4, \
    .offset = OD_OFFSET(struct_, member_, 4), .low = {.f = (low_)}, .high = {.f = (high_)},                  \
    .preset = {.f = (preset_)}, OD_TEXTS(name_, unit_, help_)                                                \
  }

/* A constant number that needs no memory: (type, index, sub, flags, value, name, help). */
#define OD_FIXED(type_, bytes_, index_, sub_, flags_, value_, name_, help_)                                      \
  {                                                                                                              \
    .index = (index_), .sub = (sub_), .type = (type_), .access = OD_CONST, .flags = (flags_), .bytes = (bytes_), \
    .offset = OD_NO_VALUE, .low = {.i = (value_)}, .high = {.i = (value_)}, .preset = {.i = (value_)},           \
    OD_TEXTS(name_, "", help_)                                                                                   \
  }

/* Sub-index 0 of a RECORD, and of an ARRAY, with the number of the highest sub-index and the object's name. */
#define OD_RECORD_HEAD(index_, highest_, name_, help_) \
  OD_FIXED(OD_UNSIGNED8, 1, index_, 0, OD_RECORD, highest_, name_, help_)
#define OD_ARRAY_HEAD(index_, highest_, name_, help_) \
  OD_FIXED(OD_UNSIGNED8, 1, index_, 0, OD_RECORD | OD_ARRAY, highest_, name_, help_)

/* Text in a char array of the struct; the array may be full, without a final zero. */
#define OD_TEXT(index_, sub_, access_, flags_, struct_, member_, preset_, name_, help_)                    \
  {                                                                                                        \
    .index = (index_), .sub = (sub_), .type = OD_VISIBLE_STRING, .access = (access_), .flags = (flags_),   \
    .bytes = (uint16_t)sizeof(((struct_ *)0)->member_),                                                    \
    .offset = OD_OFFSET(struct_, member_, sizeof(((struct_ *)0)->member_)), .preset = {.text = (preset_)}, \
    OD_TEXTS(name_, "", help_)                                                                             \
  }

/* Constant text that needs no memory. */
#define OD_FIXED_TEXT(index_, sub_, value_, name_, help_)                                         \
  {                                                                                               \
    .index = (index_), .sub = (sub_), .type = OD_VISIBLE_STRING, .access = OD_CONST, .flags = 0,  \
    .bytes = (uint16_t)(sizeof(value_) - 1), .offset = OD_NO_VALUE, .preset = {.text = (value_)}, \
    OD_TEXTS(name_, "", help_)                                                                    \
  }

/* Streamed by the part's hooks. */
#define OD_STREAM(index_, sub_, access_, name_, help_)                                                \
  {                                                                                                   \
    .index = (index_), .sub = (sub_), .type = OD_DOMAIN, .access = (access_), .flags = 0, .bytes = 0, \
    .offset = OD_NO_VALUE, OD_TEXTS(name_, "", help_)                                                 \
  }

#endif
