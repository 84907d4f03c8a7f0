# SPDX-License-Identifier: Apache-2.0
# Warnings are errors in our code. Link trackservo_warnings PRIVATE, so that nobody inherits them.
include_guard(GLOBAL)

add_library(trackservo_warnings INTERFACE)
target_compile_options(
  trackservo_warnings
  INTERFACE -Wall
            -Wextra
            -Wpedantic
            -Werror
            -Wcast-align
            -Wcast-qual
            -Wconversion
            -Wdouble-promotion
            -Wformat=2
            -Wimplicit-fallthrough
            -Wpointer-arith
            -Wshadow
            -Wundef
            -Wvla
            $<$<COMPILE_LANGUAGE:C>:-Wmissing-prototypes>
            $<$<COMPILE_LANGUAGE:C>:-Wold-style-definition>
            $<$<COMPILE_LANGUAGE:C>:-Wsign-conversion>
            $<$<COMPILE_LANGUAGE:C>:-Wstrict-prototypes>
            $<$<COMPILE_LANGUAGE:C>:-Wwrite-strings>
            $<$<COMPILE_LANGUAGE:CXX>:-Wextra-semi>
            $<$<COMPILE_LANGUAGE:CXX>:-Wnon-virtual-dtor>
            $<$<COMPILE_LANGUAGE:CXX>:-Woverloaded-virtual>)
