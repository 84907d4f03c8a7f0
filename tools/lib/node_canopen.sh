# SPDX-License-Identifier: Apache-2.0
# shellcheck shell=bash
# Brings node-canopen (npm: canopen) and ini, which it needs, to third_party/node_canopen with npm: a client of another
# project, for a test. Accepted only with the SHA-512 below. node-crc, which it needs for block transfers, is native code
# and left out. Sourced by tools/setup after common.sh; expects log.
# shellcheck disable=SC2154

node_canopen_dir="$root/third_party/node_canopen"
node_canopen_packages=(canopen ini)
node_canopen_versions=(6.2.1 3.0.1)
node_canopen_sha512=(
  68a9278d8d4978044acc882782b994e719f8fa8fd66585b9902ec5c4b81364f39979fe9ac4d0265efa865107849a44754af5161f0adac30e802dedfc7c35fd38
  8ade07c950144ca05cea6f1ed625d6bd7493767745ec76dd37bd77fa4bcbaf29b14da538014056ac9e2f128a0ff95edf7b19d50f72ca701b218c618f79f48c51
)

# Whether the archives in a folder are the pinned ones.
node_canopen_is_pinned() {
  local i
  for i in "${!node_canopen_packages[@]}"; do
    echo "${node_canopen_sha512[$i]}  $1/${node_canopen_packages[$i]}-${node_canopen_versions[$i]}.tgz" |
      sha512sum --check --status 2>/dev/null || return 1
  done
}

# Whether node-canopen must be fetched.
node_canopen_missing() {
  ! { [[ -f "$node_canopen_dir/node_modules/canopen/package.json" ]] && node_canopen_is_pinned "$node_canopen_dir"; }
}

# $1: a scratch folder.
node_canopen_download() {
  local i folder
  for i in "${!node_canopen_packages[@]}"; do
    (cd "$1" && npm pack --silent "${node_canopen_packages[$i]}@${node_canopen_versions[$i]}") || return 1
  done
  node_canopen_is_pinned "$1" || return 1
  for i in "${!node_canopen_packages[@]}"; do
    folder="$1/node_modules/${node_canopen_packages[$i]}"
    mkdir -p "$folder"
    tar -xzf "$1/${node_canopen_packages[$i]}-${node_canopen_versions[$i]}.tgz" -C "$folder" --strip-components=1 || return 1
  done
}

node_canopen_install() {
  local scratch
  scratch="$(mktemp -d "$build/node_canopen.XXXXXX")"
  if ! node_canopen_download "$scratch" >>"$log" 2>&1; then
    rm -rf "$scratch"
    die "could not get node-canopen with npm, or it is not the pinned one (log: $log)."
  fi
  rm -rf "$node_canopen_dir"
  mkdir -p "$(dirname "$node_canopen_dir")"
  chmod 755 "$scratch"
  mv "$scratch" "$node_canopen_dir"
}
