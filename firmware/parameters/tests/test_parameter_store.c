/* SPDX-License-Identifier: Apache-2.0 */
/* The parameter store: its contents after any loss of power, any damage, and in any flash. */
#include "parameters/parameter_store.h"

#include <stdio.h>

#include "base/crc32.h"
#include "support/flash_model.h"
#include "unity.h"

#define MAGIC 0x54535631u
#define COMMIT 0x444E4521u

enum { MAX_ROWS = 300 };

typedef struct {
  parameter_row rows[MAX_ROWS];
  uint32_t count;
  uint32_t hash;
} row_set;

static flash_model model;
static hal_flash areas[PARAMETER_STORE_AREAS];
static parameter_store store;

void setUp(void) {}
void tearDown(void) {}

static void fit_flash(uint32_t page_bytes, uint32_t pages) {
  flash_model_init(&model, page_bytes, pages);
  areas[0] = flash_model_area(&model, 0);
  areas[1] = flash_model_area(&model, 1);
  parameter_store_open(&store, areas);
}

/* Power is on again. */
static void restart(void) {
  model.off = false;
  model.operations_left = -1;
  parameter_store_open(&store, areas);
}

static void fill(row_set *set, uint32_t seed, uint32_t count) {
  random_source random = {seed};
  set->count = count;
  set->hash = (uint32_t)random_bits(&random);
  for (uint32_t i = 0; i < count; ++i) {
    set->rows[i] = (parameter_row){(0x2000 + i) << 16 | 0x0108, (uint32_t)random_bits(&random)};
  }
}

static parameter_store_state run_save(void) {
  while (parameter_store_progress(&store) == PARAMETER_STORE_BUSY) {
    const uint32_t before = model.operations;
    parameter_store_step(&store);
    TEST_ASSERT_TRUE_MESSAGE(model.operations <= before + 1, "more than one operation in a step");
  }
  return parameter_store_progress(&store);
}

static parameter_store_state save(const row_set *set) {
  TEST_ASSERT_TRUE(parameter_store_begin(&store, set->hash, set->rows, set->count));
  return run_save();
}

/* The newest complete set is `set`, unchanged. */
static bool finds(const row_set *set) {
  static parameter_row rows[MAX_ROWS];
  return store.count > 0 && parameter_store_load(&store, 0, rows, MAX_ROWS) && store.found[0].rows == set->count &&
         store.found[0].schema_hash == set->hash && memcmp(rows, set->rows, set->count * sizeof rows[0]) == 0;
}

/* --- without faults --------------------------------------------------------------------------------------------- */

static void test_an_empty_flash_has_no_set(void) {
  fit_flash(2048, 4);
  parameter_row row;
  TEST_ASSERT_EQUAL(0, store.count);
  TEST_ASSERT_EQUAL(0, store.damaged + store.unfinished);
  TEST_ASSERT_FALSE(parameter_store_load(&store, 0, &row, 1));
  TEST_ASSERT_EQUAL(PARAMETER_STORE_IDLE, parameter_store_progress(&store));
}

static void test_what_was_saved_last_is_found(void) {
  row_set set;
  fit_flash(2048, 4);
  for (uint32_t n = 0; n < 20; ++n) {
    fill(&set, n, n * 15);
    TEST_ASSERT_EQUAL(PARAMETER_STORE_SAVED, save(&set));
    restart();
    TEST_ASSERT_TRUE(finds(&set));
    TEST_ASSERT_EQUAL(n + 1, store.found[0].sequence);
    TEST_ASSERT_EQUAL(0, store.damaged + store.unfinished);
  }
  TEST_ASSERT_EQUAL(0, model.rule_breaks);
}

