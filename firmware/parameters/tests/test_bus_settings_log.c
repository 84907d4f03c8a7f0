/* SPDX-License-Identifier: Apache-2.0 */
/* Node id and bit rate in flash: found again after every start, whatever the power did in between. */
#include "parameters/bus_settings_log.h"

#include <stdio.h>

#include "base/crc32.h"
#include "support/flash_model.h"
#include "unity.h"

enum { PAGE_BYTES = 64, UNITS = PAGE_BYTES / HAL_FLASH_UNIT_BYTES, MAX_STEPS = 8 };

static flash_model model;
static hal_flash flash;
static bus_settings_log saved;

static const bus_settings defaults = {.node_id = 1, .kbit_s = 1000};

static void restart(void) {
  model.off = false;
  model.operations_left = -1;
  flash = flash_model_area(&model, 0);
  bus_settings_log_open(&saved, &flash, &defaults);
}

void setUp(void) {
  flash_model_init(&model, PAGE_BYTES, BUS_SETTINGS_LOG_PAGES);
  restart();
}

void tearDown(void) { TEST_ASSERT_EQUAL_MESSAGE(0, model.rule_breaks, "programmed where it is not erased"); }

static bus_settings settings_no(uint32_t n) {
  static const uint16_t kbit_s[] = {1000, 500, 250, 125};
  return (bus_settings){.node_id = n % 128 == 0 ? BUS_UNCONFIGURED : (uint8_t)(n % 128), .kbit_s = kbit_s[n % 4]};
}

/* Like the board's background; returns the result. */
static bus_settings_work save(uint32_t n) {
  const bus_settings wanted = settings_no(n);
  bus_settings_work result = BUS_SETTINGS_REQUESTED;
  TEST_ASSERT_TRUE(bus_settings_log_begin(&saved, &wanted));
  for (int step = 0; step < MAX_STEPS && result == BUS_SETTINGS_REQUESTED; ++step) {
    const uint32_t before = model.operations;
    (void)bus_settings_log_step(&saved);
    TEST_ASSERT_TRUE_MESSAGE(model.operations <= before + 1, "more than one operation in a step");
    result = bus_settings_log_take_result(&saved);
  }
  return result;
}

static bool has(uint32_t n) {
  const bus_settings wanted = settings_no(n);
  return saved.found && bus_settings_are_same(&saved.newest, &wanted);
}

static void test_an_empty_flash_gives_the_defaults(void) {
  TEST_ASSERT_FALSE(saved.found);
  TEST_ASSERT_TRUE(bus_settings_are_same(&defaults, &saved.newest));
  TEST_ASSERT_FALSE(bus_settings_log_step(&saved));
  TEST_ASSERT_EQUAL(BUS_SETTINGS_IDLE, bus_settings_log_take_result(&saved));
}

static void test_what_was_saved_last_is_found_after_any_number_of_saves(void) {
  for (uint32_t n = 1; n < 1000; ++n) {
    TEST_ASSERT_EQUAL(BUS_SETTINGS_SAVED, save(n));
    TEST_ASSERT_TRUE(has(n));
    TEST_ASSERT_EQUAL(BUS_SETTINGS_IDLE, bus_settings_log_take_result(&saved));
    if (n % 3 == 0) {
      restart();
      TEST_ASSERT_TRUE(has(n));
    }
  }
}

/* An LSS master waits 20 ms, and an erase takes 22. */
/* It may be an entry whose programming was interrupted. Behind it the first save leaves a double word of zeros. */
static void test_the_first_save_after_a_start_skips_the_next_blank_double_word(void) {
  TEST_ASSERT_EQUAL(BUS_SETTINGS_SAVED, save(5));
  const uint32_t end = saved.newest_unit + 1;
  const uint8_t *skipped = &model.bytes[end * HAL_FLASH_UNIT_BYTES];
  restart();
  TEST_ASSERT_EQUAL(BUS_SETTINGS_SAVED, save(6));
  TEST_ASSERT_EACH_EQUAL_HEX8(0xFF, skipped, HAL_FLASH_UNIT_BYTES);
  TEST_ASSERT_EACH_EQUAL_HEX8(0x00, skipped + HAL_FLASH_UNIT_BYTES, HAL_FLASH_UNIT_BYTES);
  TEST_ASSERT_EQUAL(end + 2, saved.newest_unit);
}

