/* SPDX-License-Identifier: Apache-2.0 */
/* Finds frames of a fibre-optic gyro of the KVH 1750 / 1760 series, format A, in a stream of bytes.
 *
 *     FE 81 FF 55 | rate x, y, z, acceleration x, y, z: float32 | status | sequence | temperature: int16 | CRC-32
 *
 * Source: KVH 54-0857 "1750 IMU Technical Manual", section 4 (message format A). All big endian. Status bits 0 .. 2:
 * the rates x, y, z are valid. Sequence counts 0 .. 127. CRC: polynomial 04C11DB7, start FFFFFFFF, not reflected, not
 * inverted, over everything before it. Set the gyro to rates in rad/s (=RFMT,RATE; =ROTUNITS,RAD), 1000 per second
 * (=DR,1000); the rate of the axis is the channel x. */
#ifndef TRACKSERVO_SENSORS_GYRO_FRAME_H
#define TRACKSERVO_SENSORS_GYRO_FRAME_H

#include <stdbool.h>
#include <stdint.h>

enum { GYRO_FRAME_BYTES = 36, GYRO_FRAME_SEQUENCES = 128 };

typedef struct {
  float rate_rad_s;    /* channel x; finite */
  bool valid;          /* the gyro's own validity flag of channel x */
  uint8_t sequence;    /* 0 .. 127 */
  int16_t temperature; /* in the unit set in the gyro, degree Celsius by default */
} gyro_frame;

typedef struct {
  uint8_t bytes[GYRO_FRAME_BYTES];
  uint32_t count;   /* bytes of a started frame */
  uint32_t crc;     /* of these */
  uint32_t bad_crc; /* refused frames so far, including those with a rate that is not finite */
} gyro_frame_reader;

/* Takes received bytes in pieces of any length. Returns how many good frames ended in them; the last one is in `frame`.
 * After a bad frame the search restarts after its header. Takes about 10 instructions per byte. The CRC is updated with
 * each byte, so the last byte of a frame costs little more than the others. */
uint32_t gyro_frame_take(gyro_frame_reader *reader, const volatile uint8_t *bytes, uint32_t count, gyro_frame *frame);

uint32_t gyro_frame_crc(const uint8_t *bytes, uint32_t count);

#endif
