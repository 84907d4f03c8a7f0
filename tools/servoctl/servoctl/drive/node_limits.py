# SPDX-License-Identifier: Apache-2.0
"""The node's own limits of a motion: travel and rate, each with its object.

A motion is checked against all of them before it begins, because the node would stop a motion beyond them, or go into a
fault.
"""

from __future__ import annotations

import math
import struct
from dataclasses import dataclass

from ..errors import InputError
from ..objects.parameter import AXIS_SHIFT
from ..units import POSITION_RANGE_RAD, degrees, radians
from .drive import Drive

REACH_RAD = 31.5 / 64 * POSITION_RANGE_RAD
"""The longest motion of an axis without a limited travel: its targets are taken on the shorter way."""
HARD_MARGIN_RAD = radians(0.25)
"""Distance kept from the hard limits, which are a fault when the axis passes them while stopping; for nodes without
2060:17."""
OVER_SPEED_SHARE = 0.8
"""Share of the rate that is a fault; the node lets no set-point exceed it."""
GYRO_SHARE = 0.9
"""Share of the gyro's range: rates overshoot, and sensors are noisy."""
_PROTECTION, _OVER_SPEED, _GYRO_RANGE, _HARD_MINIMUM, _HARD_MAXIMUM, _STOPPING_MARGIN = 0x2060, 1, 3, 9, 10, 17


@dataclass(frozen=True)
class Bound:
    """A number that the node limits, in rad or rad/s, and its text."""

    value: float
    source: str

    def __str__(self) -> str:
        return self.source


@dataclass(frozen=True)
class NodeLimits:
    """The tightest of each kind. Angles are joint angles."""

    lowest: Bound
    highest: Bound
    fastest: Bound
    has_travel: bool = True
    """A limit of the travel is set; otherwise a motion may go `REACH_RAD` from here."""

    def within(self, travel_deg: tuple[float, float]) -> NodeLimits:
        """These limits with a smaller travel, ° of the joint; raises InputError when it exceeds them."""
        low, high = (radians(angle) for angle in travel_deg)
        if not (math.isfinite(low) and math.isfinite(high) and low < high):
            raise InputError("--travel-deg needs two angles in °, the lower one first.")
        given = f"--travel-deg {degrees(low):.5g} {degrees(high):.5g}"
        for beyond, bound in ((low < self.lowest.value, self.lowest), (high > self.highest.value, self.highest)):
            if beyond:
                raise InputError(
                    f"{given} exceeds {bound}; allowed: {degrees(self.lowest.value):.5g} to"
                    f" {degrees(self.highest.value):.5g}."
                )
        return NodeLimits(Bound(low, given), Bound(high, given), self.fastest, self.has_travel)

    def check_rate(self, rate_rad_s: float) -> None:
        """Raises InputError that names the limit, its value and an allowed value."""
        if not rate_rad_s <= self.fastest.value:
            raise InputError(
                f"the rate would be {degrees(rate_rad_s):.5g} °/s, above {self.fastest}; at most"
                f" {_down(degrees(self.fastest.value))} °/s is allowed."
            )

    def check_travel(self, axis: str, here_rad: float, backward_rad: float, forward_rad: float) -> None:
        """The same for a motion over this distance from the position of the axis; motions back from beyond a limit are
        allowed."""
        room_back, room_forward = here_rad - self.lowest.value, self.highest.value - here_rad
        for travel, room, end, bound in (
            (forward_rad, room_forward, here_rad + forward_rad, self.highest),
            (backward_rad, room_back, here_rad - backward_rad, self.lowest),
        ):
            if travel > 0.0 and not travel <= room or travel != travel:
                raise InputError(
                    f"{axis} is at {degrees(here_rad):.2f}° and would move to {degrees(end):.2f}°, beyond {bound}."
                    f" From here at most {_down(degrees(max(room_forward, 0.0)))}° forward and"
                    f" {_down(degrees(max(room_back, 0.0)))}° back are allowed ({degrees(self.lowest.value):.2f}°"
                    f" to {degrees(self.highest.value):.2f}°)."
                )


def limits_data(limits: NodeLimits) -> dict[str, float | None]:
    """For a page, in ° and °/s; None for a travel without limit."""
    return {
        "low_deg": degrees(limits.lowest.value) if limits.has_travel else None,
        "high_deg": degrees(limits.highest.value) if limits.has_travel else None,
        "rate_deg_s": degrees(limits.fastest.value),
    }


def _down(value: float) -> str:
    """Rounded so that the printed value is within."""
    return f"{int(value * 100) / 100:.2f}"


def read_limits(drive: Drive) -> NodeLimits:
    """The node's present values."""
    lowest: list[Bound] = []
    highest: list[Bound] = []
    software = drive.position_limits()
    if software is not None:
        for bounds, sub, value in ((lowest, 1, software[0]), (highest, 2, software[1])):
            bounds.append(Bound(value, f"its software limit 607D:{sub} ({degrees(value):.2f}°)"))
    low, high = _protection(drive, _HARD_MINIMUM), _protection(drive, _HARD_MAXIMUM)
    if low is not None and high is not None and low < high:
        known = _protection(drive, _STOPPING_MARGIN)
        margin = HARD_MARGIN_RAD if known is None else known
        kept = f"{degrees(margin):.3g}° margin"
        for bounds, sub, value, inward in ((lowest, _HARD_MINIMUM, low, 1), (highest, _HARD_MAXIMUM, high, -1)):
            text = f"its hard limit 2060:{sub} ({degrees(value):.2f}°, {kept})"
            bounds.append(Bound(value + inward * margin, text))
    profile = drive.rate_limit()
    fastest = [Bound(profile, f"607F ({degrees(profile):.5g} °/s)")]
    for sub, name, share in (
        (_OVER_SPEED, "the over-speed limit", OVER_SPEED_SHARE), (_GYRO_RANGE, "the gyro's range", GYRO_SHARE),
    ):  # fmt: skip
        limit = _protection(drive, sub)
        if limit is not None:
            source = f"{name} 2060:{sub} ({100 * share:.0f} % of {degrees(limit):.5g} °/s)"
            fastest.append(Bound(share * limit, source))
    has_travel = bool(lowest)
    if not has_travel:
        here, source = drive.position(), "the longest motion without a limited travel (31.5 turns)"
        lowest, highest = [Bound(here - REACH_RAD, source)], [Bound(here + REACH_RAD, source)]
    return NodeLimits(
        max(lowest, key=lambda bound: bound.value),
        min(highest, key=lambda bound: bound.value),
        min(fastest, key=lambda bound: bound.value),
        has_travel,
    )


def _protection(drive: Drive, sub: int) -> float | None:
    """None for a node that has no such limit."""
    data = drive.device.try_upload(_PROTECTION + AXIS_SHIFT * drive.axis, sub)
    return None if data is None else float(struct.unpack("<f", data)[0])
