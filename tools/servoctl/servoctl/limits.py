"""What a live test may do at most, and saying what will move before it moves."""

from __future__ import annotations

import time
from dataclasses import dataclass

import numpy as np

from .drive import Drive
from .errors import InputError, MotionError
from .stream import RateStream
from .units import POSITION_COUNTS_PER_RAD, degrees

OVERSPEED = 2.0
"""A test is broken off when the axis is faster than this times the limit: no answer to the set-point explains that."""

REACH_RAD = (2**31 - 1) / POSITION_COUNTS_PER_RAD
"""607A and 6064 are of 32 bits."""


@dataclass(frozen=True)
class Limits:
    """Largest rate (rad/s), travel (rad) and duration (s)."""

    rate_rad_s: float
    travel_rad: float
    duration_s: float


@dataclass(frozen=True)
class Plan:
    """What a test will do: one line for people, and its extremes in rad, rad/s and s."""

    axis: str
    text: str
    rate_rad_s: float
    forward_rad: float
    backward_rad: float
    duration_s: float

    def check(self, limits: Limits, drive: Drive | None = None) -> None:
        """Raises InputError when the plan is beyond the limits, or beyond 607D and 607F of the axis."""
        travel = self.forward_rad + self.backward_rad
        for what, value, limit, unit, option in (
            ("rate", degrees(self.rate_rad_s), degrees(limits.rate_rad_s), "°/s", "--max-rate"),
            ("travel", degrees(travel), degrees(limits.travel_rad), "°", "--max-travel"),
            ("duration", self.duration_s, limits.duration_s, "s", "--max-duration"),
        ):
            if not value <= limit * 1.0001:
                raise InputError(
                    f"the {what} would be {value:.3g} {unit}, more than {limit:.3g} {unit}: ask for less, or allow more"
                    f" with {option}."
                )
        if drive is None:
            return
        if not self.rate_rad_s <= drive.rate_limit():
            raise InputError(
                f"the rate would be {degrees(self.rate_rad_s):.3g} °/s, more than 607F allows: {degrees(drive.rate_limit()):.3g} °/s."
            )
        allowed = drive.position_limits()
        here = drive.position()
        if not -REACH_RAD <= here - self.backward_rad <= here + self.forward_rad <= REACH_RAD:
            raise InputError(
                f"{self.axis} would move from {degrees(here - self.backward_rad):.5g}° to {degrees(here + self.forward_rad):.5g}°,"
                f" but the device counts angles up to ±{degrees(REACH_RAD):.5g}° only."
            )
        if allowed and not allowed[0] <= here - self.backward_rad <= here + self.forward_rad <= allowed[1]:
            raise InputError(
                f"{self.axis} is at {degrees(here):.2f}° and would move from {degrees(here - self.backward_rad):.2f}° to"
                f" {degrees(here + self.forward_rad):.2f}°, beyond 607D: {degrees(allowed[0]):.2f}° to {degrees(allowed[1]):.2f}°."
            )


class Guard:
    """Looks at the axis while it moves; raises MotionError when it does what the plan does not explain."""

    def __init__(self, stream: RateStream, limits: Limits) -> None:
        self._stream = stream
        self._limits = limits
        self._travel_rad = 0.0
        self._last_s = time.monotonic()

    def look(self) -> None:
        """Call every few ms."""
        self._stream.check_alive()
        rate = self._stream.latest()
        now = time.monotonic()
        if rate is not None:
            self._travel_rad += rate * (now - self._last_s)
            if not abs(rate) <= OVERSPEED * self._limits.rate_rad_s:
                raise MotionError(f"the axis moves at {degrees(rate):.3g} °/s, far more than asked for.")
            if not abs(self._travel_rad) <= 1.2 * self._limits.travel_rad:
                raise MotionError(f"the axis has travelled {degrees(self._travel_rad):.3g}°, more than allowed.")
        self._last_s = now


def span(rates_rad_s: np.ndarray[tuple[int], np.dtype[np.float64]], period_s: float) -> tuple[float, float]:
    """Forward and backward travel, rad, of a sequence of rates."""
    way = np.concatenate([[0.0], np.cumsum(rates_rad_s) * period_s])
    return float(way.max()), float(-way.min()) + 0.0
