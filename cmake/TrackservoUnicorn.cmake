# SPDX-License-Identifier: Apache-2.0
# Unicorn, the instruction-set emulator: header and library come with the Python package that tools/requirements.txt
# pins and tools/setup puts into build/venv.
include_guard(GLOBAL)
include(TrackservoMissing)

file(GLOB unicorn_packages "${PROJECT_SOURCE_DIR}/build/venv/lib/python3*/site-packages/unicorn")
find_path(UNICORN_INCLUDE_DIR unicorn/unicorn.h HINTS ${unicorn_packages} PATH_SUFFIXES include NO_DEFAULT_PATH)
find_library(UNICORN_LIBRARY NAMES libunicorn.so.2 unicorn HINTS ${unicorn_packages} PATH_SUFFIXES lib NO_DEFAULT_PATH)
mark_as_advanced(UNICORN_INCLUDE_DIR UNICORN_LIBRARY)
if(NOT UNICORN_INCLUDE_DIR OR NOT UNICORN_LIBRARY)
  trackservo_missing("The instruction-set emulator Unicorn (in build/venv)" test)
endif()

add_library(unicorn SHARED IMPORTED GLOBAL)
set_target_properties(unicorn PROPERTIES IMPORTED_LOCATION "${UNICORN_LIBRARY}" IMPORTED_NO_SONAME ON)
target_include_directories(unicorn SYSTEM INTERFACE "${UNICORN_INCLUDE_DIR}")
