"""A picture with the time of its exposure, and the optics that turn its pixels into tangents."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

Grey = npt.NDArray[np.uint8]
"""Rows by columns."""

DEFAULT_PIXEL_URAD = 11.499
"""Of the paper's camera and of the simulator."""


@dataclass(frozen=True)
class Picture:
    """`exposed_s` is the middle of the exposure by the clock of the source, `arrived_s` by time.monotonic()."""

    grey: Grey
    number: int
    exposed_s: float
    arrived_s: float


@dataclass(frozen=True)
class Optics:
    """Scale of the picture; `azimuth_grows_right` for a camera that sees a growing azimuth on the right."""

    pixel_rad: float = DEFAULT_PIXEL_URAD * 1e-6
    azimuth_grows_right: bool = False

    def error(self, column: float, row: float, shape: tuple[int, ...]) -> tuple[float, float]:
        """Tangents of a place, as 3070:1 and 3070:2 count them: growing azimuth, and upwards."""
        height, width = shape[:2]
        across = (column - 0.5 * (width - 1)) * self.pixel_rad
        return (across if self.azimuth_grows_right else -across), (0.5 * (height - 1) - row) * self.pixel_rad
