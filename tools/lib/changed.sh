# shellcheck shell=bash
# Which steps of tools/test a changed file can affect: tools/test --changed. Sourced by tools/test after checks.sh.
# shellcheck disable=SC2154

# What compiles or runs firmware, and what compiles or runs the simulator.
firmware_steps="firmware host socketcan asan coverage attack mutate proofs fuzz cortex-m4 image reproducible tidy cppcheck python servoctl servoctl-image check"
simulator_steps="host socketcan asan attack fuzz cortex-m4 tidy python servoctl servoctl-image check"

# By the kind of the file.
steps_of_kind() {
  case "$1" in
    *.c | *.h | *.cpp | *.hpp) echo format includes words ;;
    *.py | *.md | *.toml | *.txt | *.cmake) echo words ;;
    *.sh) echo scripts words ;;
    *.*) ;;
    *) [[ -x "$1" ]] && echo scripts words ;;
  esac
}

# By the place of the file. "host:TEST" is the step host with this one of its tests. "all" is for a file that this list
# does not know, and for what every step uses. The first pattern that fits counts.
steps_of_place() {
  case "$1" in
    LICENSE | .gitignore | .dockerignore | .editorconfig | .github/*) ;;
    .ci/*) echo scripts ;;
    .clang-format) echo format python ;;
    .clang-tidy) echo tidy ;;
    .pre-commit-config.yaml) echo python ;;
    README.md) echo python readme host:test_docs ;;
    *.md)
      case "$1" in
        docs/can.md) echo socketcan host:test_docs ;;
        docs/can-objects.md) echo host:test_docs host:node ;;
        docs/faults.md) echo python host:test_docs host:node ;;
        docs/safety.md | docs/safety/*.md | docs/results/faults.md) echo python host:test_docs ;;
        docs/board.md) echo host:test_docs host:first_power_up ;;
        docs/*) echo host:test_docs ;;
        CHANGELOG.md | CONTRIBUTING.md) echo host:test_docs ;;
        tools/report/README.md) echo python host:test_docs ;;
        tools/imager/README.md | tools/servoctl/README.md | tools/servoctl/LIBRARY.md) echo servoctl host:test_docs ;;
        *) echo all ;;
      esac
      ;;
    docs/ci/*) echo check ;;
    docs/ros2/*) echo host:ros2_bus ;;
    docs/images/*) echo host:test_docs ;;

    firmware/*/tests/*.cpp) echo host asan ;;
    firmware/*/tests/*.c | hal/*/tests/*.c) echo firmware host asan coverage mutate cortex-m4 ;;
    hal/stm32g474/openocd.cfg) ;;
    hal/stm32g474/*.ld) echo host image servoctl-image check ;;
    hal/cortex_m4_qemu/*.ld) echo cortex-m4 ;;
    firmware/*.[ch]) echo "$firmware_steps" ;;
    hal/stm32g474/*.[chS]) echo host image reproducible tidy cppcheck servoctl-image check ;;
    hal/cortex_m4_qemu/*.[chS]) echo cortex-m4 cppcheck ;;
    hal/*.[ch]) echo "$firmware_steps" ;;
    sim_host/*) echo "$simulator_steps" ;;

    tests/canopen/*.py) echo host:canopen_client ;;
    tests/judges/*.py | tests/judges/*.toml) echo host:plant_against_mujoco ;;
    tests/command_line/*.py) echo host:command_line ;;
    tests/configure/*.py) echo host:configure ;;
    tests/conformance/*.py) echo host:conformance ;;
    tests/node/on_socketcan/*.py) echo socketcan ;;
    tests/node/*.py) echo socketcan host:node ;;
    tests/ros2/*.py | tools/ros2/*.py) echo host:ros2_bus ;;
    tests/socketcan/*) echo socketcan host:with_can ;;
    tests/target/*.py) echo host:emulate_board host:first_power_up ;;
    tests/real_time.args) echo host socketcan servoctl servoctl-image ;;
    tests/gate/*.py) echo check ;;
    tests/proofs/*) echo proofs ;;
    tests/fuzz/*.py) echo python ;;
    tests/fuzz/*) echo fuzz python ;;
    tests/changed/*.py | tests/demo/*.py | tests/docs/*.py | tests/hooks/*.py | tests/readme/*) echo python ;;
    tests/cortex_m4/*.sh | tests/cortex_m4/*.py) echo cortex-m4 ;;
    tests/target/probes/*) echo host:test_core ;;
    tests/cortex_m4/*.[ch]*) echo cortex-m4 host ;;
    tests/*.[ch] | tests/*.[ch]pp) echo firmware host asan coverage mutate cortex-m4 fuzz servoctl servoctl-image check ;;

    tools/demo | tools/lib/build_progress.sh) echo python ;;
    tools/fuzz | tools/lib/fuzz_corpus.sh) echo fuzz python ;;
    tools/update-docs) ;;
    tools/imager/*) echo servoctl ;;
    tools/image/*) echo host image reproducible servoctl-image check ;;
    tools/minimax/*.py) ;;
    tools/mutate | tools/mutation/*) echo mutate python ;;
    tools/prove | tools/proofs/*) echo proofs ;;
    tools/misra/*) echo cppcheck ;;
    tools/registers/*) echo image ;;
    tools/report/*) echo python ;;
    tools/servoctl/*) echo servoctl servoctl-image page-image socketcan host ;;
    tools/source_checks/*) echo includes words python ;;
    *) echo all ;;
  esac
}

# changes_base [BASE]: the commit where the present branch left BASE, or left main if no BASE is given.
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
  die "there is no branch main: name a commit, for example --changed HEAD~3."
}

# changed_files BASE: what differs from the commit BASE, and what git does not know. A renamed file counts with both names.
changed_files() {
  {
    git diff --name-only --no-renames "$1" --
    git ls-files --others --exclude-standard
  } | LC_ALL=C sort -u
}

# choose_changed_steps BASE STEP...: sets chosen to those of the steps that the changes since BASE can affect, in their
# order, and host_tests to the tests that are enough for the step host (empty: all). Prints why, a line for each step.
choose_changed_steps() {
  local base="$1" files file step word
  shift
  local -A first=() count=() tests=()
  mapfile -t files < <(changed_files "$base")
  for file in "${files[@]}"; do
    local -A affected=()
    [[ -e "$file" ]] || affected[host]=" test_docs" # pages may link to a file that is gone
    for word in $(steps_of_kind "$file") $(steps_of_place "$file"); do
      case "$word" in
        all) for step in "$@"; do affected[$step]=all; done ;;
        host:*) affected[host]+=" ${word#host:}" ;;
        *) affected[$word]=all ;;
      esac
    done
    for step in "${!affected[@]}"; do
      : "${first[$step]:=$file}"
      count[$step]=$((${count[$step]:-0} + 1))
      tests[$step]+=" ${affected[$step]}"
    done
    unset affected
  done
  chosen=()
  host_tests=()
  printf '%d files changed since %s. The steps that they can affect, and why:\n' "${#files[@]}" "$(git rev-parse --short "$base")"
  for step in "$@"; do
    [[ -n "${first[$step]:-}" ]] || continue
    chosen+=("$step")
    local reason="${first[$step]}"
    ((count[$step] == 1)) || reason+=" and $((count[$step] - 1)) more"
    if [[ "$step" == host && " ${tests[host]} " != *" all "* ]]; then
      # shellcheck disable=SC2086  # one line for each test
      mapfile -t host_tests < <(printf '%s\n' ${tests[host]} | LC_ALL=C sort -u)
      reason+=" (only these tests: ${host_tests[*]})"
    fi
    printf '  %-14s  %s\n' "$step" "$reason"
  done
  [[ ${#chosen[@]} != 0 ]] || echo "  none"
}