/* Of one page each, in areas of four: after nine saves one area has the newest set, the other one the four before. */
static void test_all_sets_that_were_not_erased_are_found_the_newest_first(void) {
  static row_set sets[11];
  static parameter_store reader;
  static parameter_row rows[5];
  fit_flash(256, 4);
  for (uint32_t n = 0; n < 11; ++n) {
    fill(&sets[n], n, 5);
    TEST_ASSERT_EQUAL(PARAMETER_STORE_SAVED, save(&sets[n]));
    parameter_store_open(&reader, areas);
    TEST_ASSERT_EQUAL(n < 8 ? n + 1 : n - 3, reader.count);
    for (uint32_t i = 0; i < reader.count; ++i) {
      TEST_ASSERT_EQUAL(n + 1 - i, reader.found[i].sequence);
      TEST_ASSERT_TRUE(parameter_store_load(&reader, i, rows, 5));
      TEST_ASSERT_EQUAL_MEMORY(sets[n - i].rows, rows, sizeof rows);
    }
  }
}

static void test_a_second_save_waits_for_the_first(void) {
  row_set set;
  fit_flash(256, 4);
  fill(&set, 1, 10);
  TEST_ASSERT_TRUE(parameter_store_begin(&store, set.hash, set.rows, set.count));
  TEST_ASSERT_FALSE(parameter_store_begin(&store, set.hash, set.rows, set.count));
  TEST_ASSERT_EQUAL(PARAMETER_STORE_SAVED, run_save());
  const uint32_t operations = model.operations;
  parameter_store_step(&store); /* nothing is left to do */
  TEST_ASSERT_EQUAL(operations, model.operations);
}

static void test_a_set_that_does_not_fit_is_refused(void) {
  row_set set;
  fit_flash(64, 4); /* 32 double words an area, 4 of them the record's frame */
  fill(&set, 1, 29);
  TEST_ASSERT_FALSE(parameter_store_begin(&store, set.hash, set.rows, 29));
  TEST_ASSERT_TRUE(parameter_store_begin(&store, set.hash, set.rows, 28));
  TEST_ASSERT_EQUAL(PARAMETER_STORE_SAVED, run_save());
  restart();
  parameter_row rows[28];
  TEST_ASSERT_FALSE(parameter_store_load(&store, 0, rows, 27));
  TEST_ASSERT_TRUE(parameter_store_load(&store, 0, rows, 28));
}

static void test_sequence_numbers_end_long_after_the_flash(void) {
  row_set set;
  fit_flash(256, 4);
  store.last_sequence = PARAMETER_STORE_MAX_SAVES - 3;
  for (uint32_t n = 0; n < 3; ++n) {
    fill(&set, n, 5);
    TEST_ASSERT_EQUAL(PARAMETER_STORE_SAVED, save(&set));
    restart();
    TEST_ASSERT_TRUE(finds(&set));
    TEST_ASSERT_EQUAL_UINT32(PARAMETER_STORE_MAX_SAVES - 2 + n, store.found[0].sequence);
  }
  row_set another;
  fill(&another, 4, 5);
  TEST_ASSERT_FALSE(parameter_store_begin(&store, another.hash, another.rows, another.count));
  restart();
  TEST_ASSERT_TRUE(finds(&set));
}

/* All three are damaged in a row; the newest one is the second of the second area. */
static void test_without_a_good_set_the_next_number_is_far_above_all_that_can_be_read(void) {
  row_set set;
  fit_flash(256, 4);
  fill(&set, 1, 5);
  TEST_ASSERT_EQUAL(PARAMETER_STORE_SAVED, save(&set));
  restart(); /* the next one begins the other area */
  TEST_ASSERT_EQUAL(PARAMETER_STORE_SAVED, save(&set));
  TEST_ASSERT_EQUAL(PARAMETER_STORE_SAVED, save(&set));
  for (uint32_t page = 0; page <= 5; page += page == 0 ? 4 : 1) {
    model.bytes[page * 256 + 2 * HAL_FLASH_UNIT_BYTES] ^= 1u;
  }
  restart();
  TEST_ASSERT_EQUAL(0, store.count);
  TEST_ASSERT_EQUAL(PARAMETER_STORE_SAVED, save(&set));
  restart();
  TEST_ASSERT_TRUE(finds(&set));
  TEST_ASSERT_EQUAL(3 + PARAMETER_STORE_DOUBT_STEP, store.found[0].sequence);
}

