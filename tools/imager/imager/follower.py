# SPDX-License-Identifier: Apache-2.0
"""Follows one object from picture to picture: found, followed, lost, found again.

    searching   the detector reads the whole picture; an object seen in CONFIRMED pictures in a row is the target
    following   the centroid in a window around the expected place. Where the object does not stand out from clutter,
                OpenCV's correlation tracker takes over from the last good picture, with a lower quality
    searching   again, after LOST pictures without the target
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from enum import Enum

import cv2

from .centroid import Blob, find_in_window
from .detector import find
from .picture import Grey, to_8_bits

CONFIRMED = 3
LOST = 15
WINDOW_OF_SIZE = 1.5
"""Half the window, in sizes of the object."""
SMALLEST_HALF_PX = 12
SIZE_CHANGE = 1.6
"""Of the mean size: beyond it, the object has merged with clutter, or is another one."""
MIN_CONTRAST = 0.35
"""Of the mean difference from the background: less is another object."""
GATE_OF_SIZE, GATE_PX = 0.5, 6.0
"""How far from the expected place it may be."""
CORRELATION_QUALITY = 25
"""Of a place that the correlation tracker gives: whole pixels, and it may drift."""
MIN_CORRELATION = 0.3
"""KCF reports the target as lost below this."""
WIDER = 3.0
"""Window and gate of the second look: the target or the camera has been accelerated."""
_BOX_OF_SIZE = 2.5
_SMALLEST_BOX_PX = 24
_VELOCITY_GAIN = 0.5
_SHAPE_GAIN = 0.05

TRACKERS = ("kcf", "csrt", "none")


class State(Enum):
    """For the overlay and the status line."""

    SEARCHING = "searching"
    FOLLOWING = "following"


@dataclass(frozen=True)
class Sighting:
    """The target in one picture; quality 0: not found."""

    state: State
    quality: int
    column: float = 0.0
    row: float = 0.0
    width: float = 0.0
    height: float = 0.0
    noise_px: float = 0.0
    by_correlation: bool = False


def make_tracker(name: str) -> cv2.Tracker | None:
    """One of TRACKERS."""
    if name == "none":
        return None
    if name == "csrt":
        return cv2.TrackerCSRT.create()
    parameters = cv2.TrackerKCF.Params()
    parameters.detect_thresh = MIN_CORRELATION
    return cv2.TrackerKCF.create(parameters)


class Follower:
    """Use: `follower.take(grey)` for each picture."""

    def __init__(self, tracker: str = "kcf") -> None:
        self._tracker_name = tracker
        self._shape: tuple[int, ...] = ()
        self._forget()

    def _forget(self) -> None:
        self._passed = 1.0
        self._blob: Blob | None = None
        self._seen = 0
        self._missed = 0
        self._velocity = (0.0, 0.0)
        self._contrast = self._size = self._area = 0.0
        self._last_good: Grey | None = None
        self._correlation: cv2.Tracker | None = None
        self._offset = (0.0, 0.0)

    @property
    def state(self) -> State:
        return State.FOLLOWING if self._seen >= CONFIRMED else State.SEARCHING

    def take(self, grey: Grey, passed: float = 1.0) -> Sighting:
        """The target in the next picture, which is so long after the last one, in any unit.

        A picture of another size begins a new search: nothing of the old ones holds in it.
        """
        if grey.shape != self._shape:
            self._shape = grey.shape
            self._forget()
        self._passed = passed
        return self._search(grey) if self.state == State.SEARCHING else self._follow(grey)

    def _search(self, grey: Grey) -> Sighting:
        blob = None
        if self._blob is not None:
            blob = self._matching(grey, self._blob.column, self._blob.row)
        if blob is None:
            self._forget()
            blob = find(grey)
        if blob is None:
            return Sighting(State.SEARCHING, 0)
        self._take_blob(grey, blob)
        if self._seen < CONFIRMED:
            return Sighting(State.SEARCHING, 0)
        return self._sighting(blob)

    def _follow(self, grey: Grey) -> Sighting:
        assert self._blob is not None
        column = self._blob.column + self._passed * self._velocity[0]
        row = self._blob.row + self._passed * self._velocity[1]
        blob = self._matching(grey, column, row) or self._matching(grey, column, row, WIDER)
        if blob is not None:
            self._take_blob(grey, blob)
            return self._sighting(blob)
        by_correlation = self._correlate(grey)
        self._missed += 1
        if by_correlation is not None:
            column, row = by_correlation
        if self._missed > LOST:
            self._forget()
            return Sighting(State.SEARCHING, 0)
        self._blob = _moved(self._blob, column, row)
        if by_correlation is None:
            return Sighting(State.FOLLOWING, 0)
        width, height = self._blob.width, self._blob.height
        return Sighting(State.FOLLOWING, CORRELATION_QUALITY, column, row, width, height, 1.0, True)

    def _matching(self, grey: Grey, column: float, row: float, wider: float = 1.0) -> Blob | None:
        """The followed object near a place, or nothing if what is there is another one."""
        assert self._blob is not None
        half = math.ceil(wider * max(SMALLEST_HALF_PX, WINDOW_OF_SIZE * self._size))
        blob = find_in_window(grey, column, row, half, self._blob.sign)
        if blob is None or not 1.0 / SIZE_CHANGE < blob.size / max(self._size, 3.0) < SIZE_CHANGE:
            return None
        if not 1.0 / SIZE_CHANGE**2 < blob.area / max(self._area, 5.0) < SIZE_CHANGE**2:
            return None
        if math.hypot(blob.column - column, blob.row - row) > wider * (GATE_OF_SIZE * self._size + GATE_PX):
            return None
        if self._seen >= CONFIRMED and blob.difference < MIN_CONTRAST * self._contrast:
            return None
        return blob

    def _take_blob(self, grey: Grey, blob: Blob) -> None:
        if self._blob is not None and self._seen > 0:
            column, row = blob.column - self._blob.column, blob.row - self._blob.row
            step = (column / self._passed, row / self._passed)
            self._velocity = (
                self._velocity[0] + _VELOCITY_GAIN * (step[0] - self._velocity[0]),
                self._velocity[1] + _VELOCITY_GAIN * (step[1] - self._velocity[1]),
            )
        first = self._seen == 0
        gain = 1.0 if first else _SHAPE_GAIN
        self._contrast += gain * (blob.difference - self._contrast)
        self._size += gain * (blob.size - self._size)
        self._area += gain * (blob.area - self._area)
        self._blob = blob
        self._seen += 1
        self._missed = 0
        self._last_good = grey
        self._correlation = None

    def _sighting(self, blob: Blob) -> Sighting:
        return Sighting(self.state, blob.quality, blob.column, blob.row, blob.width, blob.height, blob.noise_px)

    def _correlate(self, grey: Grey) -> tuple[float, float] | None:
        """The object's place by the correlation tracker, which begins with the last good picture."""
        assert self._blob is not None
        if self._correlation is None and self._last_good is not None:
            self._correlation = make_tracker(self._tracker_name)
            if self._correlation is not None:
                width, height = (max(_SMALLEST_BOX_PX, _BOX_OF_SIZE * side) for side in (self._blob.width, self._blob.height))
                left, top = round(self._blob.column - 0.5 * width), round(self._blob.row - 0.5 * height)
                self._offset = (self._blob.column - left, self._blob.row - top)
                self._correlation.init(_coloured(self._last_good), (left, top, round(width), round(height)))
            self._last_good = None
        if self._correlation is None:
            return None
        found, box = self._correlation.update(_coloured(grey))
        if not found:
            return None
        column, row = box[0] + self._offset[0], box[1] + self._offset[1]
        return (column, row) if 0 <= column < grey.shape[1] and 0 <= row < grey.shape[0] else None


def _coloured(grey: Grey) -> cv2.typing.MatLike:
    """What OpenCV's trackers take."""
    return cv2.cvtColor(to_8_bits(grey), cv2.COLOR_GRAY2BGR)


def _moved(blob: Blob, column: float, row: float) -> Blob:
    return replace(blob, column=column, row=row)
