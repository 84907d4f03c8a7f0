/* SPDX-License-Identifier: Apache-2.0 */
/* Two areas of flash in memory behind hal_flash.h, whose power can be cut at any operation.
 *
 * Like the hardware: erased is FF, a double word is programmed once after an erase, and the remains of an interrupted
 * operation are one of flash_cut. A double word can be weak: at a start it reads right, as its other value, or as two
 * wrong bits that the ECC detects (unreadable). docs/decisions/parameter-store.md has the fault model. */
#ifndef TRACKSERVO_TESTS_SUPPORT_FLASH_MODEL_H
#define TRACKSERVO_TESTS_SUPPORT_FLASH_MODEL_H

#include <string.h>

#include "hal_flash.h"
#include "support/random.h"

enum { FLASH_MODEL_MAX_BYTES = 16384 };

/* State after the operation at which the power fails. */
typedef enum {
  CUT_CLEAN,  /* nothing was done */
  CUT_TORN,   /* about half of the bits have their new value, the others the old one */
  CUT_FLIPPED /* everything was done, but one bit is wrong */
} flash_cut;

enum { FLASH_CUTS = 3, FLASH_MODEL_MAX_UNITS = FLASH_MODEL_MAX_BYTES / HAL_FLASH_UNIT_BYTES };

/* How a double word reads. */
typedef enum { SHOWS_RIGHT, SHOWS_OTHER, SHOWS_UNREADABLE } flash_show;

enum { FLASH_SHOWS = 3 };

typedef struct {
  bool changes_at_starts; /* which one it is, is drawn at each start */
  bool changes_at_reads;  /* ... at each read */
  flash_show shows;
  uint8_t other[HAL_FLASH_UNIT_BYTES];
} flash_weakness;

typedef struct {
  uint8_t bytes[FLASH_MODEL_MAX_BYTES]; /* area 0, then area 1 */
  uint32_t page_bytes;
  uint32_t pages;          /* of an area */
  int64_t operations_left; /* until the power fails in the next one; negative: never */
  flash_cut cut;
  random_source random;
  bool off;
  uint32_t operations;  /* programmed or erased so far */
  uint32_t rule_breaks; /* programmed an address that was not erased, or is out of range */
  uint32_t erases[8];   /* of each page, area 0 first */
  bool cuts_leave_weak; /* what an interrupted operation leaves may change from start to start */
  uint32_t refusals;    /* of 1,000 operations: done in part, and reported as failed, while the power stays on */
  flash_weakness weak[FLASH_MODEL_MAX_UNITS];
} flash_model;

static inline uint32_t flash_model_bytes(const flash_model *model) { return 2 * model->page_bytes * model->pages; }

static inline uint8_t *flash_model_at(const hal_flash *flash, uint32_t offset) {
  flash_model *model = (flash_model *)flash->context;
  return model->bytes + flash->area * model->page_bytes * model->pages + offset;
}

/* Half of the time as it should be. */
static inline flash_show flash_model_draw(flash_model *model) {
  const uint64_t bits = random_bits(&model->random);
  return (bits & 1) != 0 ? SHOWS_RIGHT : (bits & 2) != 0 ? SHOWS_OTHER : SHOWS_UNREADABLE;
}

/* The power is on again. */
static inline void flash_model_start(flash_model *model) {
  model->off = false;
  model->operations_left = -1;
  for (uint32_t unit = 0; unit < flash_model_bytes(model) / HAL_FLASH_UNIT_BYTES; ++unit) {
    if (model->weak[unit].changes_at_starts) {
      model->weak[unit].shows = flash_model_draw(model);
    }
  }
}

static inline uint32_t flash_model_unit(const flash_model *model, const uint8_t *place) {
  return (uint32_t)(place - model->bytes) / HAL_FLASH_UNIT_BYTES;
}

static inline bool flash_model_read(const hal_flash *flash, uint32_t offset, void *bytes, uint32_t count) {
  flash_model *model = (flash_model *)flash->context;
  const uint32_t area = model->page_bytes * model->pages;
  if (offset > area || count > area - offset) {
    model->rule_breaks++;
    return false;
  }
  const uint8_t *place = flash_model_at(flash, offset);
  flash_weakness *weak = &model->weak[flash_model_unit(model, place)];
  if (weak->changes_at_reads) {
    weak->shows = flash_model_draw(model);
  }
  memcpy(bytes, weak->shows == SHOWS_OTHER ? weak->other : place, count); /* readers read double words */
  return weak->shows != SHOWS_UNREADABLE;
}

/* True: the power fails now. */
static inline bool flash_model_fails(flash_model *model) {
  if (model->operations_left > 0) {
    model->operations_left--;
  } else if (model->operations_left == 0) {
    model->off = true;
  }
  model->operations++;
  return model->off;
}

