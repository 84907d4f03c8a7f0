# SPDX-License-Identifier: Apache-2.0
# Unity, the test framework: no code of ours, so it is brought in by tools/setup (pinned and checked) and never
# committed. -DUNITY_DIR=, or else the environment variable of that name, uses another copy. A relative folder of the
# environment counts from the project's folder.
include_guard(GLOBAL)
include(TrackservoMissing)

set(UNITY_DIR "" CACHE PATH "Folder with Unity's unity.c and unity.h; empty: the environment's UNITY_DIR, else third_party/unity")
if(NOT "$ENV{UNITY_DIR}" STREQUAL "") # kept: builds configure anew by themselves, without this environment
  set(unity_of_environment "$ENV{UNITY_DIR}" CACHE INTERNAL "The last UNITY_DIR of the environment")
endif()
set(unity_folder "${PROJECT_SOURCE_DIR}/third_party/unity")
foreach(given IN ITEMS "${unity_of_environment}" "${UNITY_DIR}")
  if(NOT given STREQUAL "")
    cmake_path(ABSOLUTE_PATH given BASE_DIRECTORY "${PROJECT_SOURCE_DIR}" OUTPUT_VARIABLE unity_folder)
  endif()
endforeach()

find_path(
  unity_source_dir unity.c
  PATHS "${unity_folder}" "${unity_folder}/src"
  NO_DEFAULT_PATH NO_CACHE)
if(NOT unity_source_dir)
  trackservo_missing("Unity, the C test framework (no unity.c in '${unity_folder}'; your own copy: -DUNITY_DIR=FOLDER)," firmware)
endif()

add_library(unity STATIC "${unity_source_dir}/unity.c")
target_include_directories(unity SYSTEM PUBLIC "${unity_source_dir}")
target_compile_definitions(unity PUBLIC UNITY_INCLUDE_DOUBLE UNITY_SUPPORT_64)
target_link_libraries(unity PRIVATE trackservo_sanitizers)
