/* SPDX-License-Identifier: Apache-2.0 */
/* From reset to main() on QEMU's mps2-an386, and from main() to QEMU's exit code.
 *
 * Files, streams and the exit code go through ARM semihosting, as newlib's librdimon implements it; the words of the
 * command line (`-semihosting-config arg=...`) become argv. An unexpected exception ends the program with a message and
 * exit code 70, so that a test that crashes fails at once. */
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { EXCEPTIONS = 14, EXIT_EXCEPTION = 70, MAX_WORDS = 16 };

/* Coprocessor access control register (ARMv7-M B3.2.20): full access to CP10 and CP11, the FPU. */
#define CPACR ((volatile uint32_t *)0xE000ED88u)
#define CPACR_FPU (0xFu << 20)

/* Semihosting operations, "Semihosting for AArch32 and AArch64", chapter 6. */
enum { SEMIHOSTING_WRITE0 = 0x04, SEMIHOSTING_GET_COMMAND_LINE = 0x15, SEMIHOSTING_EXIT_EXTENDED = 0x20 };
enum { STOPPED_BY_APPLICATION = 0x20026 };

extern uint32_t bss_start[], bss_end[], stack_top[]; /* mps2_an386.ld */

extern int main(int argc, char **argv);
extern void initialise_monitor_handles(void); /* librdimon: opens stdin, stdout and stderr */

void start_up(void);

static int semihosting(int operation, const void *argument) {
  register int r0 __asm__("r0") = operation;
  register const void *r1 __asm__("r1") = argument;
  __asm__ volatile("bkpt 0xAB" : "+r"(r0) : "r"(r1) : "memory");
  return r0;
}

static void unexpected(void) {
  uint32_t number;
  __asm__ volatile("mrs %0, ipsr" : "=r"(number));
  char text[] = "start_up: unexpected exception 00\n";
  text[sizeof text - 4] = (char)('0' + number / 10 % 10);
  text[sizeof text - 3] = (char)('0' + number % 10);
  (void)semihosting(SEMIHOSTING_WRITE0, text);
  const uint32_t reason[] = {STOPPED_BY_APPLICATION, EXIT_EXCEPTION};
  (void)semihosting(SEMIHOSTING_EXIT_EXTENDED, reason);
}

typedef struct {
  const uint32_t *stack;
  void (*reset)(void);
  void (*exceptions[EXCEPTIONS])(void); /* numbers 2 to 15: the faults and the system's own */
} vectors;

__attribute__((section(".vectors"), used)) const vectors vector_table = {
    .stack = stack_top,
    .reset = start_up,
    .exceptions = {unexpected, unexpected, unexpected, unexpected, unexpected, unexpected, unexpected, unexpected,
                   unexpected, unexpected, unexpected, unexpected, unexpected, unexpected},
};

/* Splits the command line at its blanks. */
static int read_arguments(char **argv) {
  static char line[512];
  const uintptr_t block[] = {(uintptr_t)line, sizeof line};
  int argc = 0;
  if (semihosting(SEMIHOSTING_GET_COMMAND_LINE, block) == 0) {
    for (char *word = strtok(line, " "); word != NULL && argc < MAX_WORDS; word = strtok(NULL, " ")) {
      argv[argc++] = word;
    }
  }
  argv[argc] = NULL;
  return argc;
}

void start_up(void) {
  *CPACR |= CPACR_FPU;
  __asm__ volatile("dsb\n isb");
  memset(bss_start, 0, (uintptr_t)bss_end - (uintptr_t)bss_start);
  initialise_monitor_handles();
  static char *argv[MAX_WORDS + 1];
  exit(main(read_arguments(argv), argv));
}
