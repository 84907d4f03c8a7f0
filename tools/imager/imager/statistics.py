"""Figures of a run: delay, errors, noise; printed each second and at the end."""

from __future__ import annotations

import numpy as np

from .follower import Sighting


class Statistics:
    """Of all pictures of a run."""

    def __init__(self) -> None:
        self.pictures = 0
        self.losses = 0
        self.shape: tuple[int, ...] = ()
        self._delays_s: list[float] = []
        self._errors_rad: list[tuple[float, float]] = []
        self._noise_px: list[float] = []
        self._had_target = False

    def take(self, sighting: Sighting, error_rad: tuple[float, float], delay_s: float) -> None:
        """One picture."""
        self.pictures += 1
        self._delays_s.append(delay_s)
        if sighting.quality:
            self._errors_rad.append(error_rad)
            self._noise_px.append(sighting.noise_px)
        self.losses += self._had_target and not sighting.quality
        self._had_target = sighting.quality > 0

    @property
    def found(self) -> bool:
        """In one picture at least."""
        return bool(self._errors_rad)

    def delay(self) -> str:
        """Median, 95 % and largest, in ms."""
        if not self._delays_s:
            return "no picture"
        median, most, largest = (1e3 * float(np.percentile(self._delays_s, share)) for share in (50, 95, 100))
        return f"median {median:.1f} ms, 95 % {most:.1f} ms, maximum {largest:.1f} ms"

    def errors(self, pixel_rad: float) -> str:
        """Mean and deviation of the measured error, and the centroid's part in it."""
        if not self._errors_rad:
            return "the target was never found"
        mean, deviation = (1e6 * f(np.array(self._errors_rad), axis=0) for f in (np.mean, np.std))
        noise_px = float(np.median(self._noise_px))
        return (
            f"target found in {len(self._errors_rad)} of {self.pictures} pictures, lost {self.losses} times;"
            f" measured error x {mean[0]:+.1f} ± {deviation[0]:.1f}, y {mean[1]:+.1f} ± {deviation[1]:.1f} µrad (1σ);"
            f" centroid noise {noise_px:.3f} pixels = {1e6 * noise_px * pixel_rad:.2f} µrad"
        )
