# SPDX-License-Identifier: Apache-2.0
"""The pictures of `sim_host serve --video`: numbers, times, and that simulated time does not wait for their reader."""

from __future__ import annotations

import socket
import subprocess
from pathlib import Path

import pytest
from servoctl.link.bus import parse_bus
from servoctl.link.device import Device

from imager.sources import PgmSource

from .conftest import SCENARIO, SIM_HOST, Serving, wait_until

UNREAD_MS = 3000
"""The pictures of this time fill every buffer between sender and reader."""
VIDEO = ("--target", str(SCENARIO), "--video", "pgm-tcp:0")


def end_of(served: Serving) -> tuple[str, int]:
    kind, host, port = served.video.split(":")
    assert kind == "pgm-tcp"
    return host, int(port)


def test_each_picture_has_its_number_and_its_time() -> None:
    with Serving(*VIDEO) as served:
        source = PgmSource(*end_of(served))
        pictures = [source.read() for _ in range(10)]
        source.close()
    numbers = []
    for picture in pictures:
        assert picture is not None
        assert picture.exposed_s == pytest.approx(0.020 * picture.number, abs=1e-6)
        assert picture.grey.shape == (480, 640)
        numbers.append(picture.number)
    assert numbers == sorted(set(numbers))


def test_simulated_time_does_not_wait_for_a_reader(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("XDG_RUNTIME_DIR", str(tmp_path))
    with Serving(*VIDEO) as served, Device(parse_bus(served.bus), 1) as device:
        with socket.create_connection(end_of(served)):  # reads nothing
            start = device.read_int(0x3010, 1)
            wait_until(lambda: device.read_int(0x3010, 1) - start >= UNREAD_MS, 30.0)
        source = PgmSource(*end_of(served))  # a new reader replaces it, and gets new pictures
        for _ in range(3):
            picture = source.read()
        assert picture is not None and picture.exposed_s > 1e-3 * start
        source.close()


def test_the_end_of_the_simulator_ends_the_pictures() -> None:
    with Serving(*VIDEO) as served:
        source = PgmSource(*end_of(served))
        assert source.read() is not None
    while source.read() is not None:
        pass


@pytest.mark.parametrize("address", ["pgm-tcp", "pgm-tcp:70000", "rtsp://0", "29537"])
def test_a_wrong_address_is_refused(address: str) -> None:
    done = subprocess.run(
        [SIM_HOST, "serve", "--target", str(SCENARIO), "--video", address], stdin=subprocess.DEVNULL,
        capture_output=True, text=True, timeout=20,
    )  # fmt: skip
    assert done.returncode == 2
    assert f"--video {address}: expected pgm-tcp:PORT" in done.stderr
