# SPDX-License-Identifier: Apache-2.0
# Sanitizers (all of our code, and Unity) and coverage (firmware/ only), as INTERFACE targets: empty unless the
# preset asks for them.
include_guard(GLOBAL)

# Link options travel with a static library to its executable, compile options stay at home.
add_library(trackservo_sanitizers INTERFACE)
if(TRACKSERVO_SANITIZE)
  set(sanitizers -fsanitize=address,undefined,float-cast-overflow -fno-sanitize-recover=all)
  target_compile_options(trackservo_sanitizers INTERFACE ${sanitizers} -fno-omit-frame-pointer -O1)
  # In C++ every reference would be tested, for half of the build: AddressSanitizer reports a null pointer as well, and
  # only the firmware reads numbers out of bytes.
  target_compile_options(trackservo_sanitizers INTERFACE "$<$<COMPILE_LANGUAGE:CXX>:-fno-sanitize=null,alignment>")
  # gcc's manual, of -fsanitize: with it this warning finds what is not there.
  target_compile_options(trackservo_sanitizers INTERFACE "$<$<COMPILE_LANGUAGE:CXX>:-Wno-maybe-uninitialized>")
  target_link_options(trackservo_sanitizers INTERFACE ${sanitizers})
endif()

# Clang's edge counters and sanitizers; who has a main() of libFuzzer links trackservo_fuzzer as well.
if(TRACKSERVO_FUZZ)
  if(NOT CMAKE_C_COMPILER_ID STREQUAL "Clang" OR NOT CMAKE_CXX_COMPILER_ID STREQUAL "Clang")
    message(FATAL_ERROR "The fuzzers need clang: use the preset host-fuzz.")
  endif()
  set(sanitizers -fsanitize=fuzzer-no-link,address,undefined,float-cast-overflow -fno-sanitize-recover=all)
  # Comparisons are not traced: most are the sanitizers' own, and half of the time would go there. Harnesses and seeds
  # bring the rare values instead.
  target_compile_options(trackservo_sanitizers INTERFACE ${sanitizers} -fno-sanitize-coverage=trace-cmp
                                                         -fno-omit-frame-pointer)
  target_link_options(trackservo_sanitizers INTERFACE -fsanitize=address,undefined)
  add_library(trackservo_fuzzer INTERFACE)
  target_link_options(trackservo_fuzzer INTERFACE -fsanitize=fuzzer)
endif()

# Unoptimised, so that a line and a branch are those of the source; the simulator around it stays fast.
add_library(trackservo_coverage INTERFACE)
if(TRACKSERVO_COVERAGE)
  target_compile_options(trackservo_coverage INTERFACE --coverage -O0)
  target_link_options(trackservo_coverage INTERFACE --coverage)
endif()