static void test_pages_wear_evenly(void) {
  row_set set;
  fit_flash(2048, 4);
  const uint32_t saves = 400;
  for (uint32_t n = 0; n < saves; ++n) {
    fill(&set, n, 280);
    TEST_ASSERT_EQUAL(PARAMETER_STORE_SAVED, save(&set));
  }
  for (uint32_t page = 0; page < 8; ++page) {
    TEST_ASSERT_UINT32_WITHIN(1, saves / 4, model.erases[page]);
  }
}

/* --- refused or worn ---------------------------------------------------------------------------------------------- */

static void test_the_set_in_use_survives_a_newer_one_that_was_refused(void) {
  row_set good, refused, next;
  fit_flash(256, 2);
  fill(&good, 1, 5);
  fill(&refused, 2, 60);
  fill(&next, 3, 60); /* two pages: a whole area */
  TEST_ASSERT_EQUAL(PARAMETER_STORE_SAVED, save(&good));
  TEST_ASSERT_EQUAL(PARAMETER_STORE_SAVED, save(&refused));
  restart();
  TEST_ASSERT_TRUE(finds(&refused));
  parameter_store_use(&store, 1);
  model.operations_left = 10; /* in the middle of the next save */
  TEST_ASSERT_EQUAL(PARAMETER_STORE_FAILED, save(&next));
  restart();
  TEST_ASSERT_TRUE(finds(&good));
  TEST_ASSERT_EQUAL(PARAMETER_STORE_SAVED, save(&next));
  restart();
  TEST_ASSERT_TRUE(finds(&next));
}

/* found[n] that was not found protects nothing: the next save may take any page. */
static void test_a_set_that_was_not_found_is_not_in_use(void) {
  for (uint32_t n = 0; n < 3; ++n) {
    fit_flash(256, 4);
    restart();
    parameter_store_use(&store, n);
    TEST_ASSERT_FALSE(store.has_in_use);
  }
}

static void test_a_page_that_cannot_be_programmed_leaves_the_old_set(void) {
  row_set old, next;
  fit_flash(256, 4);
  fill(&old, 1, 30);
  fill(&next, 2, 30);
  TEST_ASSERT_EQUAL(PARAMETER_STORE_SAVED, save(&old));
  model.operations_left = 3;
  TEST_ASSERT_EQUAL(PARAMETER_STORE_FAILED, save(&next));
  model.off = false; /* the program continues: no loss of power */
  model.operations_left = -1;
  TEST_ASSERT_EQUAL(PARAMETER_STORE_SAVED, save(&next));
  TEST_ASSERT_EQUAL(0, model.rule_breaks);
  restart();
  TEST_ASSERT_TRUE(finds(&next));
}

/* Two sets of rows are saved, found after a restart; gives the page of the newer one. */
static uint32_t page_of_the_newer_of_two_sets(row_set *old, row_set *newest, uint32_t page_bytes, uint32_t rows) {
  fit_flash(page_bytes, 4);
  fill(old, 1, rows);
  fill(newest, 2, rows);
  TEST_ASSERT_EQUAL(PARAMETER_STORE_SAVED, save(old));
  TEST_ASSERT_EQUAL(PARAMETER_STORE_SAVED, save(newest));
  restart();
  TEST_ASSERT_TRUE(finds(newest));
  return store.found[0].page;
}

