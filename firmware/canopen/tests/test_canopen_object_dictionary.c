/* SPDX-License-Identifier: Apache-2.0 */
#include <math.h>

#include "canopen/bench.h"
#include "canopen/object_dictionary_check.h"
#include "canopen/object_dictionary_rows.h"

void setUp(void) { bench_start(); }
void tearDown(void) {}

static od_object find(uint16_t index, uint8_t sub) {
  od_object object;
  TEST_ASSERT_EQUAL_HEX32(OD_OK, od_find(&bench.device.node.dictionary, index, sub, &object));
  return object;
}

static void test_every_table_that_ships_is_sorted_and_consistent(void) {
  const od_table_verdict verdict = od_check_dictionary(&bench.device.node.dictionary);
  TEST_ASSERT_EQUAL_MESSAGE(OD_TABLE_GOOD, verdict.fault, "see od_table_fault");
  TEST_ASSERT_EQUAL_HEX16(0, verdict.index);
  TEST_ASSERT_EQUAL(0, verdict.sub);
  const od_table_verdict of_table = od_check_table(&bench.device.node.parts[0].table);
  TEST_ASSERT_EQUAL(OD_TABLE_GOOD, of_table.fault);
  TEST_ASSERT_EQUAL_HEX16(0, of_table.index);
  TEST_ASSERT_EQUAL(0, of_table.sub);
}

static void test_search_finds_every_row_and_nothing_else(void) {
  const object_dictionary *dictionary = &bench.device.node.dictionary;
  uint32_t found = 0;
  uint32_t rows = 0;
  for (uint32_t i = 0; i < dictionary->count; i++) {
    rows += dictionary->parts[i].table.count;
  }
  for (uint32_t index = 0; index <= 0xFFFF; index++) {
    for (uint32_t sub = 0; sub < 16; sub++) {
      od_object object;
      if (od_find(dictionary, (uint16_t)index, (uint8_t)sub, &object) == OD_OK) {
        TEST_ASSERT_EQUAL_HEX16(index, od_index(&object));
        TEST_ASSERT_EQUAL(sub, object.entry->sub);
        found++;
      }
    }
  }
  TEST_ASSERT_EQUAL(rows, found);
}

static void test_missing_object_and_missing_sub_index_are_reported_apart(void) {
  od_object object;
  const object_dictionary *dictionary = &bench.device.node.dictionary;
  TEST_ASSERT_EQUAL_HEX32(OD_NO_OBJECT, od_find(dictionary, 0x2001, 0, &object));
  TEST_ASSERT_EQUAL_HEX32(OD_NO_OBJECT, od_find(dictionary, 0x0000, 0, &object));
  TEST_ASSERT_EQUAL_HEX32(OD_NO_OBJECT, od_find(dictionary, 0xFFFF, 255, &object));
  TEST_ASSERT_EQUAL_HEX32(OD_NO_SUB, od_find(dictionary, 0x2000, 3, &object));
  TEST_ASSERT_EQUAL_HEX32(OD_NO_SUB, od_find(dictionary, 0x6040, 1, &object));
  TEST_ASSERT_EQUAL_HEX32(OD_NO_SUB, od_find(dictionary, 0x1000, 1, &object)); /* the first row of a table */
}

static void test_second_axis_is_the_same_table_on_other_values(void) {
  const od_object azimuth = find(0x2000, 1);
  const od_object pitch = find(0x2800, 1);
  TEST_ASSERT_EQUAL_PTR(azimuth.entry, pitch.entry);
  od_put(&pitch, (od_number){.f = 7.0f});
  TEST_ASSERT_EQUAL_FLOAT(1.5f, bench.device.axis[0].kp);
  TEST_ASSERT_EQUAL_FLOAT(7.0f, bench.device.axis[1].kp);
}

