# SPDX-License-Identifier: Apache-2.0
# shellcheck shell=bash
# Brings uPlot, the plot library of servoctl's page, to third_party/uplot with npm, or from UPLOT_DIR, and from there into
# servoctl's package, so that the page fetches nothing. Accepted only if the package has the SHA-512 below and its files those in uplot.sha256.
# Sourced by tools/setup after common.sh; expects log.
# shellcheck disable=SC2154

uplot_version=1.6.32
uplot_sha512=2883159c6ebccefbb95d751b0b82d010f9e1c0ec41b8bc96d401eda66e882935c89a46cb824332fa369b8cb8122cc6ac36e186cd09bf7a9ded3a4c93c6989023
uplot_dir="$root/third_party/uplot"
uplot_hashes="$root/tools/lib/uplot.sha256"
uplot_page="$root/tools/servoctl/servoctl/ui/page/uplot"

uplot_has_right_files() {
  [[ -d "$1" ]] && (cd "$1" && sha256sum --check --status "$uplot_hashes" 2>/dev/null)
}

# Whether uPlot must be fetched.
uplot_missing() {
  ! uplot_has_right_files "$uplot_dir"
}

uplot_packed() {
  uplot_has_right_files "$uplot_page"
}

# $1: a scratch folder.
uplot_download() {
  (cd "$1" && npm pack --silent "uplot@$uplot_version") || return 1
  echo "$uplot_sha512  $1/uplot-$uplot_version.tgz" | sha512sum --check --status || return 1
  tar -xzf "$1/uplot-$uplot_version.tgz" -C "$1" --strip-components=1 package/LICENSE package/dist || return 1
  mv "$1"/dist/* "$1"
}

uplot_install() {
  local scratch
  if [[ -n "${UPLOT_DIR:-}" ]]; then
    uplot_has_right_files "$UPLOT_DIR" || die "UPLOT_DIR ($UPLOT_DIR) does not have the files of uPlot $uplot_version:" \
      "LICENSE, uPlot.esm.js and uPlot.min.css."
    uplot_copy "$UPLOT_DIR" "$uplot_dir"
    return
  fi
  scratch="$(mktemp -d "$build/uplot.XXXXXX")"
  if ! { uplot_download "$scratch" >>"$log" 2>&1 && uplot_has_right_files "$scratch"; }; then
    rm -rf "$scratch"
    die "could not get uPlot $uplot_version with npm, or it is not the pinned one (log: $log)."
  fi
  uplot_copy "$scratch" "$uplot_dir"
  rm -rf "$scratch"
}

# Into the package, without a download.
uplot_pack() {
  uplot_copy "$uplot_dir" "$uplot_page"
}

uplot_copy() {
  local file
  mkdir -p "$2"
  while read -r _ file; do
    cp "$1/$file" "$2/$file"
  done <"$uplot_hashes"
}
