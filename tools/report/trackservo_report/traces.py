# SPDX-License-Identifier: Apache-2.0
"""Time and frequency series from the CSV files, and their thinning for display."""

from __future__ import annotations

import itertools
import math
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from .load import InputError
from .text import read_text

Series = NDArray[np.float64]

MAX_POINTS = 1200
"""Points of one curve on the page, nearly two per pixel of a plot; keeps it responsive and the file small."""
STEPS_OF_RANGE = 2000
"""A drawn curve is rounded to its range by this, a fifth of a pixel; what is rounded can be compressed."""


def read_columns(file: Path, columns: list[str], blanks: bool = True) -> dict[str, Series]:
    """The named columns of a CSV with one header line; blank cells become NaN, or an error without `blanks`."""
    lines = (line for _, line in read_text(file).lines())
    header = [name.strip() for name in next(lines, "").split(",")]
    places = [_place(file, header, name) for name in columns]
    try:
        table = np.loadtxt(lines, delimiter=",", usecols=places, ndmin=2, converters=_number if blanks else None)
    except (ValueError, IndexError) as error:
        raise InputError(f"{file}: not a table of numbers: {error}.") from error
    if table.shape[0] < 2:
        raise InputError(f"{file}: fewer than two lines of data.")
    return {name: table[:, index] for index, name in enumerate(columns)}


def read_run(file: Path, columns: list[str]) -> dict[str, Series]:
    """As `read_columns`, for a run: time first, every value finite, time rising."""
    data = read_columns(file, ["time_s", *columns], blanks=False)
    for name, values in data.items():
        if not np.all(np.isfinite(values)):
            raise InputError(f"{file}: column {name} has a value that is not a finite number.")
    if np.any(np.diff(data["time_s"]) <= 0.0):
        raise InputError(f"{file}: time_s does not rise from line to line.")
    return data


def _place(file: Path, header: list[str], name: str) -> int:
    if name not in header:
        raise InputError(f"{file}: column {name} is missing.")
    return header.index(name)


def _number(cell: str) -> float:
    return float(cell) if cell.strip() else float("nan")


def thin(time: Series, values: Series, points: int = MAX_POINTS) -> tuple[Series, Series]:
    """Keep the smallest and the largest sample of each stretch, so that no peak is lost; same units out as in."""
    if time.size <= points:
        return time, values
    edges = np.linspace(0, time.size, points // 2 + 1).astype(int)
    stretches = list(itertools.pairwise(edges))
    lows = [start + np.argmin(values[start:end]) for start, end in stretches]
    highs = [start + np.argmax(values[start:end]) for start, end in stretches]
    keep = np.unique(np.concatenate([[0], lows, highs, [time.size - 1]]))
    return time[keep], values[keep]


def coarse(values: Series) -> list[float]:
    """Values for drawing: rounded to a decimal near their range / `STEPS_OF_RANGE`; as text they compress better than bits."""
    reach = float(np.ptp(values))
    digits = 0 if reach == 0.0 else max(0, math.ceil(-math.log10(reach / STEPS_OF_RANGE)))
    return [round(float(value), digits) for value in values]


def window(time: Series, values: Series, start: float, end: float) -> tuple[Series, Series]:
    """The part of a curve between two times, in seconds."""
    inside = (time >= start) & (time <= end)
    return time[inside], values[inside]
