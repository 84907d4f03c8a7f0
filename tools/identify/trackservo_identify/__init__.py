# SPDX-License-Identifier: Apache-2.0
"""The program `identify` of trackservo (sim_host/commands/identify.cpp) for `servoctl identify` and `servoctl tune`, which run
it outside a checkout: friction and plant of an axis from recorded runs, and gains from them."""

from __future__ import annotations

from pathlib import Path

__all__ = ["PROGRAM", "__version__"]

_HERE = Path(__file__).resolve().parent

__version__ = (_HERE / "version.txt").read_text(encoding="ascii").strip()
"""That of the program: project(VERSION) of CMakeLists.txt."""

PROGRAM = _HERE / "identify"
"""tools/release puts it there; a checkout has none."""
