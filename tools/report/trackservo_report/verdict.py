# SPDX-License-Identifier: Apache-2.0
"""Where the LuGre feedforward wins, and where it loses, against the same loop without it and against its rivals."""

from __future__ import annotations

import math
from dataclasses import dataclass

from .comparison import Comparison, badness
from .experiments import experiments
from .load import Row

JUDGED_METRICS = {
    "peak_error",
    "rms_error",
    "time_to_90_percent",
    "overshoot",
    "overshoot_above_friction_free",
    "tracking_sigma",
}

RIVALS = [
    ("pi_vob_ftc", "pi_vob"),
    ("pi_ftc", "pi"),
    ("pi_ftc", "pi_coulomb"),
    ("pi_vob_ftc", "pi_best"),
]
"""(controller with LuGre feedforward, controller it must beat)."""

SMALLEST_DIFFERENCE = {"%": 0.5, "points": 0.5, "ms": 1.0}
"""Differences below this are no difference: half a point, one tick."""

RELATIVE_TOLERANCE = 0.02


@dataclass(frozen=True)
class Duel:
    """One LuGre controller against one rival on one measurement; values in the comparison's unit."""

    comparison: Comparison
    lugre: str
    rival: str
    outcome: str  # "wins", "level" or "loses"

    def change_percent(self) -> float | None:
        """How much larger (+) or smaller (-) the error is than the rival's, in %."""
        own, other = self.comparison.value(self.lugre), self.comparison.value(self.rival)
        return None if own is None or not other else 100.0 * (own - other) / abs(other)

    def rank(self) -> tuple[bool, bool, float]:
        """Sorting key: the experiment's own metric first, azimuth first, the largest loss first."""
        item = self.comparison
        return (
            item.metric != experiments()[item.experiment].metric,
            item.axis != "azimuth",
            -(self.change_percent() or 0.0),
        )


def duels(items: list[Comparison]) -> list[Duel]:
    """Every comparison of `RIVALS` that the rows allow, on a plant with friction."""
    found = []
    for item in items:
        if item.metric not in JUDGED_METRICS or item.friction == "none":
            continue
        for lugre, rival in RIVALS:
            if lugre in item.rows and rival in item.rows:
                outcome = _outcome(item.rows[lugre], item.rows[rival])
                if outcome:
                    found.append(Duel(item, lugre, rival, outcome))
    return found


def _outcome(own: Row, other: Row) -> str | None:
    """Worse or better by more than the seeds' spread and the smallest difference that counts."""
    if own.value is None and other.value is None:
        return None
    if own.value is None or other.value is None:
        if own.metric != "time_to_90_percent":
            return None
        return "loses" if own.value is None else "wins"
    spread = math.hypot(own.spread or 0.0, other.spread or 0.0)
    tolerance = max(spread, RELATIVE_TOLERANCE * abs(other.value), SMALLEST_DIFFERENCE.get(own.unit, 0.0))
    difference = badness(own.metric, own.value) - badness(other.metric, other.value)
    return "level" if abs(difference) <= tolerance else "loses" if difference > 0 else "wins"
