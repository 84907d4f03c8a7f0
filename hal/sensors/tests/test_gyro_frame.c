/* SPDX-License-Identifier: Apache-2.0 */
/* Gyro frames in a stream of bytes, written from the gyro's manual; and the heat sink's thermistor. */
#include "sensors/gyro_frame.h"

#include <string.h>

#include "sensors/thermistor.h"
#include "support/check.h"

void setUp(void) {}
void tearDown(void) {}

typedef struct {
  uint8_t bytes[GYRO_FRAME_BYTES];
} wire_frame;

static void put_word(uint8_t *bytes, uint32_t word) {
  for (int i = 0; i < 4; ++i) {
    bytes[i] = (uint8_t)(word >> (24 - 8 * i));
  }
}

static void put_float(uint8_t *bytes, float value) {
  uint32_t word;
  memcpy(&word, &value, sizeof word);
  put_word(bytes, word);
}

/* Bit by bit, most significant first, start FFFFFFFF: CRC-32/MPEG-2. */
static uint32_t crc_by_the_definition(const uint8_t *bytes, int count) {
  uint32_t crc = UINT32_MAX;
  for (int bit = 0; bit < 8 * count; ++bit) {
    const uint32_t in = (uint32_t)bytes[bit / 8] >> (7 - bit % 8) & 1u;
    crc = crc << 1 ^ ((crc >> 31 ^ in) != 0 ? 0x04C11DB7u : 0u);
  }
  return crc;
}

static wire_frame frame_of(float rate_rad_s, uint8_t status, uint8_t sequence) {
  wire_frame f = {{0xFE, 0x81, 0xFF, 0x55}};
  put_float(f.bytes + 4, rate_rad_s);
  for (int channel = 1; channel < 6; ++channel) {
    put_float(f.bytes + 4 + 4 * channel, (float)channel);
  }
  f.bytes[28] = status;
  f.bytes[29] = sequence;
  f.bytes[31] = 25;
  put_word(f.bytes + 32, crc_by_the_definition(f.bytes, 32));
  return f;
}

static int take_all(gyro_frame_reader *reader, const uint8_t *bytes, int count, gyro_frame *last) {
  return (int)gyro_frame_take(reader, bytes, (uint32_t)count, last);
}

static void test_crc_has_the_catalogued_check_value(void) {
  const uint8_t digits[] = {'1', '2', '3', '4', '5', '6', '7', '8', '9'};
  TEST_ASSERT_EQUAL_HEX32(0x0376E6E7u, crc_by_the_definition(digits, 9)); /* CRC-32/MPEG-2 */
  TEST_ASSERT_EQUAL_HEX32(0x0376E6E7u, gyro_frame_crc(digits, 9));
}

static void test_a_frame_gives_rate_status_sequence_and_temperature(void) {
  gyro_frame_reader reader = {.count = 0};
  gyro_frame frame;
  const wire_frame f = frame_of(-0.00174533f, 0x77, 127);
  TEST_ASSERT_EQUAL(1, take_all(&reader, f.bytes, GYRO_FRAME_BYTES, &frame));
  CHECK_SAME("rate", -0.00174533f, frame.rate_rad_s);
  TEST_ASSERT_TRUE(frame.valid);
  TEST_ASSERT_EQUAL(127, frame.sequence);
  TEST_ASSERT_EQUAL(25, frame.temperature);
}

static void test_the_gyros_own_verdict_on_channel_x_counts(void) {
  gyro_frame_reader reader = {.count = 0};
  gyro_frame frame;
  const wire_frame f = frame_of(0.1f, 0x76, 0);
  TEST_ASSERT_EQUAL(1, take_all(&reader, f.bytes, GYRO_FRAME_BYTES, &frame));
  TEST_ASSERT_FALSE(frame.valid);
}

static void test_no_single_wrong_bit_gives_a_frame(void) {
  const wire_frame good = frame_of(0.25f, 0x77, 3);
  for (int bit = 0; bit < 8 * GYRO_FRAME_BYTES; ++bit) {
    wire_frame bad = good;
    bad.bytes[bit / 8] ^= (uint8_t)(1 << (bit % 8));
    gyro_frame_reader reader = {.count = 0};
    gyro_frame frame;
    TEST_ASSERT_EQUAL(0, take_all(&reader, bad.bytes, GYRO_FRAME_BYTES, &frame));
  }
}

