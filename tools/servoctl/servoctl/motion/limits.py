# SPDX-License-Identifier: Apache-2.0
"""Limits of a live test, and the announcement of a motion before it starts. The node's own limits: node_limits.py."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..drive.drive import Drive
from ..drive.node_limits import NodeLimits, read_limits
from ..errors import InputError, MotionError
from ..link.stream import RateStream
from ..units import TICK_S, degrees, radians

OVERSPEED = 2.0
"""A test is aborted when the axis is faster than this times the limit: no response to the set-point explains that."""


@dataclass(frozen=True)
class Limits:
    """Largest rate (rad/s), travel (rad) and duration (s); whether options of the command set them."""

    rate_rad_s: float
    travel_rad: float
    duration_s: float
    by_options: bool = True


def allowed_travel(drive: Drive, travel_deg: tuple[float, float] | None) -> NodeLimits:
    """The node's limits within the travel that the user allows; raises InputError when neither gives a travel."""
    node = read_limits(drive)
    if travel_deg is not None:
        return node.within(travel_deg)
    if not node.has_travel:
        raise InputError(
            f"{drive.name} has no travel limits (607D, 2060:9 and 2060:10). Give the joint angles between which it"
            " may move, e.g. --travel-deg -150 150."
        )
    return node


@dataclass(frozen=True)
class Plan:
    """The motion of a test: one line for people, and its extremes in rad, rad/s and s."""

    axis: str
    text: str
    rate_rad_s: float
    forward_rad: float
    backward_rad: float
    duration_s: float

    def check(self, limits: Limits, drive: Drive | None = None) -> None:
        """Raises InputError when the plan is beyond the node's limits, or beyond the user's."""
        if drive is not None:
            node = read_limits(drive)
            node.check_rate(self.rate_rad_s)
            node.check_travel(self.axis, drive.position(), self.backward_rad, self.forward_rad)
        travel = self.forward_rad + self.backward_rad
        for what, value, limit, unit, option in (
            ("rate", degrees(self.rate_rad_s), degrees(limits.rate_rad_s), "°/s", "--max-rate"),
            ("travel", degrees(travel), degrees(limits.travel_rad), "°", "--max-travel"),
            ("duration", self.duration_s, limits.duration_s, "s", "--max-duration"),
        ):
            if not value <= limit * 1.0001:
                more = f", or raise {option}" if limits.by_options else ""
                raise InputError(
                    f"the {what} would be {value:.3g} {unit}, but at most {limit:.3g} {unit} is allowed: request"
                    f" less{more}."
                )


class Guard:
    """Monitors the axis while it moves; raises MotionError when its motion is not explained by the plan."""

    def __init__(self, stream: RateStream, limits: Limits) -> None:
        self._stream = stream
        self._limits = limits
        self._travel_rad = 0.0
        self._last_tick = 0

    def look(self) -> None:
        """Call every few ms."""
        self._stream.check_alive()
        rate = self._stream.latest()
        tick = self._stream.ticks()
        if rate is not None:
            self._travel_rad += rate * (tick - self._last_tick) * TICK_S
            if not abs(rate) <= OVERSPEED * self._limits.rate_rad_s:
                raise MotionError(f"the axis moves at {degrees(rate):.3g} °/s, much faster than commanded.")
            if not abs(self._travel_rad) <= 1.2 * self._limits.travel_rad:
                raise MotionError(f"the axis has travelled {degrees(self._travel_rad):.3g}°, more than allowed.")
        self._last_tick = tick


def span(rates_rad_s: np.ndarray[tuple[int], np.dtype[np.float64]], period_s: float) -> tuple[float, float]:
    """Forward and backward travel, rad, of a sequence of rates."""
    displacement = np.concatenate([[0.0], np.cumsum(rates_rad_s) * period_s])
    return float(displacement.max()), float(-displacement.min()) + 0.0