static void test_values_travel_little_endian_and_back(void) {
  static const uint8_t expected[12][8] = {{1},
                                          {0xFB},
                                          {0x0C, 0xFE},
                                          {0xB0, 0x3C, 0xFF, 0xFF},
                                          {50},
                                          {0xEF, 0xBE},
                                          {0xEF, 0xBE, 0xAD, 0xDE},
                                          {0xEF, 0xCD, 0xAB, 0x89, 0x67, 0x45, 0x23, 0x01},
                                          {0xCD, 0xCC, 0xCC, 0x3D}};
  for (uint8_t sub = 1; sub <= 9; sub++) {
    const od_object object = find(0x2F00, sub);
    uint8_t bytes[8] = {0};
    uint16_t length = 0;
    TEST_ASSERT_EQUAL_HEX32(OD_OK, od_read(&object, bytes, 8, &length));
    TEST_ASSERT_EQUAL(object.entry->bytes, length);
    TEST_ASSERT_EQUAL_HEX8_ARRAY(expected[sub - 1], bytes, 8);
    TEST_ASSERT_EQUAL_HEX32(OD_OK, od_write(&object, bytes, length));
    TEST_ASSERT_EQUAL_HEX32(OD_OK, od_read(&object, bytes, 8, &length));
    TEST_ASSERT_EQUAL_HEX8_ARRAY(expected[sub - 1], bytes, 8);
  }
}

static od_abort write_int(uint8_t sub, int64_t value) {
  const od_object object = find(0x2F00, sub);
  uint8_t bytes[8];
  for (uint32_t i = 0; i < 8; i++) {
    bytes[i] = (uint8_t)((uint64_t)value >> (8 * i));
  }
  const int64_t before = od_get(&object).i;
  const od_abort answer = od_write(&object, bytes, object.entry->bytes);
  if (answer != OD_OK) {
    TEST_ASSERT_EQUAL_INT64(before, od_get(&object).i);
  } else {
    TEST_ASSERT_EQUAL_INT64(value, od_get(&object).i);
  }
  return answer;
}

static void test_integers_are_taken_exactly_within_their_limits(void) {
  for (uint8_t sub = 1; sub <= 7; sub++) {
    const od_entry *entry = find(0x2F00, sub).entry;
    TEST_ASSERT_EQUAL_HEX32(OD_OK, write_int(sub, entry->low.i));
    TEST_ASSERT_EQUAL_HEX32(OD_OK, write_int(sub, entry->high.i));
    if (sub < 6) {
      TEST_ASSERT_EQUAL_HEX32(OD_TOO_HIGH, write_int(sub, entry->high.i + 1));
    }
    if (sub > 1 && sub < 6) {
      TEST_ASSERT_EQUAL_HEX32(OD_TOO_LOW, write_int(sub, entry->low.i - 1));
    }
  }
  TEST_ASSERT_EQUAL_HEX32(OD_TOO_LOW, write_int(8, 0));
  TEST_ASSERT_EQUAL_HEX32(OD_OK, write_int(8, -1));
}

static od_abort write_float(float value) {
  const od_object object = find(0x2F00, 9);
  const uint32_t bits = bench_bits(value);
  const uint8_t bytes[4] = {(uint8_t)bits, (uint8_t)(bits >> 8), (uint8_t)(bits >> 16), (uint8_t)(bits >> 24)};
  return od_write(&object, bytes, 4);
}

static void test_reals_must_be_finite_and_within_their_limits(void) {
  TEST_ASSERT_EQUAL_HEX32(OD_OK, write_float(-1000.0f));
  TEST_ASSERT_EQUAL_HEX32(OD_OK, write_float(1000.0f));
  TEST_ASSERT_EQUAL_HEX32(OD_TOO_HIGH, write_float(1000.1f));
  TEST_ASSERT_EQUAL_HEX32(OD_TOO_LOW, write_float(-1000.1f));
  TEST_ASSERT_EQUAL_HEX32(OD_BAD_VALUE, write_float(NAN));
  TEST_ASSERT_EQUAL_HEX32(OD_TOO_HIGH, write_float(INFINITY));
  TEST_ASSERT_EQUAL_HEX32(OD_TOO_LOW, write_float(-INFINITY));
  TEST_ASSERT_EQUAL_FLOAT(1000.0f, bench.device.values.f32);
}

static void test_text_is_printable_and_fits(void) {
  const od_object object = find(0x2F00, 10);
  uint8_t bytes[17];
  uint16_t length = 0;
  TEST_ASSERT_EQUAL_HEX32(OD_OK, od_write(&object, (const uint8_t *)"sixteen letters!", 16));
  TEST_ASSERT_EQUAL_HEX32(OD_TOO_LONG, od_write(&object, (const uint8_t *)"seventeen letters", 17));
  TEST_ASSERT_EQUAL_HEX32(OD_BAD_VALUE, od_write(&object, (const uint8_t *)"a\nb", 3));
  TEST_ASSERT_EQUAL_HEX32(OD_OK, od_read(&object, bytes, 17, &length));
  TEST_ASSERT_EQUAL(16, length);
  TEST_ASSERT_EQUAL_MEMORY("sixteen letters!", bytes, 16);
  TEST_ASSERT_EQUAL_HEX32(OD_OK, od_write(&object, bytes, 0));
  TEST_ASSERT_EQUAL_HEX32(OD_OK, od_read(&object, bytes, 17, &length));
  TEST_ASSERT_EQUAL(0, length);
}

