# SPDX-License-Identifier: Apache-2.0
"""Single motions of an axis: to an angle, or at a rate for a time. As plans, so that what moves is known before it moves; and on
the live axis."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from typing import Any

from ..drive import power
from ..drive.drive import Drive
from ..drive.node_limits import read_limits
from ..errors import MotionError
from ..link.device import Device
from ..units import degrees, radians
from .limits import Limits, Plan
from .live import LiveAxis

Report = Callable[[float], object]
"""Gets the share of a motion that is done, 0 to 1."""
_POLL_S = 0.02
_RUN_POLL_S = 0.05

DEFAULT_RATE_DEG_S = 2.0
SLEW_RATE_DEG_S = 5.0
"""To the first angles of what follows."""
MOST = Limits(radians(20.0), radians(90.0), 120.0)
"""Of a motion, unless the user allows more."""


def plan_run(axis: str, rate_rad_s: float, duration_s: float) -> Plan:
    """At a rate for a time, in mode pv."""
    travel = rate_rad_s * duration_s
    return Plan(
        axis, f"runs at {degrees(rate_rad_s):.4g} °/s for {duration_s:.4g} s", abs(rate_rad_s),
        max(travel, 0.0), max(-travel, 0.0), duration_s,
    )  # fmt: skip


def plan_to(axis: str, here_rad: float, target_rad: float, rate_rad_s: float) -> Plan:
    """From here to an angle at up to a rate, in mode pp."""
    travel = target_rad - here_rad
    return Plan(
        axis,
        f"from {degrees(here_rad):.4f}° to {degrees(target_rad):.4f}° at up to {degrees(rate_rad_s):.4g} °/s",
        rate_rad_s, max(travel, 0.0), max(-travel, 0.0), abs(travel) / rate_rad_s + 1.0,
    )  # fmt: skip


def longest_s(expected_s: float) -> float:
    """Time after which a motion of an expected duration has failed."""
    return 2.0 * expected_s + 5.0


def plan_data(plan: Plan) -> dict[str, Any]:
    """The plan for --json, in ° and s."""
    return {
        "axis": plan.axis, "text": plan.text, "rate_deg_s": degrees(plan.rate_rad_s), "forward_deg": degrees(plan.forward_rad),
        "backward_deg": degrees(plan.backward_rad), "duration_s": plan.duration_s,
    }  # fmt: skip


def silent(_share: float) -> None:
    """A report that nobody reads."""


def run_at_rate(device: Device, axis: int, rate_rad_s: float, duration_s: float, report: Report = silent) -> None:
    """In mode pv, for a time of the node; then the axis stops on its ramp. Check the plan before. Raises MotionError when the
    axis does not stay enabled."""
    with LiveAxis(device, axis, power.PROFILE_VELOCITY) as live:
        live.drive.set_target_rate(rate_rad_s)
        for now_s in device.clock.every(_RUN_POLL_S, duration_s):
            live.check_enabled()
            report(now_s / duration_s)


def go_to(device: Device, axis: int, target_rad: float, plan: Plan, report: Report = silent) -> float:
    """In mode pp, at the rate of the plan, which was checked. Returns the position on arrival, rad: after it the axis is
    disabled, and wind may turn it. Raises MotionError when it does not arrive."""
    with LiveAxis(device, axis, power.PROFILE_POSITION) as live:
        drive = live.drive
        start_rad = drive.position()
        drive.start_to(target_rad, plan.rate_rad_s)
        deadline = device.clock.now() + longest_s(plan.duration_s)
        while not live.check_enabled() & power.TARGET_REACHED:
            done = abs(drive.position() - start_rad) / max(abs(target_rad - start_rad), 1e-9)
            report(min(done, 1.0))
            if device.clock.now() > deadline:
                raise MotionError(f"{drive.name} has not reached its target after {longest_s(plan.duration_s):.0f} s.")
            time.sleep(_POLL_S)
        return drive.position()


def slew(lives: Sequence[LiveAxis], targets_rad: Sequence[float], rate_rad_s: float) -> None:
    """All axes, which are in mode pp, to their angles at once; returns when they have arrived."""
    clock = lives[0].device.clock
    expected_s = 0.0
    for live, target in zip(lives, targets_rad, strict=True):
        expected_s = max(expected_s, abs(target - live.drive.position()) / rate_rad_s)
        live.drive.start_to(target, rate_rad_s)
    deadline = clock.now() + longest_s(expected_s)
    while not all([live.check_enabled() & power.TARGET_REACHED for live in lives]):
        if clock.now() > deadline:
            raise MotionError(f"the axes have not reached their first angles after {longest_s(expected_s):.0f} s.")
        time.sleep(_POLL_S)


def check_slew(drive: Drive, target_rad: float, rate_rad_s: float) -> None:
    """Raises InputError when the slew would exceed a limit of the node."""
    node = read_limits(drive)
    node.check_rate(rate_rad_s)
    here = drive.position()
    node.check_travel(drive.name, here, max(here - target_rad, 0.0), max(target_rad - here, 0.0))
