# SPDX-License-Identifier: Apache-2.0
"""Reference shapes of the angle on the live axis: it begins and ends at rest where it is, as in `step_test`."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..errors import InputError
from ..units import TICK_S, degrees
from .limits import Plan, span

Real = NDArray[np.float64]

SHAPES = ("sine", "triangle")
SETPOINT_TICKS = 4
REST_S = 0.3
"""Before and after it."""
REVERSAL_SHARE = 0.1
"""Of a period: so long each reversal of a triangle takes, at a constant acceleration."""
LONGEST_S = 120.0


@dataclass(frozen=True)
class ShapePlan:
    """The motion, and its rates (rad/s, one per tick)."""

    plan: Plan
    rates: Real


def plan_shape(axis: str, shape: str, travel_rad: float, period_s: float, periods: int) -> ShapePlan:
    """From here to `travel_rad` away and back, `periods` times; raises InputError."""
    if shape not in SHAPES:
        raise InputError(f"there is no shape '{shape}': expected {' or '.join(SHAPES)}.")
    if travel_rad == 0.0 or not (period_s >= 0.2 and periods >= 1 and period_s * periods <= LONGEST_S):
        raise InputError(f"the travel must not be 0, the period 0.2 s or more, and all periods {LONGEST_S:g} s or less.")
    phase = np.arange(0.0, period_s * periods, TICK_S) / period_s % 1.0
    if shape == "sine":  # of the angle, from its end
        rates = np.pi * travel_rad / period_s * np.sin(2 * np.pi * phase)
    else:
        ramp = np.interp(phase, [0.0, 0.5 * REVERSAL_SHARE, 0.5 - 0.5 * REVERSAL_SHARE, 0.5], [0.0, 1.0, 1.0, 0.0], right=0.0)
        back = np.interp(phase, [0.5, 0.5 + 0.5 * REVERSAL_SHARE, 1.0 - 0.5 * REVERSAL_SHARE, 1.0], [0.0, 1.0, 1.0, 0.0], left=0.0)
        rates = (ramp - back) * 2.0 * travel_rad / period_s / (1.0 - REVERSAL_SHARE)
    rest = np.zeros(int(REST_S / TICK_S))
    whole = np.concatenate([rest, rates, rest])
    forward, backward = span(whole, TICK_S)
    fastest = float(np.max(np.abs(whole)))
    text = f"{shape} over {degrees(travel_rad):.4g}°, {periods} × {period_s:g} s, at up to {degrees(fastest):.3g} °/s"
    return ShapePlan(Plan(axis, text, fastest, forward, backward, len(whole) * TICK_S), whole)