/* 2F00:8 may be anything but 0. */
static void test_a_long_number_is_taken_exactly_within_its_limits(void) {
  static const uint64_t good[] = {1, UINT64_C(0x8000000000000000), UINT64_MAX};
  const od_object object = find(0x2F00, 8);
  const uint64_t zero = 0;
  for (size_t i = 0; i < sizeof good / sizeof good[0]; i++) {
    TEST_ASSERT_EQUAL_HEX32(OD_OK, od_write(&object, (const uint8_t *)&good[i], 8));
    TEST_ASSERT_EQUAL_HEX32(OD_TOO_LOW, od_write(&object, (const uint8_t *)&zero, 8));
    TEST_ASSERT_EQUAL_HEX64(good[i], bench.device.values.u64);
  }
  od_entry from_5_to_2_63 = *object.entry;
  from_5_to_2_63.low.i = 5;
  from_5_to_2_63.high.i = INT64_MIN; /* the bits of 2^63 */
  const od_object limited = {object.part, &from_5_to_2_63};
  static const struct {
    uint64_t value;
    od_abort answer;
  } rows[] = {{4, OD_TOO_LOW},
              {5, OD_OK},
              {UINT64_C(0x8000000000000001), OD_TOO_HIGH},
              {UINT64_MAX, OD_TOO_HIGH},
              {UINT64_C(0x8000000000000000), OD_OK}};
  for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
    const uint64_t before = bench.device.values.u64;
    TEST_ASSERT_EQUAL_HEX32(rows[i].answer, od_write(&limited, (const uint8_t *)&rows[i].value, 8));
    TEST_ASSERT_EQUAL_HEX64(rows[i].answer == OD_OK ? rows[i].value : before, bench.device.values.u64);
  }
}

static void test_a_text_of_one_letter_is_read_as_it_was_written(void) {
  const od_object object = find(0x2F00, 10);
  uint8_t bytes[17] = {0};
  uint16_t length = 0;
  TEST_ASSERT_EQUAL_HEX32(OD_OK, od_write(&object, (const uint8_t *)"x", 1));
  TEST_ASSERT_EQUAL_HEX32(OD_OK, od_read(&object, bytes, 17, &length));
  TEST_ASSERT_EQUAL(1, length);
  TEST_ASSERT_EQUAL_HEX8('x', bytes[0]);
}

static void test_a_number_is_taken_with_all_its_bytes_and_no_more(void) {
  for (uint8_t sub = 1; sub <= 9; sub++) {
    const od_object object = find(0x2F00, sub);
    const int64_t before = od_get(&object).i;
    const uint8_t bytes[9] = {0x11, 0x11, 0x11, 0x11, 0x11, 0x11, 0x11, 0x11, 0x11};
    TEST_ASSERT_EQUAL_HEX32(OD_TOO_SHORT, od_write(&object, bytes, (uint16_t)(object.entry->bytes - 1)));
    TEST_ASSERT_EQUAL_HEX32(OD_TOO_LONG, od_write(&object, bytes, (uint16_t)(object.entry->bytes + 1)));
    TEST_ASSERT_EQUAL_INT64(before, od_get(&object).i);
  }
}

static void test_what_is_no_value_or_does_not_fit_is_not_read(void) {
  uint8_t bytes[17] = {0xAA};
  uint16_t length = 7;
  const od_object stream = find(0x2F01, 0);
  const od_object text = find(0x2F00, 10);
  const od_object number = find(0x2F00, 7);
  const od_object secret = find(0x2F00, 11);
  TEST_ASSERT_EQUAL_HEX32(OD_UNSUPPORTED, od_read(&stream, bytes, 17, &length));
  TEST_ASSERT_EQUAL_HEX32(OD_UNSUPPORTED, od_read(&text, bytes, 15, &length));
  TEST_ASSERT_EQUAL_HEX32(OD_UNSUPPORTED, od_read(&number, bytes, 3, &length));
  TEST_ASSERT_EQUAL_HEX32(OD_WRITE_ONLY, od_read(&secret, bytes, 17, &length));
  TEST_ASSERT_EQUAL_HEX32(OD_UNSUPPORTED, od_write(&stream, bytes, 1));
  TEST_ASSERT_EQUAL_HEX8(0xAA, bytes[0]);
  TEST_ASSERT_EQUAL(7, length);
}

