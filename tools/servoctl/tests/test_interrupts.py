# SPDX-License-Identifier: Apache-2.0
"""A request is sent, and an interrupt comes before its answer, or the answer to another request."""

from __future__ import annotations

import signal
import threading
from collections.abc import Iterator
from typing import Any

import pytest

from servoctl.drive.drive import Drive
from servoctl.drive.power import DISABLED, PROFILE_VELOCITY
from servoctl.errors import ConnectionFailed, Refused
from servoctl.link.bus import parse_bus
from servoctl.link.device import SDO_TIMEOUT_S, Device
from servoctl.motion.live import LiveAxis

from .conftest import Bench

DEVICE_TYPE, VENDOR, NAME = (0x1000, 0), (0x1018, 1), (0x1008, 0)
ANSWERS_THAT_NAME_AN_OBJECT = (0x41, 0x43, 0x60, 0x80, 0xC6)


@pytest.fixture
def device(servo: Bench, monkeypatch: pytest.MonkeyPatch) -> Iterator[Device]:
    monkeypatch.setenv("XDG_RUNTIME_DIR", str(servo.folder))
    before = signal.signal(signal.SIGINT, signal.default_int_handler)  # a background job's children ignore it
    with Device(parse_bus(servo.bus), 1) as opened:
        yield opened
    signal.signal(signal.SIGINT, before)


def interrupted(device: Device, times: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """The next `times` requests are each followed by Ctrl-C."""
    send, left = device.network.send_message, [times]

    def send_and_interrupt(*arguments: Any, **named: Any) -> None:
        send(*arguments, **named)
        if left[0]:
            left[0] -= 1
            signal.raise_signal(signal.SIGINT)

    monkeypatch.setattr(device.network, "send_message", send_and_interrupt)


def test_a_transfer_after_an_interrupted_one_gets_its_own_answer(
    device: Device, monkeypatch: pytest.MonkeyPatch
) -> None:
    expected = device.upload(*VENDOR)
    interrupted(device, 1, monkeypatch)
    with pytest.raises(KeyboardInterrupt):
        device.upload(*DEVICE_TYPE)
    assert [device.upload(*VENDOR) for _ in range(20)] == [expected] * 20


@pytest.mark.image
def test_an_answer_to_another_request_is_not_taken(device: Device) -> None:
    """Before each answer come those to others: late ones, or to another servoctl. Whole, in segments, as a block, refused."""
    take = device.node.sdo.on_response
    others = [
        bytes.fromhex(text) for text in ("43 00 10 00 92 01 02 00", "60 17 10 00 00 00 00 00", "80 00 21 02 00 00 02 06", "C6 80 30 01 08 00 00 00")
    ]  # fmt: skip

    def after_others(can_id: int, data: bytearray, time_s: float) -> None:
        for other in others if data[0] in ANSWERS_THAT_NAME_AN_OBJECT else []:
            take(can_id, other, time_s)
        take(can_id, data, time_s)

    wanted = [device.upload(*VENDOR), device.upload(*NAME)]
    device.network.unsubscribe(device.node.sdo.tx_cobid, take)
    device.network.subscribe(device.node.sdo.tx_cobid, after_others)
    assert [device.upload(*VENDOR), device.upload(*NAME)] == wanted and len(wanted[1]) > 4
    assert device.upload_block(*NAME) == wanted[1]
    device.download(0x1016, 4, bytes(4))
    with pytest.raises(Refused, match="no such object"):
        device.upload(0x1FFF)


def test_a_write_without_answer_fails_and_a_late_answer_to_a_read_is_its_answer(device: Device) -> None:
    """The node answers 50 ms after our time-out."""
    expected = device.upload(*VENDOR)
    take, waits = device.node.sdo.on_response, [True]

    def late(*arguments: Any) -> None:
        if waits.pop() if waits else False:
            threading.Timer(SDO_TIMEOUT_S + 0.05, take, arguments).start()
        else:
            take(*arguments)

    device.network.unsubscribe(device.node.sdo.tx_cobid, take)
    device.network.subscribe(device.node.sdo.tx_cobid, late)
    with pytest.raises(ConnectionFailed):
        device.download(0x1017, 0, (100).to_bytes(2, "little"))  # as it is
    assert [device.upload(*VENDOR) for _ in range(20)] == [expected] * 20
    waits.append(True)
    assert device.upload(*VENDOR) == expected


def test_an_interrupted_motion_stops_though_the_bus_fails_it_once(
    device: Device, monkeypatch: pytest.MonkeyPatch
) -> None:
    quick_stop, failures = Drive.quick_stop, [1]

    def fails_first(drive: Drive) -> None:
        if failures[0]:
            failures[0] -= 1
            raise ConnectionFailed("lost")
        quick_stop(drive)

    monkeypatch.setattr(Drive, "quick_stop", fails_first)
    monkeypatch.setattr(Drive, "disable", lambda _drive: None)  # nothing else brakes it
    with pytest.raises(KeyboardInterrupt), LiveAxis(device, 0, PROFILE_VELOCITY) as live:
        live.drive.set_target_rate(0.02)
        raise KeyboardInterrupt
    monkeypatch.undo()
    assert failures == [0] and Drive(device, 0).state() == DISABLED


@pytest.mark.real_time
def test_a_motion_that_cannot_be_stopped_leaves_the_device_monitoring_a_heartbeat(
    device: Device, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fails(_drive: Drive) -> None:
        raise ConnectionFailed("lost")

    monkeypatch.setattr(Drive, "quick_stop", fails)
    monkeypatch.setattr(Drive, "disable", fails)
    with pytest.raises(KeyboardInterrupt), LiveAxis(device, 0, PROFILE_VELOCITY) as live:
        live.drive.set_target_rate(0.02)
        raise KeyboardInterrupt
    monkeypatch.undo()
    azimuth = Drive(device, 0)
    azimuth.wait(lambda: azimuth.state() != "operation enabled", 3.0, "brake by itself")
    azimuth.wait_for_standstill()
    device.write_int(0x1016, 4, 0, 4)
    azimuth.reset_fault()
