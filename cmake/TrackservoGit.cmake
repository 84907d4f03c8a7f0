# SPDX-License-Identifier: Apache-2.0
# TRACKSERVO_GIT: the commit that is built, with "-dirty" when files differed from it, or "unknown" without git. It is
# taken when CMake runs, and every commit makes CMake run. It is the same in every clone: git would show more digits in a
# larger one, and a tag in place of the commit where there is one.
include_guard(GLOBAL)

execute_process(
  COMMAND git describe --always --dirty --abbrev=12 --exclude=*
  WORKING_DIRECTORY "${PROJECT_SOURCE_DIR}"
  OUTPUT_VARIABLE TRACKSERVO_GIT
  OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET)
if(TRACKSERVO_GIT STREQUAL "")
  set(TRACKSERVO_GIT unknown)
endif()

execute_process(
  COMMAND git rev-parse --git-path logs/HEAD
  WORKING_DIRECTORY "${PROJECT_SOURCE_DIR}"
  OUTPUT_VARIABLE trackservo_git_log
  OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET)
cmake_path(ABSOLUTE_PATH trackservo_git_log BASE_DIRECTORY "${PROJECT_SOURCE_DIR}")
if(NOT IS_DIRECTORY "${trackservo_git_log}" AND EXISTS "${trackservo_git_log}")
  set_property(DIRECTORY "${PROJECT_SOURCE_DIR}" APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS "${trackservo_git_log}")
endif()
