/*
 * For test_with_can.sh: a host whose extended registers have 11,008 bytes, as with Intel AMX. Loaded by LD_PRELOAD
 * after uml_xstate.c; refuses a shorter PTRACE_SETREGSET with EFAULT, as the kernel does, and reads 11,008 bytes.
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

enum { LARGE_BYTES = 11008 };

typedef long ptrace_function(enum __ptrace_request, ...);

static ptrace_function *next;

__attribute__((constructor)) static void find_next(void) { *(void **)&next = dlsym(RTLD_NEXT, "ptrace"); }

long ptrace(enum __ptrace_request request, ...) {
  va_list arguments;
  va_start(arguments, request);
  const pid_t process = va_arg(arguments, pid_t);
  void *const address = va_arg(arguments, void *);
  struct iovec *const data = va_arg(arguments, struct iovec *);
  va_end(arguments);
  const int extended = address == (void *)NT_X86_XSTATE;
  if (request == PTRACE_SETREGSET && extended && data->iov_len < LARGE_BYTES) {
    errno = EFAULT;
    return -1;
  }
  const size_t wanted = extended ? data->iov_len : 0;
  const long result = next(request, process, address, data);
  if (result == 0 && request == PTRACE_GETREGSET && extended && wanted > data->iov_len) {
    const size_t given = wanted < LARGE_BYTES ? wanted : LARGE_BYTES;
    memset((char *)data->iov_base + data->iov_len, 0, given - data->iov_len);
    data->iov_len = given;
  }
  return result;
}
