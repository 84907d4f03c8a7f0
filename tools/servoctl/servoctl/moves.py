# SPDX-License-Identifier: Apache-2.0
"""Single motions of an axis as plans: to an angle, or at a rate for a time. What moves is known before it moves."""

from __future__ import annotations

from typing import Any

from .limits import Plan
from .units import degrees

DEFAULT_RATE_DEG_S = 2.0


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
