/* What the bus and the fault log are still to be told of the faults of an axis.
 *
 * An axis falls into one fault, which it keeps until it is reset; others may come meanwhile, of their own or out of the
 * first. Each is told once until the reset, however often it comes and goes in this time: a loose contact must not
 * flush the log. One a tick, the worst first, so that a tick costs what it costs. */
#ifndef TRACKSERVO_NODE_FAULT_NEWS_H
#define TRACKSERVO_NODE_FAULT_NEWS_H

#include "protection/fault_table.h"

typedef struct {
  fault_set told;    /* since the axis fell into its fault */
  fault_set waiting; /* found, and still to be told */
  fault_set active;  /* told, and not over */
} fault_news;

typedef struct {
  fault_id over; /* no active fault has its code any more: "no error" is to be sent; FAULT_NONE: nothing is */
  fault_id told; /* to be told now, after `over`, and logged; FAULT_NONE: nothing is */
} fault_news_item;

/* Every tick: `latched` is the fault that the axis is in, or FAULT_NONE, `found` all that can be seen in this tick. */
fault_news_item fault_news_step(fault_news *news, fault_id latched, fault_set found);

#endif
