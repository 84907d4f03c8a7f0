/* SPDX-License-Identifier: Apache-2.0 */
/* CRC-32 of IEEE 802.3 (polynomial 04C11DB7 reflected), the one of zlib and Ethernet; bit by bit, without a table. */
#ifndef TRACKSERVO_BASE_CRC32_H
#define TRACKSERVO_BASE_CRC32_H

#include <stdint.h>

#define CRC32_START UINT32_MAX

/* Adds bytes to a running sum that began with CRC32_START. */
uint32_t crc32_add(uint32_t crc, const uint8_t *bytes, uint32_t count);

static inline uint32_t crc32_end(uint32_t crc) { return ~crc; }

#endif
