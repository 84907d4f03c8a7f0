# SPDX-License-Identifier: Apache-2.0
"""The live stream: eight signals in every tick without loss, beside a master whose TPDO1 to TPDO4 stay as they are."""

from __future__ import annotations

import json
import threading
from collections import Counter
from collections.abc import Callable
from pathlib import Path
from typing import cast

import numpy as np
import pytest

from servoctl.identify.recorder import TickGatherer, TickRecorder
from servoctl.link.borrowed_stream import BorrowedStream
from servoctl.link.bus import open_bus, parse_bus
from servoctl.link.device import Device
from servoctl.link.pdo_loan import PdoLoan, borrowed_identifiers
from servoctl.link.signal_stream import SETS, Samples, SignalStream, sample_period_ms
from servoctl.objects.parameter import AXES
from servoctl.units import degrees

from .conftest import PARAMETERS, Bench
from .page_bench import wait_for

pytestmark = pytest.mark.real_time
STREAMED = 2000
MASTERS = {0x181: 10, 0x281: 10, 0x381: 50, 0x481: 50}
"""Frames per second of TPDO1 to TPDO4 of node 1, as delivered, at rest."""
RECORDS = [(0x1800 + n, sub) for n in range(4) for sub in (1, 2, 3, 5)] + [(0x1A00 + n, sub) for n in range(4) for sub in range(5)]
IN_USE = [(index, sub) for index, sub in RECORDS if not (index in (0x1A02, 0x1A03) and sub > 2)]
"""TPDO3 and TPDO4 map two objects; what is behind them does not count."""
FURTHER = [(0x1804 + n, sub) for n in range(4) for sub in (1, 2, 3, 5)] + [(0x1A04 + n, 0) for n in range(4)]


def objects(device: Device, places: list[tuple[int, int]]) -> list[int]:
    return [device.read_int(index, sub) for index, sub in places]


class Master:
    """Another program on the bus: it counts frames and keeps their lengths."""

    def __init__(self, bus: str) -> None:
        self._bus = open_bus(parse_bus(bus))
        self.frames: Counter[int] = Counter()
        self.lengths: dict[int, set[int]] = {}
        self._end = threading.Event()
        self._thread = threading.Thread(target=self._run)

    def _run(self) -> None:
        while not self._end.is_set():
            message = self._bus.recv(0.05)
            if message is not None:
                self.frames[message.arbitration_id] += 1
                self.lengths.setdefault(message.arbitration_id, set()).add(message.dlc)

    def __enter__(self) -> Master:
        self._thread.start()
        return self

    def __exit__(self, *_error: object) -> None:
        self._end.set()
        self._thread.join()
        self._bus.shutdown()


def take(stream: SignalStream, count: int) -> Samples:
    """The next samples, `count` or a few more. How long they take is up to the computer, and to the pace of an emulated board."""
    parts: list[Samples] = []

    def enough() -> bool:
        parts.append(stream.take())
        return sum(len(part.ticks) for part in parts) >= count

    wait_for(enough, f"{count} samples", 60.0)
    return Samples(np.concatenate([p.ticks for p in parts]), np.concatenate([p.values for p in parts], axis=1))


@pytest.mark.parametrize("choice", SETS)
def test_eight_signals_come_in_every_tick_and_the_masters_tpdos_stay(servo: Bench, choice: str) -> None:
    with Device(parse_bus(servo.bus), 1) as device:
        device.set_nmt("operational")
        records, further = objects(device, RECORDS), objects(device, FURTHER)
        with SignalStream(device, choice) as stream, Master(servo.bus) as master:
            assert objects(device, RECORDS) == records
            stream.start()
            begun = Counter(master.frames)
            samples = take(stream, STREAMED)
            heard = Counter(master.frames) - begun
            assert stream.missing == 0 and stream.note == "" and stream.period_ms == 1
        assert objects(device, RECORDS) == records and objects(device, FURTHER) == further
    assert samples.values.shape == (8, len(samples.ticks)) and len(samples.ticks) >= STREAMED
    assert set(np.diff(samples.ticks)) == {1}
    passed_s = len(samples.ticks) / 1000
    for identifier, per_s in MASTERS.items():
        assert heard[identifier] == pytest.approx(per_s * passed_s, rel=0.25, abs=3), f"{identifier:03X}"
    assert [master.lengths[identifier] for identifier in MASTERS] == [{7}, {7}, {8}, {8}]
    assert not [identifier for identifier in heard if 0x680 <= identifier < 0x6B0]