/* What may have any value of its type needs no check in each PDO. */
static void test_a_value_is_unlimited_when_its_limits_are_those_of_its_type(void) {
  static const struct {
    od_type type;
    int64_t low, high;
  } types[] = {{OD_INTEGER8, INT8_MIN, INT8_MAX},    {OD_INTEGER16, INT16_MIN, INT16_MAX},
               {OD_INTEGER32, INT32_MIN, INT32_MAX}, {OD_UNSIGNED8, 0, UINT8_MAX},
               {OD_UNSIGNED16, 0, UINT16_MAX},       {OD_UNSIGNED32, 0, UINT32_MAX}};
  for (uint32_t i = 0; i < sizeof types / sizeof types[0]; i++) {
    od_entry entry = {.type = (uint8_t)types[i].type, .low = {.i = types[i].low}, .high = {.i = types[i].high}};
    TEST_ASSERT_TRUE(od_is_unlimited(&entry));
    const od_entry wider = {.type = entry.type, .low = {.i = types[i].low - 1}, .high = {.i = types[i].high + 1}};
    TEST_ASSERT_TRUE(od_is_unlimited(&wider));
    entry.low.i++;
    TEST_ASSERT_FALSE(od_is_unlimited(&entry));
    entry.low.i--;
    entry.high.i--;
    TEST_ASSERT_FALSE(od_is_unlimited(&entry));
  }
  const od_entry real = {.type = OD_REAL32, .low = {.i = INT64_MIN}, .high = {.i = INT64_MAX}};
  TEST_ASSERT_FALSE(od_is_unlimited(&real)); /* a NaN is refused */
}

static void test_only_an_owner_that_knows_stops_has_some(void) {
  const uint8_t zero[4] = {0};
  const uint8_t running[4] = {0x0F};
  const od_object controlword = find(0x6040, 0);
  const od_object sync = find(0x1005, 0);
  const od_part no_hooks = {.table = controlword.part->table, .values = controlword.part->values};
  const od_object unowned = {&no_hooks, controlword.entry};
  TEST_ASSERT_TRUE(od_is_stop(&controlword, zero));
  TEST_ASSERT_FALSE(od_is_stop(&controlword, running));
  TEST_ASSERT_FALSE(od_is_stop(&sync, zero));
  TEST_ASSERT_FALSE(od_is_stop(&unowned, zero));
}

/* The owner of the test device names those that a row needs; the node's own objects need all that it has. */
static void test_an_object_needs_the_hooks_that_its_owner_has_and_names(void) {
  const od_object mode = find(0x6060, 0);
  const od_object controlword = find(0x6040, 0);
  const od_object command = find(0x2F12, 0);
  const od_object sync = find(0x1005, 0);
  const od_part no_hooks = {.table = controlword.part->table, .values = controlword.part->values};
  const od_object unowned = {&no_hooks, controlword.entry};
  TEST_ASSERT_EQUAL_HEX32(OD_HOOK_ACCEPT | OD_HOOK_CHANGED, od_needed_hooks(&mode));
  TEST_ASSERT_EQUAL_HEX32(OD_HOOK_ACCEPT | OD_HOOK_CHANGED | OD_HOOK_WAITS, od_needed_hooks(&controlword));
  TEST_ASSERT_EQUAL_HEX32(OD_HOOK_ACCEPT | OD_HOOK_CHANGED | OD_HOOK_EXECUTE, od_needed_hooks(&command));
  TEST_ASSERT_EQUAL_HEX32(OD_HOOK_REFRESH | OD_HOOK_ACCEPT | OD_HOOK_CHANGED | OD_HOOK_EXECUTE, od_needed_hooks(&sync));
  TEST_ASSERT_EQUAL_HEX32(0, od_needed_hooks(&unowned));
}

typedef struct {
  uint32_t a;
  float f;
} little;

#define GOOD(index_, sub_) OD_U32(index_, sub_, OD_RW, 0, little, a, 0, 10, 5, "", "a name", "help")

static od_table_fault fault_of(const od_entry *rows, uint32_t count) {
  const od_table table = {rows, count};
  return od_check_table(&table).fault;
}

