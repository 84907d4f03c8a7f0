/* SPDX-License-Identifier: Apache-2.0 */
/* Both stores over a flash whose cells are weak, at which the power fails, and which reads differently from start to
 * start: a set or entry whose save was acknowledged is never replaced by an older one in silence.
 *
 * The oracle knows nothing of the stores: it remembers the number of the last acknowledged save. */
#include <stdio.h>

#include "parameters/bus_settings_log.h"
#include "parameters/parameter_store.h"
#include "support/flash_model.h"
#include "unity.h"

enum { STARTS_OF_A_FLASH = 500, FLASHES = 960, NONE = 0 };

typedef struct {
  uint32_t starts;
  uint32_t quiet;
  uint32_t reported;         /* starts that report a doubt */
  uint32_t older_reported;   /* ... and the newest acknowledged set is not in force */
  uint32_t silent_losses;    /* it is not in force, and nothing reports it */
  uint32_t wrong;            /* contents that no save had */
  uint32_t acknowledged;     /* saves */
  uint32_t cut;              /* saves */
  uint32_t first_wrong_seed; /* for a debugger */
} account;

static flash_model model;
static random_source dice;
static account all;
static uint32_t acknowledged; /* number of the last acknowledged save */
static uint32_t tried;        /* number of the last save that was begun */
static uint32_t seed;

static uint32_t throw_of(uint32_t sides) { return (uint32_t)(random_bits(&dice) % sides); }

void setUp(void) { memset(&all, 0, sizeof all); }
void tearDown(void) {}

static void new_flash(uint32_t page_bytes, uint32_t pages, uint32_t n) {
  seed = n;
  dice = (random_source){n};
  flash_model_init(&model, page_bytes, pages);
  model.random = (random_source){n + 1000000};
  model.cuts_leave_weak = true;
  acknowledged = NONE;
  tried = NONE;
}

static bool is_erased(uint32_t unit) {
  static const uint8_t blank[HAL_FLASH_UNIT_BYTES] = {0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF};
  return memcmp(model.bytes + (size_t)unit * HAL_FLASH_UNIT_BYTES, blank, sizeof blank) == 0;
}

/* Cells grow weak: one to four bits of a double word that holds data. */
static void age(void) {
  const uint32_t units = flash_model_bytes(&model) / HAL_FLASH_UNIT_BYTES;
  for (uint32_t n = throw_of(8) < 3 ? 1 + throw_of(2) : 0; n > 0; --n) {
    uint64_t wrong = 0;
    for (uint32_t bits = 1 + throw_of(4); bits > 0; --bits) {
      wrong |= UINT64_C(1) << throw_of(64);
    }
    const uint32_t unit = throw_of(units);
    if (!is_erased(unit)) {
      flash_model_weaken(&model, unit, wrong);
      model.weak[unit].changes_at_reads = throw_of(8) == 0;
    }
  }
}

static void power_may_fail(uint32_t within) {
  model.cut = (flash_cut)throw_of(FLASH_CUTS);
  model.operations_left = throw_of(2) == 0 ? (int64_t)throw_of(within) : -1;
  model.refusals = throw_of(10) == 0 ? 30 : 0;
}

/* `found`: the number of the save in force, NONE for the defaults. */
static void judge_start(uint32_t found, bool is_reported) {
  all.starts++;
  all.quiet += is_reported ? 0u : 1u;
  all.reported += is_reported ? 1u : 0u;
  const bool is_older = found < acknowledged;
  all.older_reported += is_older && is_reported ? 1u : 0u;
  if (is_older && !is_reported) {
    all.silent_losses++;
  }
  all.wrong += found > tried ? 1u : 0u;
  all.first_wrong_seed = all.first_wrong_seed == 0 && all.wrong + all.silent_losses > 0 ? seed : all.first_wrong_seed;
}

static void judge_save(bool saved) {
  if (saved) {
    acknowledged = tried;
    all.acknowledged++;
  }
  all.cut += model.off ? 1u : 0u;
}

static void report(const char *what) {
  printf(
      "%s: %u starts, %u of them quiet, %u reported a doubt, %u of these with an older set; saves: %u acknowledged, "
      "%u cut. Silent losses %u, wrong sets %u",
      what, (unsigned)all.starts, (unsigned)all.quiet, (unsigned)all.reported, (unsigned)all.older_reported,
      (unsigned)all.acknowledged, (unsigned)all.cut, (unsigned)all.silent_losses, (unsigned)all.wrong);
  printf(all.first_wrong_seed == 0 ? "\n" : "; first with seed %u\n", (unsigned)all.first_wrong_seed);
  TEST_ASSERT_EQUAL(0, all.silent_losses);
  TEST_ASSERT_EQUAL(0, all.wrong);
  TEST_ASSERT_TRUE(all.quiet > 0 && all.older_reported > 0 && all.cut > 0);
}

/* --- parameter sets ----------------------------------------------------------------------------------------------- */

enum { PAGE_BYTES = 128, PAGES = 4, UNITS = PAGE_BYTES / HAL_FLASH_UNIT_BYTES, MAX_ROWS = 3 * UNITS };

static parameter_store store;
static hal_flash areas[PARAMETER_STORE_AREAS];

/* The sets of a flash have 1, 2 or 3 pages, those of another flash as many as a firmware with more objects has. */
static uint32_t rows_of(uint32_t number) {
  return seed % 3 * UNITS + 1 + number * 7 % (UNITS - PARAMETER_STORE_FRAME_UNITS);
}

