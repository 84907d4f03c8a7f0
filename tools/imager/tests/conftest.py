# SPDX-License-Identifier: Apache-2.0
"""The programs under test, and a served servo.

SERVOCTL_TEST_DEVICE selects the servo as for the tests of servoctl: `sim`, or `image` for the tests that are marked
smoke_image; all others need pictures, which only the simulator renders. SIM_HOST, EMULATE_BOARD, TARGET_IMAGE and
NODE_DESCRIPTIONS name the built programs and files; without them those of build are used.
"""

from __future__ import annotations

import os
import subprocess
import sys
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

PACKAGE = Path(__file__).resolve().parents[1]
ROOT = PACKAGE.parents[1]
SIM_HOST = os.environ.get("SIM_HOST", str(ROOT / "build/host/bin/sim_host"))
DESCRIPTIONS = Path(os.environ.get("NODE_DESCRIPTIONS", str(ROOT / "build/host/share/trackservo")))
SERVERS = {
    "sim": [SIM_HOST, "serve"],
    "image": [
        os.environ.get("EMULATE_BOARD", str(ROOT / "build/host/bin/emulate_board")),
        os.environ.get("TARGET_IMAGE", str(ROOT / "build/stm32g474/bin/trackservo.bin")),
    ],
}
SERVER = SERVERS[os.environ.get("SERVOCTL_TEST_DEVICE", "sim")]
SCENARIO = ROOT / "sim_host/scenarios/tracking.toml"


def environment(folder: Path) -> dict[str, str]:
    """Of the imager as a program; other tests on this computer keep their locks separate."""
    paths = os.pathsep.join((str(PACKAGE), str(ROOT / "tools/servoctl")))
    ours = {name: value for name, value in os.environ.items() if not name.startswith("OPENCV_")}
    return {**ours, "PYTHONPATH": paths, "XDG_RUNTIME_DIR": str(folder), "XDG_CACHE_HOME": str(folder)}


@dataclass(frozen=True)
class Result:
    """Of a run of the imager."""

    code: int
    out: str
    err: str


def run_imager(folder: Path, *arguments: str, timeout: float = 60.0) -> Result:
    """From start to end."""
    done = subprocess.run(
        [sys.executable, "-m", "imager", *arguments], cwd=folder, env=environment(folder), text=True, timeout=timeout,
        stdin=subprocess.DEVNULL, capture_output=True,
    )  # fmt: skip
    return Result(done.returncode, done.stdout, done.stderr)


def wait_until(condition: Callable[[], bool], seconds: float = 10.0) -> None:
    """And no longer."""
    end = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < end, f"not within {seconds} s"
        time.sleep(0.02)


class Serving:
    """A servo with these options, until the end of the `with` block."""

    def __init__(self, *options: str) -> None:
        self.process = subprocess.Popen(
            [*SERVER, "--until-stdin-ends", "--bus", "slcan-tcp:0", *options],
            stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True,
        )  # fmt: skip
        self.lines: list[str] = []

    def __enter__(self) -> Serving:
        assert self.process.stdout is not None
        for line in self.process.stdout:
            if line == "ready\n":
                return self
            self.lines.append(line.strip())
        raise AssertionError(f"{SERVER} has ended: {self.lines}")

    def __exit__(self, *_: object) -> None:
        assert self.process.stdin is not None
        self.process.stdin.close()
        assert self.process.wait(timeout=20) == 0

    @property
    def bus(self) -> str:
        return self.lines[0]

    @property
    def video(self) -> str:
        return self.lines[1]
