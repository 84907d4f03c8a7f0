/* SPDX-License-Identifier: Apache-2.0 */
/* Temperature from a 10 kOhm NTC (B25/85 = 3435 K) to ground with 10 kOhm to the ADC's reference, 12 bit.
 *
 *     counts = 4096 R / (R + R25),  R = R25 exp(B (1 / T - 1 / T25))
 *
 * The source is the Beta equation, as a table with linear interpolation. Its error is below 0.5 K from 0 to 100 degree
 * Celsius (a test compares). */
#ifndef TRACKSERVO_SENSORS_THERMISTOR_H
#define TRACKSERVO_SENSORS_THERMISTOR_H

/* Returns the temperature of counts 0 .. 4095; beyond the table (-20 .. 120 degree Celsius) its last value. An open
 * sensor reads cold, a shorted one hot. */
float thermistor_celsius(int counts);

#endif