static void test_check_names_what_is_wrong_with_a_table(void) {
  const od_entry unsorted[] = {GOOD(0x2001, 0), GOOD(0x2000, 0)};
  const od_entry twice[] = {GOOD(0x2000, 0), GOOD(0x2000, 0)};
  const od_entry headless[] = {GOOD(0x2000, 1)};
  const od_entry variable_with_sub[] = {GOOD(0x2000, 0), GOOD(0x2000, 1)};
  const od_entry low_head[] = {OD_RECORD_HEAD(0x2000, 1, "r", ""), GOOD(0x2000, 1), GOOD(0x2000, 2)};
  const od_entry limits[] = {OD_U32(0x2000, 0, OD_RW, 0, little, a, 9, 3, 5, "", "n", "h")};
  const od_entry preset[] = {OD_U32(0x2000, 0, OD_RW, 0, little, a, 0, 3, 5, "", "n", "h")};
  const od_entry nan_limit[] = {OD_F32(0x2000, 0, OD_RW, 0, little, f, NAN, 3.0f, 0.0f, "", "n", "h")};
  const od_entry nan_preset[] = {OD_F32(0x2000, 0, OD_RW, 0, little, f, 0.0f, 3.0f, NAN, "", "n", "h")};
  const od_entry mapping[] = {OD_U32(0x2000, 0, OD_RO, OD_RPDO, little, a, 0, 3, 0, "", "n", "h")};
  const od_entry nameless[] = {OD_U32(0x2000, 0, OD_RW, 0, little, a, 0, 3, 0, "", "", "h")};
  const od_entry stored[] = {OD_U32(0x2000, 0, OD_RO, OD_STORED, little, a, 0, 3, 0, "", "n", "h")};
  TEST_ASSERT_EQUAL(OD_TABLE_UNSORTED, fault_of(unsorted, 2));
  TEST_ASSERT_EQUAL(OD_TABLE_UNSORTED, fault_of(twice, 2));
  TEST_ASSERT_EQUAL(OD_TABLE_NO_HEAD, fault_of(headless, 1));
  TEST_ASSERT_EQUAL(OD_TABLE_NO_HEAD, fault_of(variable_with_sub, 2));
  TEST_ASSERT_EQUAL(OD_TABLE_HEAD_TOO_LOW, fault_of(low_head, 3));
  TEST_ASSERT_EQUAL(OD_TABLE_BAD_LIMITS, fault_of(limits, 1));
  TEST_ASSERT_EQUAL(OD_TABLE_BAD_DEFAULT, fault_of(preset, 1));
  TEST_ASSERT_EQUAL(OD_TABLE_BAD_LIMITS, fault_of(nan_limit, 1));
  TEST_ASSERT_EQUAL(OD_TABLE_BAD_DEFAULT, fault_of(nan_preset, 1));
  TEST_ASSERT_EQUAL(OD_TABLE_BAD_MAPPING, fault_of(mapping, 1));
  TEST_ASSERT_EQUAL(OD_TABLE_NO_TEXT, fault_of(nameless, 1));
  TEST_ASSERT_EQUAL(OD_TABLE_NOT_STORABLE, fault_of(stored, 1));
}

static void test_check_finds_an_object_that_two_parts_have(void) {
  const object_dictionary *good = &bench.device.node.dictionary;
  const od_part twice[] = {good->parts[0], good->parts[1], good->parts[0]};
  const object_dictionary bad = {.parts = twice, .count = 3};
  TEST_ASSERT_EQUAL(OD_TABLE_OVERLAP, od_check_dictionary(&bad).fault);
  const od_entry headless[] = {GOOD(0x2000, 1)};
  const od_part first_is_bad[] = {{.table = {headless, 1}}, good->parts[0]};
  const object_dictionary begins_badly = {.parts = first_is_bad, .count = 2};
  TEST_ASSERT_EQUAL(OD_TABLE_NO_HEAD, od_check_dictionary(&begins_badly).fault);
}

