#include "node/fault_news.h"

#include <stdbool.h>

static bool has_code(fault_set set, uint16_t code) {
  bool found = false;
  for (int i = 1; i < FAULT_COUNT; ++i) {
    found = found || ((set >> i & 1u) != 0 && fault_table[i].code == code);
  }
  return found;
}

/* An error on the bus is one source and one code: it ends when no fault with this code is left. */
static fault_id end_one(fault_news *news, fault_set present) {
  const fault_id gone = fault_worst(news->active & ~present);
  if (gone == FAULT_NONE) {
    return FAULT_NONE;
  }
  news->active &= ~fault_bit(gone);
  return has_code(news->active, fault_table[gone].code) ? FAULT_NONE : gone;
}

/* The fault that the axis is in comes before those detected with it. */
static fault_id tell_one(fault_news *news, fault_id latched) {
  const bool first = (news->waiting & fault_bit(latched)) != 0;
  const fault_id next = first ? latched : fault_worst(news->waiting);
  if (next == FAULT_NONE) {
    return FAULT_NONE;
  }
  news->waiting &= ~fault_bit(next);
  news->told |= fault_bit(next);
  news->active |= fault_bit(next);
  return next;
}

fault_news_item fault_news_step(fault_news *news, fault_id latched, fault_set found) {
  fault_set present = 0;
  if (latched == FAULT_NONE) {
    news->told = 0;
    news->waiting = 0;
  } else {
    present = found | fault_bit(latched);
    news->waiting |= present & ~news->told;
  }
  fault_news_item item;
  item.over = end_one(news, present);
  item.told = tell_one(news, latched);
  return item;
}
