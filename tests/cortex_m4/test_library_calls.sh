#!/usr/bin/env bash
# Usage: test_library_calls.sh NM ARCHIVE...
# What the firmware's archives call outside themselves may only be what gives the same bits everywhere and costs little:
# no function of the C library that rounds in its own way (expf, sinf), no arithmetic in double, no heap.
set -euo pipefail

allowed=(
  'memcpy|memmove|memset|strlen'  # bytes
  'sqrtf|roundf|frexpf'           # exact by their definition
  '__aeabi_f2lz|__aeabi_l2f'      # float to int64 and back
  'hal_.*'                        # the boundary, hal/hal.h
)

nm="$1"
shift
symbols() { "$nm" "$@" 2>/dev/null | awk 'NF >= 2 { print $NF }' | sort -u; }

called="$(comm -23 <(symbols --undefined-only "$@") <(symbols --defined-only "$@"))"
[[ -n "$called" ]] || { echo "$nm tells of no call at all"; exit 1; }
unexpected="$(grep -vxE "$(IFS='|' && echo "${allowed[*]}")" <<<"$called" || true)"
if [[ -n "$unexpected" ]]; then
  printf 'The firmware calls what it must not: %s\n' "${unexpected//$'\n'/ }"
  exit 1
fi
printf 'Called: %s\n' "${called//$'\n'/ }"
