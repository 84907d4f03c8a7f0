/* SPDX-License-Identifier: Apache-2.0 */
/* The object dictionary: typed entries as data, found by index and sub-index.
 *
 * Standard: CiA 301 v4.2.0, clause 7.4 (object dictionary, data types) and table 22 (SDO abort codes). A dictionary
 * consists of a few parts. A part is one const table of entries and the struct of their values. So one table serves
 * both axes (the second with its indices shifted by 0x800), many nodes can run in one process, and EDS, DBC and
 * documentation are printed from the same rows. */
#ifndef TRACKSERVO_CANOPEN_OBJECT_DICTIONARY_H
#define TRACKSERVO_CANOPEN_OBJECT_DICTIONARY_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

/* The numbers are those of CiA 301, table 44. */
typedef enum {
  OD_BOOLEAN = 0x01,
  OD_INTEGER8 = 0x02,
  OD_INTEGER16 = 0x03,
  OD_INTEGER32 = 0x04,
  OD_UNSIGNED8 = 0x05,
  OD_UNSIGNED16 = 0x06,
  OD_UNSIGNED32 = 0x07,
  OD_REAL32 = 0x08,
  OD_VISIBLE_STRING = 0x09,
  OD_DOMAIN = 0x0F,
  OD_UNSIGNED64 = 0x1B
} od_type;

typedef enum {
  OD_CONST, /* never changes */
  OD_RO,
  OD_WO,
  OD_RW
} od_access;

/* Flags of an entry. */
enum {
  OD_RPDO = 1,     /* may be mapped into an RPDO */
  OD_TPDO = 2,     /* may be mapped into a TPDO */
  OD_EVENT = 4,    /* a change of this mapped value sends an event-driven TPDO */
  OD_NODE_ID = 8,  /* the node id is added to the default */
  OD_ARRAY = 16,   /* on sub-index 0: the object is an ARRAY, not a RECORD; for the EDS only */
  OD_STORED = 32,  /* belongs to what 0x1010 saves and 0x1011 restores */
  OD_RECORD = 64,  /* on sub-index 0: the head of an ARRAY or RECORD; `name` is that of the whole object */
  OD_GUARDED = 128 /* can cause damage: the application allows a write only after an unlock */
};

/* SDO abort codes; OD_OK and OD_PENDING are internal and are never sent. */
typedef enum {
  OD_OK = 0,
  OD_PENDING = 1, /* execute() only: not done yet, ask again in the next tick */
  OD_TOGGLE = 0x05030000,
  OD_TIME_OUT = 0x05040000,
  OD_BAD_COMMAND = 0x05040001,
  OD_BAD_BLOCK_SIZE = 0x05040002,
  OD_BAD_SEQUENCE = 0x05040003,
  OD_BAD_CRC = 0x05040004,
  OD_UNSUPPORTED = 0x06010000,
  OD_WRITE_ONLY = 0x06010001,
  OD_READ_ONLY = 0x06010002,
  OD_NO_OBJECT = 0x06020000,
  OD_NOT_MAPPABLE = 0x06040041,
  OD_MAPPING_TOO_LONG = 0x06040042,
  OD_INCOMPATIBLE = 0x06040043,
  OD_HARDWARE = 0x06060000,
  OD_WRONG_LENGTH = 0x06070010,
  OD_TOO_LONG = 0x06070012,
  OD_TOO_SHORT = 0x06070013,
  OD_NO_SUB = 0x06090011,
  OD_BAD_VALUE = 0x06090030,
  OD_TOO_HIGH = 0x06090031,
  OD_TOO_LOW = 0x06090032,
  OD_GENERAL = 0x08000000,
  OD_NOT_TRANSFERRED = 0x08000020,
  OD_LOCAL_CONTROL = 0x08000021,
  OD_DEVICE_STATE = 0x08000022,
  OD_NO_DATA = 0x08000024
} od_abort;

/* A value outside its struct: REAL32 in f, text in text, every other type in i (UNSIGNED64 as its bit pattern). */
typedef union {
  int64_t i;
  float f;
  const char *text;
} od_number;

/* One row. Rows of a table are sorted by index, then sub-index. */
typedef struct {
  uint8_t type; /* od_type */
  uint8_t sub;
  uint16_t index;
  uint8_t access;        /* od_access */
  uint8_t flags;         /* OD_* flags */
  uint16_t bytes;        /* size of the value; capacity of a string; 0 for DOMAIN */
  uint32_t offset;       /* offset of the value in the part's struct, or OD_NO_VALUE: the default is the value */
  od_number low;         /* smallest value that a write may have; not used by strings and DOMAIN */
  od_number high;        /* largest */
  od_number preset;      /* default; of a string: its text */
#ifndef OD_WITHOUT_TEXTS /* a board needs none of these; leaving them out saves 20 KiB */
  const char *name;      /* as in the EDS, unique within the dictionary */
  const char *unit;      /* SI, "" when there is none */
  const char *help;      /* one sentence for the person who tunes the drive */
#endif
} od_entry;

