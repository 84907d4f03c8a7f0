# SPDX-License-Identifier: Apache-2.0
"""Which joint angle lasts longest: an axis that turns by more than one revolution between its limits can look in some
directions with two angles, one revolution apart (as firmware/control/cable_wrap.h)."""

from __future__ import annotations

import math
from collections.abc import Sequence

from ..drive.drive import Drive
from ..drive.node_limits import NodeLimits, read_limits
from ..errors import InputError
from ..units import degrees
from .trajectory import AxisLimits, Trajectory

AZIMUTH = 0
REVOLUTION = 2 * math.pi
TURNS = (0, 1, -1)
"""Revolutions that are tried, the given angle first."""


def lasts_s(limits: NodeLimits, angle_rad: float, rate_rad_s: float) -> float:
    """How long an axis can go on from this angle at this rate: negative outside of the travel, infinite at rest."""
    if not limits.lowest.value <= angle_rad <= limits.highest.value:
        return -1.0
    if rate_rad_s == 0.0:
        return math.inf
    return ((limits.lowest.value if rate_rad_s < 0.0 else limits.highest.value) - angle_rad) / rate_rad_s


def longest_lasting(limits: NodeLimits, angle_rad: float, rate_rad_s: float | None) -> int:
    """Revolutions to add to an angle so that it lasts longest at this rate; an unknown rate (None) counts as one of 1 rad/s
    towards the nearer limit. 0 when no other one is better."""
    if not limits.has_travel:
        return 0
    rates = (1.0, -1.0) if rate_rad_s is None else (rate_rad_s,)
    return max(TURNS, key=lambda turns: min(lasts_s(limits, angle_rad + turns * REVOLUTION, rate) for rate in rates))


def lasting_cue(drive: Drive, angle_rad: float, rate_rad_s: float | None) -> tuple[float, str]:
    """The azimuth of a cue that lasts longest, and how it came about ("": as given)."""
    turns = longest_lasting(read_limits(drive), angle_rad, rate_rad_s)
    return angle_rad + turns * REVOLUTION, turned_text(angle_rad, turns)


def turned_text(angle_rad: float, turns: int) -> str:
    """How an angle came about, for a line; "" for the given one."""
    if turns == 0:
        return ""
    return f" ({degrees(angle_rad):.3f}° {'+' if turns > 0 else '−'} {360 * abs(turns)}°, which lasts longer)"


def with_turns(trajectory: Trajectory) -> list[Trajectory]:
    """The trajectory, and the same one with the azimuth a revolution further and back."""
    return [trajectory.turned(AZIMUTH, turns) for turns in TURNS] if AZIMUTH in trajectory.angle_rad else [trajectory]


def longest_within(candidates: Sequence[Trajectory], limits: dict[int, AxisLimits]) -> int:
    """The number of the first one that keeps the limits; raises InputError with the reason of the one that lasts
    longest."""
    found = [trajectory.first_violation(limits) for trajectory in candidates]
    rows, texts = [], []
    for number, violation in enumerate(found):
        if violation is None:
            return number
        rows.append(violation[0])
        texts.append(violation[1])
    best = rows.index(max(rows))
    text = texts[best]
    if len(set(rows)) > 1:
        text = f"{text.removesuffix('.')}; of all whole turns of the azimuth, {360 * TURNS[best]:+d}° lasts longest."
    raise InputError(text)
