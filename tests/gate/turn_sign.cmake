# SPDX-License-Identifier: Apache-2.0
# Writes OUT: the file IN with the observer's estimate negated. Fails when the file does not have that line.
file(READ "${IN}" text)
set(line "return scalar_clamp(state->estimate_nm,")
string(FIND "${text}" "${line}" found)
if(found EQUAL -1)
  message(FATAL_ERROR "${IN} has no line with '${line}': say here which one gives the estimate now.")
endif()
string(REPLACE "${line}" "return scalar_clamp(-state->estimate_nm," text "${text}")
file(WRITE "${OUT}" "${text}")