#define OD_NO_VALUE UINT32_MAX

typedef struct {
  const od_entry *entries;
  uint32_t count;
} od_table;

typedef struct od_part od_part;

/* Result of a search: valid as long as its part. */
typedef struct {
  const od_part *part;
  const od_entry *entry;
} od_object;

/* Hooks of an object, as bits. */
enum { OD_HOOK_REFRESH = 1, OD_HOOK_ACCEPT = 2, OD_HOOK_CHANGED = 4, OD_HOOK_EXECUTE = 8, OD_HOOK_WAITS = 16 };

/* Hooks of the owner of a part, beside plain storage; each may be NULL. */
typedef struct {
  /* Before a read: brings the value up to date. */
  od_abort (*refresh)(void *owner, const od_object *object);
  /* Before a write that passed type and limits: judges the value, and may refuse it. It changes nothing, since a PDO
   * checks all its objects before it writes any. Not called for strings and DOMAIN. */
  od_abort (*accept)(void *owner, const od_object *object, od_number value);
  /* A write that was accepted, before its value is stored: carries out a command. Called once for each write, by SDO
   * and by RPDO, also when the value does not change. OD_OK: the value is stored and `changed` is called. Any
   * other answer: neither happens, and
   * - an SDO client gets the abort code; with OD_PENDING, accept and execute are called again in the next tick;
   * - an RPDO writes its other objects, since some may have been written before, and is counted as refused. A command
   *   that answers OD_PENDING must not be mappable, because nothing calls it again.
   * Not called for strings and DOMAIN. */
  od_abort (*execute)(void *owner, const od_object *object, od_number value);
  /* After a write. */
  void (*changed)(void *owner, const od_object *object);
  /* Whether this value is a stop: it takes effect even when another object of the same RPDO refuses its value. Such an
   * object has no accept(). NULL: none is. */
  bool (*stops)(const od_object *object, od_number value);
  /* Takes a stop that must wait (see waits), and whose frame cannot: it takes effect in a later tick, in its turn. */
  void (*defer)(void *owner, const od_object *object, od_number value);
  /* Whether the value of this object has been written and has not taken effect yet. A different one waits for it: an
   * SDO download until the next tick, an RPDO and all process data behind it likewise. NULL: none waits. */
  bool (*waits)(void *owner, const od_object *object);
  /* Which hooks an object needs, a sum of OD_HOOK_*; NULL: every hook that is set. Called when a PDO is mapped, so that
   * values without hooks are copied directly. */
  unsigned (*needed)(const od_object *object);

  /* DOMAIN, any length, at most one transfer per SDO server at a time. `begin` returns the size when reading, and
   * receives the announced size (OD_SIZE_UNKNOWN if none) when writing. Reads may come at any offset within the size,
   * also twice; writes come in order. `end` with complete = false discards what was written. */
  od_abort (*stream_begin)(void *owner, const od_object *object, bool writing, uint32_t *size);
  od_abort (*stream_read)(void *owner, const od_object *object, uint32_t offset, uint8_t *bytes, uint32_t length);
  od_abort (*stream_write)(void *owner, const od_object *object, uint32_t offset, const uint8_t *bytes,
                           uint32_t length);
  od_abort (*stream_end)(void *owner, const od_object *object, bool writing, bool complete, uint32_t total);
} od_hooks;

#define OD_SIZE_UNKNOWN UINT32_MAX

struct od_part {
  od_table table;
  uint16_t shift;     /* added to every index of the table: 0x800 for the second axis */
  bool has_commands;  /* a reset of the application gives its values their defaults */
  bool measures;      /* an RPDO writes what a sensor measures: a PDO of such objects alone is no word of the master */
  const char *prefix; /* prefix of every name in EDS, DBC and documentation; "" for none */
  void *values;       /* the struct to which the offsets of the table refer */
  void *owner;        /* passed to the hooks */
  const od_hooks *hooks; /* NULL: plain storage */
  const void *defaults;  /* values as in the struct, the defaults of what is OD_STORED; NULL: those of the table */
};

/* Indices in groups of 0x800, the shift between the axes; one bit per part that has objects in the group. */
enum { OD_GROUPS = 32, OD_GROUP_SHIFT = 11, OD_GROUPED_PARTS = 32 };

