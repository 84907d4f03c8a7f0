# SPDX-License-Identifier: Apache-2.0
"""Figures of a run: delay, errors, noise; printed each second and at the end. A run may last for months: the shares of delay and
noise are those of the newest pictures, everything else is of all.
"""

from __future__ import annotations

import math
from collections import deque

import numpy as np

from .follower import Sighting


_NEWEST = 100_000
"""Half an hour at 50 Hz."""


class Statistics:
    """Of all pictures of a run."""

    def __init__(self) -> None:
        self.pictures = 0
        self.losses = 0
        self.shape: tuple[int, ...] = ()
        self._delays_s: deque[float] = deque(maxlen=_NEWEST)
        self._longest_s = 0.0
        self._found = 0
        self._mean_rad = np.zeros(2)
        self._squares_rad2 = np.zeros(2)  # of the differences from the mean: Welford's sums
        self._noise_px: deque[float] = deque(maxlen=_NEWEST)
        self._had_target = False

    def take(self, sighting: Sighting, error_rad: tuple[float, float], delay_s: float) -> None:
        """One picture."""
        self.pictures += 1
        self._delays_s.append(delay_s)
        self._longest_s = max(self._longest_s, delay_s)
        if sighting.quality:
            self._found += 1
            off_rad = np.array(error_rad) - self._mean_rad
            self._mean_rad += off_rad / self._found
            self._squares_rad2 += off_rad * (np.array(error_rad) - self._mean_rad)
            self._noise_px.append(sighting.noise_px)
        self.losses += self._had_target and not sighting.quality
        self._had_target = sighting.quality > 0

    @property
    def found(self) -> bool:
        """In one picture at least."""
        return self._found > 0

    def delay(self) -> str:
        """Median, 95 % and largest, in ms."""
        if not self._delays_s:
            return "no picture"
        median, most = (1e3 * float(np.percentile(self._delays_s, share)) for share in (50, 95))
        return f"median {median:.1f} ms, 95 % {most:.1f} ms, maximum {1e3 * self._longest_s:.1f} ms"

    def errors(self, pixel_rad: float) -> str:
        """Mean and deviation of the measured error, and the centroid's part in it."""
        if not self._found:
            return "the target was never found"
        mean = 1e6 * self._mean_rad
        deviation = [1e6 * math.sqrt(squares / self._found) for squares in self._squares_rad2]
        noise_px = float(np.median(self._noise_px))
        return (
            f"target found in {self._found} of {self.pictures} pictures, lost {self.losses} times;"
            f" measured error x {mean[0]:+.1f} ± {deviation[0]:.1f}, y {mean[1]:+.1f} ± {deviation[1]:.1f} µrad (1σ);"
            f" centroid noise {noise_px:.3f} pixels = {1e6 * noise_px * pixel_rad:.2f} µrad"
        )
