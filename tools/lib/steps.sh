# SPDX-License-Identifier: Apache-2.0
# shellcheck shell=bash
# The steps of tools/test: each is a function step_NAME that succeeds or fails. Sourced by tools/test after checks.sh.
# shellcheck disable=SC2154

# Attacks, mutants and fuzzers draw by it: days since 1970.
seed_of_the_day=$(($(date -u +%s) / 86400))

configure_build_test() {
  cmake --preset "$1" && cmake --build --preset "$1" && ctest --preset "$1"
}

step_format() {
  local sources
  mapfile -t sources < <(our_sources)
  check_format "${sources[@]}"
}

step_scripts() {
  local scripts
  mapfile -t scripts < <(our_scripts)
  check_scripts "${scripts[@]}"
}

step_includes() {
  "$venv/bin/python" -m pytest -q -p no:cacheprovider tools/source_checks/tests/test_includes.py &&
    "$venv/bin/python" tools/source_checks/includes.py
}

# host_tests SIZE STEP: the host's build and its tests in this size, or those of them that --changed limits STEP to.
host_tests() {
  local limits named label without
  mapfile -t limits < <(limited_tests "$2")
  if [[ ${#limits[@]} == 0 ]]; then
    cmake --workflow --preset "$1"
    return
  fi
  named="^($(printf '%s\n' "${limits[@]}" | grep -v ^- | paste -sd '|'))\$"
  label="$(printf '%s\n' "${limits[@]}" | sed -n 's/^-//p')"
  cmake --preset host && cmake --build --preset "$1" || return
  if [[ -z "$label" ]]; then
    ctest --preset "$1" --tests-regex "$named"
  else
    # By name: a preset that leaves out labels takes no other ones.
    without="$(ctest --test-dir build/host -N --label-regex "^$label\$" | sed -n 's/^ *Test *#[0-9]*: //p' | paste -sd '|')"
    ctest --preset "$1" --exclude-regex "^($without)\$" &&
      ctest --preset "$1" --label-regex "^$label\$" --tests-regex "$named" --no-tests=ignore
  fi
}

step_short() {
  host_tests host-short short
}

step_long() {
  host_tests host long
}

step_sanitized() {
  configure_build_test firmware-asan
}

step_firmware() {
  cmake --workflow --preset firmware
}

step_socketcan() {
  # First, so that a machine without vcan0 says so in one sentence.
  tests/socketcan/with-can true &&
    cmake --preset host && cmake --build --preset host --target sim_host node_descriptions && ctest --preset host-socketcan
}

step_asan() {
  configure_build_test host-asan
}

step_coverage() {
  need_tool gcovr test || return
  # Counts of an earlier run would be added to those of this one.
  if [[ -d build/host-coverage ]]; then
    find build/host-coverage -name '*.gcda' -delete
  fi
  mkdir -p build/coverage
  local gcovr=(gcovr --root "$root" --filter 'firmware/' --exclude '.*/tests/') traces=(--add-tracefile build/coverage/coverage.json)
  configure_build_test host-coverage &&
    "${gcovr[@]}" --object-directory build/host-coverage --json build/coverage/coverage.json build/host-coverage &&
    "${gcovr[@]}" "${traces[@]}" --html-details build/coverage/index.html &&
    "${gcovr[@]}" "${traces[@]}" | tee build/coverage/lines.txt &&
    "${gcovr[@]}" "${traces[@]}" --branches --print-summary --fail-under-line 95 --fail-under-branch 90 |
    tee build/coverage/branches.txt
}

step_attack() {
  local first=$((5000 * seed_of_the_day + 1))
  echo "Seeds of the day: $first to $((first + 4999))"
  cmake --preset host && cmake --build --preset host --target sim_host &&
    build/host/bin/sim_host attack --seeds "$first-$((first + 4999))"
}

step_mutate() {
  tools/mutate --sample 60 --seed "$seed_of_the_day" --minimum 90
}

step_proofs() {
  tools/prove
}

step_fuzz() {
  tools/fuzz --short --seed "$seed_of_the_day"
}

step_cortex-m4() {
  configure_build_test cortex-m4-qemu && tests/cortex_m4/print_cost.sh
}

step_image() {
  cmake --workflow --preset stm32g474 && "$venv/bin/python" tools/image/loop_bounds.py &&
    "$venv/bin/python" -m pytest -q -p no:cacheprovider -n 2 tools/image/tests tools/registers/tests
}

# step_tidy's and step_lint's: clang-tidy with the commands of build/NAME on the sources that the regular expression
# PATTERN names; its findings go into build/clang-tidy.log.
tidy_of() {
  local name="$1" pattern="$2"
  shift 2
  cmake --preset "$name" >/dev/null &&
    run-clang-tidy -quiet -j "$(nproc)" -p "build/$name" "$@" "$pattern" >>build/clang-tidy.log 2>&1
}

print_tidy_findings() {
  sed 's/\x1b\[[0-9;]*m//g' build/clang-tidy.log | grep -E 'error:|Error' | sort -u | head -n 100
}

# For a regular expression.
escaped() {
  printf '%s' "$1" | sed 's/[][\.*^$+?(){}|]/\\&/g'
}

on_board=(-extra-arg=--target=arm-none-eabi -extra-arg=-isystem/usr/include/newlib)

step_tidy() {
  need_tool run-clang-tidy test || return
  local here failed=0
  here="$(escaped "$root")"
  : >build/clang-tidy.log
  mkdir -p build/host-tidy
  printf "InheritParentConfig: true\nChecks: '-bugprone-suspicious-include'\n" >build/host-tidy/.clang-tidy
  tidy_of host-tidy "^$here/(build/host-tidy/sim_host/.*Unity/|(firmware|hal|sim_host/emulator/(core|chip|board))/(?!.*tests/))" || failed=1
  tidy_of stm32g474 "^$here/hal/(chips/stm32g4|boards/nucleo_g474)/" "${on_board[@]}" || failed=1
  [[ $failed == 1 ]] || { echo "Nothing found." && return; }
  print_tidy_findings
  return 1
}

# The commit of the last full run that is committed, if this clone has it.
full_run_commit() {
  local commit
  commit="$(sed -n 's/^- Commit: \([0-9a-f]*\)$/\1/p' "$full_run_page" 2>/dev/null)"
  grep -q '^| tidy | [0-9]* | passed |$' "$full_run_page" 2>/dev/null && [[ -n "$commit" ]] && git cat-file -e "$commit^{commit}" 2>/dev/null && echo "$commit"
}

# Sources without tests that have changed since the commit BASE; for a header the one of its name, or else the first that
# includes it.
sources_to_lint() {
  local file source
  changed_files "$1" | grep -E '^(firmware|hal|sim_host)/.*\.(c|h|cpp|hpp)$' | grep -v /tests/ | while read -r file; do
    [[ -e "$file" ]] || continue
    case "$file" in
      *.c | *.cpp) echo "$file" ;;
      *)
        for source in "${file%.*}.c" "${file%.*}.cpp"; do
          [[ ! -e "$source" ]] || { echo "$source" && continue 2; }
        done
        # A header that only other headers or tests include gives none; that is no error.
        { grep -rlE "#include \"(.*/)?${file##*/}\"" --include='*.c' --include='*.cpp' firmware hal sim_host || true; } |
          sed '/\/tests\//d' | LC_ALL=C sort | sed -n 1p
        ;;
    esac
  done | LC_ALL=C sort -u
}

# The sources on standard input that changed last, COUNT of them at most.
newest_of() {
  local file
  while read -r file; do
    printf '%s %s\n' "$(git log -1 --format=%ct -- "$file")" "$file"
  done | LC_ALL=C sort -k1,1nr -k2 | sed -n "1,$1p" | cut -d' ' -f2-
}

# tidy_sources FILE...: clang-tidy on these sources, with the commands of the build that each belongs to.
tidy_sources() {
  local failed=0 all
  : >build/clang-tidy.log
  all="^$(escaped "$root")/($(for source in "$@"; do escaped "$source" && printf '|'; done))\$"
  all="${all/|)/)}"
  tidy_of host-lint "$all" || failed=1
  ! grep -qE "/hal/(chips|boards/nucleo)" <<<"$all" || tidy_of stm32g474 "$all" "${on_board[@]}" || failed=1
  [[ $failed == 1 ]] || { echo "Nothing found." && return; }
  print_tidy_findings
  return 1
}

step_reproducible() {
  cmake --workflow --preset stm32g474 && tools/image/compare-builds
}

# misra_changed BASE FILE...: MISRA on those of these sources that are the firmware's or the HAL's, or on all if its rules
# have changed since the commit BASE. What a rule sees in several files is left to the full run.
misra_changed() {
  local in_c=()
  if changed_files "$1" | grep '^tools/misra/' >/dev/null; then
    tools/misra/check firmware
    return
  fi
  mapfile -t in_c < <(printf '%s\n' "${@:2}" | grep -E '^(firmware|hal)/.*\.c$')
  [[ ${#in_c[@]} == 0 ]] || tools/misra/check files "${in_c[@]}"
}

# The full run and the step by name: MISRA on all sources; the step tidy has all of clang-tidy. The gate, which has little
# time, and --changed: what changed last since the last full run, or since the branch left its base.
step_lint() {
  need_tool run-clang-tidy test || return
  local base="" sources=() most=10
  if [[ "$run" == full ]]; then
    tools/misra/check firmware
    return
  fi
  if [[ "$run" == changed ]]; then base="$changed_since"; else base="$(full_run_commit)" || true; fi
  if [[ -z "$base" ]]; then
    echo "clang-tidy is left to the full run: this clone does not have the commit of a $full_run_page."
    tools/misra/check firmware
    return
  fi
  mapfile -t sources < <(sources_to_lint "$base" | newest_of "$most")
  echo "The ${#sources[@]} sources that changed last since ${base:0:8}, $most at most: ${sources[*]}"
  if [[ "$run" == steps ]]; then tools/misra/check firmware; else misra_changed "$base" "${sources[@]}"; fi || return
  [[ ${#sources[@]} == 0 ]] || tidy_sources "${sources[@]}"
}

# client_types SYSTEM: servoctl and imager use nothing that this system lacks, as far as types tell.
client_types() {
  local client
  for client in servoctl imager; do
    (cd "tools/$client" && "$venv/bin/python" -m mypy --platform "$1" --cache-dir "$root/build/mypy-$1-$client" "$client") || return
  done
}

# In a set-up of its own, because nothing else needs wheels.
step_release() {
  tools/setup release &&
    "$venv/bin/python" -m mypy --strict --cache-dir build/mypy-releasing --python-executable "$release_venv/bin/python" tools/releasing/*.py &&
    client_types win32 && client_types darwin &&
    "$venv/bin/python" -m pytest -q -p no:cacheprovider --durations=5 tools/releasing/tests tests/release
}

step_cppcheck() {
  tools/misra/check simulator
}

step_python() {
  PYTHONPATH=tools/report:tools/servoctl "$venv/bin/python" -m pytest -q -p no:cacheprovider -n 2 tools/report/tests tools/mutation/tests tests/readme tests/changed tests/demo tests/docs tests/fuzz tests/hooks
}

# What its test needs beside the gate's packages is installed here: the gate does without.
step_site() {
  tools/setup site && cmake --preset host && cmake --build --preset host --target sim_host identify &&
    "$venv/bin/python" -m pytest -q -p no:cacheprovider -n 2 --durations=5 tools/website/tests
}

step_readme() {
  local cache=()
  ! command -v ccache >/dev/null || cache=(--ccache "$(ccache --get-config cache_dir)")
  "$venv/bin/python" tests/readme/run_readme.py "${cache[@]}"
}

# client_tests CLIENT OPTION...: those of tools/CLIENT.
client_tests() {
  (cd "tools/$1" && "$venv/bin/python" -m pytest "@$root/tests/real_time.args" "${@:2}")
}

# servoctl_tests OPTION...: three at a time, of which one has the browser; most of them wait for a motion.
servoctl_tests() {
  client_tests servoctl -n 3 --dist loadgroup "$@"
}

# every_servoctl_test: those that measure a time to milliseconds last, without one beside them.
every_servoctl_test() {
  servoctl_tests -m "not alone" && client_tests servoctl -m alone
}

# build_clients_devices TARGET...: what the tests of the clients start, beside these targets.
build_clients_devices() {
  cmake --preset host &&
    cmake --build --preset host --target sim_host node_descriptions canopen_test_node print_test_eds identify "$@"
}

step_clients() {
  cmake --workflow --preset stm32g474 && build_clients_devices emulate_board &&
    servoctl_tests -m smoke && client_tests imager -m smoke &&
    SERVOCTL_TEST_DEVICE=image client_tests servoctl -m smoke_image && SERVOCTL_TEST_DEVICE=image client_tests imager -m smoke_image
}

step_servoctl() {
  build_clients_devices &&
    (cd tools/servoctl && "$venv/bin/python" -m mypy --cache-dir "$root/build/mypy") &&
    (cd tools/imager && "$venv/bin/python" -m mypy --cache-dir "$root/build/mypy-imager") &&
    every_servoctl_test && client_tests imager -n 2
}

step_servoctl-image() {
  cmake --workflow --preset stm32g474 && build_clients_devices emulate_board &&
    SERVOCTL_TEST_DEVICE=image every_servoctl_test && SERVOCTL_TEST_DEVICE=image client_tests imager -m smoke_image
}

step_check() {
  cmake --preset host &&
    cmake --build --preset host --target sim_host check_board check_wrong_observer node_descriptions &&
    cmake --preset stm32g474 && cmake --build --preset stm32g474 &&
    PYTHONPATH=tools/servoctl "$venv/bin/python" -m pytest -q -p no:cacheprovider -n 2 --dist loadgroup --durations=5 tests/gate -k "not container"
}
