/* SPDX-License-Identifier: Apache-2.0 */
#include "parameter_flash.h"

#include <string.h>

#include "clock.h"
#include "registers/flash.h"

/* From the linker script: the same memory, for reading and for writing. */
extern const uint8_t parameter_pages_start[];
extern volatile uint32_t parameter_pages_words[];

/* RM0440: bank 2 begins at 0x08040000; the pieces are pages 118 .. 127 of its 128, as PNB counts. */
enum { PAGE_BYTES = 2048, FIRST_PAGE_OF_BANK_2 = 118 };

/* By parameter_piece, counted from the first of these pages. */
static const struct {
  uint8_t first_page;
  uint8_t pages;
} pieces[PARAMETER_PIECES] = {
    [PARAMETER_AREA_0] = {2, 4},
    [PARAMETER_AREA_1] = {6, 4},
    [BUS_SETTINGS_PIECE] = {0, 2},
};

enum { MAX_WAIT_US = 100000 };

static const uint32_t errors = FLASH_SR_OPERR | FLASH_SR_PROGERR | FLASH_SR_WRPERR | FLASH_SR_PGAERR | FLASH_SR_SIZERR |
                               FLASH_SR_PGSERR | FLASH_SR_MISERR | FLASH_SR_FASTERR;

static bool wait_until_idle(const hal_flash *flash) {
  const uint32_t start = clock_cycles();
  /* Bound: MAX_WAIT_US, by the if in it. */
  while ((FLASH->sr & FLASH_SR_BSY) != 0) {
    if (clock_cycles() - start > MAX_WAIT_US * CLOCK_CYCLES_PER_US) {
      return false;
    }
    flash->waiting(flash->context);
  }
  return true;
}

bool parameter_flash_has_its_banks(void) {
  return (FLASH->optr & (FLASH_OPTR_DBANK | FLASH_OPTR_BFB2)) == FLASH_OPTR_DBANK;
}

static bool unlock(const hal_flash *flash) {
  if (!parameter_flash_has_its_banks() || !wait_until_idle(flash)) {
    return false;
  }
  if ((FLASH->cr & FLASH_CR_LOCK) != 0) {
    FLASH->keyr = FLASH_KEY_1;
    FLASH->keyr = FLASH_KEY_2;
  }
  FLASH->sr = errors | FLASH_SR_EOP; /* cleared by writing ones */
  return (FLASH->cr & FLASH_CR_LOCK) == 0;
}

/* Waits, and leaves the controller locked. */
static bool finish(const hal_flash *flash) {
  const bool idle = wait_until_idle(flash);
  const bool good = (FLASH->sr & errors) == 0;
  FLASH->cr = FLASH_CR_LOCK;
  return idle && good;
}

static volatile bool unreadable; /* since the last read began */

bool parameter_flash_take_nmi(void) {
  const uint32_t both = FLASH_ECCR_ECCD | FLASH_ECCR_BK_ECC;
  if ((FLASH->eccr & both) != both) {
    return false;
  }
  FLASH->eccr = FLASH_ECCR_ECCC | FLASH_ECCR_ECCD; /* cleared by writing ones */
  unreadable = true;
  return true;
}

static uint32_t bytes_of(const hal_flash *flash) { return flash->pages * flash->page_bytes; }

static uint32_t offset_of(const hal_flash *flash, uint32_t offset) {
  return (uint32_t)pieces[flash->area].first_page * PAGE_BYTES + offset;
}

static const uint8_t *at(const hal_flash *flash, uint32_t offset) {
  return parameter_pages_start + offset_of(flash, offset);
}

/* The data cache may still hold other contents than the flash. */
static void forget_cached_data(void) {
  FLASH->acr &= ~FLASH_ACR_DCEN;
  FLASH->acr |= FLASH_ACR_DCRST;
  FLASH->acr &= ~FLASH_ACR_DCRST;
  FLASH->acr |= FLASH_ACR_DCEN;
}

/* The bank of an error is recorded only while neither flag is set: one from a corrected bit of the program would make
 * two wrong bits here look like two in the program. What could not be read must not be found in the cache. */
static bool read_bytes(const hal_flash *flash, uint32_t offset, void *bytes, uint32_t count) {
  if (offset > bytes_of(flash) || count > bytes_of(flash) - offset) {
    return false;
  }
  FLASH->eccr = FLASH_ECCR_ECCC;
  unreadable = false;
  memcpy(bytes, at(flash, offset), count);
  if (unreadable) {
    forget_cached_data();
  }
  return !unreadable;
}

/* Both halves in order, without any other access between (RM0440). */
static bool program(const hal_flash *flash, uint32_t offset, const uint32_t double_word[2]) {
  if (offset % HAL_FLASH_UNIT_BYTES != 0 || offset > bytes_of(flash) - HAL_FLASH_UNIT_BYTES || !unlock(flash)) {
    return false;
  }
  volatile uint32_t *target = parameter_pages_words + offset_of(flash, offset) / sizeof(uint32_t);
  FLASH->cr = FLASH_CR_PG;
  target[0] = double_word[0];
  target[1] = double_word[1];
  const bool programmed = finish(flash);
  uint32_t written[2];
  forget_cached_data();
  return programmed && read_bytes(flash, offset, written, sizeof written) &&
         memcmp(written, double_word, sizeof written) == 0;
}

static bool erase(const hal_flash *flash, uint32_t page) {
  if (page >= flash->pages || !unlock(flash)) {
    return false;
  }
  const uint32_t number = FIRST_PAGE_OF_BANK_2 + pieces[flash->area].first_page + page;
  FLASH->cr = FLASH_CR_PER | FLASH_CR_BKER | FIELD_VALUE(FLASH_CR_PNB, number);
  FLASH->cr |= FLASH_CR_STRT;
  const bool good = finish(flash);
  forget_cached_data();
  return good;
}

hal_flash parameter_flash(parameter_piece piece, void (*waiting)(void *context), void *context) {
  return (hal_flash){.read = read_bytes,
                     .program = program,
                     .erase = erase,
                     .waiting = waiting,
                     .context = context,
                     .area = (uint32_t)piece,
                     .page_bytes = PAGE_BYTES,
                     .pages = pieces[piece].pages};
}
