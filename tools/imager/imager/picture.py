# SPDX-License-Identifier: Apache-2.0
"""A picture with the time of its exposure, and the optics that turn its pixels into tangents."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
import numpy.typing as npt

from .errors import ImagerError

Grey = npt.NDArray[np.uint8] | npt.NDArray[np.uint16]
"""Rows by columns. More than 8 bits are kept: a dim target may have only the low ones."""

DEFAULT_PIXEL_URAD = 11.499
"""Of the paper's camera and of the simulator."""
_DARKEST_SHARE, _BRIGHTEST_SHARE = 0.1, 99.9
_EVERY = 4
"""Of the rows and columns: enough for these shares (%)."""


@dataclass(frozen=True)
class Picture:
    """`exposed_s` is the middle of the exposure by the clock of the source, `arrived_s` by time.monotonic()."""

    grey: Grey
    number: int
    exposed_s: float
    arrived_s: float
    file_s: float | None = None
    """Time in a video file, whose pictures need not have equal distances."""

    @property
    def progress(self) -> float:
        """Grows with time, in a unit of the source: for how far a target has moved since another picture."""
        return float(self.number) if self.file_s is None else self.file_s


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


class UsedBits:
    """Removes the low bits that no picture of a source has used: 12 bits may come in the high ones of 16."""

    def __init__(self) -> None:
        self._used = 0

    def take(self, grey: Grey) -> Grey:
        """The same picture in steps of 1, as the detector counts its noise."""
        if grey.dtype == np.uint8:
            return grey
        self._used |= int(np.bitwise_or.reduce(grey, axis=None))
        unused = (self._used & -self._used).bit_length() - 1 if self._used else 0
        return grey >> np.uint16(unused) if unused else grey


def grey_of(values: cv2.typing.MatLike, where: str) -> Grey:
    """One channel of 8 or 16 bits of an array as OpenCV gives it; raises ImagerError for other pixels."""
    if values.dtype == np.uint8:
        return np.asarray(_one_channel(values), dtype=np.uint8)
    if values.dtype == np.uint16:
        return np.asarray(_one_channel(values), dtype=np.uint16)
    raise ImagerError(f"{where}: a picture has pixels of {values.dtype}; expected whole numbers of 8 or 16 bits.")


def _one_channel(values: cv2.typing.MatLike) -> cv2.typing.MatLike:
    if values.ndim == 2:
        return values
    channels = values.shape[2]
    if channels == 1:
        return values[:, :, 0]
    return cv2.cvtColor(values, cv2.COLOR_BGRA2GRAY if channels == 4 else cv2.COLOR_BGR2GRAY)


def to_8_bits(grey: Grey) -> npt.NDArray[np.uint8]:
    """To be shown, or for OpenCV's trackers: more bits are stretched from the darkest to the brightest pixels."""
    if grey.dtype == np.uint8:
        return np.asarray(grey, dtype=np.uint8)
    dark, bright = np.percentile(grey[::_EVERY, ::_EVERY], (_DARKEST_SHARE, _BRIGHTEST_SHARE))
    factor = 255.0 / max(float(bright - dark), 255.0)
    return np.asarray(np.clip(factor * (grey.astype(np.float32) - dark), 0.0, 255.0), dtype=np.uint8)
