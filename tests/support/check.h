/* SPDX-License-Identifier: Apache-2.0 */
/* Assertions on real numbers that print the measured value, for Unity tests in C and C++.
 *
 * Unity's own float assertions depend on its configuration and print no double; these compare in double for every
 * argument type, never pass a NaN, and describe the failure in words. */
#ifndef TRACKSERVO_TESTS_SUPPORT_CHECK_H
#define TRACKSERVO_TESTS_SUPPORT_CHECK_H

#include <math.h>
#include <stdbool.h>
#include <stdio.h>

#include "unity.h"

static inline void check_verdict(bool passed, const char *what, double actual, const char *relation, double bound,
                                 double tolerance, int line) {
  if (!passed) {
    char text[240];
    (void)snprintf(text, sizeof text, "%s: measured %.9g, must be %s %.9g (band %.3g)", what, actual, relation, bound,
                   tolerance);
    UNITY_TEST_FAIL((UNITY_LINE_TYPE)line, text);
  }
}

static inline void check_note(const char *what, double value, int line) {
  char text[240];
  (void)snprintf(text, sizeof text, "%s = %.4g", what, value);
  UnityMessage(text, (UNITY_LINE_TYPE)line);
}

static inline void check_near(const char *what, double expected, double actual, double tolerance, int line) {
  check_verdict(fabs(actual - expected) <= tolerance, what, actual, "near", expected, tolerance, line);
}

/* |actual - expected| <= tolerance */
#define CHECK_NEAR(what, expected, actual, tolerance) \
  check_near(what, (double)(expected), (double)(actual), (double)(tolerance), __LINE__)

static inline void check_relative(const char *what, double expected, double actual, double fraction, int line) {
  check_near(what, expected, actual, fraction * fabs(expected), line);
}

/* |actual - expected| <= fraction * |expected| */
#define CHECK_RELATIVE(what, expected, actual, fraction) \
  check_relative(what, (double)(expected), (double)(actual), (double)(fraction), __LINE__)

static inline void check_at_most(const char *what, double bound, double actual, int line) {
  check_verdict(actual <= bound, what, actual, "at most", bound, 0.0, line);
}

#define CHECK_AT_MOST(what, bound, actual) check_at_most(what, (double)(bound), (double)(actual), __LINE__)

static inline void check_at_least(const char *what, double bound, double actual, int line) {
  check_verdict(actual >= bound, what, actual, "at least", bound, 0.0, line);
}

#define CHECK_AT_LEAST(what, bound, actual) check_at_least(what, (double)(bound), (double)(actual), __LINE__)

/* Equal to the last bit. */
#define CHECK_SAME(what, expected, actual) CHECK_NEAR(what, expected, actual, 0.0)

#define CHECK_STATUS(expected, actual) TEST_ASSERT_EQUAL_INT((int)(expected), (int)(actual))

/* A measured number for the log, without a check. */
#define LOG_VALUE(what, value) check_note(what, (double)(value), __LINE__)

#endif