/* Every bit of the newest record, one at a time. */
static void test_a_wrong_bit_anywhere_gives_the_set_before_and_is_reported(void) {
  row_set old, newest;
  uint8_t *record = model.bytes + page_of_the_newer_of_two_sets(&old, &newest, 256, 12) * model.page_bytes;
  for (uint32_t bit = 0; bit < 8 * HAL_FLASH_UNIT_BYTES * (12 + PARAMETER_STORE_FRAME_UNITS); ++bit) {
    record[bit / 8] = (uint8_t)(record[bit / 8] ^ 1u << bit % 8);
    restart();
    TEST_ASSERT_TRUE(finds(&old));
    TEST_ASSERT_EQUAL(1, store.damaged + store.unfinished);
    record[bit / 8] = (uint8_t)(record[bit / 8] ^ 1u << bit % 8);
  }
}

static void test_an_unreadable_double_word_anywhere_gives_the_set_before_and_is_reported(void) {
  row_set old, newest;
  const uint32_t page = page_of_the_newer_of_two_sets(&old, &newest, 256, 12);
  const uint32_t first = page * model.page_bytes / HAL_FLASH_UNIT_BYTES;
  for (uint32_t unit = 0; unit < 12 + PARAMETER_STORE_FRAME_UNITS; ++unit) {
    model.weak[first + unit].shows = SHOWS_UNREADABLE;
    restart();
    TEST_ASSERT_TRUE(finds(&old));
    TEST_ASSERT_EQUAL(1, store.damaged);
    TEST_ASSERT_EQUAL(0, store.unfinished);
    model.weak[first + unit].shows = SHOWS_RIGHT;
  }
}

static void flip(uint8_t *record, uint32_t bit) { record[bit / 8] = (uint8_t)(record[bit / 8] ^ 1u << bit % 8); }

/* Bound: all pairs of bits of the newest record, of two rows (73,536), and every double word of it replaced by blank,
 * by zeros and by each other double word of the record. */
static void test_two_wrong_bits_or_a_wrong_double_word_give_the_set_before(void) {
  enum { ROWS = 2, UNITS = ROWS + PARAMETER_STORE_FRAME_UNITS, BITS = UNITS * 8 * HAL_FLASH_UNIT_BYTES };
  row_set old, newest;
  uint8_t *record = model.bytes + page_of_the_newer_of_two_sets(&old, &newest, 64, ROWS) * model.page_bytes;
  uint32_t tried = 0, wrong = 0;
  for (uint32_t one = 0; one < (uint32_t)random_cases(BITS); ++one) {
    for (uint32_t other = one + 1; other < BITS; ++other, ++tried) {
      flip(record, one);
      flip(record, other);
      restart();
      wrong += finds(&old) ? 0u : 1u;
      flip(record, one);
      flip(record, other);
    }
  }
  uint8_t good[UNITS + 2][HAL_FLASH_UNIT_BYTES] = {{0}};
  memcpy(good, record, (size_t)UNITS * HAL_FLASH_UNIT_BYTES);
  memset(good[UNITS + 1], 0xFF, HAL_FLASH_UNIT_BYTES); /* and [UNITS] is zeros */
  for (uint32_t place = 0; place < UNITS; ++place) {
    for (uint32_t from = 0; from < UNITS + 2; ++from, ++tried) {
      const bool same = memcmp(good[from], good[place], HAL_FLASH_UNIT_BYTES) == 0;
      memcpy(record + place * HAL_FLASH_UNIT_BYTES, good[from], HAL_FLASH_UNIT_BYTES);
      restart();
      wrong += finds(same ? &newest : &old) ? 0u : 1u;
      memcpy(record + place * HAL_FLASH_UNIT_BYTES, good[place], HAL_FLASH_UNIT_BYTES);
    }
  }
  printf("wrong records: %u tried, %u taken\n", (unsigned)tried, (unsigned)wrong);
  TEST_ASSERT_EQUAL(0, wrong);
}

/* --- loss of power ------------------------------------------------------------------------------------------------ */

typedef struct {
  uint32_t cuts;
  uint32_t old;
  uint32_t complete;
  uint32_t neither;
} cut_counts;

