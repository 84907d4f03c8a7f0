# SPDX-License-Identifier: Apache-2.0
"""Finds an object that stands out from its surroundings, anywhere in the picture, without learned weights.

At each size (the picture is halved from size to size) a pixel is compared with the mean of its surroundings, in
deviations of these surroundings. So a threshold of constant false alarm rate follows from sky to clutter: what stands
out from sky may be lost in clutter, but clutter itself does not stand out.
"""

from __future__ import annotations

import cv2
import numpy as np
import numpy.typing as npt

from .centroid import Blob, find_in_window
from .errors import ImagerError
from .picture import Grey

SURROUNDINGS_PX = 31
"""Side of the square that a pixel is compared with ..."""
OBJECT_PX = 13
"""... and of the square in its middle, which may belong to the object and does not count."""
THRESHOLD = 6.0
"""In deviations of the surroundings."""
CANDIDATES = 6
SMALLEST_SIDE_PX = 28
LOWEST_DEVIATION = 1.0
"""Grey levels: less is not noise of a camera."""
_LEVELS = 5


def check_size(shape: tuple[int, ...]) -> None:
    """Raises ImagerError for a picture that is too small."""
    height, width = shape[:2]
    if min(height, width) < SMALLEST_SIDE_PX:
        raise ImagerError(f"the pictures have {width} x {height} pixels; a target can be found in {SMALLEST_SIDE_PX} x {SMALLEST_SIDE_PX} or more.")


Level = npt.NDArray[np.float32] | npt.NDArray[np.float64]


def _around(values: Level) -> Level:
    """Mean of the surroundings of each pixel."""
    whole = cv2.boxFilter(values, -1, (SURROUNDINGS_PX, SURROUNDINGS_PX), normalize=False)
    middle = cv2.boxFilter(values, -1, (OBJECT_PX, OBJECT_PX), normalize=False)
    found: Level = np.subtract(whole, middle, dtype=values.dtype) / values.dtype.type(SURROUNDINGS_PX**2 - OBJECT_PX**2)
    return found


def _halved(values: Level) -> Level:
    found: Level = np.zeros_like(values[::2, ::2])
    cv2.pyrDown(values, found)
    return found


def _standing_out(grey: Level) -> npt.NDArray[np.float32]:
    """How far each pixel (3 by 3) is from its surroundings, in their deviations."""
    mean, square = _around(grey), _around(grey * grey)
    deviation = np.sqrt(np.maximum(square - mean * mean, LOWEST_DEVIATION**2))
    return np.asarray((cv2.GaussianBlur(grey, (3, 3), 0) - mean) / deviation, dtype=np.float32)


def candidates(grey: Grey) -> list[tuple[float, float, float]]:
    """Places that stand out, at most CANDIDATES: deviations, column, row; the most outstanding first."""
    found: list[tuple[float, float, float]] = []
    # The squares of 16 bits need more digits than float32 has.
    level: Level = grey.astype(np.float32) if grey.dtype == np.uint8 else grey.astype(np.float64)
    scale = 1.0
    for _ in range(_LEVELS):
        if min(level.shape) < SMALLEST_SIDE_PX:
            break
        strength = np.abs(_standing_out(level))
        for _ in range(2):
            _, peak, _, place = cv2.minMaxLoc(strength)
            if peak < THRESHOLD:
                break
            found.append((peak, (place[0] + 0.5) * scale - 0.5, (place[1] + 0.5) * scale - 0.5))
            cv2.circle(strength, place, SURROUNDINGS_PX // 2, 0.0, -1)
        level = _halved(level)
        scale *= 2.0
    return sorted(found, reverse=True)[:CANDIDATES]


def find(grey: Grey) -> Blob | None:
    """The object that stands out most, or nothing."""
    best: Blob | None = None
    largest = min(grey.shape) // 2
    for _, column, row in candidates(grey):
        half = 12
        while half <= largest:
            blob = find_in_window(grey, column, row, half)
            if blob is not None and blob.size < 0.75 * half:
                if best is None or blob.contrast * blob.area**0.5 > best.contrast * best.area**0.5:
                    best = blob
                break
            half *= 2
    return best
