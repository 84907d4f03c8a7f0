# pytest, in the virtual environment that tools/setup makes.
#
# These tests talk to a servo in real time, on machines that are shared: one that fails has two more chances, and
# "rerun" in its summary (-rR) tells of those that needed them.
include_guard(DIRECTORY) # what it sets is of the folder that includes it

find_program(TRACKSERVO_PYTEST pytest HINTS "${PROJECT_SOURCE_DIR}/build/venv/bin" REQUIRED NO_DEFAULT_PATH)
set(trackservo_pytest_in_real_time "${TRACKSERVO_PYTEST}" -q -rRs -p no:cacheprovider --reruns 2 --reruns-delay 1)
