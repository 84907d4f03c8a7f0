# SPDX-License-Identifier: Apache-2.0
"""A step of the rate in numbers: delay, rise, overshoot, settling, all from demand and response."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Real = NDArray[np.float64]

SETTLED_SHARE = 0.05
FINAL_SHARE = 0.3
"""The last share of the record from which the final value and the noise are taken."""


@dataclass(frozen=True)
class StepNumbers:
    """Times in s from the step of the demand, rates in rad/s, overshoot in % of the step; None: not attained."""

    from_rad_s: float
    to_rad_s: float
    time_to_half_s: float | None
    rise_s: float | None
    time_to_90_s: float | None
    overshoot_percent: float
    settling_s: float | None
    final_error_rad_s: float
    noise_rad_s: float


def analyse_step(demand: Real, answer: Real, sample_s: float) -> StepNumbers:
    """`demand` jumps once in the record; raises ValueError when it does not.

    Rise is 10 % to 90 %; settling is the last time outside of 5 % of the step around the demand (or of three times the
    noise, when that is more).
    """
    jump = float(demand[-1] - demand[0])
    moved = np.flatnonzero(np.abs(demand - demand[0]) > 0.5 * abs(jump))
    if jump == 0.0 or moved.size == 0:
        raise ValueError("the demand contains no step")
    start = int(moved[0])
    share = (answer[start:] - demand[0]) / jump
    tail = answer[len(answer) - max(2, int(FINAL_SHARE * (len(answer) - start))) :]
    noise = float(np.std(tail))
    band = max(SETTLED_SHARE, 3 * noise / abs(jump))
    outside = np.flatnonzero(np.abs(share - 1.0) > band)
    settled = (int(outside[-1]) + 1) * sample_s if outside.size else 0.0
    t10, t50, t90 = (_first(share, level, sample_s) for level in (0.1, 0.5, 0.9))
    return StepNumbers(
        from_rad_s=float(demand[0]),
        to_rad_s=float(demand[-1]),
        time_to_half_s=t50,
        rise_s=t90 - t10 if t10 is not None and t90 is not None else None,
        time_to_90_s=t90,
        overshoot_percent=100.0 * max(0.0, float(np.max(share)) - 1.0),
        settling_s=settled if not outside.size or outside[-1] < len(share) - 1 else None,
        final_error_rad_s=float(np.mean(tail) - demand[-1]),
        noise_rad_s=noise,
    )


def _first(share: Real, level: float, sample_s: float) -> float | None:
    """Time of the first crossing, interpolated between samples."""
    above = np.flatnonzero(share >= level)
    if above.size == 0:
        return None
    i = int(above[0])
    if i == 0:
        return 0.0
    return float((i - 1 + (level - share[i - 1]) / (share[i] - share[i - 1])) * sample_s)
