# SPDX-License-Identifier: Apache-2.0
# shellcheck shell=bash
# What setup, demo and test share: where things are, and how they speak and fail.

root="$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)"
build="$root/build"
# shellcheck disable=SC2034  # used by the scripts that source this file
venv="$build/venv" release_venv="$build/release-venv"

headline() {
  if [[ -t 1 ]]; then
    printf '\n\033[1m== %s\033[0m\n' "$*"
  else
    printf '\n== %s\n' "$*"
  fi
}

die() {
  printf '%s: %s\n' "${0##*/}" "$*" >&2
  exit 1
}

# need_tool COMMAND MODE: whether there is such a command; if not, says that tools/setup MODE installs it.
need_tool() {
  command -v "$1" >/dev/null && return
  printf '%s: %s is missing: ./tools/setup %s installs it.\n' "${0##*/}" "${1##*/}" "$2" >&2
  return 1
}

# Where Unity is: the user's own copy (UNITY_DIR), or else the one that tools/setup brings. UNITY_DIR becomes an absolute
# path here, because scripts change the folder.
if [[ -n "${UNITY_DIR:-}" ]]; then
  UNITY_DIR="$(realpath --canonicalize-missing -- "$UNITY_DIR")"
  export UNITY_DIR
fi
unity_dir="${UNITY_DIR:-$root/third_party/unity}"

unity_present() {
  [[ -f "$unity_dir/unity.c" || -f "$unity_dir/src/unity.c" ]]
}
