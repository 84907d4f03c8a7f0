# SPDX-License-Identifier: Apache-2.0
"""Numbers with units, as users type them and as the device counts them.

Angles and rates are typed in degrees or radians; the device counts positions in 1e-7 rad and rates in 1e-6 rad/s
(objects 60A8 and 60A9).
"""

from __future__ import annotations

import math
import re

from .errors import InputError

POSITION_COUNTS_PER_RAD = 1e7
POSITION_RANGE_RAD = 64 * 2 * math.pi
"""Range of positions (607B) of an axis without a limited travel: beyond it they wrap, by whole ranges."""
RATE_COUNTS_PER_RAD_S = 1e6
TORQUE_COUNTS_OF_RATED = 1e3
TICK_S = 0.001

_DEGREE = math.pi / 180.0

_FACTORS: dict[str, dict[str, float]] = {
    "rad": {"rad": 1.0, "mrad": 1e-3, "urad": 1e-6, "deg": _DEGREE, "°": _DEGREE},
    "rad/s": {"rad/s": 1.0, "mrad/s": 1e-3, "urad/s": 1e-6, "deg/s": _DEGREE, "°/s": _DEGREE, "rpm": math.pi / 30},
    "rad/s^2": {"rad/s^2": 1.0, "deg/s^2": _DEGREE, "°/s^2": _DEGREE, "°/s²": _DEGREE},
    "s": {"s": 1.0, "ms": 1e-3, "us": 1e-6, "min": 60.0},
    "Hz": {"Hz": 1.0, "kHz": 1e3, "rad/s": 1 / (2 * math.pi)},
    "N m": {"N m": 1.0, "Nm": 1.0, "mNm": 1e-3, "mN m": 1e-3},
    "A": {"A": 1.0, "mA": 1e-3},
    "ohm": {"ohm": 1.0, "mohm": 1e-3},
    "H": {"H": 1.0, "mH": 1e-3, "uH": 1e-6},
}
"""Factors to the SI unit, by that unit."""

_QUANTITY = re.compile(
    r"\s*([-+]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][-+]?[0-9]+)?|[-+]?(?:inf|nan))(?![\d_])\s*(.*?)\s*$", re.IGNORECASE
)


def is_plain(text: str) -> bool:
    """No underscores and no digits of other scripts, which only Python takes in a number."""
    return text.isascii() and "_" not in text


def whole_number(text: str) -> int:
    """Of decimal digits or 0x; raises InputError."""
    try:
        return int(text if is_plain(text) else "", 0)
    except ValueError:
        raise InputError(f"'{text}' is not a whole number.") from None


def parse_quantity(text: str, unit: str, bare: str | None = None) -> float:
    """The value of "5 deg" in `unit`; a bare number is in `bare` (default: `unit`).

    Raises InputError for text that is no number or has a unit that does not fit.
    """
    match = _QUANTITY.match(text)
    if match is None:
        raise InputError(f"'{text}' is not a number{f' in {unit}' if unit else ''}.")
    value, typed = float(match.group(1)), match.group(2)
    if not typed:
        typed = bare or unit
    if _plain(typed) == _plain(unit):
        return value
    factors = _FACTORS.get(unit, {})
    if typed not in factors:
        right = ", ".join(factors) or unit or "a number without unit"
        raise InputError(f"'{text}' has the unit '{typed}', which does not fit; expected: {right}.")
    return value * factors[typed]


def _plain(unit: str) -> str:
    return unit.replace(" ", "").replace("*", "").replace("·", "")


def degrees(radians: float) -> float:
    """Radians to degrees, also per second."""
    return radians / _DEGREE


def radians(value_deg: float) -> float:
    """Degrees to radians, also per second."""
    return value_deg * _DEGREE


class Shown:
    """Form of a unit's values for people: angles and rates in degrees, with as many places as the sensors justify."""

    def __init__(self, unit: str) -> None:
        """`unit` is that of the values."""
        self.unit, self.factor, self._places = _SHOWN.get(unit, (unit, 1.0, None))

    def text(self, value: float) -> str:
        """A value of the device's unit, in `self.unit`."""
        return f"{value:.5g}" if self._places is None else f"{value * self.factor:.{self._places}f}"


_SHOWN: dict[str, tuple[str, float, int | None]] = {
    "rad": ("°", 1 / _DEGREE, 4), "rad/s": ("°/s", 1 / _DEGREE, 4), "N m": ("N m", 1.0, 3), "A": ("A", 1.0, 3),
    "V": ("V", 1.0, 2),
}  # fmt: skip


def rounded(value: float | int | bool | str | bytes | None) -> str:
    """A value for comparing at a glance: six digits."""
    return f"{value:.6g}" if isinstance(value, float) else number(value)


def number(value: float | int | bool | str | bytes | None) -> str:
    """A value as printed: the shortest text that is this float32, integers unchanged."""
    if value is None:
        return "–"
    if isinstance(value, bytes):
        return f"{len(value)} bytes"
    if isinstance(value, float):
        if value == 0 or 1e-4 <= abs(value) < 1e7:
            text = f"{value:.10f}".rstrip("0")
            return text + "0" if text.endswith(".") else text
        return f"{value:g}" if float(f"{value:g}") == value else repr(value)
    return str(value)
