#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Usage: test_library_calls.sh READELF ARCHIVE...
# The firmware's archives may call only functions that give the same bits everywhere and cost little: no function of the
# C library with its own rounding (expf, sinf), no arithmetic in double, no heap.
set -euo pipefail

allowed=(
  'memcpy|memmove|memset|memcmp|strlen'  # bytes
  'sqrtf|roundf|frexpf|ceilf|floorf'  # exact by definition
  'acosf|atan2f'                  # phases in loop_stability, which judges a gain set and controls nothing
  '__aeabi_f2lz|__aeabi_l2f'      # float to int64 and back
  'hal_.*'                        # the boundary, hal/hal.h
)

# Not nm: for code that will be optimised across files it lists the source's calls, not those of the machine code.
readelf="$1"
shift
undefined() { "$readelf" --syms --wide "$@" | awk '$7 == "UND" && NF == 8 { print $8 }' | sort -u; }
defined() { "$readelf" --syms --wide "$@" | awk '$7 != "UND" && NF == 8 { print $8 }' | sort -u; }

called="$(comm -23 <(undefined "$@") <(defined "$@"))"
[[ -n "$called" ]] || { echo "$readelf lists no call at all"; exit 1; }
unexpected="$(grep -vxE "$(IFS='|' && echo "${allowed[*]}")" <<<"$called" || true)"
if [[ -n "$unexpected" ]]; then
  printf 'The firmware calls what it must not: %s\n' "${unexpected//$'\n'/ }"
  exit 1
fi
printf 'Called: %s\n' "${called//$'\n'/ }"
