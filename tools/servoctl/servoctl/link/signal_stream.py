# SPDX-License-Identifier: Apache-2.0
"""Eight signals as a stream, in every tick, over TPDO5 to TPDO8; TPDO1 to TPDO4 stay the master's.

    pair of 32 bits | pair of 32 bits | pair of 32 bits | tick counter (3010:1), two signals of 16 bits

The frames of a tick are combined as in recorder.py, so that samples of two ticks are never mixed, and what is missing
is counted by the node's tick counter. A slow bus carries fewer samples per second. Firmware without TPDO5 to TPDO8 sends
six of the signals over TPDO2 to TPDO4, which are borrowed.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ..identify.recorder import TickGatherer
from ..objects.parameter import AXES, AXIS_SHIFT
from ..units import POSITION_COUNTS_PER_RAD, RATE_COUNTS_PER_RAD_S, TORQUE_COUNTS_OF_RATED, degrees
from .borrowed_stream import BorrowedStream
from .device import Device
from .pdo_loan import PdoLoan, borrowed_identifiers

Real = NDArray[np.float32]

_FURTHER_TPDOS = (4, 5, 6, 7)
_BORROWED_TPDOS = (1, 2, 3)
"""Counted from 0; the latter with firmware that has no others."""
_WORDS, _WORDS_BORROWED, _HALF_WORDS = 6, 4, 2
"""Signals of 32 bits, and those of 16 bits after them."""
_BYTES = {"i4": 4, "f4": 4, "i2": 2}
_PERIODS_MS = ((1000, 1), (500, 2), (250, 5), (0, 10))
"""Ticks from one sample to the next from this bit rate on, kbit/s: four frames of 8 bytes are at most 54 % of the bus."""
_FASTEST_HZ = 1000


@dataclass(frozen=True)
class Signal:
    """One line of a plot: its object, and the unit that people read. `plot` names the plot that it belongs to, `kind` the
    type of its values on the bus."""

    name: str
    axis: int
    index: int
    unit: str
    factor: float
    plot: str
    sub: int = 0
    kind: str = "i4"


_ANGLE = degrees(1 / POSITION_COUNTS_PER_RAD)
_RATE = degrees(1 / RATE_COUNTS_PER_RAD_S)
_TORQUE = 1 / TORQUE_COUNTS_OF_RATED
"""Of the rated torque; a stream multiplies it by that of its axis."""


def _angle(axis: int) -> Signal:
    return Signal(f"{AXES[axis]} angle", axis, 0x6064, "°", _ANGLE, "angle")


def _demanded_angle(axis: int) -> Signal:
    return Signal(f"{AXES[axis]} demanded angle", axis, 0x6062, "°", _ANGLE, "angle")


def _rate(axis: int) -> Signal:
    return Signal(f"{AXES[axis]} rate", axis, 0x606C, "°/s", _RATE, "rate")


def _joint_rate(axis: int) -> Signal:
    return Signal(f"{AXES[axis]} joint rate", axis, 0x2101, "°/s", degrees(1.0), "rate", 5, "f4")


def _demanded_rate(axis: int) -> Signal:
    return Signal(f"{AXES[axis]} demanded rate", axis, 0x606B, "°/s", _RATE, "rate")


def _error(axis: int) -> Signal:
    return Signal(f"{AXES[axis]} following error", axis, 0x60F4, "µrad", 1e6 / POSITION_COUNTS_PER_RAD, "following error")


def _torque(axis: int) -> Signal:
    return Signal(f"{AXES[axis]} torque", axis, 0x6077, "N m", _TORQUE, "torque", 0, "i2")


def _demanded_torque(axis: int) -> Signal:
    return Signal(f"{AXES[axis]} demanded torque", axis, 0x6074, "N m", _TORQUE, "torque", 0, "i2")


def _of_one(axis: int) -> tuple[Signal, ...]:
    return (
        _demanded_rate(axis), _rate(axis), _error(axis), _angle(axis), _demanded_angle(axis), _joint_rate(axis),
        _demanded_torque(axis), _torque(axis),
    )  # fmt: skip


SETS: dict[str, tuple[Signal, ...]] = {
    "both": (_angle(0), _angle(1), _rate(0), _rate(1), _error(0), _error(1), _torque(0), _torque(1)),
    "azimuth": _of_one(0),
    "pitch": _of_one(1),
    "tracking": (_angle(0), _angle(1), _error(0), _error(1), _demanded_rate(0), _demanded_rate(1), _torque(0), _torque(1)),
}
"""Six signals of 32 bits and two of 16 bits, by the name of the choice. Older firmware leaves out the fifth and sixth."""


def _bit_rate_kbit_s(device: Device) -> int:
    """In force (3050:2); 1 Mbit/s for firmware that does not report it."""
    return int.from_bytes(device.try_upload(0x3050, 2) or b"", "little") or 1000


def sample_period_ms(kbit_s: int) -> int:
    """Ticks from one sample to the next at this bit rate."""
    return next(period for least, period in _PERIODS_MS if kbit_s >= least)


@dataclass(frozen=True)
class Samples:
    """Numbers of the ticks, and a row of values per signal in its unit."""

    ticks: NDArray[np.uint32]
    values: Real


class SignalStream(BorrowedStream):
    """The signals of one of SETS, in a `with` block; `take` gives what has come since the last time."""

    def __init__(self, device: Device, choice: str = "both") -> None:
        further = device.try_upload(0x1800 + _FURTHER_TPDOS[0], 0) is not None
        tpdos, words = (_FURTHER_TPDOS, _WORDS) if further else (_BORROWED_TPDOS, _WORDS_BORROWED)
        kbit_s = _bit_rate_kbit_s(device)
        self.choice = choice
        self.period_ms = sample_period_ms(kbit_s)
        rated_nm = [device.axis_int(axis, 0x6076) / 1e3 for axis in range(len(AXES))]
        chosen = (*SETS[choice][:words], *SETS[choice][_WORDS:])
        self.signals = tuple(replace(s, factor=s.factor * rated_nm[s.axis]) if s.plot == "torque" else s for s in chosen)
        self.note = _note(len(self.signals), self.period_ms, kbit_s, further)
        """Why there are fewer signals or samples than there could be; empty: there are not."""
        kinds = [signal.kind for signal in self.signals]
        self._layout = np.dtype(
            [(f"s{n}", f"<{kind}") for n, kind in enumerate(kinds[:words])]
            + [("tick", "<u4")]
            + [(f"s{n}", f"<{kind}") for n, kind in enumerate(kinds[words:], words)]
        )
        self._frames = len(tpdos)
        self._gatherer = self._new_gatherer()
        loans = [PdoLoan(device, 0x1800 + n, 0x1A00 + n) for n in tpdos]
        super().__init__(device, 0, loans, borrowed_identifiers(device.node_id, len(tpdos)))

    def _new_gatherer(self) -> TickGatherer:
        return TickGatherer(self.period_ms, self._frames)

    def _check_bus(self) -> None:
        """Any bus will do: the period follows its bit rate."""

    def _borrow(self) -> None:
        objects = [(s.index + AXIS_SHIFT * s.axis) << 16 | s.sub << 8 | 8 * _BYTES[s.kind] for s in self.signals]
        words = len(objects) - _HALF_WORDS
        frames = [objects[n : n + 2] for n in range(0, words, 2)]
        frames.append([0x3010 << 16 | 1 << 8 | 32, *objects[words:]])
        for loan, identifier, mapped in zip(self._loans, self._identifiers, frames, strict=True):
            loan.take(identifier, mapped, event_ms=self.period_ms)

    def _take(self, which: int, data: bytes, timestamp_s: float) -> None:
        if len(data) == 8:
            self._gatherer.take(which, data)

    def _forget(self) -> None:
        self._gatherer = self._new_gatherer()

    @property
    def missing(self) -> int:
        """Samples that did not come, or not whole, between those that did."""
        return self._gatherer.missing

    def take(self) -> Samples:
        """What has come since the last time."""
        with self.lock:
            data, self._gatherer.ticks = bytes(self._gatherer.ticks), bytearray()
        raw = np.frombuffer(data, dtype=self._layout)
        values = np.array([raw[f"s{n}"] * signal.factor for n, signal in enumerate(self.signals)], dtype=np.float32)
        return Samples(raw["tick"].copy(), values.reshape(len(self.signals), len(raw)))


def _note(count: int, period_ms: int, kbit_s: int, further: bool) -> str:
    """One sentence for each reason."""
    notes = []
    if not further:
        notes.append(
            f"{count} signals over TPDO2 to TPDO4, which the master does not get meanwhile: this firmware has no TPDO5 to TPDO8."
        )
    if period_ms > 1:
        notes.append(f"{count} signals at {1000 // period_ms} Hz: {_FASTEST_HZ} Hz need 1 Mbit/s, this bus has {kbit_s} kbit/s.")
    return " ".join(notes)