static void test_check_finds_the_overlap_in_each_row(void) {
  const od_entry three[] = {GOOD(0x2000, 0), GOOD(0x2001, 0), GOOD(0x2002, 0)};
  for (uint16_t row = 0; row < 4; row++) {
    const od_entry one[] = {GOOD(0x2000, 0)};
    const od_part parts[] = {{.table = {three, 3}}, {.table = {one, 1}, .shift = row}};
    const object_dictionary both = {.parts = parts, .count = 2};
    const od_part turned[] = {parts[1], parts[0]};
    const object_dictionary other_order = {.parts = turned, .count = 2};
    const od_table_fault expected = row < 3 ? OD_TABLE_OVERLAP : OD_TABLE_GOOD;
    TEST_ASSERT_EQUAL(expected, od_check_dictionary(&both).fault);
    TEST_ASSERT_EQUAL(expected, od_check_dictionary(&other_order).fault);
    TEST_ASSERT_EQUAL_HEX16(row < 3 ? 0x2000 + row : 0, od_check_dictionary(&other_order).index);
  }
}

static od_table_fault fault_of_number(od_type type, uint16_t bytes, int64_t low, int64_t high, int64_t preset) {
  od_entry entry = GOOD(0x2000, 0);
  entry.type = (uint8_t)type;
  entry.bytes = bytes;
  entry.low.i = low;
  entry.high.i = high;
  entry.preset.i = preset;
  return fault_of(&entry, 1);
}

/* The smallest and largest value of each type as CiA 301 defines it. */
static void test_check_knows_the_size_and_the_range_of_each_integer(void) {
  static const struct {
    od_type type;
    uint16_t bytes;
    int64_t low, high;
  } rows[] = {
      {OD_BOOLEAN, 1, 0, 1},
      {OD_INTEGER8, 1, -128, 127},
      {OD_INTEGER16, 2, -32768, 32767},
      {OD_INTEGER32, 4, -INT64_C(2147483648), INT64_C(2147483647)},
      {OD_UNSIGNED8, 1, 0, 255},
      {OD_UNSIGNED16, 2, 0, 65535},
      {OD_UNSIGNED32, 4, 0, INT64_C(4294967295)},
  };
  for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
    const od_type type = rows[i].type;
    const uint16_t bytes = rows[i].bytes;
    const int64_t low = rows[i].low, high = rows[i].high;
    TEST_ASSERT_EQUAL(bytes, od_type_bytes(type));
    TEST_ASSERT_EQUAL(OD_TABLE_GOOD, fault_of_number(type, bytes, low, high, low));
    TEST_ASSERT_EQUAL(OD_TABLE_GOOD, fault_of_number(type, bytes, low, high, high));
    TEST_ASSERT_EQUAL(OD_TABLE_GOOD, fault_of_number(type, bytes, high, high, high));
    TEST_ASSERT_EQUAL(OD_TABLE_BAD_LIMITS, fault_of_number(type, bytes, low - 1, high, high));
    TEST_ASSERT_EQUAL(OD_TABLE_BAD_LIMITS, fault_of_number(type, bytes, low, high + 1, high));
    TEST_ASSERT_EQUAL(OD_TABLE_BAD_LIMITS, fault_of_number(type, bytes, high, low, high));
    TEST_ASSERT_EQUAL(OD_TABLE_BAD_DEFAULT, fault_of_number(type, bytes, low + 1, high, low));
    TEST_ASSERT_EQUAL(OD_TABLE_BAD_DEFAULT, fault_of_number(type, bytes, low, high - 1, high));
    TEST_ASSERT_EQUAL(OD_TABLE_BAD_TYPE, fault_of_number(type, (uint16_t)(bytes + 1), low, high, low));
  }
  TEST_ASSERT_EQUAL(4, od_type_bytes(OD_REAL32));
  TEST_ASSERT_EQUAL(8, od_type_bytes(OD_UNSIGNED64));
  TEST_ASSERT_EQUAL(0, od_type_bytes(OD_VISIBLE_STRING)); /* as long as its row says */
  TEST_ASSERT_EQUAL(0, od_type_bytes(OD_DOMAIN));
  TEST_ASSERT_EQUAL(OD_TABLE_GOOD, fault_of_number(OD_UNSIGNED64, 8, 0, -1, -1)); /* -1: all bits */
  TEST_ASSERT_EQUAL(OD_TABLE_GOOD, fault_of_number(OD_UNSIGNED64, 8, 5, 5, 5));
  TEST_ASSERT_EQUAL(OD_TABLE_GOOD, fault_of_number(OD_DOMAIN, 0, 9, 3, 5)); /* a stream has no limits */
  TEST_ASSERT_EQUAL(OD_TABLE_BAD_LIMITS, fault_of_number(OD_UNSIGNED64, 8, -1, 0, 0));
  TEST_ASSERT_EQUAL(OD_TABLE_BAD_DEFAULT, fault_of_number(OD_UNSIGNED64, 8, 2, 9, 1));
  TEST_ASSERT_EQUAL(OD_TABLE_BAD_DEFAULT, fault_of_number(OD_UNSIGNED64, 8, 2, 9, 10));
  TEST_ASSERT_EQUAL(OD_TABLE_BAD_TYPE, fault_of_number(OD_UNSIGNED64, 4, 0, 9, 1));
  TEST_ASSERT_EQUAL(OD_TABLE_BAD_TYPE, fault_of_number((od_type)0x7F, 4, 0, 9, 1));
}

