# shellcheck shell=bash
# What setup, demo and test share: where things are, and how they speak and fail.

root="$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)"
build="$root/build"
# shellcheck disable=SC2034  # used by the scripts that source this file
venv="$build/venv"

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

# Unity as tools/setup laid it, or the user's own copy.
unity_present() {
  [[ -n "${UNITY_DIR:-}" || -f "$root/third_party/unity/unity.c" ]]
}