static void test_a_stream_that_begins_anywhere_gives_every_frame_after_the_first(void) {
  uint8_t stream[4 * GYRO_FRAME_BYTES];
  for (int i = 0; i < 4; ++i) {
    const wire_frame f = frame_of((float)i, 0x77, (uint8_t)i);
    memcpy(stream + i * GYRO_FRAME_BYTES, f.bytes, GYRO_FRAME_BYTES);
  }
  for (int start = 1; start < GYRO_FRAME_BYTES; ++start) {
    gyro_frame_reader reader = {.count = 0};
    gyro_frame frame = {.rate_rad_s = -1.0f};
    TEST_ASSERT_EQUAL(3, take_all(&reader, stream + start, (int)sizeof stream - start, &frame));
    CHECK_SAME("rate of the last", 3.0, frame.rate_rad_s);
  }
}

/* A header within the data must not hide the frame that follows. */
static void test_a_lost_byte_costs_one_frame(void) {
  for (int lost = 0; lost < GYRO_FRAME_BYTES; ++lost) {
    gyro_frame_reader reader = {.count = 0};
    gyro_frame frame;
    int frames = 0;
    for (int i = 0; i < 3; ++i) {
      const wire_frame f = frame_of(1.0f + (float)i, 0x77, (uint8_t)i);
      const int before = i == 0 ? lost : GYRO_FRAME_BYTES;
      frames += take_all(&reader, f.bytes, before, &frame);
      if (i == 0) {
        frames += take_all(&reader, f.bytes + lost + 1, GYRO_FRAME_BYTES - lost - 1, &frame);
      }
    }
    TEST_ASSERT_EQUAL(2, frames);
    CHECK_SAME("rate of the last", 3.0, frame.rate_rad_s);
  }
}

static void test_pieces_of_any_length_give_the_same_frames(void) {
  uint8_t stream[3 * GYRO_FRAME_BYTES];
  for (int i = 0; i < 3; ++i) {
    const wire_frame f = frame_of((float)i, 0x77, (uint8_t)i);
    memcpy(stream + i * GYRO_FRAME_BYTES, f.bytes, GYRO_FRAME_BYTES);
  }
  for (int piece = 1; piece <= (int)sizeof stream; ++piece) {
    gyro_frame_reader reader = {.count = 0};
    gyro_frame frame;
    int frames = 0;
    for (int at = 0; at < (int)sizeof stream; at += piece) {
      const int left = (int)sizeof stream - at;
      frames += take_all(&reader, stream + at, piece < left ? piece : left, &frame);
    }
    TEST_ASSERT_EQUAL(3, frames);
    CHECK_SAME("rate of the last", 2.0, frame.rate_rad_s);
  }
}

static void test_a_rate_that_is_no_number_is_refused(void) {
  const float bad[] = {NAN, INFINITY, -INFINITY};
  for (int i = 0; i < 3; ++i) {
    gyro_frame_reader reader = {.count = 0};
    gyro_frame frame;
    const wire_frame f = frame_of(bad[i], 0x77, 0);
    TEST_ASSERT_EQUAL(0, take_all(&reader, f.bytes, GYRO_FRAME_BYTES, &frame));
    TEST_ASSERT_EQUAL(1, reader.bad_crc);
  }
}

static void test_thermistor_is_within_half_a_kelvin_of_the_beta_equation(void) {
  const double beta_k = 3435.0;
  const double t25_k = 298.15;
  double worst_k = 0.0;
  for (int celsius = 0; celsius <= 100; ++celsius) {
    const double ratio = exp(beta_k * (1.0 / ((double)celsius + 273.15) - 1.0 / t25_k));
    const int counts = (int)lround(4096.0 * ratio / (ratio + 1.0));
    worst_k = fmax(worst_k, fabs((double)thermistor_celsius(counts) - (double)celsius));
  }
  CHECK_AT_MOST("error of the thermistor's table", 0.5, worst_k);
}

static void test_thermistor_open_reads_cold_and_shorted_hot(void) {
  CHECK_SAME("open", -20.0, thermistor_celsius(4095));
  CHECK_SAME("shorted", 120.0, thermistor_celsius(0));
}

int main(void) {
  UNITY_BEGIN();
  RUN_TEST(test_crc_has_the_catalogued_check_value);
  RUN_TEST(test_a_frame_gives_rate_status_sequence_and_temperature);
  RUN_TEST(test_the_gyros_own_verdict_on_channel_x_counts);
  RUN_TEST(test_no_single_wrong_bit_gives_a_frame);
  RUN_TEST(test_a_stream_that_begins_anywhere_gives_every_frame_after_the_first);
  RUN_TEST(test_a_lost_byte_costs_one_frame);
  RUN_TEST(test_pieces_of_any_length_give_the_same_frames);
  RUN_TEST(test_a_rate_that_is_no_number_is_refused);
  RUN_TEST(test_thermistor_is_within_half_a_kelvin_of_the_beta_equation);
  RUN_TEST(test_thermistor_open_reads_cold_and_shorted_hot);
  return UNITY_END();
}
