# SPDX-License-Identifier: Apache-2.0
# shellcheck shell=bash
# The checks of source text: tools/test runs them on all files, the hooks of .pre-commit-config.yaml on changed files.
# Sourced after common.sh; the working folder is the project's.
# shellcheck disable=SC2154

our_sources() {
  find firmware hal sim_host tests tools -type f \( -name '*.c' -o -name '*.h' -o -name '*.cpp' -o -name '*.hpp' \)
}

# Executables and *.sh whose first line names a shell.
our_scripts() {
  find .ci firmware hal sim_host tests tools -type f \( -name '*.sh' -o -perm -u+x \) ! -path '*/build/*' -exec \
    awk 'FNR <= 2 && /^#( shellcheck shell=|!.*sh$)/ { print FILENAME; nextfile } FNR > 2 { nextfile }' {} +
}

# check_format FILE...: clang-format finds nothing to change in these C and C++ files.
check_format() {
  local found
  need_tool "$venv/bin/clang-format" test || return
  if found="$("$venv/bin/clang-format" --dry-run --Werror "$@" 2>&1)"; then
    echo "$# files are formatted."
  else
    echo "To be formatted, with build/venv/bin/clang-format -i:"
    sed -n 's/:[0-9]*:[0-9]*: error: .*//p' <<<"$found" | sort -u
    return 1
  fi
}

# check_scripts FILE...: shellcheck finds nothing in these shell scripts.
check_scripts() {
  need_tool shellcheck test || return
  shellcheck --external-sources "$@" && echo "Nothing found in $# scripts."
}
