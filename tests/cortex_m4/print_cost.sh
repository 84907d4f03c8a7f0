#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Prints the tables of instructions from the last run of the tests of preset cortex-m4-qemu.
set -euo pipefail
log=build/cortex-m4-qemu/Testing/Temporary/LastTest.log
grep -E '^instructions |^(speed loop|current loop|pointing|1 kHz task|deferred task)' "$log"
