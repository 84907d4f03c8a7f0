/* What object 0x1009 names: the product, and the board that its image is for. */
#ifndef TRACKSERVO_PRODUCTS_BRUSHED_TRACKER_HARDWARE_VERSION_H
#define TRACKSERVO_PRODUCTS_BRUSHED_TRACKER_HARDWARE_VERSION_H

#define HARDWARE_VERSION "brushed_tracker, stm32g474"

#endif
