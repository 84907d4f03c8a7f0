# SPDX-License-Identifier: Apache-2.0
# shellcheck shell=bash
# Brings Unity, the C test framework, to third_party/unity unless UNITY_DIR names another copy. It is taken from the source package of the machine's own
# distribution that carries it, and accepted only if every file has the SHA-256 in unity.sha256.
# Sourced by tools/setup after common.sh; expects log.
# shellcheck disable=SC2154

unity_hashes="$root/tools/lib/unity.sha256"
unity_package=ntpsec
unity_folder=tests/unity

unity_has_right_files() {
  [[ -d "$1" ]] && (cd "$1" && sha256sum --check --status "$unity_hashes" 2>/dev/null)
}

# Whether Unity must be installed. A copy that the user gives is used as it is.
unity_missing() {
  if [[ -n "${UNITY_DIR:-}" ]]; then
    unity_present || die "there is no unity.c in UNITY_DIR ($UNITY_DIR): give the folder of Unity's unity.c and unity.h," \
      "or unset UNITY_DIR."
    return 1
  fi
  ! unity_has_right_files "$unity_dir"
}

# The archives of the distribution itself, so that other vendors' archives are not queried for its sources.
unity_distribution_uris() {
  local names
  # shellcheck disable=SC1091
  names="$(. /etc/os-release && echo "${ID:-} ${ID_LIKE:-}")"
  # shellcheck disable=SC2016  # apt expands these, not the shell
  apt-get indextargets --format '$(ORIGIN) $(REPO_URI)' 'Created-By: Packages' 2>/dev/null |
    awk -v names="$names" '
      BEGIN { count = split(tolower(names), name, " ") }
      { for (i = 1; i <= count; i++) if (tolower($1) == name[i]) print $2 }' | sort -u
}

# $1: folder for the entries; the machine's own configuration is only read.
unity_write_source_entries() {
  local uris file number=0
  uris="$(unity_distribution_uris)"
  for file in /etc/apt/sources.list /etc/apt/sources.list.d/*.list; do
    [[ -f "$file" ]] || continue
    number=$((number + 1))
    awk -v format=list -v distribution_uris="$uris" -f "$root/tools/lib/source_entries.awk" "$file" \
      >"$1/$number.list"
  done
  for file in /etc/apt/sources.list.d/*.sources; do
    [[ -f "$file" ]] || continue
    number=$((number + 1))
    awk -v RS= -v format=sources -v distribution_uris="$uris" -f "$root/tools/lib/source_entries.awk" "$file" \
      >"$1/$number.sources"
  done
  find "$1" -type f -empty -delete
  [[ -n "$(ls "$1")" ]]
}

# $1: a scratch folder. apt works in it alone: its own entries, lists and caches, as the present user.
unity_download() {
  local apt=(apt-get -q
    -o "Dir::Etc::sourcelist=/dev/null" -o "Dir::Etc::sourceparts=$1/entries"
    -o "Dir::State::lists=$1/lists" -o "Dir::Cache=$1/cache" -o "APT::Sandbox::User=$(id -un)")
  mkdir -p "$1/entries" "$1/lists/partial" "$1/cache/archives/partial" "$1/source" "$1/unpacked"
  unity_write_source_entries "$1/entries" || return 1
  # An archive without sources is no reason to give up: the download shows whether the others have them.
  "${apt[@]}" update || true
  (cd "$1/source" && "${apt[@]}" source --download-only --tar-only "$unity_package") || return 1
  local tarballs=("$1"/source/*.tar.*)
  tar -xf "${tarballs[0]}" -C "$1/unpacked" --strip-components=1 --wildcards "*/$unity_folder/*"
}

unity_install() {
  local scratch
  scratch="$(mktemp -d "$build/unity.XXXXXX")"
  if ! unity_download "$scratch" >>"$log" 2>&1; then
    rm -rf "$scratch"
    die "could not get the source package '$unity_package', which carries Unity: give your own copy with the" \
      "environment variable UNITY_DIR (log: $log)."
  fi
  if ! unity_has_right_files "$scratch/unpacked/$unity_folder"; then
    rm -rf "$scratch"
    die "the Unity in this distribution's '$unity_package' is not the pinned one (tools/lib/unity.sha256): give" \
      "your own copy with the environment variable UNITY_DIR."
  fi
  local file
  mkdir -p "$unity_dir"
  while read -r _ file; do
    cp "$scratch/unpacked/$unity_folder/$file" "$unity_dir/$file"
  done <"$unity_hashes"
  rm -rf "$scratch"
}