static void test_a_save_never_waits_for_an_erase(void) {
  for (uint32_t n = 1; n < 100; ++n) {
    const uint32_t erases = model.erases[0] + model.erases[1];
    TEST_ASSERT_EQUAL(BUS_SETTINGS_SAVED, save(n));
    TEST_ASSERT_EQUAL(erases, model.erases[0] + model.erases[1]);
    while (bus_settings_log_step(&saved)) { /* the background between two requests */
    }
  }
  TEST_ASSERT_TRUE(model.erases[0] > 5 && model.erases[1] > 5);
}

static void test_the_same_settings_are_not_written_again(void) {
  TEST_ASSERT_EQUAL(BUS_SETTINGS_SAVED, save(3));
  const uint32_t operations = model.operations;
  TEST_ASSERT_EQUAL(BUS_SETTINGS_SAVED, save(3));
  TEST_ASSERT_EQUAL(operations, model.operations);
}

static void test_the_defaults_are_written_when_they_are_requested(void) {
  const bus_settings other_defaults = {.node_id = 9, .kbit_s = 125};
  bus_settings_log_open(&saved, &flash, &other_defaults);
  TEST_ASSERT_TRUE(bus_settings_log_begin(&saved, &other_defaults));
  TEST_ASSERT_FALSE(bus_settings_log_begin(&saved, &other_defaults)); /* one at a time */
  while (bus_settings_log_step(&saved)) {
  }
  restart();
  TEST_ASSERT_TRUE(bus_settings_are_same(&other_defaults, &saved.newest));
}

static void test_without_a_flash_they_are_kept_until_the_power_goes(void) {
  bus_settings_log_open(&saved, NULL, &defaults);
  TEST_ASSERT_EQUAL(BUS_SETTINGS_SAVED, save(7));
  TEST_ASSERT_EQUAL(7, saved.newest.node_id);
}

static void test_a_flash_that_refuses_changes_nothing(void) {
  TEST_ASSERT_EQUAL(BUS_SETTINGS_SAVED, save(5));
  model.off = true;
  for (uint32_t n = 0; n < 2 * UNITS; ++n) { /* also when a page is full of failed entries */
    TEST_ASSERT_EQUAL(BUS_SETTINGS_FAILED, save(100 + n));
  }
  TEST_ASSERT_FALSE_MESSAGE(bus_settings_log_step(&saved), "erased again and again");
  model.off = false;
  TEST_ASSERT_TRUE(has(5));
  TEST_ASSERT_EQUAL(BUS_SETTINGS_SAVED, save(6));
  restart();
  TEST_ASSERT_TRUE(has(6));
}

/* For any number of failed entries and erases before the flash works again. */
static void test_a_flash_that_works_again_takes_the_next_settings(void) {
  for (uint32_t refused = 0; refused < 3 * UNITS; ++refused) {
    setUp();
    for (uint32_t n = 0; n < 2 * UNITS + refused % 5; ++n) { /* both pages have entries */
      TEST_ASSERT_EQUAL(BUS_SETTINGS_SAVED, save(n));
    }
    model.off = true;
    for (uint32_t n = 0; n < refused; ++n) {
      TEST_ASSERT_EQUAL(BUS_SETTINGS_FAILED, save(100 + n));
    }
    model.off = false;
    for (uint32_t n = 0; n < UNITS; ++n) {
      TEST_ASSERT_EQUAL(BUS_SETTINGS_SAVED, save(6 + n));
      restart();
      TEST_ASSERT_TRUE(has(6 + n));
    }
    tearDown();
  }
}

static void test_sequence_numbers_end_and_the_last_settings_stay(void) {
  TEST_ASSERT_EQUAL(BUS_SETTINGS_SAVED, save(5));
  saved.sequence = BUS_SETTINGS_LOG_MAX_SAVES - 1;
  TEST_ASSERT_EQUAL(BUS_SETTINGS_SAVED, save(6));
  TEST_ASSERT_EQUAL(BUS_SETTINGS_FAILED, save(7));
  restart();
  TEST_ASSERT_TRUE(has(6));
}

