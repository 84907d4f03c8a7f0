# SPDX-License-Identifier: Apache-2.0
"""What the imager sends, as the node understands it: by the dictionary that its build describes, and by the node."""

from __future__ import annotations

import json
import struct
import time
from pathlib import Path

import can
import pytest
from servoctl.link.bus import open_bus, parse_bus
from servoctl.link.device import Device
from servoctl.motion.tracking import FRAME

from imager.camera_frame import AGE, CAMERA_ID, NODE_CLOCK, STROBE, TIME_KIND, TIME_S, FrameSender, Result

from .conftest import DESCRIPTIONS, SCENARIO, Serving, run_imager, wait_until

FORMATS = {"INTEGER16": "h", "UNSIGNED16": "H", "UNSIGNED8": "B"}


def described() -> dict[tuple[int, int], dict[str, object]]:
    """The objects of parameters.json by index and sub-index."""
    entries = json.loads((DESCRIPTIONS / "parameters.json").read_text())["objects"]
    return {(entry["index"], entry["sub"]): entry for entry in entries}


def test_the_mapping_is_that_of_the_nodes_dictionary() -> None:
    objects = described()
    names, bits = [], 0
    for mapped in FRAME:
        entry = objects[mapped >> 16, mapped >> 8 & 0xFF]
        assert struct.calcsize(FORMATS[str(entry["type"])]) * 8 == mapped & 0xFF
        names.append(str(entry["name"]))
        bits += mapped & 0xFF
    assert bits == 64
    assert names == [f"Camera {what}" for what in ("error x", "error y", "exposure", "quality", "frame counter")]


@pytest.mark.smoke_image
def test_the_node_takes_the_frames_and_afterwards_its_rpdo_is_as_before(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("XDG_RUNTIME_DIR", str(tmp_path))
    with Serving() as served, Device(parse_bus(served.bus), 1) as device:
        device.set_nmt("operational")
        device.write_int(*TIME_KIND, STROBE, 1)
        before = [device.upload(*where) for where in ((0x1403, 1), (0x1603, 0), (0x1603, 1), (0x3071, 5))]
        with FrameSender(device, AGE) as sender, open_bus(parse_bus(served.bus)) as listener:
            assert device.read_int(*TIME_KIND) == STROBE + AGE  # the camera's strobe stays in use
            sender.send(Result(-123e-6, 456e-6, 0.0321, 88))
            frame = next(message for message in iter(lambda: listener.recv(5.0), None) if _is_ours(message))
            assert bytes(frame.data) == struct.pack("<hhHBB", -123, 456, 3210, 88, 1)
            wait_until(lambda: sender.report().taken == 1)
            taken = [device.read_int(mapped >> 16, mapped >> 8 & 0xFF, signed=i < 2) for i, mapped in enumerate(FRAME)]
            assert taken == [-123, 456, 3210, 88, 1]
            report = sender.report()
            assert (report.taken, report.dropped, report.age_ms) == (1, 0, 32)
            sender.send(Result(0.0, 0.0, 0.2, 88))
            wait_until(lambda: sender.report().dropped == 1)
            assert (sender.report().dropped, sender.report().last_drop) == (1, 2)  # older than 127 ms
            sender.send(Result(-0.1, 0.02, 0.0321, 88))
            ours = (message for message in iter(lambda: listener.recv(5.0), None) if _is_ours(message))
            _, frame = next(ours), next(ours)
            assert struct.unpack("<hh", bytes(frame.data[:4])) == (-0x7FFF, 20000) and sender.clipped == 1
        after = [device.upload(*where) for where in ((0x1403, 1), (0x1603, 0), (0x1603, 1), (0x3071, 5))]
        assert after == before


def test_the_simulators_time_is_the_clock_of_the_node(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("XDG_RUNTIME_DIR", str(tmp_path))
    with Serving("--speed", "0.5") as served, Device(parse_bus(served.bus), 1) as device:
        device.set_nmt("operational")
        with FrameSender(device, NODE_CLOCK) as sender:
            for _ in range(5):
                now_s = TIME_S * 100 * device.read_int(0x3010, 1)
                sender.send(Result(0.0, 0.0, now_s - 0.050, 100))
                time.sleep(0.05)
            report = sender.report()
        assert (report.taken, report.dropped) == (5, 0)
        assert 50 <= report.age_ms < 127  # half the speed: 127 ms of the node are 254 ms here


def test_without_a_node_on_the_bus(tmp_path: Path) -> None:
    with Serving("--target", str(SCENARIO), "--video", "pgm-tcp:0") as served:
        result = run_imager(tmp_path, served.video, "--bus", served.bus, "--node", "9")
    assert result.code == 2
    assert result.err.startswith("imager: node 9 does not answer on ") and result.err.count("\n") == 1


def _is_ours(message: can.Message) -> bool:
    return message.arbitration_id == CAMERA_ID + 1
