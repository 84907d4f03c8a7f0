# SPDX-License-Identifier: Apache-2.0
# shellcheck shell=bash
# Which steps of tools/test a changed file can affect: tools/test --changed. Sourced by tools/test after checks.sh.
# shellcheck disable=SC2034,SC2154

# What compiles or runs firmware, and what compiles or runs the simulator.
firmware_steps="sanitized short clients image lint firmware long asan coverage attack mutate proofs fuzz cortex-m4 reproducible socketcan tidy python servoctl servoctl-image check"
simulator_steps="short clients lint long asan attack fuzz cortex-m4 socketcan tidy cppcheck python servoctl servoctl-image check site readme"

# By the kind of the file.
steps_of_kind() {
  case "$1" in
    *.c | *.h | *.cpp | *.hpp) echo format includes ;;
    *.sh) echo scripts ;;
    *.*) ;;
    *) [[ -x "$1" ]] && echo scripts ;;
  esac
}

# By the place of the file. "short:TEST" is the step short with this one of its tests; likewise "long:TEST", for a test
# that the gate leaves out. "short:-LABEL" is the step short without the tests that have this label of CTest. "all" is for a
# file that this list does not know, and for what every step uses. The first pattern that fits counts.
steps_of_place() {
  case "$1" in
    .github/workflows/release.yml | tests/release/*.py) echo release ;;
    LICENSE | .gitignore | .dockerignore | .editorconfig | .github/*) ;;
    .ci/*) echo scripts ;;
    .clang-format) echo format python ;;
    .clang-tidy) echo lint tidy ;;
    .pre-commit-config.yaml) echo python ;;
    README.md) echo short:test_docs python readme ;;
    *.md)
      case "$1" in
        docs/can.md) echo short:test_docs socketcan site ;;
        docs/can-objects.md) echo short:test_docs short:descriptions site ;;
        docs/faults.md) echo short:test_docs short:descriptions python site ;;
        docs/safety.md | docs/safety/*.md | docs/results/faults.md) echo short:test_docs python site ;;
        docs/board.md) echo short:test_docs long:first_power_up site ;;
        docs/* | CHANGELOG.md | CONTRIBUTING.md) echo short:test_docs site ;;
        tools/releasing/START.md | tools/identify/README.md) echo release ;;
        tools/report/README.md) echo short:test_docs python site ;;
        tools/imager/README.md | tools/servoctl/README.md | tools/servoctl/LIBRARY.md) echo short:test_docs servoctl site ;;
        *) echo all ;;
      esac
      ;;
    docs/ci/*) echo check readme ;;
    docs/ros2/*) echo short:device long:device_image ;;
    docs/images/*) echo short:test_docs site ;;

    firmware/*/tests/*.cpp) echo short asan ;;
    firmware/*/tests/*.c | hal/*/tests/*.c) echo sanitized firmware coverage mutate cortex-m4 ;;
    hal/boards/nucleo_g474/openocd.cfg) ;;
    hal/chips/stm32g4/*.ld) echo image short long servoctl-image check ;;
    hal/boards/cortex_m4_qemu/*.ld) echo cortex-m4 ;;
    firmware/canopen/*.[ch] | firmware/*.h) echo "$firmware_steps" ;;
    firmware/*.c) echo "${firmware_steps/ short / short:-without_servo }" ;;
    hal/chips/stm32g4/*.[chS] | hal/boards/nucleo_g474/*.[ch]) echo image lint short long reproducible tidy servoctl-image check ;;
    hal/boards/cortex_m4_qemu/*.[chS]) echo lint cortex-m4 ;;
    hal/*.[ch]) echo "$firmware_steps" ;;
    sim_host/*) echo "$simulator_steps" ;;

    tests/canopen/*.py) echo short:canopen_client ;;
    tests/judges/*.py | tests/judges/*.toml) echo short:plant_against_mujoco ;;
    tests/fmi/*.py) echo long:fmi_units ;;
    tests/command_line/*.py) echo short:command_line ;;
    tests/configure/*.py) echo long:configure ;;
    tests/device/on_socketcan/*.py) echo socketcan ;;
    tests/device/*.py) echo short:device long:device_image socketcan ;;
    tests/socketcan/*) echo socketcan ;;
    tests/target/*.py) echo short:emulate_board long:first_power_up ;;
    tests/real_time.args) echo short long clients servoctl servoctl-image ;;
    tests/gate/*.py) echo check ;;
    tests/proofs/*) echo proofs ;;
    tests/fuzz/*.py) echo python ;;
    tests/fuzz/*) echo fuzz python ;;
    tests/readme/*) echo python readme ;;
    tests/changed/*.py | tests/demo/*.py | tests/docs/*.py | tests/hooks/*.py) echo python ;;
    tests/cortex_m4/*.sh | tests/cortex_m4/*.py) echo cortex-m4 ;;
    tests/target/probes/*) echo short:test_core ;;
    tests/cortex_m4/*.[ch]*) echo cortex-m4 short ;;
    tests/store/*.c) echo sanitized firmware coverage mutate ;;
    tests/*.[ch] | tests/*.[ch]pp) echo sanitized short long firmware asan coverage mutate cortex-m4 fuzz servoctl check ;;

    tools/demo | tools/lib/build_progress.sh) echo python readme ;;
    tools/fuzz | tools/lib/fuzz_corpus.sh) echo fuzz python ;;
    tools/site | tools/website/* | tools/requirements-site.*) echo site ;;
    tools/update-docs) ;;
    tools/release | tools/lib/release.sh | tools/releasing/* | tools/requirements-release.txt | tools/identify/*) echo release ;;
    tools/servoctl/pyproject.toml | tools/servoctl/setup.py | tools/imager/pyproject.toml | tools/imager/setup.py) echo clients release servoctl servoctl-image readme ;;
    tools/imager/*) echo clients servoctl servoctl-image site ;;
    tools/image/board | tools/image/option_bytes.py) echo image short long reproducible release servoctl-image check ;;
    tools/image/*) echo image short long reproducible servoctl-image check ;;
    tools/minimax/*.py) ;;
    tools/mutate | tools/mutation/*) echo mutate python ;;
    tools/prove | tools/proofs/*) echo proofs ;;
    tools/misra/*) echo lint cppcheck ;;
    tools/registers/*) echo image ;;
    tools/report/*) echo python ;;
    tools/servoctl/servoctl/show/text_file.py) echo clients servoctl servoctl-image socketcan short long python ;;
    tools/servoctl/*) echo clients servoctl servoctl-image socketcan short long site readme ;;
    tools/source_checks/*) echo includes python ;;
    *) echo all ;;
  esac
}

# changes_base [BASE]: the commit where the present branch left BASE, or left main if no BASE is given. Fails if there is no
# main.
changes_base() {
  local branch
  if [[ $# -gt 0 ]]; then
    git merge-base HEAD "$1" 2>/dev/null ||
      die "'$1' is no commit with a common history: name one, for example --changed HEAD~3."
    return
  fi
  for branch in main origin/main; do
    git merge-base HEAD "$branch" 2>/dev/null && return
  done
  return 1
}

# changed_files BASE: what differs from the commit BASE, and what git does not know. A renamed file counts with both names.
changed_files() {
  {
    git diff --name-only --no-renames "$1" --
    git ls-files --others --exclude-standard
  } | LC_ALL=C sort -u
}

# add_affected WORD FILE: WORD as steps_of_place gives it.
add_affected() {
  local step="${1%%:*}" test="all"
  [[ "$1" != *:* ]] || test="${1#*:}"
  : "${affected_first[$step]:=$2}"
  affected_by[$step]+=" $2"
  affected_tests[$step]+=" $test"
}

# print_affected STEP...: a line for each of these steps that a change affects; its reason.
print_affected() {
  local step none=yes reason
  for step in "$@"; do
    [[ -n "${affected_first[$step]:-}" ]] || continue
    none=no
    local others
    others=$(($(tr ' ' '\n' <<<"${affected_by[$step]}" | sort -u | grep -c .) - 1))
    reason="${affected_first[$step]}"
    ((others == 0)) || reason+=" and $others more"
    [[ -z "$(limited_tests "$step")" ]] || reason+=" ($(limits_in_words "$step"))"
    printf '  %-14s  %s\n' "$step" "$reason"
  done
  [[ $none == no ]] || echo "  none"
}

# limited_tests STEP: the tests that the step is limited to by the changes, or -LABEL, one per line; nothing if it runs all.
limited_tests() {
  case " ${affected_tests[$1]:-all} " in
    *" all "*) ;;
    *) tr ' ' '\n' <<<"${affected_tests[$1]}" | grep . | LC_ALL=C sort -u ;;
  esac
}

# limits_in_words STEP: what limited_tests says.
limits_in_words() {
  local label named
  label="$(limited_tests "$1" | sed -n 's/^-//p')"
  named="$(limited_tests "$1" | grep -v ^- | paste -sd ' ')"
  if [[ -z "$label" ]]; then
    echo "only these tests: $named"
  else
    echo "without the tests with the label $label${named:+, but with these: $named}"
  fi
}

declare -A affected_first=() affected_by=() affected_tests=()

# choose_changed_steps BASE DEPTH: sets chosen to the steps of the gate that the changes since BASE can affect; also to
# those of the depth if DEPTH is yes. Prints both and why.
choose_changed_steps() {
  local files file word step
  mapfile -t files < <(changed_files "$1")
  for file in "${files[@]}"; do
    [[ -e "$file" ]] || add_affected short:test_docs "$file" # pages may link to a file that is gone
    for word in $(steps_of_kind "$file") $(steps_of_place "$file"); do
      if [[ "$word" == all ]]; then
        for step in "${gate_steps[@]}" "${depth_steps[@]}"; do add_affected "$step" "$file"; done
      else
        add_affected "$word" "$file"
      fi
    done
  done
  printf '%d files changed since %s. Steps of the gate that they can affect, and why:\n' "${#files[@]}" "$(git rev-parse --short "$1")"
  print_affected "${gate_steps[@]}"
  if [[ "$2" == yes ]]; then
    echo "Steps of the depth:"
  else
    echo "Steps of the depth, which --changed --full runs:"
  fi
  print_affected "${depth_steps[@]}"
  chosen=()
  for step in "${gate_steps[@]}" $([[ "$2" == no ]] || echo "${depth_steps[@]}"); do
    [[ -z "${affected_first[$step]:-}" ]] || chosen+=("$step")
  done
}
