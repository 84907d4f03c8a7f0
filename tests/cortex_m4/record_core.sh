#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Usage: record_core.sh FOLDER
# Builds the host's record_core when it is out of date, and lets it write the traces into FOLDER.
set -euo pipefail
[[ -f build/host/build.ninja ]] || cmake --preset host
cmake --build --preset host --target record_core
build/host/bin/record_core "$1"
