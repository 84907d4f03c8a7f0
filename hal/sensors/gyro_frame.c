/* SPDX-License-Identifier: Apache-2.0 */
#include "sensors/gyro_frame.h"

#include <math.h>
#include <string.h>

enum { HEADER_BYTES = 4, RATE_X = 4, STATUS = 28, SEQUENCE = 29, TEMPERATURE = 30 };

static const uint8_t header[HEADER_BYTES] = {0xFE, 0x81, 0xFF, 0x55};
static const uint32_t crc_of_header = 0x586AEC15u;

static uint32_t word_at(const uint8_t *bytes) {
  return (uint32_t)bytes[0] << 24 | (uint32_t)bytes[1] << 16 | (uint32_t)bytes[2] << 8 | bytes[3];
}

/* Entry n is n x^32 modulo the polynomial: the sum of the contributions of its bits. */
#define BIT(n, bit, remainder) (((n) >> (bit)&1u) != 0 ? (remainder) : 0u)
#define ENTRY(n)                                                                                       \
  (BIT(n, 0, 0x04C11DB7u) ^ BIT(n, 1, 0x09823B6Eu) ^ BIT(n, 2, 0x130476DCu) ^ BIT(n, 3, 0x2608EDB8u) ^ \
   BIT(n, 4, 0x4C11DB70u) ^ BIT(n, 5, 0x9823B6E0u) ^ BIT(n, 6, 0x34867077u) ^ BIT(n, 7, 0x690CE0EEu))
#define ENTRIES_4(n) ENTRY(n), ENTRY((n) + 1u), ENTRY((n) + 2u), ENTRY((n) + 3u)
#define ENTRIES_16(n) ENTRIES_4(n), ENTRIES_4((n) + 4u), ENTRIES_4((n) + 8u), ENTRIES_4((n) + 12u)
#define ENTRIES_64(n) ENTRIES_16(n), ENTRIES_16((n) + 16u), ENTRIES_16((n) + 32u), ENTRIES_16((n) + 48u)

static const uint32_t remainder_of[256] = {ENTRIES_64(0u), ENTRIES_64(64u), ENTRIES_64(128u), ENTRIES_64(192u)};

static uint32_t crc_with(uint32_t crc, uint8_t byte) { return crc << 8 ^ remainder_of[crc >> 24 ^ byte]; }

uint32_t gyro_frame_crc(const uint8_t *bytes, uint32_t count) {
  uint32_t crc = UINT32_MAX;
  /* Bound: bytes of a frame, GYRO_FRAME_BYTES. */
  for (uint32_t i = 0; i < count; ++i) {
    crc = crc_with(crc, bytes[i]);
  }
  return crc;
}

/* With the CRC sent after it, not inverted, the CRC of a whole frame is 0. */
static bool read_frame(const uint8_t *bytes, uint32_t crc, gyro_frame *frame) {
  if (crc != 0) {
    return false;
  }
  const uint32_t rate = word_at(bytes + RATE_X);
  gyro_frame read = {.valid = (bytes[STATUS] & 1u) != 0,
                     .sequence = bytes[SEQUENCE] % GYRO_FRAME_SEQUENCES,
                     .temperature = (int16_t)(bytes[TEMPERATURE] << 8 | bytes[TEMPERATURE + 1])};
  memcpy(&read.rate_rad_s, &rate, sizeof rate);
  if (!isfinite(read.rate_rad_s)) {
    return false;
  }
  *frame = read;
  return true;
}

/* The longest suffix of the received bytes that can begin a header. No proper suffix of the header begins it again, so
 * after a mismatch only a match of the first header byte counts. */
static void search_header(gyro_frame_reader *reader, uint8_t byte) {
  if (byte != header[reader->count]) {
    reader->count = 0;
  }
  if (byte == header[reader->count]) {
    reader->bytes[reader->count++] = byte;
    reader->crc = crc_of_header;
  }
}

/* After the header of an invalid frame, the bytes may contain the start of a valid one. */
static void search_again(gyro_frame_reader *reader) {
  reader->count = 0;
  for (uint32_t i = 1; i < GYRO_FRAME_BYTES; ++i) {
    const uint8_t byte = reader->bytes[i];
    if (reader->count < HEADER_BYTES) {
      search_header(reader, byte);
    } else {
      reader->bytes[reader->count++] = byte;
      reader->crc = crc_with(reader->crc, byte);
    }
  }
}

static uint32_t end_frame(gyro_frame_reader *reader, gyro_frame *frame) {
  if (read_frame(reader->bytes, reader->crc, frame)) {
    reader->count = 0;
    return 1;
  }
  reader->bad_crc++;
  search_again(reader);
  return 0;
}

static void append(gyro_frame_reader *reader, const volatile uint8_t *from, uint32_t count) {
  uint8_t *to = reader->bytes + reader->count;
  uint32_t crc = reader->crc;
  /* Bound: bytes of a frame, GYRO_FRAME_BYTES. */
  for (uint32_t i = 0; i < count; ++i) {
    const uint8_t byte = from[i];
    to[i] = byte;
    crc = crc_with(crc, byte);
  }
  reader->crc = crc;
  reader->count += count;
}

uint32_t gyro_frame_take(gyro_frame_reader *reader, const volatile uint8_t *bytes, uint32_t count, gyro_frame *frame) {
  uint32_t frames = 0;
  uint32_t taken = 0;
  /* Bound: bytes in the DMA's ring: each round takes at least one. */
  while (taken < count) {
    if (reader->count < HEADER_BYTES) {
      search_header(reader, bytes[taken++]);
      continue;
    }
    const uint32_t missing = GYRO_FRAME_BYTES - reader->count;
    const uint32_t there = count - taken < missing ? count - taken : missing;
    append(reader, bytes + taken, there);
    taken += there;
    if (there == missing) {
      frames += end_frame(reader, frame);
    }
  }
  return frames;
}