typedef struct {
  uint32_t parts[OD_GROUPS];
} od_groups;

typedef struct {
  const od_part *parts;
  uint32_t count;
  const od_groups *groups; /* of these parts, by od_group_parts(); NULL: a search tries all of them */
} object_dictionary;

/* Groups the parts, at most OD_GROUPED_PARTS of them. */
void od_group_parts(od_groups *groups, const od_part *parts, uint32_t count);

/* Finds an object. Returns OD_OK, OD_NO_OBJECT or OD_NO_SUB. Cost: a binary search in each part that can have the
 * object. */
od_abort od_find(const object_dictionary *dictionary, uint16_t index, uint8_t sub, od_object *object);

/* Returns the index as the bus sees it. */
uint16_t od_index(const od_object *object);

/* Returns the address of the value in the part's struct, or NULL when the default is the value. */
uint8_t *od_place(const od_object *object);

/* Returns the hooks to call when this object is read or written, a sum of OD_HOOK_*. */
unsigned od_needed_hooks(const od_object *object);

/* Returns whether this value must wait because an earlier one has not taken effect yet (od_hooks.waits). */
bool od_must_wait(const od_object *object, const uint8_t *bytes);

/* Returns whether the limits allow every value of an integer; false for types whose values must be checked. */
bool od_is_unlimited(const od_entry *entry);

/* Copies a number in bus order, which is also memory order; `size` is 1, 2, 4 or 8. */
static inline void od_copy_number(void *to, const void *from, uint32_t size) {
  switch (size) { /* cheaper than memcpy() with a variable size */
    case 1:
      memcpy(to, from, 1);
      break;
    case 2:
      memcpy(to, from, 2);
      break;
    case 4:
      memcpy(to, from, 4);
      break;
    default:
      memcpy(to, from, 8);
      break;
  }
}

/* Returns whether two numbers of `size` bytes are equal, as above. */
static inline bool od_same_number(const void *a, const void *b, uint32_t size) {
  uint64_t of_a = 0;
  uint64_t of_b = 0;
  od_copy_number(&of_a, a, size);
  od_copy_number(&of_b, b, size);
  return of_a == of_b;
}

/* Returns the number of bytes of a value of this type; 0 for strings and DOMAIN. */
uint16_t od_type_bytes(od_type type);

/* Returns the current value, without access check; text points into the struct. */
od_number od_get(const od_object *object);

/* Returns the value with which a device starts while nothing is stored, and that 0x1011 restores. The node id is not
 * added. */
od_number od_default(const od_object *object);

/* Writes a value without any check; for defaults, and for a store that has checked the value. Strings are cut to the
 * capacity. */
void od_put(const od_object *object, od_number value);

/* Reads in bus order (little endian). `bytes` must hold the entry's size; DOMAIN is refused with OD_UNSUPPORTED. */
od_abort od_read(const od_object *object, uint8_t *bytes, uint16_t capacity, uint16_t *length);

/* Returns whether the owner calls this value, in bus order, a stop; see od_hooks.stops. */
bool od_is_stop(const od_object *object, const uint8_t *bytes);

/* Hands a stop to the owner if it must wait for the value before it; see od_hooks.defer. Returns whether it did. */
bool od_defer_stop(const od_object *object, const uint8_t *bytes);

/* Returns what od_write would return if execute() succeeds; changes nothing. */
od_abort od_check_write(const od_object *object, const uint8_t *bytes, uint16_t length);

/* Checks access, length, limits, finiteness and the owner's accept(), then executes and stores; on any result but OD_OK
 * nothing is stored. OD_PENDING: call again in the next tick. */
od_abort od_write(const od_object *object, const uint8_t *bytes, uint16_t length);

/* Executes and stores a value for which od_check_write has just returned OD_OK; returns the result of execute(). */
od_abort od_write_checked(const od_object *object, const uint8_t *bytes, uint16_t length);

/* Writes all defaults of a part, read-only values included, as the table has them. */
void od_restore_defaults(const od_part *part, uint8_t node_id);

/* Returns whether all values with OD_STORED are equal, bit for bit, in two structs of the table's values. */
bool od_same_stored(const od_table *table, const void *one, const void *other);

/* Returns whether all values with OD_GUARDED are equal, bit for bit, in two structs of the table's values. */
bool od_same_guarded(const od_table *table, const void *one, const void *other);

/* Copies the values with OD_STORED from one struct of the table's values to another. */
void od_copy_stored(const od_table *table, const void *from, void *to);

#endif