static void test_entries_that_say_what_cannot_be_are_skipped(void) {
  static const struct {
    uint32_t content; /* node id, index of the bit rate, sequence number */
    uint32_t wrong;   /* bits of the CRC */
    bool counts;
  } entries[] = {
      {0x00050000, 0, false}, /* node id 0 */
      {0x00050080, 0, false}, /* node id 128 */
      {0x00050103, 0, false}, /* 800 kbit/s */
      {0x00050503, 0, false}, /* beyond the table of bit rates */
      {0xFFFF0003, 0, false}, /* a sequence number that an erased entry also has */
      {0x00050203, 1, false}, /* a wrong CRC */
      {0x00010203, 0, false}, /* older */
      {0x00050203, 0, true},
  };
  for (uint32_t i = 0; i < sizeof entries / sizeof entries[0]; ++i) {
    setUp();
    TEST_ASSERT_EQUAL(BUS_SETTINGS_SAVED, save(4));
    TEST_ASSERT_EQUAL(BUS_SETTINGS_SAVED, save(5));
    const uint32_t content = entries[i].content;
    const uint32_t crc = crc32_end(crc32_add(CRC32_START, (const uint8_t *)&content, sizeof content));
    const uint32_t words[2] = {content, crc ^ entries[i].wrong};
    memcpy(&model.bytes[PAGE_BYTES - sizeof words], words, sizeof words);
    restart();
    TEST_ASSERT_EQUAL(!entries[i].counts, has(5));
    TEST_ASSERT_EQUAL(entries[i].counts ? 3 : 5, saved.newest.node_id);
  }
}

/* --- in doubt ----------------------------------------------------------------------------------------------------- */

static void make_unreadable(uint32_t page, uint32_t unit) { model.weak[page * UNITS + unit].shows = SHOWS_UNREADABLE; }

static void make_readable(void) { memset(model.weak, 0, sizeof model.weak); }

/* Returns the number of the newest entry, which is the first one of the second page. */
static uint32_t fill_the_first_page(void) {
  uint32_t n = 0;
  while (saved.newest_page == 0) {
    TEST_ASSERT_EQUAL(BUS_SETTINGS_SAVED, save(++n));
  }
  return n;
}

static void test_an_unreadable_newest_entry_is_in_doubt_until_the_next_save(void) {
  TEST_ASSERT_EQUAL(BUS_SETTINGS_SAVED, save(5));
  TEST_ASSERT_EQUAL(BUS_SETTINGS_SAVED, save(6));
  make_unreadable(0, saved.newest_unit);
  restart();
  TEST_ASSERT_TRUE(has(5));
  TEST_ASSERT_TRUE(saved.in_doubt);
  TEST_ASSERT_EQUAL(BUS_SETTINGS_SAVED, save(5)); /* the same, and written nevertheless */
  TEST_ASSERT_FALSE(saved.in_doubt);
  restart();
  TEST_ASSERT_FALSE(saved.in_doubt);
  make_readable();
  restart();
  TEST_ASSERT_TRUE(has(5));
  make_unreadable(0, saved.newest_unit + 2); /* behind the double word that a first save skips */
  restart();
  TEST_ASSERT_TRUE(has(5));
  TEST_ASSERT_TRUE(saved.in_doubt);
}

static void test_an_unreadable_older_entry_is_not_in_doubt(void) {
  TEST_ASSERT_EQUAL(BUS_SETTINGS_SAVED, save(5));
  make_unreadable(0, saved.newest_unit);
  TEST_ASSERT_EQUAL(BUS_SETTINGS_SAVED, save(6));
  restart();
  TEST_ASSERT_TRUE(has(6));
  TEST_ASSERT_FALSE(saved.in_doubt);
}

/* The page without the newest entry, on either side: what is behind its good entries is older. */
static void test_remains_behind_the_entries_of_the_older_page_are_not_in_doubt(void) {
  for (uint32_t page = 0; page < 2; ++page) {
    setUp();
    uint32_t n = fill_the_first_page();
    while (saved.newest_page == page) {
      TEST_ASSERT_EQUAL(BUS_SETTINGS_SAVED, save(++n));
    }
    make_unreadable(page, UNITS - 1);
    restart();
    TEST_ASSERT_TRUE(has(n));
    TEST_ASSERT_FALSE(saved.in_doubt);
  }
}

/* An entry of the second page alone: that page is kept until the next entry is in the first. */
static void test_an_unreadable_entry_of_the_second_page_is_in_doubt_until_the_next_save(void) {
  for (int64_t operation = 0; operation < 3; ++operation) {
    setUp();
    const uint32_t n = fill_the_first_page();
    memset(model.bytes, 0xFF, PAGE_BYTES); /* the first page has been erased since */
    make_unreadable(1, 0);
    restart();
    TEST_ASSERT_FALSE(saved.found);
    TEST_ASSERT_TRUE(saved.in_doubt);
    model.operations_left = operation;
    const bool done = save(100) == BUS_SETTINGS_SAVED;
    restart();
    TEST_ASSERT_TRUE(done || saved.in_doubt || has(100));
    make_readable();
    restart();
    TEST_ASSERT_TRUE_MESSAGE(has(100) || has(n), "the defaults in silence");
  }
}