static void count_what_is_found(cut_counts *counts, const row_set *old, const row_set *next) {
  counts->cuts++;
  if (finds(old)) {
    counts->old++;
  } else if (finds(next)) {
    counts->complete++;
  } else {
    counts->neither++;
  }
}

/* The power fails in the next operation of the save in progress; then it is on again, and another set is saved. The
 * whole change is undone. */
static void try_cut(cut_counts *counts, flash_cut cut, const row_set *old, const row_set *next) {
  static flash_model before_cut;
  static parameter_store store_before_cut;
  row_set third;
  before_cut = model;
  memcpy(&store_before_cut, &store, sizeof store);
  model.cut = cut;
  model.operations_left = 0;
  while (!model.off && parameter_store_progress(&store) == PARAMETER_STORE_BUSY) {
    parameter_store_step(&store);
  }
  restart();
  count_what_is_found(counts, old, next);
  fill(&third, counts->cuts + 1000000, 7);
  const bool saved = save(&third) == PARAMETER_STORE_SAVED && model.rule_breaks == 0;
  restart();
  TEST_ASSERT_TRUE_MESSAGE(saved && finds(&third), "cannot save after a loss of power");
  const random_source random = model.random;
  model = before_cut;
  model.random = random;
  memcpy(&store, &store_before_cut, sizeof store);
}

/* Saves this many times, and tries every cut in every operation of each save except the first. */
static cut_counts cut_everywhere(int saves, uint32_t rows) {
  cut_counts counts = {0};
  static row_set old, next;
  fill(&old, 1, rows);
  TEST_ASSERT_EQUAL(PARAMETER_STORE_SAVED, save(&old));
  for (int n = 0; n < saves; ++n) {
    fill(&next, (uint32_t)n + 2, rows);
    TEST_ASSERT_TRUE(parameter_store_begin(&store, next.hash, next.rows, next.count));
    while (parameter_store_progress(&store) == PARAMETER_STORE_BUSY) {
      for (int cut = 0; cut < FLASH_CUTS; ++cut) {
        try_cut(&counts, (flash_cut)cut, &old, &next);
      }
      parameter_store_step(&store);
    }
    TEST_ASSERT_EQUAL(PARAMETER_STORE_SAVED, parameter_store_progress(&store));
    restart();
    TEST_ASSERT_TRUE(finds(&next));
    TEST_ASSERT_EQUAL(0, store.damaged + store.unfinished);
    old = next;
  }
  TEST_ASSERT_EQUAL(0, model.rule_breaks);
  return counts;
}

static void judge(const char *what, int saves, cut_counts counts) {
  printf("%s: %d saves, %u cuts: old set %u, new set %u, neither %u\n", what, saves, (unsigned)counts.cuts,
         (unsigned)counts.old, (unsigned)counts.complete, (unsigned)counts.neither);
  TEST_ASSERT_EQUAL(0, counts.neither);
  TEST_ASSERT_TRUE(counts.old > 0);
}

static void test_a_cut_at_every_operation_of_a_thousand_saves_leaves_the_old_set_or_the_new_one(void) {
  const int saves = random_cases(1000);
  fit_flash(256, 4);
  judge("power cuts, two pages a set", saves, cut_everywhere(saves, 40));
}

static void test_a_cut_in_a_set_of_the_real_size_leaves_the_old_set_or_the_new_one(void) {
  const int saves = random_cases(50) / 10 + 1;
  fit_flash(2048, 4);
  judge("power cuts, pages of the board", saves, cut_everywhere(saves, 280));
}

