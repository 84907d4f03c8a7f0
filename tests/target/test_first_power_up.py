# SPDX-License-Identifier: Apache-2.0
"""The first power-up of docs/board.md, executed as written: its commands are read from the page and given to servoctl,
which talks to the board's image on the emulated board, with the machine that the page describes."""

import math
import os
import pathlib
import shlex
import subprocess
import sys

import pytest

PROJECT = pathlib.Path(__file__).resolve().parents[2]
PROGRAM = os.environ["EMULATE_BOARD"]
IMAGE = os.environ["TARGET_IMAGE"]
BENCH = ("--plant", str(PROJECT / "sim_host/plants/bench_motor.toml"),
         "--without", "azimuth-gyro,pitch-gyro,pitch-encoder")


def steps():
    """Number of a step and its commands, in order."""
    page = (PROJECT / "docs/board.md").read_text().split("## First power-up")[1].split("\n## ")[0]
    number, inside, found = 0, False, {}
    for line in page.splitlines():
        head = line.split(". ")[0]
        if head.isdigit():
            number = int(head)
        if line.strip().startswith("```"):
            inside = line.strip() == "```sh"
        elif inside and line.strip():
            found.setdefault(number, []).append(line.strip())
    return found


@pytest.fixture
def servoctl(tmp_path):
    board = subprocess.Popen([PROGRAM, IMAGE, *BENCH, "--bus", "slcan-tcp:0", "--until-stdin-ends"],
                             stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
    address = board.stdout.readline().strip()
    environment = {**os.environ, "SERVOCTL_BUS": address, "SERVOCTL_STATE": str(tmp_path),
                   "PYTHONPATH": str(PROJECT / "tools/servoctl")}

    def run(*words):
        return subprocess.run([sys.executable, "-m", "servoctl", *words], env=environment, capture_output=True,
                              text=True, timeout=240)

    yield run
    board.stdin.close()
    assert board.wait(timeout=60) == 0, "the image broke a rule of the chip"


def angle_deg(servoctl):
    """6064, in 1e-7 rad."""
    shown = servoctl("get", "azimuth.position_actual_value").stdout
    return math.degrees(1e-7 * float(shown.split("=")[1].split()[0]))


def test_the_page_has_the_steps_that_can_be_executed():
    found = steps()
    assert sorted(found) == [3, 4, 5, 10]
    assert all(line.startswith("servoctl ") for lines in found.values() for line in lines)


def test_the_first_power_up_is_carried_out_as_written(servoctl):
    angles = []
    for number, lines in sorted(steps().items()):
        for line in lines:
            if number == 10:
                angles.append(angle_deg(servoctl))
            done = servoctl(*shlex.split(line)[1:])
            assert done.returncode == 0, (number, line, done.stdout, done.stderr)
            if line == "servoctl state":
                assert "7310" in done.stdout and "7320" in done.stdout, done.stdout
            if line == "servoctl state azimuth reset":
                assert "fault" not in servoctl("state", "azimuth").stdout
    angles.append(angle_deg(servoctl))
    assert [there - here for here, there in zip(angles, angles[1:])] == pytest.approx([10.0, -10.0], abs=0.1), angles
    assert "fault" not in servoctl("state", "azimuth").stdout


def test_at_24_v_nothing_switches_on_before_step_5(servoctl):
    """2060:15 is 36 V at first: the page states it, and the resulting state."""
    for line in steps()[4]:
        assert servoctl(*shlex.split(line)[1:]).returncode == 0
    refused = servoctl("move", "azimuth", "--by", "1", "--yes")
    assert refused.returncode != 0 and "ready to switch on" in refused.stderr, refused
