#include "sensors/gyro_frame.h"

#include <math.h>
#include <string.h>

enum { HEADER_BYTES = 4, RATE_X = 4, STATUS = 28, SEQUENCE = 29, TEMPERATURE = 30, CRC = 32 };

static const uint8_t header[HEADER_BYTES] = {0xFE, 0x81, 0xFF, 0x55};

static uint32_t word_at(const uint8_t *bytes) {
  return (uint32_t)bytes[0] << 24 | (uint32_t)bytes[1] << 16 | (uint32_t)bytes[2] << 8 | bytes[3];
}

/* By nibbles: entry n is n x^32 modulo the polynomial. */
uint32_t gyro_frame_crc(const uint8_t *bytes, uint32_t count) {
  static const uint32_t remainder_of[16] = {
      0x00000000u, 0x04C11DB7u, 0x09823B6Eu, 0x0D4326D9u, 0x130476DCu, 0x17C56B6Bu, 0x1A864DB2u, 0x1E475005u,
      0x2608EDB8u, 0x22C9F00Fu, 0x2F8AD6D6u, 0x2B4BCB61u, 0x350C9B64u, 0x31CD86D3u, 0x3C8EA00Au, 0x384FBDBDu};
  uint32_t crc = UINT32_MAX;
  for (uint32_t i = 0; i < count; ++i) {
    crc ^= (uint32_t)bytes[i] << 24;
    crc = crc << 4 ^ remainder_of[crc >> 28];
    crc = crc << 4 ^ remainder_of[crc >> 28];
  }
  return crc;
}

static bool read_frame(const uint8_t *bytes, gyro_frame *frame) {
  if (gyro_frame_crc(bytes, CRC) != word_at(bytes + CRC)) {
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

/* The longest end of what is there that could begin a header; no end of the header but itself begins it anew, so a byte
 * that does not fit counts only if it is the first. */
static void search_header(gyro_frame_reader *reader, uint8_t byte) {
  if (byte != header[reader->count]) {
    reader->count = 0;
  }
  if (byte == header[reader->count]) {
    reader->bytes[reader->count++] = byte;
  }
}

/* What is behind the header of a frame that was none may hold the beginning of a true one. */
static void search_again(gyro_frame_reader *reader) {
  reader->count = 0;
  for (uint32_t i = 1; i < GYRO_FRAME_BYTES; ++i) {
    const uint8_t byte = reader->bytes[i];
    if (reader->count < HEADER_BYTES) {
      search_header(reader, byte);
    } else {
      reader->bytes[reader->count++] = byte;
    }
  }
}

bool gyro_frame_take(gyro_frame_reader *reader, uint8_t byte, gyro_frame *frame) {
  if (reader->count < HEADER_BYTES) {
    search_header(reader, byte);
    return false;
  }
  reader->bytes[reader->count++] = byte;
  if (reader->count < GYRO_FRAME_BYTES) {
    return false;
  }
  if (read_frame(reader->bytes, frame)) {
    reader->count = 0;
    return true;
  }
  reader->bad_crc++;
  search_again(reader);
  return false;
}