/* The remains of a cut are there when the next one comes. */
static void test_cuts_upon_cuts_leave_the_old_set_or_the_new_one(void) {
  const int saves = random_cases(20000);
  random_source random = {7};
  cut_counts counts = {0};
  static row_set old, next;
  fit_flash(128, 4);
  fill(&old, 1, 20);
  TEST_ASSERT_EQUAL(PARAMETER_STORE_SAVED, save(&old));
  for (int n = 0; n < saves; ++n) {
    fill(&next, (uint32_t)n + 2, 8 + (uint32_t)(random_bits(&random) % 24));
    model.cut = (flash_cut)(random_bits(&random) % FLASH_CUTS);
    model.operations_left = (int64_t)(random_bits(&random) % 40);
    (void)save(&next);
    restart();
    count_what_is_found(&counts, &old, &next);
    if (finds(&next)) {
      old = next;
    }
  }
  TEST_ASSERT_EQUAL(0, model.rule_breaks);
  judge("power cuts upon power cuts", saves, counts);
  TEST_ASSERT_TRUE(counts.complete > 0);
}

/* --- any contents
 * --------------------------------------------------------------------------------------------------- */

/* The conditions for a record without rows, written differently than in the reader. */
static bool is_complete_and_empty(const uint32_t *words) {
  const uint32_t crc = crc32_end(crc32_add(CRC32_START, (const uint8_t *)words, 16));
  return words[0] == MAGIC && words[3] == 0 && words[4] == crc && words[5] == ~crc && words[6] == COMMIT &&
         words[7] == words[1] && words[1] >> 31 == 0;
}

/* Bound: all contents of the first 8 words of an area (a whole record without rows), each word one of 7 values, with
 * everything else blank: 5,764,801 flashes. The last two values are 7 and FFFFFFFE in the words that are summed, and
 * the right CRC and its complement behind them. */
static void test_the_reader_takes_exactly_what_is_complete_out_of_all_short_contents(void) {
  enum { VALUES = 7, WORDS = 8 };
  uint32_t values[VALUES] = {UINT32_MAX, 0, 1, MAGIC, COMMIT, 7, UINT32_MAX - 1};
  uint32_t tried = 0, complete = 0, taken = 0, wrong = 0;
  fit_flash(64, 1);
  uint32_t *words = (uint32_t *)(void *)model.bytes;
  const uint32_t cases = (uint32_t)random_cases(5764801);
  for (uint32_t n = 0; n < cases; ++n, ++tried) {
    uint32_t left = n;
    for (int word = 0; word < 4; ++word, left /= VALUES) {
      words[word] = values[left % VALUES];
    }
    values[5] = crc32_end(crc32_add(CRC32_START, model.bytes, 16));
    values[6] = ~values[5];
    for (int word = 4; word < WORDS; ++word, left /= VALUES) {
      words[word] = values[left % VALUES];
    }
    values[5] = 7;
    values[6] = UINT32_MAX - 1;
    parameter_store_open(&store, areas);
    const bool expected = is_complete_and_empty(words);
    complete += expected ? 1 : 0;
    taken += store.count;
    wrong += (store.count == 1) != expected ? 1 : 0;
  }
  printf("short contents: %u flashes, %u complete, %u taken\n", (unsigned)tried, (unsigned)complete, (unsigned)taken);
  TEST_ASSERT_EQUAL(0, wrong);
  TEST_ASSERT_EQUAL(0, model.rule_breaks);
  TEST_ASSERT_EQUAL(complete, taken);
}

static void test_the_number_of_rows_cannot_lead_out_of_the_area(void) {
  const uint32_t counts[] = {1, 4, 5, 511, 512, 513, 0x1FFFFFFC, 0x1FFFFFFD, 0x7FFFFFFF, 0x80000000, UINT32_MAX - 3};
  fit_flash(64, 1);
  uint32_t *words = (uint32_t *)(void *)model.bytes;
  for (uint32_t i = 0; i < sizeof counts / sizeof counts[0]; ++i) {
    for (uint32_t word = 0; word < 16; word += 2) {
      words[word] = COMMIT;
      words[word + 1] = 1;
    }
    words[0] = MAGIC;
    words[3] = counts[i];
    restart();
    TEST_ASSERT_EQUAL(0, store.count);
    TEST_ASSERT_EQUAL(1, store.damaged + store.unfinished);
    TEST_ASSERT_EQUAL(0, model.rule_breaks);
  }
}

