# SPDX-License-Identifier: Apache-2.0
"""The examples of LIBRARY.md, run one after the other in one program, as a reader would in a notebook."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import pytest

import servoctl
from servoctl.show.recording import read

from .conftest import PACKAGE, ROOT, Bench
from .still_target import StillTarget

BLOCK = re.compile(r"^```python\n(.*?)^```$", re.MULTILINE | re.DOTALL)
FEWEST = 6


@pytest.mark.real_time
def test_the_examples_of_the_library_run(servo: Bench) -> None:
    """A camera sees a target near the angles of the cue."""
    blocks = BLOCK.findall((PACKAGE / "LIBRARY.md").read_text(encoding="utf-8"))
    assert len(blocks) >= FEWEST
    program = servo.folder / "examples.py"
    program.write_text("\n".join(blocks), encoding="utf-8")
    command = [sys.executable, str(program)]
    with StillTarget(servo.bus, 0x541, 0.8, 2.8):
        done = subprocess.run(command, cwd=servo.folder, env=servo.environment, text=True, capture_output=True, timeout=240)
    assert done.returncode == 0, done.stderr
    print(done.stdout)
    # a step, forward or backward: on a busy computer one of them may be disturbed
    for part in (
        "N m s/rad", "->", "on trial", "moved by 2.00", "samples, torque", "tracking ", "ward: overshoot", "phase margin",
        "limits met", "did you mean azimuth.speed_loop", "at most 57.29 °/s is allowed", "samples from", "experiments at",
    ):  # fmt: skip
        assert part in done.stdout, done.stdout
    assert servo.json("state", "azimuth")["axes"][0]["state"] == "switch on disabled"


def test_what_the_package_offers_is_imported_when_it_is_used_and_is_that_of_its_module() -> None:
    code = "import sys, servoctl; assert 'can' not in sys.modules; from servoctl import *; print(len(dir(servoctl)), Device.__module__, LiveAxis)"
    done = subprocess.run([sys.executable, "-c", code], cwd=PACKAGE, text=True, capture_output=True)
    assert done.returncode == 0 and "servoctl.link.device" in done.stdout, done.stderr
    assert servoctl.read_recording is read
    assert {getattr(servoctl, name).__name__ for name in servoctl.__all__} == {*servoctl.__all__, "read"} - {"read_recording"}
    with pytest.raises(AttributeError, match="no attribute 'Devise'"):
        servoctl.Devise  # noqa: B018


def test_the_examples_are_typed(tmp_path: Path) -> None:
    """As mypy sees them in somebody's project."""
    program = tmp_path / "examples.py"
    program.write_text("\n".join(BLOCK.findall((PACKAGE / "LIBRARY.md").read_text(encoding="utf-8"))), encoding="utf-8")
    command = [sys.executable, "-m", "mypy", "--cache-dir", str(ROOT / "build/mypy"), "--follow-imports=silent", str(program)]
    done = subprocess.run(command, cwd=PACKAGE, text=True, capture_output=True)
    assert done.returncode == 0, done.stdout