static parameter_row row_of(uint32_t number, uint32_t row) { return (parameter_row){row << 16, number}; }

/* The number of the save that had these contents; `tried` + 1 for none. */
static uint32_t number_of(const parameter_row *rows, uint32_t count, uint32_t hash) {
  const uint32_t number = rows[0].value;
  bool same = hash == ~number && count == rows_of(number);
  for (uint32_t row = 0; same && row < count; ++row) {
    const parameter_row wanted = row_of(number, row);
    same = memcmp(&rows[row], &wanted, sizeof wanted) == 0;
  }
  return same ? number : tried + 1;
}

/* Like persisted_storage_start. Once in 200 starts the checks of values refuse the newest set. */
static void start_with_the_newest_set(void) {
  static parameter_row rows[MAX_ROWS];
  const bool refuses = throw_of(200) == 0;
  flash_model_start(&model);
  parameter_store_open(&store, areas);
  uint32_t refused = 0;
  uint32_t found = NONE;
  for (uint32_t n = 0; n < store.count && found == NONE; ++n) {
    if ((n > 0 || !refuses) && parameter_store_load(&store, n, rows, MAX_ROWS)) {
      parameter_store_use(&store, n);
      found = number_of(rows, store.found[n].rows, store.found[n].schema_hash);
    } else {
      refused++;
    }
  }
  judge_start(found, store.damaged + store.unfinished + refused > 0);
}

static void save_a_set(void) {
  static parameter_row rows[MAX_ROWS];
  tried++;
  for (uint32_t row = 0; row < rows_of(tried); ++row) {
    rows[row] = row_of(tried, row);
  }
  power_may_fail(60);
  TEST_ASSERT_TRUE(parameter_store_begin(&store, ~tried, rows, rows_of(tried)));
  while (parameter_store_progress(&store) == PARAMETER_STORE_BUSY) {
    parameter_store_step(&store);
  }
  judge_save(parameter_store_progress(&store) == PARAMETER_STORE_SAVED);
}

static void test_no_acknowledged_set_is_replaced_by_an_older_one_in_silence(void) {
  const uint32_t flashes = (uint32_t)random_cases(FLASHES);
  for (uint32_t n = 1; n <= flashes; ++n) {
    new_flash(PAGE_BYTES, PAGES, n);
    areas[0] = flash_model_area(&model, 0);
    areas[1] = flash_model_area(&model, 1);
    for (int start = 0; start < STARTS_OF_A_FLASH; ++start) {
      start_with_the_newest_set();
      for (uint32_t saves = throw_of(3); saves > 0 && !model.off; --saves) {
        save_a_set();
      }
      age();
    }
    TEST_ASSERT_EQUAL_MESSAGE(0, model.rule_breaks, "programmed where it is not erased");
  }
  report("parameter sets");
}

/* --- node id and bit rate ----------------------------------------------------------------------------------------- */

static bus_settings_log settings;
static hal_flash bus_pages;

static const bus_settings defaults = {.node_id = 127, .kbit_s = 1000};

/* Four numbers in a node id and a bit rate: enough to distinguish the last saves. */
static bus_settings settings_no(uint32_t number) {
  static const uint16_t kbit_s[] = {1000, 500, 250, 125};
  return (bus_settings){.node_id = (uint8_t)(1 + number % 126), .kbit_s = kbit_s[number / 126 % 4]};
}

/* The last save that had these settings. */
static uint32_t number_of_settings(const bus_settings *found) {
  for (uint32_t number = tried; number > 0 && number + 500 > tried; --number) {
    const bus_settings wanted = settings_no(number);
    if (bus_settings_are_same(found, &wanted)) {
      return number;
    }
  }
  return tried + 1;
}

static void start_with_the_newest_settings(void) {
  flash_model_start(&model);
  bus_settings_log_open(&settings, &bus_pages, &defaults);
  judge_start(settings.found ? number_of_settings(&settings.newest) : NONE, settings.in_doubt);
}

static void save_settings(void) {
  const bus_settings wanted = settings_no(++tried);
  power_may_fail(4);
  bus_settings_work result = BUS_SETTINGS_REQUESTED;
  TEST_ASSERT_TRUE(bus_settings_log_begin(&settings, &wanted));
  while (result == BUS_SETTINGS_REQUESTED) {
    TEST_ASSERT_TRUE(bus_settings_log_step(&settings));
    result = bus_settings_log_take_result(&settings);
  }
  judge_save(result == BUS_SETTINGS_SAVED);
}

static void test_no_acknowledged_node_id_is_replaced_by_an_older_one_in_silence(void) {
  const uint32_t flashes = (uint32_t)random_cases(FLASHES);
  for (uint32_t n = 1; n <= flashes; ++n) {
    new_flash(PAGE_BYTES, BUS_SETTINGS_LOG_PAGES, n);
    bus_pages = flash_model_area(&model, 0);
    for (int start = 0; start < STARTS_OF_A_FLASH; ++start) {
      start_with_the_newest_settings();
      for (uint32_t saves = throw_of(3); saves > 0 && !model.off; --saves) {
        save_settings();
        if (throw_of(2) == 0) {
          (void)bus_settings_log_step(&settings); /* ahead of the next one */
        }
      }
      age();
    }
  }
  report("node id and bit rate");
}

int main(void) {
  UNITY_BEGIN();
  RUN_TEST(test_no_acknowledged_set_is_replaced_by_an_older_one_in_silence);
  RUN_TEST(test_no_acknowledged_node_id_is_replaced_by_an_older_one_in_silence);
  return UNITY_END();
}
