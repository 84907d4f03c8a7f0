# SPDX-License-Identifier: Apache-2.0
"""Several motions at one node: each is monitored separately, and no motion runs without monitoring."""

from __future__ import annotations

import json
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager

import can
import pytest

from servoctl.drive.drive import Drive
from servoctl.link.bus import open_bus, parse_bus
from servoctl.link.device import Device
from servoctl.link.supervision import MONITOR_MS, Supervision
from servoctl.units import RATE_COUNTS_PER_RAD_S

from .conftest import Bench, Eventually

pytestmark = pytest.mark.real_time
ENTRIES = [f"0x1016:{sub}" for sub in (1, 2, 3, 4)]
NODE = 1


def entries(servo: Bench) -> list[int]:
    """The heartbeats that the node monitors."""
    return [row["value"] for row in servo.json("get", *ENTRIES)]


def set_monitored(servo: Bench, values: list[int]) -> None:
    for name, value in zip(ENTRIES, values, strict=True):
        servo.json("set", name, str(value))


def masters(servo: Bench) -> list[int]:
    return sorted(value >> 16 for value in entries(servo) if value)


def state(servo: Bench, axis: str) -> str:
    return str(servo.json("state", axis)["axes"][0]["state"])


def rate(servo: Bench, axis: str) -> float:
    return abs(float(servo.json("state", axis)["axes"][0]["rate_deg_s"]))


@pytest.fixture
def unwatched(servo: Bench) -> Iterator[Bench]:
    """The servo, whose entries are free before and after."""
    set_monitored(servo, [0] * 4)
    yield servo
    set_monitored(servo, [0] * 4)
    for axis in ("azimuth", "pitch"):
        if state(servo, axis) == "fault":
            servo("state", axis, "reset")


@contextmanager
def heartbeat_of(servo: Bench, node: int) -> Iterator[None]:
    """Another master on the bus, that takes no locks."""
    end = threading.Event()
    bus = open_bus(parse_bus(servo.bus))

    def beat() -> None:
        while not end.wait(0.1):
            bus.send(can.Message(arbitration_id=0x700 + node, data=[5], is_extended_id=False))

    thread = threading.Thread(target=beat)
    thread.start()
    try:
        yield
    finally:
        end.set()
        thread.join()
        bus.shutdown()


@contextmanager
def emergency(servo: Bench, code: int) -> Iterator[threading.Event]:
    """Set when the node has sent this error code."""
    heard = threading.Event()

    def notice(message: can.Message) -> None:
        if message.arbitration_id == 0x80 + NODE and message.data[:2] == code.to_bytes(2, "little"):
            heard.set()

    with open_bus(parse_bus(servo.bus)) as bus:
        notifier = can.Notifier(bus, [notice])
        yield heard
        notifier.stop()


@pytest.mark.parametrize(("others", "expected"), [(0, "operational"), (0x40 << 16 | 500, "pre-operational")])
def test_a_node_that_missed_our_heartbeat_is_started_again_unless_it_monitors_others(
    unwatched: Bench, monkeypatch: pytest.MonkeyPatch, others: int, expected: str
) -> None:
    """As on a computer that is too busy for a second."""
    for name, value in unwatched.environment.items():
        monkeypatch.setenv(name, value)
    set_monitored(unwatched, [others, 0, 0, 0])
    with Device(parse_bus(unwatched.bus), NODE) as device:
        device.set_nmt("operational")
        supervision = Supervision(device)
        supervision.begin()
        assert supervision._beat is not None
        supervision._beat.stop()
        while device.nmt_state() != "pre-operational":
            pass
        supervision.end()
        assert device.nmt_state() == expected


@pytest.mark.image
def test_motions_side_by_side_have_entries_of_their_own_and_the_last_one_puts_nmt_back(
    unwatched: Bench, eventually: Eventually
) -> None:
    servo = unwatched
    with open_bus(parse_bus(servo.bus)) as bus:
        bus.send(can.Message(arbitration_id=0, data=[0x80, NODE], is_extended_id=False))
        time.sleep(0.1)
    assert servo.json("info")["nmt"] == "pre-operational"
    short = servo.start("move", "azimuth", "--rate", "1", "--for", "3", "--yes")
    eventually(lambda: masters(servo) == [127], 15.0)
    long = servo.start("move", "pitch", "--rate", "0.5", "--for", "6", "--yes")
    eventually(lambda: masters(servo) == [126, 127], 15.0)
    assert short.wait(timeout=60) == 0
    assert masters(servo) == [126] and state(servo, "pitch") == "operation enabled"
    assert servo.json("info")["nmt"] == "operational"
    assert long.wait(timeout=30) == 0
    assert entries(servo) == [0] * 4
    assert servo.json("info")["nmt"] == "pre-operational"