/* The first page is blank, but has been in use: an entry that was cut there can look blank. It is erased once more. */
static void test_a_page_that_looks_erased_is_erased_before_it_is_used_again(void) {
  const uint32_t n = fill_the_first_page();
  memset(model.bytes, 0xFF, PAGE_BYTES);
  restart();
  TEST_ASSERT_TRUE(has(n));
  TEST_ASSERT_FALSE(saved.in_doubt);
  const uint32_t erases = model.erases[0];
  TEST_ASSERT_EQUAL(BUS_SETTINGS_SAVED, save(100));
  TEST_ASSERT_EQUAL(erases + 1, model.erases[0]);
  TEST_ASSERT_EQUAL(0, saved.newest_page);
  restart();
  TEST_ASSERT_TRUE(has(100));
}

static void test_in_doubt_nothing_is_erased_before_a_save(void) {
  const uint32_t newest = fill_the_first_page();
  make_unreadable(1, 0);
  restart();
  TEST_ASSERT_TRUE(saved.found && saved.in_doubt);
  const uint32_t operations = model.operations;
  TEST_ASSERT_FALSE(bus_settings_log_step(&saved));
  TEST_ASSERT_EQUAL(operations, model.operations);
  make_readable();
  restart();
  TEST_ASSERT_TRUE(has(newest));
  TEST_ASSERT_FALSE(saved.in_doubt);
}

/* The page in doubt is erased once. The other one keeps what was stored before. */
static void test_a_save_in_doubt_erases_only_the_page_in_doubt(void) {
  (void)fill_the_first_page();
  make_unreadable(1, 0);
  restart();
  const uint32_t erases[] = {model.erases[0], model.erases[1]};
  make_readable(); /* erased cells are readable again */
  TEST_ASSERT_EQUAL(BUS_SETTINGS_SAVED, save(100));
  TEST_ASSERT_EQUAL(BUS_SETTINGS_SAVED, save(101));
  TEST_ASSERT_EQUAL(erases[0], model.erases[0]);
  TEST_ASSERT_EQUAL(erases[1] + 1, model.erases[1]);
}

static void test_a_cut_save_in_doubt_leaves_it_in_doubt(void) {
  for (int64_t operation = 0; operation < 3; ++operation) { /* trace, erase, entry */
    setUp();
    const uint32_t newest = fill_the_first_page();
    make_unreadable(1, 0);
    restart();
    model.operations_left = operation;
    TEST_ASSERT_EQUAL(BUS_SETTINGS_FAILED, save(100));
    restart();
    TEST_ASSERT_TRUE_MESSAGE(saved.in_doubt || has(newest), "an older node id in silence");
    TEST_ASSERT_EQUAL(BUS_SETTINGS_SAVED, save(100));
    restart();
    TEST_ASSERT_TRUE(has(100));
    TEST_ASSERT_FALSE(saved.in_doubt);
  }
}

static void test_without_a_readable_entry_the_defaults_are_in_doubt_until_the_next_save(void) {
  for (int64_t operation = -1; operation < 2; ++operation) { /* none is cut; erase, entry */
    setUp();
    TEST_ASSERT_EQUAL(BUS_SETTINGS_SAVED, save(5));
    make_unreadable(0, saved.newest_unit);
    restart();
    TEST_ASSERT_FALSE(saved.found);
    TEST_ASSERT_TRUE(saved.in_doubt);
    model.operations_left = operation;
    TEST_ASSERT_EQUAL(operation < 0 ? BUS_SETTINGS_SAVED : BUS_SETTINGS_FAILED, save(6));
    restart();
    TEST_ASSERT_EQUAL(operation >= 0, saved.in_doubt);
    TEST_ASSERT_EQUAL(BUS_SETTINGS_SAVED, save(7));
    restart();
    TEST_ASSERT_TRUE(has(7));
    TEST_ASSERT_FALSE(saved.in_doubt);
  }
}

/* Remains of an interrupted erase beside a page that is not full. */
static void test_a_page_of_remains_is_erased_by_the_next_save(void) {
  TEST_ASSERT_EQUAL(BUS_SETTINGS_SAVED, save(5));
  model.bytes[PAGE_BYTES + 9] = 0;
  restart();
  TEST_ASSERT_TRUE(has(5));
  TEST_ASSERT_TRUE(saved.in_doubt);
  TEST_ASSERT_EQUAL(BUS_SETTINGS_SAVED, save(6));
  TEST_ASSERT_EQUAL(BUS_SETTINGS_SAVED, save(7));
  restart();
  TEST_ASSERT_TRUE(has(7));
  TEST_ASSERT_FALSE(saved.in_doubt);
}