static void test_check_knows_the_range_of_a_real_and_the_room_of_a_text(void) {
  static const struct {
    float low, high, preset;
    od_table_fault fault;
  } reals[] = {{-1.0f, 2.0f, -1.0f, OD_TABLE_GOOD},
               {-1.0f, 2.0f, 2.0f, OD_TABLE_GOOD},
               {2.0f, 2.0f, 2.0f, OD_TABLE_GOOD},
               {-1.0f, 2.0f, -1.1f, OD_TABLE_BAD_DEFAULT},
               {-1.0f, 2.0f, 2.1f, OD_TABLE_BAD_DEFAULT},
               {2.0f, -1.0f, 0.0f, OD_TABLE_BAD_LIMITS},
               {-1.0f, INFINITY, 0.0f, OD_TABLE_BAD_LIMITS},
               {-INFINITY, 2.0f, 0.0f, OD_TABLE_BAD_LIMITS},
               {-1.0f, NAN, 0.0f, OD_TABLE_BAD_LIMITS}};
  for (size_t i = 0; i < sizeof reals / sizeof reals[0]; i++) {
    const od_entry row =
        OD_F32(0x2000, 0, OD_RW, 0, little, f, reals[i].low, reals[i].high, reals[i].preset, "", "n", "h");
    TEST_ASSERT_EQUAL(reals[i].fault, fault_of(&row, 1));
  }
  static const char *const texts[] = {NULL, "", "abcd", "abcde"};
  for (size_t i = 0; i < 4; i++) {
    od_entry row = GOOD(0x2000, 0);
    row.type = OD_VISIBLE_STRING;
    row.bytes = 4;
    row.preset.text = texts[i];
    TEST_ASSERT_EQUAL(i < 3 ? OD_TABLE_GOOD : OD_TABLE_BAD_DEFAULT, fault_of(&row, 1));
  }
}

static void test_check_knows_what_may_be_mapped_and_stored(void) {
  static const struct {
    od_type type;
    uint16_t bytes;
    od_access access;
    uint32_t flags;
    od_table_fault fault;
  } rows[] = {
      {OD_UNSIGNED8, 1, OD_RW, OD_RPDO | OD_TPDO | OD_EVENT, OD_TABLE_GOOD},
      {OD_UNSIGNED8, 1, OD_RO, OD_TPDO, OD_TABLE_GOOD},
      {OD_UNSIGNED8, 1, OD_RO, OD_RPDO, OD_TABLE_BAD_MAPPING},
      {OD_UNSIGNED8, 1, OD_WO, OD_RPDO, OD_TABLE_GOOD},
      {OD_UNSIGNED8, 1, OD_WO, OD_TPDO, OD_TABLE_BAD_MAPPING},
      {OD_UNSIGNED8, 1, OD_RW, OD_EVENT, OD_TABLE_BAD_MAPPING},
      {OD_UNSIGNED8, 1, OD_RW, OD_RPDO | OD_GUARDED, OD_TABLE_BAD_MAPPING},
      {OD_UNSIGNED8, 1, OD_RW, OD_TPDO | OD_GUARDED, OD_TABLE_GOOD},
      {OD_BOOLEAN, 1, OD_RW, OD_TPDO, OD_TABLE_BAD_MAPPING},
      {OD_VISIBLE_STRING, 4, OD_RW, OD_TPDO, OD_TABLE_BAD_MAPPING},
      {OD_DOMAIN, 0, OD_RW, OD_TPDO, OD_TABLE_BAD_MAPPING},
      {OD_DOMAIN, 4, OD_RW, 0, OD_TABLE_BAD_TYPE},
      {OD_UNSIGNED8, 1, OD_RW, OD_STORED, OD_TABLE_GOOD},
      {OD_UNSIGNED8, 1, OD_RO, OD_STORED, OD_TABLE_NOT_STORABLE},
      {OD_UNSIGNED8, 1, OD_WO, OD_STORED, OD_TABLE_NOT_STORABLE},
  };
  for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
    od_entry row = GOOD(0x2000, 0);
    row.type = (uint8_t)rows[i].type;
    row.bytes = rows[i].bytes;
    row.access = (uint8_t)rows[i].access;
    row.flags = (uint8_t)rows[i].flags;
    row.high.i = row.preset.i = 1;
    if (row.type == OD_VISIBLE_STRING) {
      row.preset.text = "";
    }
    TEST_ASSERT_EQUAL(rows[i].fault, fault_of(&row, 1));
  }
  od_entry without_value = GOOD(0x2000, 0);
  without_value.flags = OD_STORED;
  without_value.offset = OD_NO_VALUE;
  TEST_ASSERT_EQUAL(OD_TABLE_NOT_STORABLE, fault_of(&without_value, 1));
}

