# SPDX-License-Identifier: Apache-2.0
# One clear error for each tool and library that is missing: what it is, and which command installs it.
include_guard(GLOBAL)

function(trackservo_missing what mode)
  message(FATAL_ERROR "${what} is missing: ./tools/setup ${mode} installs it.")
endfunction()

# trackservo_find_library(WHAT PACKAGE ARGUMENTS...): find_package for a library of the simulator.
macro(trackservo_find_library what package)
  find_package(${package} ${ARGN} QUIET)
  if(NOT ${package}_FOUND)
    trackservo_missing("${what}" demo)
  endif()
endmacro()
