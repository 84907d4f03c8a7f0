# SPDX-License-Identifier: Apache-2.0
"""The centroid of one object in a window, with the noise that it must have.

The background of a pixel is the median of its surroundings, which are larger than the object: so the edge between sky and
ground is background, too. What differs from it by more than a threshold, and is connected and nearest to the expected
place, is the object. Each of its pixels counts with what it differs beyond the
threshold, so that the centroid is finer than a pixel: its noise is

    sigma^2 = noise^2 sum((x - centroid)^2) / sum(weight)^2

along the rows, and alike along the columns, for pixels with independent `noise`.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import cv2
import numpy as np
import numpy.typing as npt

from .picture import Grey

THRESHOLD_OF_NOISE = 2.5
"""Differences below so many deviations of the background are background."""
MIN_PEAK_OF_NOISE = 4.0
"""What differs less nowhere is no object."""
THRESHOLD_OF_PEAK = 0.2
"""Differences below this share of the object's are background."""
SMALLEST_AREA_PX = 3
GOOD_NOISE_PX = 0.2
"""A centroid with this noise has half the quality."""
MEDIAN_RANGE_BITS = 12
"""Of the background in a window: 16 passes of OpenCV's median at most."""
_MAD_TO_DEVIATION = 1.4826


@dataclass(frozen=True)
class Blob:
    """An object in the picture: place and size in pixels."""

    column: float
    row: float
    width: float
    height: float
    area: float
    sign: int
    """1: brighter than its background, -1: darker."""
    difference: float
    """Mean, from the background, in grey levels."""
    contrast: float
    """The same in deviations of the background."""
    noise_px: float
    """Expected deviation of column and row, the larger one."""

    @property
    def size(self) -> float:
        """The longer side."""
        return max(self.width, self.height)

    @property
    def quality(self) -> int:
        """1 .. 100."""
        return max(1, min(100, round(100.0 / (1.0 + (self.noise_px / GOOD_NOISE_PX) ** 2))))


def deviation_of_border(difference: npt.NDArray[np.float32], border: int) -> float:
    """Robust against an object that crosses the border."""
    ring = np.concatenate(
        (difference[:border].ravel(), difference[-border:].ravel(),
         difference[border:-border, :border].ravel(), difference[border:-border, -border:].ravel())
    )  # fmt: skip
    deviation = _MAD_TO_DEVIATION * float(np.median(np.abs(ring - np.median(ring))))
    return max(deviation, 0.5)  # grey levels are whole numbers


def median(window: Grey, side: int) -> Grey:
    """Of the `side` by `side` pixels around each one.

    OpenCV's has 8 bits. The median of the high bits is the high bits of the median; with it known, the low bits are the
    median of what is left within its step. Of a range beyond MEDIAN_RANGE_BITS the lowest bits do not count.
    """
    if window.dtype == np.uint8:
        return np.asarray(cv2.medianBlur(window, side), dtype=np.uint8)
    least = int(window.min())
    coarser = max(0, (int(window.max()) - least).bit_length() - MEDIAN_RANGE_BITS)
    values = (window.astype(np.int32) - least) >> coarser
    high = cv2.medianBlur((values >> 8).astype(np.uint8), side)
    found = np.zeros_like(values)
    for step in np.unique(high):
        base = 256 * int(step)
        low = cv2.medianBlur(np.clip(values - base, 0, 255).astype(np.uint8), side)
        found = np.where(high == step, base + low.astype(np.int32), found)
    return np.asarray(least + (found << coarser), dtype=np.uint16)


def find_in_window(grey: Grey, column: float, row: float, half: int, sign: int = 0) -> Blob | None:
    """The object nearest to a place, in a window of 2 `half` + 1 pixels; `sign` 0: brighter or darker."""
    height, width = grey.shape
    left, right = max(0, round(column) - half), min(width, round(column) + half + 1)
    top, bottom = max(0, round(row) - half), min(height, round(row) + half + 1)
    border = max(1, half // 6)
    if right - left < 4 * border or bottom - top < 4 * border:
        return None
    window = grey[top:bottom, left:right]
    difference = window.astype(np.float32) - median(window, min(2 * (2 * half // 3) + 1, 255)).astype(np.float32)
    deviation = deviation_of_border(difference, border)
    smoothed = cv2.GaussianBlur(difference, (3, 3), 0)
    if sign == 0:
        near = smoothed[border:-border, border:-border]
        sign = 1 if float(near.max()) > -float(near.min()) else -1
    difference, smoothed = sign * difference, sign * smoothed
    peak = float(smoothed.max())
    threshold = max(THRESHOLD_OF_NOISE * deviation, THRESHOLD_OF_PEAK * peak)
    if peak < MIN_PEAK_OF_NOISE * deviation:
        return None
    mask = (smoothed > threshold).astype(np.uint8)
    count, labels, stats, centres = cv2.connectedComponentsWithStats(mask, connectivity=8)
    best, best_value = 0, 0.0
    for label in range(1, count):
        area = float(stats[label, cv2.CC_STAT_AREA])
        distance = math.hypot(centres[label][0] + left - column, centres[label][1] + top - row)
        value = area / (1.0 + (distance / (0.5 * half)) ** 2)
        if area >= SMALLEST_AREA_PX and value > best_value:
            best, best_value = label, value
    if best == 0:
        return None
    x, y, w, h = (int(stats[best, part]) for part in range(4))
    if x == 0 or y == 0 or x + w == mask.shape[1] or y + h == mask.shape[0]:
        return None  # cut off: its centroid is unknown
    # A weight that begins with 0 at the threshold: a pixel that comes in or drops out does not shift the centroid.
    inside = cv2.dilate((labels == best).astype(np.uint8), np.ones((3, 3), np.uint8)).astype(bool) & (difference > threshold)
    weights = np.where(inside, difference - threshold, np.float32(0.0))
    total = float(weights.sum())
    if total <= 0.0:
        return None
    rows, columns = np.nonzero(inside)
    values = weights[rows, columns].astype(np.float64)
    at_column, at_row = float(values @ columns) / total, float(values @ rows) / total
    spread = max(float(((columns - at_column) ** 2).sum()), float(((rows - at_row) ** 2).sum()))
    return Blob(
        column=left + at_column,
        row=top + at_row,
        width=w,
        height=h,
        area=float(stats[best, cv2.CC_STAT_AREA]),
        sign=sign,
        difference=total / len(values) + threshold,
        contrast=(total / len(values) + threshold) / deviation,
        noise_px=deviation * math.sqrt(spread) / total,
    )