/* --- loss of power ------------------------------------------------------------------------------------------------ */

/* At each operation of a long sequence of saves, with each kind of remains of a cut, and then a second cut. */
static void test_a_loss_of_power_at_any_operation_leaves_the_old_settings_or_the_new_ones(void) {
  const uint32_t saves = 3 * UNITS;
  uint32_t cuts = 0, old = 0;
  bool cut = true;
  for (uint32_t operation = 0; cut; ++operation) {
    for (int kind = 0; kind < FLASH_CUTS; ++kind) {
      setUp();
      model.random = (random_source){operation + 1};
      model.cut = (flash_cut)kind;
      model.operations_left = operation;
      uint32_t last_good = 0;
      uint32_t n = 1;
      while (n <= saves && !model.off) {
        last_good = save(n) == BUS_SETTINGS_SAVED ? n : last_good;
        (void)bus_settings_log_step(&saved);
        ++n;
      }
      cut = model.off;
      restart();
      const bool is_old = last_good == 0 ? !saved.found : has(last_good);
      TEST_ASSERT_TRUE(is_old || has(n - 1));
      cuts += cut ? 1 : 0;
      old += cut && is_old ? 1 : 0;
      const uint32_t retained_number = is_old ? last_good : n - 1;
      model.operations_left = 0; /* the next one too */
      TEST_ASSERT_EQUAL(BUS_SETTINGS_FAILED, save(200));
      restart();
      TEST_ASSERT_TRUE(has(200) || (retained_number == 0 ? !saved.found : has(retained_number)));
      for (uint32_t again = 0; again < 2 * UNITS; ++again) {
        TEST_ASSERT_EQUAL(BUS_SETTINGS_SAVED, save(300 + again));
      }
      restart();
      TEST_ASSERT_TRUE(has(300 + 2 * UNITS - 1));
    }
  }
  printf("power cuts in the log of node id and bit rate: %u, of which %u left the old settings\n", (unsigned)cuts,
         (unsigned)old);
  TEST_ASSERT_TRUE(cuts > 50 && old > 20);
}

int main(void) {
  UNITY_BEGIN();
  RUN_TEST(test_an_empty_flash_gives_the_defaults);
  RUN_TEST(test_what_was_saved_last_is_found_after_any_number_of_saves);
  RUN_TEST(test_the_first_save_after_a_start_skips_the_next_blank_double_word);
  RUN_TEST(test_a_save_never_waits_for_an_erase);
  RUN_TEST(test_the_same_settings_are_not_written_again);
  RUN_TEST(test_the_defaults_are_written_when_they_are_requested);
  RUN_TEST(test_without_a_flash_they_are_kept_until_the_power_goes);
  RUN_TEST(test_a_flash_that_refuses_changes_nothing);
  RUN_TEST(test_a_flash_that_works_again_takes_the_next_settings);
  RUN_TEST(test_sequence_numbers_end_and_the_last_settings_stay);
  RUN_TEST(test_entries_that_say_what_cannot_be_are_skipped);
  RUN_TEST(test_an_unreadable_newest_entry_is_in_doubt_until_the_next_save);
  RUN_TEST(test_an_unreadable_older_entry_is_not_in_doubt);
  RUN_TEST(test_remains_behind_the_entries_of_the_older_page_are_not_in_doubt);
  RUN_TEST(test_an_unreadable_entry_of_the_second_page_is_in_doubt_until_the_next_save);
  RUN_TEST(test_a_page_that_looks_erased_is_erased_before_it_is_used_again);
  RUN_TEST(test_in_doubt_nothing_is_erased_before_a_save);
  RUN_TEST(test_a_save_in_doubt_erases_only_the_page_in_doubt);
  RUN_TEST(test_a_cut_save_in_doubt_leaves_it_in_doubt);
  RUN_TEST(test_without_a_readable_entry_the_defaults_are_in_doubt_until_the_next_save);
  RUN_TEST(test_a_page_of_remains_is_erased_by_the_next_save);
  RUN_TEST(test_a_loss_of_power_at_any_operation_leaves_the_old_settings_or_the_new_ones);
  return UNITY_END();
}
