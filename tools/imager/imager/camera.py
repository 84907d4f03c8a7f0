# SPDX-License-Identifier: Apache-2.0
"""A camera of Video4Linux, and what may be asked of it."""

from __future__ import annotations

import time
from dataclasses import dataclass

import cv2

from .errors import ImagerError
from .picture import Picture, UsedBits, grey_of
from .video import DEFAULT_RATE_HZ

MANY_BITS = tuple(cv2.VideoWriter.fourcc(*name) for name in ("Y10 ", "Y12 ", "Y16 "))
"""Pixel formats with more than 8 bits of grey."""
_BUFFERED_STAMP_S = 1.0
"""A driver's time stamp that is further from now is not one of our clock."""


@dataclass(frozen=True)
class CameraMode:
    """None: as the camera chooses."""

    size_px: tuple[int, int] | None = None
    rate_hz: float | None = None
    pixel_format: str | None = None
    """Four characters of Video4Linux (V4L2_PIX_FMT), as MJPG or Y16."""

    def refuse_picture(self, source: str) -> None:
        """Raises ImagerError for size or format: `source` is no camera."""
        for value, option in ((self.size_px, "--size"), (self.pixel_format, "--pixel-format")):
            if value is not None:
                raise ImagerError(f"{option} is for a camera; '{source}' has pictures of its own.")

    def refuse_all(self, source: str) -> None:
        """Raises ImagerError for any wish: the pictures of `source` have times, too."""
        self.refuse_picture(source)
        if self.rate_hz is not None:
            raise ImagerError(f"--rate is for a camera or a folder of pictures; '{source}' has times of its own.")


class CameraSource:
    """Pictures come by themselves, and the last one never ends well. `forms` says what else a source may be."""

    node_clock = False
    waits = False
    is_playlist = False
    damage = ""

    def __init__(self, number: int, name: str, mode: CameraMode, forms: str) -> None:
        self._name = name
        self._capture = cv2.VideoCapture()
        if not self._capture.open(number, cv2.CAP_V4L2):
            raise ImagerError(f"the camera '{name}' cannot be opened; expected {forms}.")
        try:
            self._ask(mode)
        except ImagerError:
            self.close()
            raise
        if int(self._capture.get(cv2.CAP_PROP_FOURCC)) in MANY_BITS:
            self._capture.set(cv2.CAP_PROP_CONVERT_RGB, 0.0)  # which would make 8 bits of them
        rate = self._capture.get(cv2.CAP_PROP_FPS)
        self.rate_hz = rate if 1.0 <= rate <= 1000.0 else DEFAULT_RATE_HZ
        self._used_bits = UsedBits()
        self._number = 0

    def _ask(self, mode: CameraMode) -> None:
        """A driver takes what is nearest to the wish: another format or size would be another angle of a pixel."""
        wanted = None
        if mode.pixel_format is not None:
            wanted = cv2.VideoWriter.fourcc(*mode.pixel_format.ljust(4))
            self._capture.set(cv2.CAP_PROP_FOURCC, float(wanted))
        if mode.size_px is not None:
            width, height = mode.size_px
            self._capture.set(cv2.CAP_PROP_FRAME_WIDTH, float(width))
            self._capture.set(cv2.CAP_PROP_FRAME_HEIGHT, float(height))
            given = [round(self._capture.get(side)) for side in (cv2.CAP_PROP_FRAME_WIDTH, cv2.CAP_PROP_FRAME_HEIGHT)]
            if given != [width, height]:
                raise self._has_not(f"the size {width}x{height}, but {given[0]}x{given[1]}")
        if mode.rate_hz is not None:
            self._capture.set(cv2.CAP_PROP_FPS, mode.rate_hz)
            rate = self._capture.get(cv2.CAP_PROP_FPS)
            if abs(rate - mode.rate_hz) > 0.01 * mode.rate_hz:
                raise self._has_not(f"{mode.rate_hz:g} pictures per second, but {rate:g}")
        if wanted is not None and int(self._capture.get(cv2.CAP_PROP_FOURCC)) != wanted:
            raise self._has_not(f"the pixel format '{mode.pixel_format}' with this size and rate")

    def _has_not(self, what: str) -> ImagerError:
        return ImagerError(
            f"the camera '{self._name}' has not {what}; 'v4l2-ctl --list-formats-ext' lists formats, sizes and rates."
        )

    def read(self) -> Picture | None:
        """Waits for the next picture."""
        if not self._capture.grab():
            raise ImagerError(f"'{self._name}' gives no more pictures; check its cable, then start again.")
        now = time.monotonic()
        stamp = 1e-3 * self._capture.get(cv2.CAP_PROP_POS_MSEC)  # the driver's, by the same clock
        exposed = stamp if 0.0 <= now - stamp < _BUFFERED_STAMP_S else now
        try:
            good, values = self._capture.retrieve()
        except cv2.error:  # a format that OpenCV has no conversion for
            good = False
        if not good:
            raise ImagerError(f"'{self._name}' gives a picture that cannot be decoded; choose another --pixel-format.")
        self._number += 1
        return Picture(self._used_bits.take(grey_of(values, f"'{self._name}'")), self._number, exposed, now)

    def close(self) -> None:
        """The device is free."""
        self._capture.release()
