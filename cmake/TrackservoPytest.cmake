# SPDX-License-Identifier: Apache-2.0
# pytest, in the virtual environment that tools/setup makes.
#
# Options of the tests that talk to a servo: tests/real_time.args, for tools/test, too.
include_guard(DIRECTORY) # what it sets is of the folder that includes it
include(TrackservoMissing)

find_program(TRACKSERVO_PYTEST pytest HINTS "${PROJECT_SOURCE_DIR}/build/venv/bin" NO_DEFAULT_PATH)
if(NOT TRACKSERVO_PYTEST)
  trackservo_missing("pytest (in build/venv, the project's Python environment)" test)
endif()
set(trackservo_pytest_in_real_time "${TRACKSERVO_PYTEST}" "@${PROJECT_SOURCE_DIR}/tests/real_time.args")
