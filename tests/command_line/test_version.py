# SPDX-License-Identifier: Apache-2.0
"""One version number: that of CMakeLists.txt. Programs state it, and the objects of the device that do. The test `descriptions`
compares the packages' version.txt; the image's version block is in tools/image/tests/test_image.py."""

import pathlib
import re
import subprocess
import sys

import pytest
from programs import PROGRAMS, PROJECT

STATED = re.search(r"^  VERSION (\d+\.\d+\.\d+)$", (PROJECT / "CMakeLists.txt").read_text("utf-8"), re.MULTILINE)[1]
BOARD = pathlib.Path(PROGRAMS["sim_host"]).with_name("emulate_board")
COMMANDS = {
    **{name: [program] for name, program in PROGRAMS.items()},
    "emulate_board": [str(BOARD)],
    "servoctl": [sys.executable, "-m", "servoctl"],
    "imager": [sys.executable, "-m", "imager"],
}


@pytest.mark.parametrize("name", COMMANDS)
def test_every_program_states_the_version(name):
    done = subprocess.run([*COMMANDS[name], "--version"], capture_output=True, text=True, timeout=60)
    assert (done.returncode, done.stdout, done.stderr) == (0, f"{name} {STATED}\n", "")


@pytest.mark.parametrize("place", ["100A | 0", "3030 | 1"])
def test_the_device_states_the_version(place):
    """The page is printed by the build (test `descriptions`)."""
    rows = [line for line in (PROJECT / "docs/can-objects.md").read_text("utf-8").splitlines() if line.startswith(f"| {place} |")]
    assert len(rows) == 1 and f'| "{STATED}" |' in rows[0]
