# SPDX-License-Identifier: Apache-2.0
"""The deceleration that an axis surely has, from stops with the whole torque of its motor.

Protection trusts this figure (2060:19): it brakes early enough for it, whatever a master commands. So the figure is
what the weakest of several stops reached, less what the strongest wind takes, less a reserve.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..errors import MotionError
from ..units import degrees

Real = NDArray[np.float64]

FULL_SHARE = 0.98
"""Of the motor's torque: from here on the torque counts as full."""
MOVING_SHARE = 0.15
"""Of the rate before the stop: below it the loop takes the torque back."""
SETTLING_S = 0.004
"""After the torque has become full: the current still rises."""
MIN_SAMPLES = 10
RESERVE = 0.8
"""Share of the measured deceleration that is relied on."""


@dataclass(frozen=True)
class Stop:
    """One stop: the rate before it, the deceleration while the torque was full and how long that was."""

    rate_rad_s: float
    deceleration_rad_s2: float
    deviation_rad_s2: float
    """Standard deviation of the deceleration, from the scatter of the rate around the straight line."""
    full_torque_s: float


def analyse_stop(time_s: Real, rate_rad_s: Real, torque_nm: Real, full_nm: float) -> Stop:
    """A stop that begins at time 0. Raises MotionError when the torque was not full for long enough to measure."""
    before = rate_rad_s[time_s < 0.0]
    if before.size < MIN_SAMPLES:
        raise MotionError(f"only {before.size} samples were recorded before the stop, at least {MIN_SAMPLES} are needed.")
    start = float(np.mean(before))
    forward = np.sign(start)
    braking = (time_s >= 0.0) & (-forward * torque_nm >= FULL_SHARE * full_nm)
    first = int(np.argmax(braking)) if np.any(braking) else len(time_s)
    step_s = float(np.median(np.diff(time_s)))
    ends = np.flatnonzero(~braking[first:])
    full = slice(first, first + int(ends[0]) if ends.size else len(time_s))
    fitted = slice(full.start + round(SETTLING_S / step_s), full.stop)
    keep = forward * rate_rad_s[fitted] > MOVING_SHARE * abs(start)
    time, rate = time_s[fitted][keep], rate_rad_s[fitted][keep]
    if time.size < MIN_SAMPLES:
        reached = float(np.max(-forward * torque_nm[time_s >= 0.0], initial=0.0))
        raise MotionError(
            f"the torque was full for {time.size * 1e3 * step_s:.0f} ms only (it reached {reached:.3g} of"
            f" {full_nm:.3g} N m), at least {MIN_SAMPLES * 1e3 * step_s:.0f} ms are needed: repeat at a higher --rate"
            f" (it was {degrees(abs(start)):.3g} °/s)."
        )
    (slope, _), covariance = np.polyfit(time, rate, 1, cov="unscaled")
    scatter = float(np.std(rate - np.polyval((slope, _), time), ddof=2))
    return Stop(
        rate_rad_s=start,
        deceleration_rad_s2=-float(slope) * float(forward),
        deviation_rad_s2=scatter * float(np.sqrt(covariance[0, 0])),
        full_torque_s=(full.stop - full.start) * step_s,
    )


def sure_deceleration(stops: Sequence[Stop], full_nm: float, wind_nm: float) -> float:
    """What can be relied on, rad/s², when `wind_nm` more than during the stops may act.

    The wind takes its share of the torque. Friction helped in the stops as well, so its share of the deceleration
    is at most that: the result is on the safe side.
    """
    least = min(stop.deceleration_rad_s2 - 2.0 * stop.deviation_rad_s2 for stop in stops)
    return RESERVE * least * (1.0 - wind_nm / full_nm)