static inline void flash_model_leave(flash_model *model, uint8_t *place, const uint8_t *wanted, uint32_t count) {
  if (model->cut == CUT_TORN) {
    for (uint32_t i = 0; i < count; ++i) {
      const uint8_t done = (uint8_t)random_bits(&model->random);
      place[i] = (uint8_t)((place[i] & ~done) | (wanted[i] & done));
    }
  } else if (model->cut == CUT_FLIPPED) {
    const uint32_t bit = (uint32_t)(random_bits(&model->random) % (8 * count));
    memcpy(place, wanted, count);
    place[bit / 8] = (uint8_t)(place[bit / 8] ^ 1u << bit % 8);
  }
}

/* The double words at `place`, of which each had `before` and was to have `wanted`, from now on read as they are. After
 * an interrupted operation, each second one may read as one of these too. */
static inline void flash_model_settle(flash_model *model, const uint8_t *place, const uint8_t *before,
                                      const uint8_t *wanted, uint32_t count, bool interrupted) {
  for (uint32_t at = 0; at < count; at += HAL_FLASH_UNIT_BYTES) {
    flash_weakness *weak = &model->weak[flash_model_unit(model, place + at)];
    memset(weak, 0, sizeof *weak);
    if (interrupted && model->cuts_leave_weak) {
      const uint64_t bits = random_bits(&model->random);
      weak->changes_at_starts = (bits & 1) != 0;
      memcpy(weak->other, (bits & 2) != 0 ? before + at : wanted + at, HAL_FLASH_UNIT_BYTES);
    }
  }
}

/* Returns false when the operation was interrupted. */
static inline bool flash_model_change(flash_model *model, uint8_t *place, const uint8_t *wanted, uint32_t count) {
  static uint8_t before[FLASH_MODEL_MAX_BYTES];
  if (model->off) {
    return false;
  }
  memcpy(before, place, count);
  const bool interrupted =
      flash_model_fails(model) || (model->refusals > 0 && random_bits(&model->random) % 1000 < model->refusals);
  if (interrupted) {
    flash_model_leave(model, place, wanted, count);
  } else {
    memcpy(place, wanted, count);
  }
  flash_model_settle(model, place, before, wanted, count, interrupted);
  return !interrupted;
}

static inline bool flash_model_program(const hal_flash *flash, uint32_t offset, const uint32_t double_word[2]) {
  flash_model *model = (flash_model *)flash->context;
  if (offset % HAL_FLASH_UNIT_BYTES != 0 ||
      offset > model->page_bytes * model->pages - (uint32_t)HAL_FLASH_UNIT_BYTES) {
    model->rule_breaks++;
    return false;
  }
  uint8_t *place = flash_model_at(flash, offset);
  for (int i = 0; i < HAL_FLASH_UNIT_BYTES; ++i) {
    model->rule_breaks += place[i] != 0xFF && !model->off ? 1 : 0;
  }
  return flash_model_change(model, place, (const uint8_t *)double_word, HAL_FLASH_UNIT_BYTES);
}

static inline bool flash_model_erase(const hal_flash *flash, uint32_t page) {
  static uint8_t blank[FLASH_MODEL_MAX_BYTES];
  flash_model *model = (flash_model *)flash->context;
  if (page >= model->pages) {
    model->rule_breaks++;
    return false;
  }
  memset(blank, 0xFF, model->page_bytes);
  model->erases[flash->area * model->pages + page]++;
  return flash_model_change(model, flash_model_at(flash, page * model->page_bytes), blank, model->page_bytes);
}

/* From now on the double word `unit` of all can read with these bits wrong, or not at all. */
static inline void flash_model_weaken(flash_model *model, uint32_t unit, uint64_t wrong_bits) {
  flash_weakness *weak = &model->weak[unit];
  memcpy(weak->other, model->bytes + (size_t)unit * HAL_FLASH_UNIT_BYTES, HAL_FLASH_UNIT_BYTES);
  for (uint32_t bit = 0; bit < 8 * HAL_FLASH_UNIT_BYTES; ++bit) {
    weak->other[bit / 8] = (uint8_t)(weak->other[bit / 8] ^ (wrong_bits >> bit & 1u) << bit % 8);
  }
  weak->changes_at_starts = true;
}

/* Everything is erased, the power is on. */
static inline void flash_model_init(flash_model *model, uint32_t page_bytes, uint32_t pages) {
  memset(model, 0, sizeof *model);
  memset(model->bytes, 0xFF, sizeof model->bytes);
  model->page_bytes = page_bytes;
  model->pages = pages;
  model->operations_left = -1;
}

static inline hal_flash flash_model_area(flash_model *model, uint32_t area) {
  hal_flash flash = {.read = flash_model_read, .program = flash_model_program, .erase = flash_model_erase};
  flash.context = model;
  flash.area = area;
  flash.page_bytes = model->page_bytes;
  flash.pages = model->pages;
  return flash;
}

#endif
