# SPDX-License-Identifier: Apache-2.0
# shellcheck shell=bash
# What has been compiled before, in this folder or in another clone, is not compiled again. Sourced after common.sh.
# shellcheck disable=SC2154

# Sets for CMake and ccache what they need, if ccache is there. Paths inside the project count relative to it.
# CCACHE_DEPEND stays off: with it ccache would not see through the files that CMake writes to join others and to compile
# headers beforehand, which name the project by its whole path.
use_compiler_cache() {
  local folder probe
  command -v ccache >/dev/null || return 0
  export CMAKE_C_COMPILER_LAUNCHER=ccache CMAKE_CXX_COMPILER_LAUNCHER=ccache
  # What ccache asks of who compiles headers beforehand.
  export CCACHE_SLOPPINESS=pch_defines,time_macros
  export CCACHE_BASEDIR="$root" CCACHE_NOHASHDIR=1 CCACHE_MAXSIZE="${CCACHE_MAXSIZE:-10G}"
  folder="$(ccache --get-config cache_dir)"
  if ! { mkdir -p "$folder" && probe="$(mktemp -p "$folder")" && head -c 1000000 /dev/zero >"$probe" && rm "$probe"; } 2>/dev/null; then
    rm -f "${probe:-}"
    echo "The compiler cache in $folder cannot be written: compiling without it. CCACHE_DIR names another folder."
    export CCACHE_DISABLE=1
  fi
}
