#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# What would make a test on vcan0 pass without having run: with-can must give the exit code of its command, end it after
# the time limit, and say in one sentence that there is no vcan0. Runs in the mode that the tests get on this machine.
set -uo pipefail

with_can="$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)/with-can"
work="$(mktemp -d /tmp/test-with-can.XXXXXX)"
trap 'rm -rf "$work"' EXIT
failed=0

# gives CODE OUT ERR COMMAND...: exit code, whole output, and a pattern of the only line of errors (empty: no error).
gives() {
  local wanted="$1" out="$2" err="$3" lines=0 code=0
  shift 3
  [[ -z "$err" ]] || lines=1
  "$@" >"$work/out" 2>"$work/err" || code=$?
  if [[ "$code" == "$wanted" && "$(<"$work/out")" == "$out" && "$(wc -l <"$work/err")" == "$lines" ]] &&
    { [[ -z "$err" ]] || grep -q "$err" "$work/err"; }; then
    echo "ok    $wanted: $*"
  else
    failed=1
    echo "FAIL  $*: exit code $code, expected $wanted"
    sed 's/^/      /' "$work/out" "$work/err"
  fi
}

# A PATH whose first folder has an ip that cannot create an interface, as on a kernel without vcan.
mkdir "$work/no_vcan"
printf '#!/bin/sh\necho "Error: Unknown device type." >&2\nexit 2\n' >"$work/no_vcan/ip"
chmod +x "$work/no_vcan/ip"

gives 7 "out" "" "$with_can" sh -c 'echo out; exit 7'
gives 127 "" "no-such-command" "$with_can" no-such-command
gives 124 "begun" "'sh' was terminated after 2 s" "$with_can" --timeout 2 sh -c 'trap "" TERM; echo begun; sleep 1001; sleep 1001'
gives 125 "" "no vcan0: .*Unknown device type.*install" env PATH="$work/no_vcan:$PATH" "$with_can" --via kernel true
exit "$failed"