/* A constant COB-ID and a constant inhibit time have no place in the struct of values. */
static void test_a_row_without_a_value_follows_no_bus_setting(void) {
  static const od_entry rows[] = {OD_FIXED(OD_UNSIGNED32, 4, 0x1014, 0, OD_NODE_ID, 0x80, "A COB-ID", "Fixed."),
                                  OD_FIXED(OD_UNSIGNED16, 2, 0x1800, 3, 0, 100, "An inhibit time", "Fixed.")};
  const od_table table = {rows, 2};
  uint32_t value = 0x81;
  bus_defaults_follow(&table, &value, &(bus_settings){1, 1000}, &(bus_settings){2, 500});
  TEST_ASSERT_EQUAL_HEX32(0x81, value);
}

static void test_check_misses_each_text_and_names_the_row(void) {
  for (int missing = 0; missing < 3; missing++) {
    od_entry rows[] = {OD_RECORD_HEAD(0x2000, 2, "r", ""), GOOD(0x2000, 1), GOOD(0x2000, 2)};
    rows[2].name = missing == 0 ? NULL : rows[2].name;
    rows[2].unit = missing == 1 ? NULL : rows[2].unit;
    rows[2].help = missing == 2 ? NULL : rows[2].help;
    const od_table table = {rows, 3};
    const od_table_verdict verdict = od_check_table(&table);
    TEST_ASSERT_EQUAL(OD_TABLE_NO_TEXT, verdict.fault);
    TEST_ASSERT_EQUAL_HEX16(0x2000, verdict.index);
    TEST_ASSERT_EQUAL(2, verdict.sub);
  }
}

int main(void) {
  UNITY_BEGIN();
  RUN_TEST(test_every_table_that_ships_is_sorted_and_consistent);
  RUN_TEST(test_search_finds_every_row_and_nothing_else);
  RUN_TEST(test_missing_object_and_missing_sub_index_are_reported_apart);
  RUN_TEST(test_second_axis_is_the_same_table_on_other_values);
  RUN_TEST(test_values_travel_little_endian_and_back);
  RUN_TEST(test_integers_are_taken_exactly_within_their_limits);
  RUN_TEST(test_reals_must_be_finite_and_within_their_limits);
  RUN_TEST(test_text_is_printable_and_fits);
  RUN_TEST(test_a_long_number_is_taken_exactly_within_its_limits);
  RUN_TEST(test_a_text_of_one_letter_is_read_as_it_was_written);
  RUN_TEST(test_a_number_is_taken_with_all_its_bytes_and_no_more);
  RUN_TEST(test_what_is_no_value_or_does_not_fit_is_not_read);
  RUN_TEST(test_a_value_is_unlimited_when_its_limits_are_those_of_its_type);
  RUN_TEST(test_only_an_owner_that_knows_stops_has_some);
  RUN_TEST(test_an_object_needs_the_hooks_that_its_owner_has_and_names);
  RUN_TEST(test_check_names_what_is_wrong_with_a_table);
  RUN_TEST(test_check_finds_an_object_that_two_parts_have);
  RUN_TEST(test_check_finds_the_overlap_in_each_row);
  RUN_TEST(test_check_knows_the_size_and_the_range_of_each_integer);
  RUN_TEST(test_check_knows_the_range_of_a_real_and_the_room_of_a_text);
  RUN_TEST(test_check_knows_what_may_be_mapped_and_stored);
  RUN_TEST(test_a_row_without_a_value_follows_no_bus_setting);
  RUN_TEST(test_check_misses_each_text_and_names_the_row);
  return UNITY_END();
}
