# SPDX-License-Identifier: Apache-2.0
"""The numbers of all options: with a unit, finite, and in a sensible range."""

from __future__ import annotations

import math
from typing import Any

import click

from ..errors import InputError
from ..units import is_plain, parse_quantity


class Whole(click.IntRange):
    """Refuses 1_000 and digits of other scripts, which are whole numbers to click."""

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> int:
        """As click does."""
        if isinstance(value, str) and not is_plain(value):
            self.fail(f"'{value}' is not a whole number.", param, ctx)
        return int(super().convert(value, param, ctx))


class Quantity(click.ParamType):  # type: ignore[type-arg] # not generic in click 8.1
    """A number with a unit, e.g. "5deg" or "0.1 rad/s"; bare numbers are in `bare`. Refuses values that are not
    finite."""

    name = "value"

    def __init__(
        self, unit: str, bare: str = "", low: float = -math.inf, high: float = math.inf, above: float = -math.inf
    ) -> None:
        """`low`, `high` and `above`, in `unit`: the value is low to high, and more than `above`."""
        self.unit = unit
        self.bare = bare or unit
        self.low = low
        self.high = high
        self.above = above

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> float:
        """To the SI unit."""
        try:
            found = float(value) if isinstance(value, float) else parse_quantity(str(value), self.unit, self.bare)
        except InputError as error:
            self.fail(str(error), param, ctx)
        if not math.isfinite(found):
            self.fail(f"'{value}' is not a finite number.", param, ctx)
        if not found > self.above:
            self.fail(f"'{value}' must be greater than {self.above:g}.", param, ctx)
        if not self.low <= found <= self.high:
            right = f"{self.low:g} or more" if math.isinf(self.high) else f"{self.low:g} to {self.high:g}"
            self.fail(f"'{value}' must be {right} {self.unit}".rstrip() + ".", param, ctx)
        return found

    def get_metavar(self, param: click.Parameter, ctx: click.Context) -> str:
        """The unit of bare numbers."""
        return self.bare.replace("deg", "°") or "NUMBER"


ANGLE = Quantity("rad", "deg")
DEGREES = Quantity("deg")
RATE = Quantity("rad/s", "deg/s")
LONGEST_TRAVEL = Quantity("rad", "deg", above=0.0)
FASTEST_RATE = Quantity("rad/s", "deg/s", above=0.0)
DURATION = Quantity("s", low=0.001)
LEAD = Quantity("s", low=0.0)
FREQUENCY = Quantity("Hz", above=0.0)
