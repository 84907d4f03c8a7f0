/* SPDX-License-Identifier: Apache-2.0 */
/* How much a test tries: the environment variable TESTS_SIZE. The assertions are the same in each size. */
#ifndef TRACKSERVO_TESTS_SUPPORT_TEST_SIZE_H
#define TRACKSERVO_TESTS_SUPPORT_TEST_SIZE_H

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#if defined(__ARM_ARCH_PROFILE) && __ARM_ARCH_PROFILE == 'M'
#define TEST_SIZE_ON_TARGET 1 /* computes double in software */
#else
#define TEST_SIZE_ON_TARGET 0
#endif

typedef enum {
  TEST_SMALL,  /* "small": the gate, coverage and the emulated Cortex-M */
  TEST_MEDIUM, /* "medium", and without TESTS_SIZE: the full run */
  TEST_LARGE   /* "large": takes minutes to hours; on demand */
} test_size;

/* Returns the size that TESTS_SIZE names. Ends the program with code 2 if it names none. */
static inline test_size test_size_wanted(void) {
  const char *name = getenv("TESTS_SIZE");
  if (TEST_SIZE_ON_TARGET || (name != NULL && strcmp(name, "small") == 0)) {
    return TEST_SMALL;
  }
  if (name == NULL || strcmp(name, "medium") == 0) {
    return TEST_MEDIUM;
  }
  if (strcmp(name, "large") != 0) {
    fprintf(stderr, "TESTS_SIZE is '%s': expected small, medium or large.\n", name);
    exit(2);
  }
  return TEST_LARGE;
}

/* Returns the argument of the wanted size. */
static inline int by_size(int small, int medium, int large) {
  const test_size wanted = test_size_wanted();
  return wanted == TEST_SMALL ? small : wanted == TEST_MEDIUM ? medium : large;
}

#endif
