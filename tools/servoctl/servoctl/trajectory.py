"""A trajectory of the joints over time: read from CSV, interpolated, and checked against the node's limits.

Between two rows the angle is the cubic that has the angle and the rate of both rows (cubic Hermite). A file without
rates gets those of parabolas through neighbouring rows.
"""

from __future__ import annotations

import csv
import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from .errors import InputError
from .node_limits import NodeLimits
from .parameter import AXES
from .units import degrees, radians

Real = NDArray[np.float64]

TIME_UNITS = {"s": 1.0, "ms": 1e-3}
ANGLE_UNITS = {"deg": radians(1.0), "rad": 1.0, "mrad": 1e-3, "urad": 1e-6}
LARGEST = 1e12
"""Of a number in the file, in its unit: beyond it, the computation would be inexact."""
MAX_ROWS = 200_000
MAX_BYTES = 50_000_000
_NUMBER = re.compile(r"\s*[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?\s*")
_LOOKS = 33
"""Instants of each interval at which angle and rate are checked; the acceleration is largest at its ends."""


@dataclass(frozen=True)
class AxisLimits:
    """What a trajectory of one axis must keep: travel and rate (node_limits.py), and 6083 and 6084 in rad/s²."""

    node: NodeLimits
    acceleration_rad_s2: float
    deceleration_rad_s2: float


@dataclass(frozen=True)
class Trajectory:
    """Angles (rad) and rates (rad/s) of some axes, by axis number, at increasing times (s); `places` names each row."""

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
        places = [f"{self.places[0]} (start from rest)"] * 2 + [*self.places[:-1]]
        return Trajectory(time_s, angles, rates, [*places, f"{self.places[-1]} (stop after it)", ""])

    def fastest(self, axis: int) -> float:
        """The largest rate of an axis, rad/s."""
        row, time_s = self._instants()
        return float(np.max(np.abs(self._at(axis, row, time_s, 1))))

    def _instants(self) -> tuple[NDArray[np.int64], Real]:
        """`_LOOKS` of each interval, with its number."""
        time_s = self.time_s[:-1, None] + np.diff(self.time_s)[:, None] * np.linspace(0.0, 1.0, _LOOKS)
        return np.repeat(np.arange(len(self.time_s) - 1), _LOOKS), time_s.ravel()

    def check(self, limits: dict[int, AxisLimits]) -> None:
        """Raises InputError for the first row after which an axis would exceed a limit of the node."""
        found = self.first_violation(limits)
        if found is not None:
            raise InputError(found[1])

    def first_violation(self, limits: dict[int, AxisLimits]) -> tuple[int, str] | None:
        """The first row after which an axis would exceed a limit of the node, and what would happen where and when."""
        row, time_s = self._instants()
        found: list[tuple[int, str]] = []
        for axis, limit in limits.items():
            with np.errstate(all="ignore"):  # what is not finite is a violation, too
                violations = _violations(limit, *(self._at(axis, row, time_s, n) for n in range(3)))
            for values, bad, text in violations:
                if bad.any():
                    first = int(np.argmax(bad))
                    worst = values[row == row[first]][np.argmax(np.abs(values[row == row[first]]))]
                    found.append((int(row[first]), f"{AXES[axis]} {text.format(float(worst))}"))
        if not found:
            return None
        row_number, text = min(found, key=lambda item: item[0])
        return row_number, f"{self.places[row_number]}: at {self.time_s[row_number]:.6g} s {text}"

    def _at(self, axis: int, row: NDArray[np.int64], time_s: Real, derivative: int) -> Real:
        """Of the interval `row`, also at its end, where the next one begins."""
        inside = np.minimum(time_s, np.nextafter(self.time_s[row + 1], -np.inf))
        return self._hermite(axis, inside, derivative)


