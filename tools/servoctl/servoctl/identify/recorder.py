# SPDX-License-Identifier: Apache-2.0
"""Every tick of one axis, recorded over three borrowed TPDOs that carry object 0x2101.

    angle, joint rate | inertial rate, torque | number, kind, run, reference      each 1 ms, in this order

The first two are taken for the tick of the third only when they came once each, in order, between the third of the
previous tick and this one; everything else is a gap. So frames of two ticks are never mixed, whoever has lost one.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..errors import InputError, MotionError
from ..link.borrowed_stream import BorrowedStream
from ..link.device import Device
from ..link.pdo_loan import PdoLoan, borrowed_identifiers
from ..objects.parameter import AXIS_SHIFT
from ..show.number_table import read_columns
from ..units import TICK_S

Real = NDArray[np.float64]

_TPDOS = (1, 2, 3)
"""TPDO2 to TPDO4, counted from 0; TPDO1 still sends azimuth's state."""
_OBJECT = 0x2101
_FRAMES = (((4, 32), (5, 32)), ((6, 32), (7, 32)), ((1, 16), (2, 8), (3, 8), (8, 32)))
"""Sub-index and bits of the contents of each frame."""
_LAYOUT = np.dtype(
    [("angle", "<u4"), ("joint_rate", "<f4"), ("inertial_rate", "<f4"), ("torque", "<f4"),
     ("number", "<u2"), ("kind", "u1"), ("run", "u1"), ("reference", "<f4")]
)  # fmt: skip
_RAD_PER_TURN32 = 2 * np.pi / 2**32
SPEED_SWEEP, TORQUE_RAMPS, HYSTERESIS, CHIRP, BREAK_AWAY = 1, 2, 3, 4, 5


@dataclass(frozen=True)
class Recording:
    """Columns of equal length, one row for each complete tick; docs/identification.md describes them.

    `run` counts up from 1 with each experiment and each move between two; `kind` of a move is a speed sweep.
    """

    time_s: Real
    run: NDArray[np.int64]
    kind: NDArray[np.int64]
    joint_angle_rad: Real
    joint_rate_rad_s: Real
    inertial_rate_rad_s: Real
    torque_nm: Real
    reference: Real

    def __len__(self) -> int:
        return len(self.time_s)

    @property
    def missing(self) -> int:
        """Missing ticks between the first and the last."""
        return round((self.time_s[-1] - self.time_s[0]) / TICK_S) + 1 - len(self) if len(self) else 0

    def missing_share(self, run: int) -> float:
        """Of the ticks of one run."""
        times = self.time_s[self.run == run]
        return 1.0 - len(times) / (round((times[-1] - times[0]) / TICK_S) + 1) if len(times) else 1.0

    def write(self, path: Path) -> None:
        """CSV, in the form that `identify fit` reads."""
        columns = {name: getattr(self, name) for name in self.__dataclass_fields__}
        formats = ["%.3f", "%d", "%d", "%.10g", "%.7g", "%.7g", "%.7g", "%.8g"]
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
            table = np.column_stack(list(columns.values()))
            np.savetxt(path, table, delimiter=",", header=",".join(columns), comments="", fmt=formats)
        except OSError as error:
            raise InputError(f"{path}: cannot be written: {error.strerror}.") from error


def read_recording(path: Path) -> Recording:
    """What `Recording.write` has written; raises InputError."""
    columns: dict[str, Any] = dict(read_columns(path))
    if list(columns) != list(Recording.__dataclass_fields__):
        raise InputError(f"{path}:1: is not the title line of a recording, {','.join(Recording.__dataclass_fields__)}.")
    whole = {name: columns[name].astype(np.int64) for name in ("run", "kind")}
    return Recording(**{**columns, **whole})


