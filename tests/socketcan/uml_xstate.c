/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Lets User Mode Linux run on processors whose extended registers (XSAVE) are larger than it knows.
 *
 * linux.uml of Debian 12 keeps 2,696 bytes of them for each of its processes. The host's kernel takes them back only in
 * the size that the processor has: with Intel AMX, 11,008 bytes. ptrace() then fails with EFAULT, and User Mode Linux
 * ends at its first process. Loaded by LD_PRELOAD, this ptrace() repeats such a call with the bytes that are missing,
 * as the process has them. Programs in User Mode Linux cannot use these registers; all else is as without it.
 */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <elf.h>
#include <errno.h>
#include <stdarg.h>
#include <string.h>
#include <sys/ptrace.h>
#include <sys/types.h>
#include <sys/uio.h>

typedef long ptrace_function(enum __ptrace_request, ...);

/* Not on the stack: it is a kernel stack of User Mode Linux, of 16 KiB. One thread calls ptrace(). */
static char all[65536];
static ptrace_function *next;

__attribute__((constructor)) static void find_next(void) { *(void **)&next = dlsym(RTLD_NEXT, "ptrace"); }

static long set_all_registers(pid_t process, const struct iovec *known) {
  struct iovec whole = {all, sizeof all};
  if (next(PTRACE_GETREGSET, process, (void *)NT_X86_XSTATE, &whole) != 0) {
    return -1;
  }
  if (known->iov_len >= whole.iov_len) {
    errno = EFAULT;
    return -1;
  }
  memcpy(all, known->iov_base, known->iov_len);
  return next(PTRACE_SETREGSET, process, (void *)NT_X86_XSTATE, &whole);
}

long ptrace(enum __ptrace_request request, ...) {
  va_list arguments;
  va_start(arguments, request);
  const pid_t process = va_arg(arguments, pid_t);
  void *const address = va_arg(arguments, void *);
  void *const data = va_arg(arguments, void *);
  va_end(arguments);
  const long result = next(request, process, address, data);
  if (result == -1 && errno == EFAULT && request == PTRACE_SETREGSET && address == (void *)NT_X86_XSTATE) {
    return set_all_registers(process, data);
  }
  return result;
}