def _violations(limit: AxisLimits, angle: Real, rate: Real, acceleration: Real) -> list[tuple[Real, NDArray[np.bool_], str]]:
    node = limit.node
    speeding = ~(acceleration * rate < 0.0)
    tolerance = 1.0 + 1e-6
    return [
        (degrees(1) * angle, ~(angle >= node.lowest.value),
         f"would move to {{:.3f}}°, beyond {node.lowest}; lowest allowed: {degrees(node.lowest.value):.2f}°."),
        (degrees(1) * angle, ~(angle <= node.highest.value),
         f"would move to {{:.3f}}°, beyond {node.highest}; highest allowed: {degrees(node.highest.value):.2f}°."),
        (degrees(1) * rate, ~(np.abs(rate) <= tolerance * node.fastest.value),
         f"would turn at {{:.4g}} °/s, above {node.fastest}; at most {degrees(node.fastest.value):.4g} °/s is allowed."),
        (degrees(1) * acceleration, speeding & ~(np.abs(acceleration) <= tolerance * limit.acceleration_rad_s2),
         f"would accelerate by {{:.4g}} °/s², above 6083 ({degrees(limit.acceleration_rad_s2):.4g} °/s²)."),
        (degrees(1) * acceleration, ~speeding & ~(np.abs(acceleration) <= tolerance * limit.deceleration_rad_s2),
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
    for title in titles:
        column = _column(title.strip())
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


def _cells(place: str, line: str) -> list[str]:
    try:
        return next(csv.reader([line], strict=True))
    except csv.Error as error:
        raise InputError(f"{place}: is not a row of a CSV file: {error}.") from error


def _number(place: str, title: str, text: str) -> float:
    value = float(text) if _NUMBER.fullmatch(text) else np.nan
    if not np.abs(value) <= LARGEST:
        raise InputError(f"{place}: {title.strip()} is '{text.strip()}', expected a number from {-LARGEST:g} to {LARGEST:g}.")
    return value


def read_trajectory(path: Path) -> Trajectory:
    """A CSV file, a row per instant; raises InputError with file and line."""
    try:
        if path.exists() and not path.is_file():
            raise InputError(f"{path}: is not a file.")
        if (size := path.stat().st_size) > MAX_BYTES:
            raise InputError(f"{path}: has {size / 1e6:.0f} MB; at most {MAX_BYTES / 1e6:.0f} MB can be followed.")
        text = path.read_text(encoding="utf-8-sig")
    except (OSError, UnicodeDecodeError) as error:
        reason = error.strerror if isinstance(error, OSError) else "it is not a text file"
        raise InputError(f"{path}: cannot be read: {reason}.") from error
    lines = [(number, line) for number, line in enumerate(text.splitlines(), 1) if line.strip() and line.lstrip()[0] != "#"]
    if len(lines) > MAX_ROWS:
        raise InputError(f"{path}:{lines[MAX_ROWS][0]}: the trajectory has {len(lines) - 1} rows; at most {MAX_ROWS - 1} can be followed.")
    rows = [(number, _cells(f"{path}:{number}", line)) for number, line in lines]
    if len(rows) < 3:
        raise InputError(f"{path}:{rows[-1][0] if rows else 1}: a trajectory needs a title line and at least two rows.")
    titles = rows[0][1]
    columns = _columns(f"{path}:{rows[0][0]}", titles)
    values, places = [], []
    for number, cells in rows[1:]:
        place = f"{path}:{number}"
        if len(cells) != len(columns):
            raise InputError(f"{place}: {len(cells)} values, but the title line has {len(columns)} columns.")
        values.append([
            column.factor * _number(place, title, cell) for column, title, cell in zip(columns, titles, cells, strict=True)
        ])  # fmt: skip
        places.append(place)
    table = {column.kind: np.array(values).T[i] for i, column in enumerate(columns)}
    time_s = table["time"]
    late = np.flatnonzero(np.diff(time_s) <= 0.0)
    if len(late):
        row = int(late[0]) + 1
        raise InputError(f"{places[row]}: the time {time_s[row]:g} s is not after {time_s[row - 1]:g} s, that of the row before.")
    axes = [axis for axis, name in enumerate(AXES) if name in table]
    angle = {axis: table[AXES[axis]] for axis in axes}
    rate = {axis: table.get(f"{AXES[axis]}_rate", slopes(time_s, angle[axis])) for axis in axes}
    return Trajectory(time_s, angle, rate, places)


def slopes(time_s: Real, angle_rad: Real) -> Real:
    """Rates of parabolas through neighbouring rows, at most three times the mean rate beside the row: so the cubics do
    not swing out where rows are far apart or jump."""
    with np.errstate(all="ignore"):  # rows that are too close: what is not finite is refused by the limits
        mean = np.diff(angle_rad) / np.diff(time_s)
        parabolas = np.gradient(angle_rad, time_s, edge_order=2 if len(time_s) > 2 else 1)
    most = 3.0 * np.minimum(np.abs(np.append(mean, mean[-1])), np.abs(np.insert(mean, 0, mean[0])))
    return np.asarray(np.clip(parabolas, -most, most), dtype=np.float64)