def test_the_signals_are_what_their_names_say(servo: Bench) -> None:
    """Each axis at rest, against its objects."""
    with Device(parse_bus(servo.bus), 1) as device:
        device.set_nmt("operational")
        for axis, name in enumerate(AXES):
            with SignalStream(device, name) as stream:
                stream.start()
                samples = take(stream, 300)
                angle_deg = degrees(1e-7 * device.axis_int(axis, 0x6064, signed=True))
            column = {signal.name: samples.values[n] for n, signal in enumerate(stream.signals)}
            assert [signal.axis for signal in stream.signals] == [axis] * 8
            assert column[f"{name} angle"][-1] == pytest.approx(angle_deg, abs=0.01)
            assert np.all(np.isfinite(samples.values))
            assert np.std(column[f"{name} joint rate"]) > 0.0  # the noise of the encoder
            assert abs(np.mean(column[f"{name} joint rate"])) < 0.1


@pytest.mark.image
def test_the_frames_of_an_axis_in_motion_agree(servo: Bench) -> None:
    """Joint rate, rate and the change of the angle are the same motion; torque and error are those of the objects, in N m and
    µrad."""
    with Device(parse_bus(servo.bus), 1) as device:
        device.set_nmt("operational")
        with SignalStream(device, "azimuth") as stream:
            stream.start()
            mover = servo.start("move", "azimuth", "--by", "2", "--rate", "4", "--yes")
            read: list[tuple[int, int]] = []
            while mover.poll() is None:
                read.append((device.axis_int(0, 0x6077, signed=True), device.axis_int(0, 0x60F4, signed=True)))
            assert mover.returncode == 0
            samples = take(stream, 4000)
            rated_nm = 1e-3 * device.axis_int(0, 0x6076)
    column = {signal.name: samples.values[n] for n, signal in enumerate(stream.signals)}
    joint, rate, angle = (column[f"azimuth {name}"] for name in ("joint rate", "rate", "angle"))
    assert np.max(rate) == pytest.approx(4.0, abs=0.5) and np.max(column["azimuth demanded rate"]) == pytest.approx(4.0, abs=0.1)
    assert np.sum(joint) * 1e-3 == pytest.approx(angle[-1] - angle[0], abs=0.05)
    assert np.corrcoef(joint, rate)[0, 1] > 0.98
    assert np.max(np.abs(column["azimuth torque"])) > 1.0 and np.max(np.abs(column["azimuth demanded torque"])) > 1.0
    torque_nm, error_urad = rated_nm * 1e-3 * np.array([torque for torque, _ in read]), 0.1 * np.array([error for _, error in read])
    for objects, streamed in ((torque_nm, "azimuth torque"), (error_urad, "azimuth following error")):
        assert np.max(np.abs(objects)) == pytest.approx(np.max(np.abs(column[streamed])), rel=0.5), streamed


# --- older firmware, slower buses --------------------------------------------------------------------------------------


class OlderDevice(Device):
    """Firmware without TPDO5 to TPDO8."""

    def try_upload(self, index: int, sub: int = 0) -> bytes | None:
        return None if 0x1804 <= index < 0x1808 else super().try_upload(index, sub)


def test_firmware_without_tpdo5_to_8_sends_six_signals_and_says_so(servo: Bench) -> None:
    with OlderDevice(parse_bus(servo.bus), 1) as device:
        device.set_nmt("operational")
        before = objects(device, IN_USE)
        with SignalStream(device, "azimuth") as stream:
            stream.start()
            samples = take(stream, 1000)
            missing = stream.missing
            assert objects(device, IN_USE) != before and device.read_int(0x1804, 1) & 0x80000000
        assert objects(device, IN_USE) == before
    assert samples.values.shape[0] == 6 and missing == 0 and set(np.diff(samples.ticks)) == {1}
    assert [signal.name.split(" ", 1)[1] for signal in stream.signals] == [
        "demanded rate", "rate", "following error", "angle", "demanded torque", "torque",
    ]  # fmt: skip
    assert stream.note.startswith("6 signals over TPDO2 to TPDO4, which the master does not get meanwhile")


class SlowDevice:
    """At 250 kbit/s."""

    node_id = 1

    def try_upload(self, index: int, _sub: int) -> bytes:
        return (250).to_bytes(2, "little") if index == 0x3050 else b"\x06"

    def axis_int(self, _axis: int, _index: int) -> int:
        return 1000


