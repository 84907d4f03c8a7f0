# SPDX-License-Identifier: Apache-2.0
# shellcheck shell=bash
# Brings what others say about the board's chip to third_party/stm32g4, for the check of our register definitions: the
# SVD-derived registers of the crate stm32g4, pins and DMA requests of stm32g4xx-hal, the core's registers of cortex-m.
# Text that tests read; nothing of it is compiled. Accepted only if all files together have the SHA-256 in
# stm32g4.sha256. Sourced by tools/setup after common.sh; expects log.
# shellcheck disable=SC2154

stm32g4_dir="$root/third_party/stm32g4"
stm32g4_hash="$root/tools/lib/stm32g4.sha256"

# One number for a folder: of the names and contents of its files.
stm32g4_hash_of() {
  (cd "$1" && find . -type f -print0 | LC_ALL=C sort -z | xargs -0 sha256sum | sha256sum | cut -d ' ' -f 1)
}

stm32g4_has_right_files() {
  [[ -d "$1" && "$(stm32g4_hash_of "$1")" == "$(cat "$stm32g4_hash")" ]]
}

# $1: a scratch folder.
stm32g4_download() {
  mkdir -p "$1/project"
  cat >"$1/project/Cargo.toml" <<'TOML'
[package]
name = "registers"
version = "0.0.0"
edition = "2021"
[lib]
path = "lib.rs"
[dependencies]
cortex-m = "=0.7.7"
stm32g4 = "=0.16.0"
stm32g4xx-hal = { version = "=0.1.0", default-features = false }
TOML
  touch "$1/project/lib.rs"
  (cd "$1/project" && cargo vendor --quiet --versioned-dirs "$1/crates" >/dev/null)
}

# $1: the scratch folder. Of each crate the few files that are read.
stm32g4_select() {
  local crates="$1/crates" chosen="$1/chosen"
  mkdir -p "$chosen/core" "$chosen/pins"
  cp -r "$crates/stm32g4-0.16.0/src/stm32g474" "$chosen/registers" || return 1
  cp "$crates"/cortex-m-0.7.7/src/peripheral/{dcb,dwt,mod,mpu,nvic,scb}.rs "$chosen/core/" || return 1
  cp "$crates"/stm32g4xx-hal-0.1.0/src/{can,pwm,spi}.rs "$crates/stm32g4xx-hal-0.1.0/src/serial/usart.rs" \
    "$crates/stm32g4xx-hal-0.1.0/src/adc/g4.rs" "$crates/stm32g4xx-hal-0.1.0/src/dma/mux.rs" "$chosen/pins/"
}

stm32g4_install() {
  local scratch
  scratch="$(mktemp -d "$build/stm32g4.XXXXXX")"
  if ! { stm32g4_download "$scratch" && stm32g4_select "$scratch"; } >>"$log" 2>&1; then
    rm -rf "$scratch"
    die "could not get the crates stm32g4, stm32g4xx-hal and cortex-m with cargo (log: $log)."
  fi
  if ! stm32g4_has_right_files "$scratch/chosen"; then
    rm -rf "$scratch"
    die "the crates stm32g4, stm32g4xx-hal and cortex-m are not the pinned ones (tools/lib/stm32g4.sha256)."
  fi
  rm -rf "$stm32g4_dir"
  mkdir -p "$(dirname "$stm32g4_dir")"
  mv "$scratch/chosen" "$stm32g4_dir"
  rm -rf "$scratch"
}