/* Pages without a head that are not blank: those in a row are of one record, those behind a blank page of another. */
static void test_remains_behind_a_blank_page_are_counted_by_themselves(void) {
  static const struct {
    bool written[4];
    uint32_t damaged;
  } areas_of[] = {{{true, true, false, false}, 1}, {{true, false, true, false}, 2}, {{false, true, true, false}, 1}};
  for (uint32_t i = 0; i < sizeof areas_of / sizeof areas_of[0]; ++i) {
    fit_flash(64, 4);
    for (uint32_t page = 0; page < 4; ++page) {
      model.bytes[64 * page + 8] = areas_of[i].written[page] ? 0x55 : 0xFF;
    }
    restart();
    TEST_ASSERT_EQUAL(areas_of[i].damaged, store.damaged);
  }
}

/* The first double word of the head has been programmed. Behind it, both words blank: the save was cut there. */
static void test_a_head_that_is_half_blank_is_damaged(void) {
  static const struct {
    uint32_t schema_hash, rows;
    uint32_t unfinished, damaged;
  } heads[] = {{UINT32_MAX, UINT32_MAX, 1, 0}, {7, UINT32_MAX, 0, 1}, {UINT32_MAX, 513, 0, 1}};
  for (uint32_t i = 0; i < sizeof heads / sizeof heads[0]; ++i) {
    fit_flash(64, 1);
    uint32_t *words = (uint32_t *)(void *)model.bytes;
    words[0] = MAGIC;
    words[1] = 1;
    words[2] = heads[i].schema_hash;
    words[3] = heads[i].rows;
    restart();
    TEST_ASSERT_EQUAL(heads[i].unfinished, store.unfinished);
    TEST_ASSERT_EQUAL(heads[i].damaged, store.damaged);
  }
}

int main(void) {
  UNITY_BEGIN();
  RUN_TEST(test_an_empty_flash_has_no_set);
  RUN_TEST(test_what_was_saved_last_is_found);
  RUN_TEST(test_all_sets_that_were_not_erased_are_found_the_newest_first);
  RUN_TEST(test_a_second_save_waits_for_the_first);
  RUN_TEST(test_a_set_that_does_not_fit_is_refused);
  RUN_TEST(test_sequence_numbers_end_long_after_the_flash);
  RUN_TEST(test_without_a_good_set_the_next_number_is_far_above_all_that_can_be_read);
  RUN_TEST(test_pages_wear_evenly);
  RUN_TEST(test_the_set_in_use_survives_a_newer_one_that_was_refused);
  RUN_TEST(test_a_set_that_was_not_found_is_not_in_use);
  RUN_TEST(test_a_page_that_cannot_be_programmed_leaves_the_old_set);
  RUN_TEST(test_a_wrong_bit_anywhere_gives_the_set_before_and_is_reported);
  RUN_TEST(test_an_unreadable_double_word_anywhere_gives_the_set_before_and_is_reported);
  RUN_TEST(test_two_wrong_bits_or_a_wrong_double_word_give_the_set_before);
  RUN_TEST(test_a_cut_at_every_operation_of_a_thousand_saves_leaves_the_old_set_or_the_new_one);
  RUN_TEST(test_a_cut_in_a_set_of_the_real_size_leaves_the_old_set_or_the_new_one);
  RUN_TEST(test_cuts_upon_cuts_leave_the_old_set_or_the_new_one);
  RUN_TEST(test_the_reader_takes_exactly_what_is_complete_out_of_all_short_contents);
  RUN_TEST(test_the_number_of_rows_cannot_lead_out_of_the_area);
  RUN_TEST(test_remains_behind_a_blank_page_are_counted_by_themselves);
  RUN_TEST(test_a_head_that_is_half_blank_is_damaged);
  return UNITY_END();
}