def decode(frames: bytes, near_rad: float = 0.0) -> Recording:
    """The ticks of `frames`, 24 bytes each; the first angle is the one nearest to `near_rad`."""
    raw = np.frombuffer(frames, dtype=_LAYOUT)
    if not len(raw):
        raise MotionError("not one complete tick was received over the bus.")
    steps = np.diff(raw["number"].astype(np.int64)) % 0x10000
    number = np.concatenate([[0], np.cumsum(steps)])
    angle = np.unwrap(_RAD_PER_TURN32 * raw["angle"])
    angle = angle + 2 * np.pi * np.round((near_rad - angle[0]) / (2 * np.pi))
    reference = raw["reference"].astype(np.float64)
    loops = raw["kind"] == HYSTERESIS
    turns = np.round((angle[loops] - reference[loops]) / (2 * np.pi))
    reference[loops] += 2 * np.pi * turns
    new_run = (np.diff(raw["kind"]) != 0) | (np.diff(raw["run"]) != 0)
    return Recording(
        time_s=TICK_S * number,
        run=1 + np.concatenate([[0], np.cumsum(new_run)]),
        kind=np.where(raw["kind"] == 0, SPEED_SWEEP, raw["kind"]).astype(np.int64),
        joint_angle_rad=angle,
        joint_rate_rad_s=raw["joint_rate"].astype(np.float64),
        inertial_rate_rad_s=raw["inertial_rate"].astype(np.float64),
        torque_nm=raw["torque"].astype(np.float64),
        reference=reference,
    )


class TickGatherer:
    """Combines the frames of a tick, in the order of arrival; the last one begins with the number of the tick."""

    def __init__(self, step: int = 1, frames: int = 3) -> None:
        """`step`: ticks from one sample to the next; `frames`: of a tick."""
        self.ticks = bytearray()
        self.missing = 0
        """Samples that did not come, or not whole, between those that did."""
        self._step = step
        self._before = frames - 1
        self._parts: list[bytes] = []
        self._whole = False
        self._last: int | None = None

    def take(self, which: int, data: bytes) -> None:
        """`which`: the frame's place in a tick, from 0."""
        if which < self._before:
            self._whole = len(self._parts) == which and (self._whole or which == 0)
            self._parts.append(data)
            return
        number = int.from_bytes(data[:2], "little")
        passed = self._step if self._last is None else (number - self._last) & 0xFFFF
        follows = self._last is not None and passed == self._step
        if follows and self._whole and len(self._parts) == self._before:
            self.ticks += b"".join(self._parts) + data
        elif self._last is not None:
            self.missing += max(1, passed // self._step)
        self._last = number
        self._parts.clear()
        self._whole = False


class TickRecorder(BorrowedStream):
    """Records every tick of one axis."""

    def __init__(self, device: Device, axis: int) -> None:
        self._shift = AXIS_SHIFT * axis
        self._gatherer = TickGatherer()
        loans = [PdoLoan(device, 0x1800 + n, 0x1A00 + n) for n in _TPDOS]
        super().__init__(device, axis, loans, borrowed_identifiers(device.node_id, len(_TPDOS)))

    def _borrow(self) -> None:
        if self.device.try_upload(_OBJECT + self._shift, 1) is None:
            raise MotionError(
                f"node {self.device.node_id} cannot record ticks: it has no object {_OBJECT + self._shift:04X}."
                " Update its firmware."
            )
        for loan, identifier, entries in zip(self._loans, self._identifiers, _FRAMES, strict=True):
            objects = [(_OBJECT + self._shift) << 16 | sub << 8 | bits for sub, bits in entries]
            loan.take(identifier, objects, event_ms=1)

    def _take(self, which: int, data: bytes, timestamp_s: float) -> None:
        if len(data) == 8:
            self._gatherer.take(which, data)

    def _forget(self) -> None:
        self._gatherer = TickGatherer()

    @property
    def missing(self) -> int:
        """Ticks that did not come, or not whole, between those that did."""
        return self._gatherer.missing

    def frames_from(self, first: int) -> tuple[bytes, int]:
        """Those received since `start` from this byte on, whole ticks, for `decode`, and the number of all bytes."""
        with self.lock:
            return bytes(self._gatherer.ticks[first:]), len(self._gatherer.ticks)

    def recording(self, near_rad: float) -> Recording:
        """Ticks received since `start`; the first joint angle is the one nearest to `near_rad`."""
        with self.lock:
            frames = bytes(self._gatherer.ticks)
        return decode(frames, near_rad)
