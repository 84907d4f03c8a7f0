# SPDX-License-Identifier: Apache-2.0
"""A trajectory of the joints over time: read from CSV, interpolated, and checked against the node's limits.

Between two rows the angle is the cubic that has the angle and the rate of both rows (cubic Hermite). A file without
rates gets those of parabolas through neighbouring rows.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import overload

import numpy as np
from numpy.typing import NDArray

from ..drive.node_limits import NodeLimits
from ..errors import InputError
from ..objects.parameter import AXES
from ..show.number_table import read_table
from ..show.text_file import TextFile, read_text
from ..units import degrees, radians

Real = NDArray[np.float64]

TIME_UNITS = {"s": 1.0, "ms": 1e-3}
ANGLE_UNITS = {"deg": radians(1.0), "rad": 1.0, "mrad": 1e-3, "urad": 1e-6}
MAX_ROWS = 4_000_000
"""More than an hour at 1 kHz."""
_LOOKS = 33
"""Instants of an interval at which angle and rate are checked; the acceleration is largest at its ends."""
_AT_ONCE = 4096
"""Intervals that are looked at together."""
_TOLERANCE = 1.0 + 1e-6


@dataclass(frozen=True)
class AxisLimits:
    """What a trajectory of one axis must keep: travel and rate (node_limits.py), and 6083 and 6084 in rad/s²."""

    node: NodeLimits
    acceleration_rad_s2: float
    deceleration_rad_s2: float


@dataclass(frozen=True)
class Trajectory:
    """Angles (rad) and rates (rad/s) of some axes, by axis number, at increasing times (s); `places` names each row.

    All are arrays, and stay so: a trajectory of 10 min at 1 kHz has 600,000 rows.
    """

    time_s: Real
    angle_rad: dict[int, Real]
    rate_rad_s: dict[int, Real]
    places: Sequence[str]

    @property
    def duration_s(self) -> float:
        """From the first row to the last one."""
        return float(self.time_s[-1] - self.time_s[0])

    def shortened(self, seconds: float) -> Trajectory:
        """The rows of the first seconds, two at least."""
        rows = max(2, int(np.searchsorted(self.time_s, self.time_s[0] + seconds, side="right")))
        angle = {axis: values[:rows] for axis, values in self.angle_rad.items()}
        rate = {axis: values[:rows] for axis, values in self.rate_rad_s.items()}
        return Trajectory(self.time_s[:rows], angle, rate, self.places[:rows])

    def later(self, time_s: float) -> Trajectory:
        """The rows from this time on, two at least; their times stay."""
        row = min(int(np.searchsorted(self.time_s, time_s)), len(self.time_s) - 2)
        angle = {axis: values[row:] for axis, values in self.angle_rad.items()}
        rate = {axis: values[row:] for axis, values in self.rate_rad_s.items()}
        return Trajectory(self.time_s[row:], angle, rate, self.places[row:])

    def turned(self, axis: int, turns: int) -> Trajectory:
        """The same directions, with an axis whole revolutions further."""
        angle = self.angle_rad | {axis: self.angle_rad[axis] + 2 * np.pi * turns}
        return Trajectory(self.time_s, angle, self.rate_rad_s, self.places)

    def angles(self, axis: int, time_s: Real) -> Real:
        """Angles at these times; before and after the trajectory, its ends."""
        return self._hermite(axis, np.clip(time_s, self.time_s[0], self.time_s[-1]), 0)

    def rates(self, axis: int, time_s: Real) -> Real:
        """Rates at these times, within the trajectory."""
        return self._hermite(axis, np.clip(time_s, self.time_s[0], self.time_s[-1]), 1)

    def _hermite(self, axis: int, time_s: Real, derivative: int) -> Real:
        row = np.clip(np.searchsorted(self.time_s, time_s, side="right") - 1, 0, len(self.time_s) - 2)
        angle, rate = self.angle_rad[axis], self.rate_rad_s[axis]
        step = self.time_s[row + 1] - self.time_s[row]
        u = (time_s - self.time_s[row]) / step
        mean = (angle[row + 1] - angle[row]) / step
        begin, end = rate[row] - mean, rate[row + 1] - mean
        if derivative == 1:
            return mean + (1 - u) * (1 - 3 * u) * begin - u * (2 - 3 * u) * end
        if derivative == 2:
            return ((6 * u - 4) * begin + (6 * u - 2) * end) / step
        return angle[row] + step * u * (mean + (1 - u) * ((1 - u) * begin - u * end))

    def extended(self, acceleration_rad_s2: float, rest_s: float) -> Trajectory:
        """With a start from rest and a stop at the end, each at this acceleration at most, and `rest_s` at rest before.

        Its rows belong to the first and the last row of the file.
        """
        first = max(abs(rate[0]) for rate in self.rate_rad_s.values()) / acceleration_rad_s2
        last = max(abs(rate[-1]) for rate in self.rate_rad_s.values()) / acceleration_rad_s2
        first, last = max(first, 0.1), max(last, 0.1)
        time_s = np.concatenate([
            [self.time_s[0] - first - rest_s, self.time_s[0] - first], self.time_s, [self.time_s[-1] + last]
        ])  # fmt: skip
        angles, rates = {}, {}
        for axis, angle in self.angle_rad.items():
            rate = self.rate_rad_s[axis]
            begin = angle[0] - 0.5 * first * rate[0]
            angles[axis] = np.concatenate([[begin, begin], angle, [angle[-1] + 0.5 * last * rate[-1]]])
            rates[axis] = np.concatenate([[0.0, 0.0], rate, [0.0]])
        return Trajectory(time_s, angles, rates, _ExtendedPlaces(self.places))

    def fastest(self, axis: int) -> float:
        """The largest rate of an axis, rad/s: at a row, or where the acceleration between two rows is 0."""
        curves = self._curves(axis, slice(None))
        with np.errstate(all="ignore"):
            u = curves.begins / (curves.begins - curves.ends)
        turning = np.flatnonzero((u > 0.0) & (u < 1.0))
        at_row = float(np.max(np.abs(self.rate_rad_s[axis])))
        between = self._curves(axis, turning).at(u[turning], 1)
        return max(at_row, float(np.max(np.abs(between), initial=0.0)))

    def check(self, limits: dict[int, AxisLimits]) -> None:
        """Raises InputError for the first row after which an axis would exceed a limit of the node."""
        found = self.first_violation(limits)
        if found is not None:
            raise InputError(found[1])

    def first_violation(self, limits: dict[int, AxisLimits]) -> tuple[int, str] | None:
        """The first row after which an axis would exceed a limit of the node, and what would happen where and when.

        Only intervals that could exceed one, by the bounds of their cubics, are looked at closely.
        """
        doubtful = np.zeros(len(self.time_s) - 1, dtype=np.bool_)
        with np.errstate(all="ignore"):  # what is not finite is a violation, too
            for axis, limit in limits.items():
                for begin in range(0, len(doubtful), _AT_ONCE):
                    part = slice(begin, min(begin + _AT_ONCE, len(doubtful)))
                    doubtful[part] |= ~self._curves(axis, part).surely_within(limit)
            rows = np.flatnonzero(doubtful)
            for begin in range(0, len(rows), _AT_ONCE):
                found = self._violation_in(rows[begin : begin + _AT_ONCE], limits)
                if found is not None:
                    return found
        return None

    def _violation_in(self, rows: NDArray[np.int64], limits: dict[int, AxisLimits]) -> tuple[int, str] | None:
        found: list[tuple[int, str]] = []
        u = np.linspace(0.0, 1.0, _LOOKS)[:, None]
        for axis, limit in limits.items():
            curves = self._curves(axis, rows)
            for values, bad, text in _violations(limit, *(curves.at(u, n) for n in range(3))):
                if bad.any():
                    first = int(np.argmax(bad.any(axis=0)))
                    worst = values[np.argmax(np.abs(values[:, first])), first]
                    found.append((int(rows[first]), f"{AXES[axis]} {text.format(float(worst))}"))
        if not found:
            return None
        row, text = min(found, key=lambda item: item[0])
        return row, f"{self.places[row]}: at {self.time_s[row]:.6g} s {text}"

    def _curves(self, axis: int, rows: NDArray[np.int64] | slice) -> _Curves:
        """Of the intervals that begin with these rows."""
        def pair(values: Real) -> tuple[Real, Real]:
            return values[:-1][rows], values[1:][rows]

        (t0, t1), (a0, a1), (r0, r1) = pair(self.time_s), pair(self.angle_rad[axis]), pair(self.rate_rad_s[axis])
        with np.errstate(all="ignore"):
            return _Curves(t1 - t0, a0, a1, r0, r1)


class _Curves:
    """The cubics of some intervals: u goes from 0 to 1 in each."""

    def __init__(self, step: Real, angle: Real, next_angle: Real, rate: Real, next_rate: Real) -> None:
        self._step, self._angle, self._next_angle = step, angle, next_angle
        self._mean = (next_angle - angle) / step
        self._rate, self._next_rate = rate, next_rate
        self._begin, self._end = rate - self._mean, next_rate - self._mean
        self.begins, self.ends = -(4 * self._begin + 2 * self._end) / step, (2 * self._begin + 4 * self._end) / step
        """Accelerations at both ends; between them, they change linearly."""

    def at(self, u: Real, derivative: int) -> Real:
        """Angles, rates or accelerations."""
        mean, begin, end = self._mean, self._begin, self._end
        if derivative == 1:
            return mean + (1 - u) * (1 - 3 * u) * begin - u * (2 - 3 * u) * end
        if derivative == 2:
            return ((6 * u - 4) * begin + (6 * u - 2) * end) / self._step
        return self._angle + self._step * u * (mean + (1 - u) * ((1 - u) * begin - u * end))

    def surely_within(self, limit: AxisLimits) -> NDArray[np.bool_]:
        """By the Bézier points of the cubics, which enclose them; False where only a closer look can tell."""
        node, third = limit.node, self._step / 3
        least = min(limit.acceleration_rad_s2, limit.deceleration_rad_s2)
        good = np.maximum(np.abs(self.begins), np.abs(self.ends)) <= least
        for angle in (self._angle, self._angle + third * self._rate, self._next_angle - third * self._next_rate, self._next_angle):
            good &= (angle >= node.lowest.value) & (angle <= node.highest.value)
        for rate in (self._rate, 3 * self._mean - self._rate - self._next_rate, self._next_rate):
            good &= np.abs(rate) <= node.fastest.value
        return np.asarray(good, dtype=np.bool_)


class _ExtendedPlaces(Sequence[str]):
    """Places of a trajectory with a start from rest and a stop."""

    def __init__(self, inner: Sequence[str]) -> None:
        self._inner = inner

    def __len__(self) -> int:
        return len(self._inner) + 3

    @overload
    def __getitem__(self, row: int) -> str: ...
    @overload
    def __getitem__(self, row: slice) -> Sequence[str]: ...
    def __getitem__(self, row: int | slice) -> str | Sequence[str]:
        if isinstance(row, slice):
            return [self[number] for number in range(*row.indices(len(self)))]
        number = range(len(self))[row]
        if number < 2:
            return f"{self._inner[0]} (start from rest)"
        if number == len(self) - 1:
            return ""
        last = len(self._inner) - 1
        return f"{self._inner[last]} (stop after it)" if number - 2 == last else self._inner[number - 2]


def _violations(limit: AxisLimits, angle: Real, rate: Real, acceleration: Real) -> list[tuple[Real, NDArray[np.bool_], str]]:
    node = limit.node
    speeding = ~(acceleration * rate < 0.0)
    return [
        (degrees(1) * angle, ~(angle >= node.lowest.value),
         f"would move to {{:.3f}}°, beyond {node.lowest}; lowest allowed: {degrees(node.lowest.value):.2f}°."),
        (degrees(1) * angle, ~(angle <= node.highest.value),
         f"would move to {{:.3f}}°, beyond {node.highest}; highest allowed: {degrees(node.highest.value):.2f}°."),
        (degrees(1) * rate, ~(np.abs(rate) <= _TOLERANCE * node.fastest.value),
         f"would turn at {{:.4g}} °/s, above {node.fastest}; at most {degrees(node.fastest.value):.4g} °/s is allowed."),
        (degrees(1) * acceleration, speeding & ~(np.abs(acceleration) <= _TOLERANCE * limit.acceleration_rad_s2),
         f"would accelerate by {{:.4g}} °/s², above 6083 ({degrees(limit.acceleration_rad_s2):.4g} °/s²)."),
        (degrees(1) * acceleration, ~speeding & ~(np.abs(acceleration) <= _TOLERANCE * limit.deceleration_rad_s2),
         f"would slow down by {{:.4g}} °/s², above 6084 ({degrees(limit.deceleration_rad_s2):.4g} °/s²)."),
    ]  # fmt: skip


# --- files ------------------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class _Column:
    kind: str
    """"time", or "azimuth" ... , or "azimuth_rate" ..."""
    factor: float


def _column(name: str) -> _Column | None:
    """What a title means; None for an unknown one."""
    for unit, factor in TIME_UNITS.items():
        if name == f"time_{unit}":
            return _Column("time", factor)
    for axis in AXES:
        for unit, factor in ANGLE_UNITS.items():
            if name == f"{axis}_{unit}":
                return _Column(axis, factor)
            if name == f"{axis}_rate_{unit}_s":
                return _Column(f"{axis}_rate", factor)
    return None


def _columns(place: str, titles: Sequence[str]) -> list[_Column]:
    found: list[_Column] = []
    for number, title in enumerate(titles, 1):
        column = _column(title.strip())
        if not title.strip():
            raise InputError(f"{place}: column {number} has no title; name it, or remove it from all rows.")
        if column is None:
            raise InputError(
                f"{place}: unknown column '{title.strip()}'; expected time_s, azimuth_deg, pitch_deg, azimuth_rate_deg_s,"
                " pitch_rate_deg_s (units: s, ms; deg, rad, mrad, urad)."
            )
        if any(column.kind == other.kind for other in found):
            raise InputError(f"{place}: {column.kind.replace('_', ' ')} has two columns; remove one of them.")
        found.append(column)
    kinds = [column.kind for column in found]
    if "time" not in kinds or not any(axis in kinds for axis in AXES):
        raise InputError(f"{place}: the title line needs time_s, and azimuth_deg or pitch_deg or both.")
    for axis in AXES:
        if f"{axis}_rate" in kinds and axis not in kinds:
            raise InputError(f"{place}: {axis} has a rate but no angle; add {axis}_deg.")
    return found


def read_trajectory(file: Path | TextFile) -> Trajectory:
    """A CSV file, a row per instant; raises InputError with file and line."""
    source = read_text(file) if isinstance(file, Path) else file
    read = read_table(source, _columns, "a trajectory", MAX_ROWS)
    columns = _columns("", read.titles)
    table = {column.kind: column.factor * read.values[:, i] for i, column in enumerate(columns)}
    places, time_s = read.places, table["time"]
    late = np.flatnonzero(np.diff(time_s) <= 0.0)
    if len(late):
        row = int(late[0]) + 1
        raise InputError(f"{places[row]}: the time {time_s[row]:g} s is not after {time_s[row - 1]:g} s, that of the row before.")
    axes = [axis for axis, name in enumerate(AXES) if name in table]
    angle = {axis: table[AXES[axis]] for axis in axes}
    rates = {axis: table.get(f"{AXES[axis]}_rate") for axis in axes}
    rate = {axis: slopes(time_s, angle[axis]) if given is None else given for axis, given in rates.items()}
    return Trajectory(time_s, angle, rate, places)


def slopes(time_s: Real, angle_rad: Real) -> Real:
    """Rates of parabolas through neighbouring rows, at most three times the mean rate beside the row: so the cubics do
    not swing out where rows are far apart or jump."""
    with np.errstate(all="ignore"):  # rows that are too close: what is not finite is refused by the limits
        mean = np.diff(angle_rad) / np.diff(time_s)
        parabolas = np.gradient(angle_rad, time_s, edge_order=2 if len(time_s) > 2 else 1)
    most = 3.0 * np.minimum(np.abs(np.append(mean, mean[-1])), np.abs(np.insert(mean, 0, mean[0])))
    return np.asarray(np.clip(parabolas, -most, most), dtype=np.float64)
