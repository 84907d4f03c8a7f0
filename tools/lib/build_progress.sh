# SPDX-License-Identifier: Apache-2.0
# shellcheck shell=bash
# Progress of a build: one rewritten line on a terminal, and elsewhere a line every ten seconds at most.

# Seconds from any origin; a test replaces it by its own.
progress_now_s() { printf '%s' "$SECONDS"; }

# duration_words SECONDS: "40 s", "3 min 20 s"
duration_words() {
  local seconds="$1"
  if ((seconds < 90)); then
    printf '%d s' "$((seconds > 10 ? (seconds + 2) / 5 * 5 : seconds > 0 ? seconds : 1))"
  elif (((seconds + 5) / 10 % 6 == 0)); then
    printf '%d min' "$(((seconds + 5) / 60))"
  else
    printf '%d min %d s' "$(((seconds + 5) / 60))" "$(((seconds + 5) / 10 % 6 * 10))"
  fi
}

# Reads Ninja's lines ("[12/209] Building ..."), writes progress and remaining time. The pace is that of the completed
# files.
show_build_progress() {
  local started last now line step total left text terminal=no begun=no
  [[ -t 1 ]] && terminal=yes
  started="$(progress_now_s)"
  last="$started"
  while IFS= read -r line; do
    [[ "$line" =~ ^\[([0-9]+)/([0-9]+)\] ]] || continue
    step="${BASH_REMATCH[1]}"
    total="${BASH_REMATCH[2]}"
    ((step > 0)) || continue # "[0/2] Re-checking globbed directories", before Ninja has counted its work
    begun=yes
    now="$(progress_now_s)"
    left=$(((now - started) * (total - step) / step))
    if [[ "$terminal" == no ]] && ((now - last < 10 && step != total - 1)); then
      continue
    fi
    last="$now"
    text="$step of $total steps"
    ((step == total - 1)) && text="$text, linking"
    ((step * 50 > total && step < total)) && text="$text; about $(duration_words "$left") left"
    if [[ "$terminal" == yes ]]; then
      printf '\r[%3d %%] %-60s' "$((100 * step / total))" "$text"
    else
      printf '[%3d %%] %s\n' "$((100 * step / total))" "$text"
    fi
  done
  if [[ "$begun" == yes ]]; then
    text="$(duration_words "$(($(progress_now_s) - started))")"
    if [[ "$terminal" == yes ]]; then
      printf '\r[100 %%] built, took %-50s\n' "$text"
    else
      printf '[100 %%] built, took %s\n' "$text"
    fi
  else
    printf '[100 %%] nothing to build\n'
  fi
}
