# Unity, the test framework: no code of ours, so it is brought in by tools/setup (pinned and checked) and never
# committed. -DUNITY_DIR=, or the environment variable of that name, uses another copy.
include_guard(GLOBAL)

set(unity_default "${PROJECT_SOURCE_DIR}/third_party/unity")
if(DEFINED ENV{UNITY_DIR})
  set(unity_default "$ENV{UNITY_DIR}")
endif()
set(UNITY_DIR "${unity_default}" CACHE PATH "Folder with Unity's unity.c and unity.h")

find_path(
  unity_source_dir unity.c
  PATHS "${UNITY_DIR}" "${UNITY_DIR}/src"
  NO_DEFAULT_PATH NO_CACHE)
if(NOT unity_source_dir)
  message(FATAL_ERROR "No Unity in '${UNITY_DIR}': run ./tools/setup test, or pass -DUNITY_DIR=FOLDER.")
endif()

add_library(unity STATIC "${unity_source_dir}/unity.c")
target_include_directories(unity SYSTEM PUBLIC "${unity_source_dir}")
target_compile_definitions(unity PUBLIC UNITY_INCLUDE_DOUBLE UNITY_SUPPORT_64)
target_link_libraries(unity PRIVATE trackservo_sanitizers)
