# SPDX-License-Identifier: Apache-2.0
# shellcheck shell=bash
# What tools/test remembers of a run: build/last-run.json, and docs/checks/full-run.md of a full one. Sourced by tools/test.
# shellcheck disable=SC2154

last_run="$build/last-run.json"
full_run_page=docs/checks/full-run.md
recorded=() # STEP SECONDS RESULT

# Except for the page that the last full run has written.
commit_is_clean() {
  local found
  found="$(git status --porcelain -- . ":(exclude)$full_run_page" 2>/dev/null)" && [[ -z "$found" ]]
}

head_commit() {
  git rev-parse HEAD 2>/dev/null || echo unknown
}

# value_of KEY: of build/last-run.json, which has one key or step in each line.
value_of() {
  sed -n "s/^  \"$1\": \"\{0,1\}\([^\",]*\).*/\1/p" "$last_run" 2>/dev/null
}

# begin_record RUN RESUME: RUN is gate, full, changed or steps. Keeps what has passed in the last full run of this commit if
# RESUME is yes.
begin_record() {
  run="$1"
  started_at="$(date -u +%Y-%m-%dT%H:%MZ)"
  commit="$(head_commit)"
  uncommitted=false
  commit_is_clean || uncommitted=true
  [[ "$2" == yes ]] || return 0
  [[ "$(value_of run)" == full ]] || die "--resume: build/last-run.json is not of a full run."
  [[ "$(value_of commit)" == "$commit" && "$(value_of uncommitted)" == false && "$uncommitted" == false ]] ||
    die "--resume: the last full run was of $(value_of commit)$([[ "$(value_of uncommitted)" == false ]] || echo " with uncommitted changes")," \
      "this is $commit$([[ "$uncommitted" == false ]] || echo " with uncommitted changes"): run without --resume."
  started_at="$(value_of date)"
  seed_of_the_day=$(($(date -u -d "$started_at" +%s) / 86400))
  mapfile -t recorded < <(sed -n 's/^    {"step": "\([^"]*\)", "seconds": \([0-9]*\), "result": "passed"}.*/\1 \2 passed/p' "$last_run" | grep -v '^setup ')
  echo "Resuming the full run of $started_at: ${#recorded[@]} steps have passed."
}

# is_recorded STEP: it has run; in a run that is resumed, it has passed.
is_recorded() {
  local line
  for line in "${recorded[@]}"; do
    [[ "$line" != "$1 "* ]] || return 0
  done
  return 1
}

# How long a run has taken that was not resumed.
took() {
  if [[ "${resume:-no}" == yes ]]; then
    echo "$(recorded_seconds) s in parts"
  else
    echo "$SECONDS s"
  fi
}

recorded_seconds() {
  local line sum=0 seconds
  for line in "${recorded[@]}"; do
    read -r _ seconds _ <<<"$line"
    sum=$((sum + seconds))
  done
  echo "$sum"
}

# record STEP SECONDS RESULT
record() {
  recorded+=("$*")
  local line step seconds result comma=""
  mkdir -p "$build"
  {
    printf '{\n  "run": "%s",\n  "commit": "%s",\n  "uncommitted": %s,\n  "date": "%s",\n  "seconds": %s,\n  "steps": [' \
      "$run" "$commit" "$uncommitted" "$started_at" "$(recorded_seconds)"
    for line in "${recorded[@]}"; do
      read -r step seconds result <<<"$line"
      printf '%s\n    {"step": "%s", "seconds": %s, "result": "%s"}' "$comma" "$step" "$seconds" "$result"
      comma=,
    done
    printf '\n  ]\n}\n'
  } >"$last_run.new"
  mv "$last_run.new" "$last_run"
}

slowest_first() {
  printf '%s\n' "${recorded[@]}" | sort -k2,2nr
}

# The ten slowest tests that ctest has run since this run began. Without head: it ends before sort has written all, and with
# pipefail the signal that then ends sort would end a run in which every step has passed.
slowest_tests() {
  find build -path '*/Testing/Temporary/LastTest.log' -newermt "@$(($(date +%s) - SECONDS))" -exec awk '
    / Testing: / { name = $NF }
    /^Test time = / { printf "%8.1f s  %s (%s)\n", $4, name, FILENAME }' {} + 2>/dev/null |
    sed -E 's#build/([^/]*)/Testing/.*#\1)#' | sort -rn | sed -n 1,10p
}

# Seconds of a step in the last committed full run; nothing if it is not there.
seconds_in_full_run() {
  sed -n "s/^| $1 | \([0-9]*\) | passed |\$/\1/p" "$full_run_page" 2>/dev/null
}

# Which steps of a gate that takes too long have grown since the last committed full run.
print_growth() {
  echo "The gate took $SECONDS s; at most $gate_limit_s s are allowed (2 idle cores). Against $full_run_page:"
  local step seconds before
  while read -r step seconds _; do
    before="$(seconds_in_full_run "$step")"
    [[ -z "$before" || "$seconds" -le "$before" ]] || printf '  %s: %s s, %s s before\n' "$step" "$seconds" "$before"
  done < <(slowest_first)
}

machine() {
  printf '%s cores (%s), %s GiB, %s' "$(nproc)" "$(sed -n 's/^model name[^:]*: //p' /proc/cpuinfo | head -n 1)" \
    "$(awk '/^MemTotal/ { printf "%.0f", $2 / 1048576 }' /proc/meminfo)" "$(sed -n 's/^PRETTY_NAME="\(.*\)"$/\1/p' /etc/os-release)"
}

write_full_run_page() {
  if [[ "$uncommitted" == true ]]; then
    echo "Uncommitted changes: $full_run_page is left as it was."
    return
  fi
  local line step seconds result
  mkdir -p "$(dirname "$full_run_page")"
  {
    # shellcheck disable=SC2016 # Markdown
    printf '# The last full run\n\n`./tools/test --full` wrote this page.\n\n'
    printf -- '- Commit: %s\n- Begun: %s\n- Machine: %s\n- Seed of the day: %s\n- Took: %s (tidy and cppcheck beside readme)\n\n' \
      "$commit" "$started_at" "$(machine)" "$seed_of_the_day" "$(took)"
    printf '| step | seconds | result |\n|---|---|---|\n'
    for line in "${recorded[@]}"; do
      read -r step seconds result <<<"$line"
      printf '| %s | %s | %s |\n' "$step" "$seconds" "$result"
    done
  } >"$full_run_page"
  echo "Written: $full_run_page"
}

# Steps and tests, slowest first, and the result; fails if a step has failed.
print_summary() {
  local step seconds result failed=()
  while read -r step seconds result; do
    printf '%8s s  %s%s\n' "$seconds" "$step" "$([[ "$result" == passed ]] || echo "  FAILED")"
    [[ "$result" == passed ]] || failed+=("$step")
  done < <(slowest_first)
  local tests
  tests="$(slowest_tests)"
  [[ -z "$tests" ]] || printf 'The slowest tests:\n%s\n' "$tests"
  [[ "$run" != full ]] || write_full_run_page
  [[ "$run" != gate || "$SECONDS" -le "$gate_limit_s" ]] || print_growth
  if [[ ${#failed[@]} != 0 ]]; then
    echo "FAILED: ${failed[*]} (${#failed[@]} of ${#recorded[@]} steps; it took $(took))"
    return 1
  fi
  echo "All ${#recorded[@]} steps passed; it took $(took)."
}
