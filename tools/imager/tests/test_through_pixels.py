# SPDX-License-Identifier: Apache-2.0
"""The whole path: rendered pictures, imager, CAN, node, simulated machine.

IMAGER_TEST_SECONDS sets how long the target is followed, IMAGER_TEST_SEEDS which seeds of the simulator's noise are run
("1 2 3 4 5"). The defaults keep the tests short. IMAGER_TEST_SPEED below 1 slows simulated time, for a computer that does
more than one thing: a delay of the computer then counts for less of the simulated time.
"""

from __future__ import annotations

import csv
import os
import re
import statistics
import subprocess
import sys
from pathlib import Path

import pytest
from servoctl.link.bus import parse_bus
from servoctl.link.device import Device
from servoctl.drive.drive import Drive

from .conftest import SCENARIO, Serving, environment, wait_until

SECONDS = float(os.environ.get("IMAGER_TEST_SECONDS", "8"))
SEEDS = [int(text) for text in os.environ.get("IMAGER_TEST_SEEDS", "1").split()]
SPEED = float(os.environ.get("IMAGER_TEST_SPEED", "0.5"))
SETTLING_S = 4.0
REQUIRED_URAD = 10.0
PP, TRACKING = 1, -1
SLEW_RAD_S = 0.3
ON_TARGET, COASTING = 3, 4
STANDS_STILL_MS = 40.0
"""A computer that delays a picture for longer does something else; the node then coasts for want of frames."""


def slew(device: Device, angles_rad: tuple[float, float]) -> None:
    """Both axes enabled, at these angles."""
    device.set_nmt("operational")
    drives = [Drive(device, axis) for axis in range(2)]
    for drive, angle_rad in zip(drives, angles_rad, strict=True):
        device.axis_write(drive.axis, 0x6007, 0, 2)  # a silent master stops nothing
        drive.set_mode(PP)
        drive.enable()
        drive.start_to(angle_rad, SLEW_RAD_S)
    for drive in drives:
        wait_until(lambda drive=drive: drive.statusword() & 0x400 != 0, 30.0 / SPEED)  # type: ignore[misc]


@pytest.mark.smoke
@pytest.mark.parametrize("seed", SEEDS)
def test_a_target_is_held_through_pixels(tmp_path: Path, seed: int) -> None:
    scenario = tmp_path / "flight.toml"
    scenario.write_text(SCENARIO.read_text().replace("duration_s = 45.0", "duration_s = 90.0"))
    truth = tmp_path / "truth.csv"
    options = ("--target", str(scenario), "--video", "pgm-tcp:0", "--truth", str(truth), "--seed", str(seed), "--speed", f"{SPEED:g}")
    with Serving(*options) as served, Device(parse_bus(served.bus), 1) as device:
        imager = subprocess.Popen(
            [sys.executable, "-m", "imager", served.video, "--bus", served.bus],
            env=environment(tmp_path), cwd=tmp_path, text=True, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
        )  # fmt: skip
        try:
            slew(device, (0.0141, 0.0492))
            for axis in range(2):
                device.axis_write(axis, 0x6060, TRACKING, 1)
            wait_until(lambda: [device.read_int(0x3072, sub) for sub in (5, 6)] == [ON_TARGET] * 2, 30.0 / SPEED)
            start_ticks = device.read_int(0x3010, 1)
            states: set[int] = set()

            def flown() -> bool:
                states.update(device.read_int(0x3072, sub) for sub in (5, 6))
                return device.read_int(0x3010, 1) - start_ticks > 1000 * SECONDS

            wait_until(flown, 5.0 * SECONDS / SPEED)
            for axis in range(2):
                device.axis_write(axis, 0x6040, 0, 2)
        finally:
            imager.terminate()
            out, err = imager.communicate(timeout=20)
    print(out)
    assert imager.returncode == 0 and err == ""
    with truth.open() as file:
        rows = [row for row in csv.DictReader(file) if SETTLING_S < float(row["flight_s"]) < SECONDS]
    assert len(rows) > 900 * (SECONDS - SETTLING_S)
    sigmas = [
        statistics.pstdev(float(row[f"{name}_error_urad"]) for row in rows) for name in ("cross_elevation", "elevation")
    ]
    noise = re.search(r"centroid noise [\d.]+ pixels = ([\d.]+) µrad", out)
    lost = re.search(r"lost (\d+) times", out)
    assert noise is not None and lost is not None
    print(
        f"seed {seed}: true error of the line of sight, 1σ: {sigmas[0]:.2f} and {sigmas[1]:.2f} µrad;"
        f" lost {lost.group(1)} times; centroid noise {noise.group(1)} µrad"
    )
    longest = re.search(r"delay, .* maximum ([\d.]+) ms", out)
    assert longest is not None
    stood_still = float(longest.group(1)) > STANDS_STILL_MS
    assert states <= ({ON_TARGET, COASTING} if stood_still else {ON_TARGET}), "the node coasted, or lost the target"
    assert stood_still or int(lost.group(1)) == 0
    assert max(sigmas) < REQUIRED_URAD
    frames = re.search(r"frames: (\d+) sent, (\d+) taken and (\d+) dropped", out)
    assert frames is not None
    sent, taken, dropped = (int(text) for text in frames.groups())
    assert dropped <= (0.05 if stood_still else 0.0) * sent
    assert taken >= 0.9 * sent  # none before the node is operational
