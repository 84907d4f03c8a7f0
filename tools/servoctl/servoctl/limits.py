"""What a live test may do at most, and saying what will move before it moves."""

from __future__ import annotations

import math
import time
from dataclasses import dataclass

import numpy as np

from .drive import Drive
from .errors import InputError, MotionError
from .stream import RateStream
from .units import POSITION_COUNTS_PER_RAD, degrees, radians

OVERSPEED = 2.0
"""A test is broken off when the axis is faster than this times the limit: no answer to the set-point explains that."""

REACH_RAD = (2**31 - 1) / POSITION_COUNTS_PER_RAD
"""607A and 6064 are of 32 bits."""


@dataclass(frozen=True)
class Limits:
    """Largest rate (rad/s), travel (rad) and duration (s); whether options of the command set them."""

    rate_rad_s: float
    travel_rad: float
    duration_s: float
    by_options: bool = True


def allowed_travel(drive: Drive, travel_deg: tuple[float, float] | None) -> tuple[float, float]:
    """Joint angles, rad, that the user and 607D allow; raises InputError for what neither has said."""
    limits = drive.position_limits()
    if travel_deg is None and limits is None:
        raise InputError(
            f"{drive.name} has no position limits (607D): say between which joint angles it may move, as in"
            " --travel-deg -150 150."
        )
    low, high = (radians(angle) for angle in travel_deg) if travel_deg else limits or (0.0, 0.0)
    if not (math.isfinite(low) and math.isfinite(high) and low < high):
        raise InputError("--travel-deg wants two angles in °, the lower one first.")
    if limits and (low < limits[0] or high > limits[1]):
        raise InputError(
            f"--travel-deg {degrees(low):.5g} {degrees(high):.5g} is beyond 607D:"
            f" {degrees(limits[0]):.5g}° to {degrees(limits[1]):.5g}°."
        )
    return low, high


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
                more = f", or allow more with {option}" if limits.by_options else ""
                raise InputError(
                    f"the {what} would be {value:.3g} {unit}, more than {limit:.3g} {unit}: ask for less{more}."
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

    def check_travel(self, drive: Drive, allowed: tuple[float, float]) -> None:
        """Raises InputError when it would leave these joint angles, rad."""
        here = drive.position()
        first, last = here - self.backward_rad, here + self.forward_rad
        if not allowed[0] <= first <= last <= allowed[1]:
            raise InputError(
                f"{self.axis} would move from {degrees(first):.1f}° to {degrees(last):.1f}°, beyond"
                f" {degrees(allowed[0]):.5g}° to {degrees(allowed[1]):.5g}°: move it away from there first, or turn the"
                " other way with a negative --bias."
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