def test_a_slow_bus_carries_fewer_samples_and_says_so() -> None:
    assert [sample_period_ms(kbit_s) for kbit_s in (1000, 500, 250, 125)] == [1, 2, 5, 10]
    for kbit_s in (1000, 500, 250, 125):
        assert 4 * 135 / sample_period_ms(kbit_s) <= 0.541 * kbit_s  # bits of four frames, with stuff bits, per ms
    stream = SignalStream(cast(Device, SlowDevice()))
    assert stream.note == "8 signals at 200 Hz: 1000 Hz need 1 Mbit/s, this bus has 250 kbit/s."


# --- the frames of a tick ----------------------------------------------------------------------------------------------


def test_a_sample_of_four_frames_of_which_one_is_lost_is_missing_whole() -> None:
    def last(tick: int) -> bytes:
        return tick.to_bytes(4, "little") + bytes(4)

    for lost in range(4):
        gatherer = TickGatherer(frames=4)
        for tick in range(10):
            for which in range(4):
                if not (tick == 5 and which == lost):
                    gatherer.take(which, last(tick) if which == 3 else bytes([tick] * 8))
        ticks = np.frombuffer(bytes(gatherer.ticks), dtype=[("frames", "u1", (24,)), ("tick", "<u4"), ("rest", "u1", (4,))])
        assert gatherer.missing == (2 if lost == 3 else 1)
        assert all(np.all(row["frames"] == row["tick"]) for row in ticks)


# --- identifiers --------------------------------------------------------------------------------------------------------


@pytest.mark.image
def test_a_masters_tpdo5_is_given_back_and_that_of_a_killed_program_is_switched_off(servo: Bench) -> None:
    with Device(parse_bus(servo.bus), 1) as device:
        off = objects(device, FURTHER)
        try:
            masters = PdoLoan(device, 0x1804, 0x1A04)
            masters.take(0x680, [0x60410010], event_ms=200)
            mapped = objects(device, FURTHER)
            with SignalStream(device):
                assert device.read_int(0x1804, 1) & 0x7FF == borrowed_identifiers(1)[0]
            assert objects(device, FURTHER) == mapped
            masters.give_back()
            PdoLoan(device, 0x1805, 0x1A05).take(borrowed_identifiers(1)[1], [0x60410010], event_ms=200)  # and is killed
            with SignalStream(device):
                pass
            assert objects(device, FURTHER) == off
        finally:
            for n in range(4):
                device.write_int(0x1804 + n, 1, 0xC0000680 + 12 * n, 4)
                device.write_int(0x1A04 + n, 0, 0, 1)


@pytest.mark.parametrize(("communication", "mapped"), [(0x1801, 0x60410010), (0x1806, 0x60410010), (0x1403, 0x60FF0020)])
def test_firmware_of_another_release_streams_although_a_killed_program_has_left_its_pdos(
    servo: Bench, tmp_path: Path, communication: int, mapped: int
) -> None:
    """Their defaults are not known then: they are switched off."""
    other = tmp_path / "other.json"
    content = json.loads(PARAMETERS.read_text(encoding="utf-8"))
    other.write_text(json.dumps(content | {"schema_hash": content["schema_hash"] ^ 1}), encoding="utf-8")
    with Device(parse_bus(servo.bus), 1) as device:
        before = device.read_int(communication, 1)
        loan = PdoLoan(device, communication, communication + 0x200)
        loan.take(borrowed_identifiers(1)[0], [mapped], event_ms=0)  # and is killed
        with Device(parse_bus(servo.bus), 1, other) as unknown, SignalStream(unknown):
            assert not unknown.schema_fits
        assert device.read_int(communication, 1) == before | 0x80000000 and device.read_int(communication + 0x200) == 0
        loan.give_back()
        assert device.read_int(communication, 1) == before


@pytest.mark.parametrize(("communication", "mapped"), [(0x1801, 0x60410010), (0x1804, 0x60410010), (0x1403, 0x60FF0020)])
@pytest.mark.parametrize("stream", [SignalStream, lambda device: TickRecorder(device, 0)])
def test_what_a_killed_program_has_borrowed_is_no_obstacle_to_another_stream(
    servo: Bench, stream: Callable[[Device], BorrowedStream], communication: int, mapped: int
) -> None:
    """Of other PDOs than the stream's, with the same identifiers, which the node accepts once."""
    with Device(parse_bus(servo.bus), 1) as device:
        before = device.read_int(communication, 1)
        PdoLoan(device, communication, communication + 0x200).take(borrowed_identifiers(1)[0], [mapped], event_ms=0)  # and is killed
        with stream(device):
            pass
        assert device.read_int(communication, 1) == before