@pytest.mark.parametrize("victim", ["azimuth", "pitch"])
def test_a_killed_motion_is_noticed_though_another_ones_heartbeat_goes_on(
    unwatched: Bench, eventually: Eventually, victim: str
) -> None:
    servo = unwatched
    running = {}
    for count, axis in enumerate(("azimuth", "pitch"), 1):
        running[axis] = servo.start("move", axis, "--rate", "1", "--for", "40", "--yes")
        eventually(lambda count=count: len(masters(servo)) == count, 15.0)  # type: ignore[misc]
    eventually(lambda: rate(servo, victim) > 0.5, 15.0)
    running[victim].kill()
    eventually(lambda: state(servo, victim) == "fault" and rate(servo, victim) < 0.1, 15.0)
    other = next(process for axis, process in running.items() if axis != victim)
    assert other.wait(timeout=60) == 6  # the node stops all: it cannot know whose heartbeat it was
    assert len(masters(servo)) == 1  # only the entry of the killed one is left ...
    for axis in running:
        servo.json("state", axis, "reset")
    assert servo("move", victim, "--rate", "1", "--for", "0.5", "--yes").code == 0
    assert entries(servo) == [0] * 4  # ... for the next one


def test_no_motion_when_there_is_no_entry_for_its_heartbeat(unwatched: Bench) -> None:
    servo = unwatched
    foreign = [node << 16 | 500 for node in (10, 11, 12, 127)]
    set_monitored(servo, foreign)
    before = state(servo, "azimuth")
    refused = servo("move", "azimuth", "--rate", "1", "--for", "1", "--yes")
    assert refused.code == 6 and "1016: nodes" in refused.err and refused.err.count("\n") == 1
    assert entries(servo) == foreign and state(servo, "azimuth") == before


def test_entries_of_killed_motions_are_taken_over(unwatched: Bench) -> None:
    servo = unwatched
    left = [node << 16 | MONITOR_MS for node in (124, 125, 126, 127)]
    set_monitored(servo, left)
    for _ in left:
        assert servo("move", "azimuth", "--rate", "1", "--for", "0.2", "--yes").code == 0
    assert entries(servo) == [0] * 4


def test_an_id_heard_on_the_bus_is_another_ones_and_so_is_its_entry(unwatched: Bench, eventually: Eventually) -> None:
    servo = unwatched
    theirs = 127 << 16 | MONITOR_MS
    with heartbeat_of(servo, 127):
        set_monitored(servo, [theirs, 0, 0, 0])
        move = servo.start("move", "azimuth", "--rate", "1", "--for", "3", "--yes")
        eventually(lambda: masters(servo) == [126, 127], 15.0)
        assert move.wait(timeout=60) == 0
        assert entries(servo) == [theirs, 0, 0, 0]
        set_monitored(servo, [0] * 4)


def test_one_axis_and_one_stream_belong_to_one_motion_at_a_time(unwatched: Bench, eventually: Eventually) -> None:
    servo = unwatched
    measuring = servo.start("bode", "azimuth", "--low", "2", "--periods", "2", "--yes")
    eventually(lambda: masters(servo) == [127], 15.0)
    for words, reported in (
        (("move", "azimuth", "--rate", "1", "--for", "1", "--yes"), "another servoctl is moving azimuth"),
        (("step", "pitch", "--yes"), "another servoctl is measuring"),
    ):
        refused = servo(*words)
        assert refused.code == 6 and reported in refused.err, refused
    assert measuring.wait(timeout=60) == 0


@pytest.mark.image
def test_a_stop_for_a_silent_master_is_told_with_time_and_remedy_until_the_axis_is_enabled(
    unwatched: Bench,
) -> None:
    with Device(parse_bus(unwatched.bus), NODE) as device, emergency(unwatched, 0x8101) as stopped:
        drive = Drive(device, 0)
        drive.enable()
        device.write_int(0x6060, 0, 3, 1)
        device.write_int(0x60FF, 0, round(0.02 * RATE_COUNTS_PER_RAD_S), 4)
        assert stopped.wait(20.0)  # silent: any question of the test would be a master's frame
        assert "warning" in drive.flags(drive.statusword())
    for command in ("info", "state"):
        shown = unwatched(command)
        assert "azimuth was stopped" in shown.err and "master silent (EMCY 8101)" in shown.err, shown.err
        assert "Let the master send" in shown.err and "pitch was stopped" not in shown.err
        azimuth, pitch = unwatched.json(command)["axes"]
        assert 0.0 < azimuth["silent_stop_age_s"] < 30.0 and pitch["silent_stop_age_s"] is None
    heard = unwatched("monitor", "--for", "0.5", "--json").out.splitlines()
    assert [e["code"] for e in json.loads(heard[-1])["emergencies"]] == [0x8101]
    for words in (("monitor", "--for", "0.5"), ("explain", "8101")):
        assert "Let the master send" in " ".join(unwatched(*words).out.split()), words
    unwatched("state", "azimuth", "enable")
    assert unwatched.json("info")["axes"][0]["silent_stop_age_s"] is None
    unwatched("state", "azimuth", "disable")
