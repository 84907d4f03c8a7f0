# SPDX-License-Identifier: Apache-2.0
"""Writes a video with the target's box, its error and the quality: the picture that a window would show.

A video has one size, that of the first picture. Others are scaled into it, with black bars where their sides have
another ratio, so that no picture is missing. In .mkv and .mp4 each picture keeps its time; .avi has one rate.
"""

from __future__ import annotations

from fractions import Fraction
from pathlib import Path

import av
import cv2
import numpy as np
from av.video.stream import VideoStream

from .errors import ImagerError
from .follower import Sighting, State
from .picture import Picture, to_8_bits

CODECS = {".avi": ("mjpeg", "yuvj420p"), ".mp4": ("mpeg4", "yuv420p"), ".mkv": ("mjpeg", "yuvj420p")}
"""With the form of its pixels."""
ONE_RATE = (".avi",)
TICKS_HZ = 1000
QUALITY = 3
"""FFmpeg's scale: 2 is the best, 31 the worst."""
_FOLLOWED, _CORRELATED, _TEXT = (80, 220, 80), (60, 200, 255), (255, 255, 255)


class Recorder:
    """Use: `write` for each picture, then `close`."""

    def __init__(self, file: Path, rate_hz: float) -> None:
        """Raises ImagerError for a kind of file or a folder that cannot be used."""
        if file.suffix.lower() not in CODECS:
            raise ImagerError(f"--record '{file}': expected a file name that ends with {', '.join(CODECS)}.")
        if not file.absolute().parent.is_dir():
            raise ImagerError(f"--record '{file}': the folder does not exist.")
        self._file = file
        self._rate_hz = rate_hz
        self._container: av.container.OutputContainer | None = None
        self._size = (0, 0)
        self._first_s = 0.0
        self._last = -1
        """Time of the last picture, in ticks of the stream."""

    def _open(self, picture: Picture) -> None:
        codec, form = CODECS[self._file.suffix.lower()]
        height, width = picture.grey.shape
        self._size = (width, height)
        self._first_s = picture.exposed_s
        rate = Fraction(self._rate_hz).limit_denominator(TICKS_HZ)
        try:
            self._container = av.open(str(self._file), "w")
            stream = self._container.add_stream(codec, rate=rate)
            assert isinstance(stream, VideoStream)
            stream.width, stream.height, stream.pix_fmt = width + width % 2, height + height % 2, form
            stream.codec_context.time_base = 1 / rate if self._file.suffix.lower() in ONE_RATE else Fraction(1, TICKS_HZ)
            stream.codec_context.qmin = stream.codec_context.qmax = QUALITY
            self._stream = stream
        except av.error.FFmpegError as error:
            raise ImagerError(f"--record '{self._file}': the file cannot be written: {error.strerror}.") from error

    def _add(self, shown: cv2.typing.MatLike, exposed_s: float) -> None:
        assert self._container is not None
        tick = self._stream.codec_context.time_base
        assert tick is not None
        one_rate = self._file.suffix.lower() in ONE_RATE
        self._last = self._last + 1 if one_rate else max(self._last + 1, round((exposed_s - self._first_s) / tick))
        frame = av.VideoFrame.from_ndarray(np.asarray(shown, dtype=np.uint8), format="bgr24")
        frame.pts, frame.time_base = self._last, tick
        try:
            self._container.mux(self._stream.encode(frame))
        except av.error.FFmpegError as error:
            raise ImagerError(f"--record '{self._file}': the file cannot be written: {error.strerror}.") from error

    def write(self, picture: Picture, sighting: Sighting, error_rad: tuple[float, float]) -> None:
        """The picture with its overlay."""
        height, width = picture.grey.shape
        if self._container is None:
            self._open(picture)
        shown = cv2.cvtColor(to_8_bits(picture.grey), cv2.COLOR_GRAY2BGR)
        middle = ((width - 1) // 2, (height - 1) // 2)
        cv2.drawMarker(shown, middle, _TEXT, cv2.MARKER_CROSS, 12, 1)
        text = f"{picture.number}  {sighting.state.value}"
        if sighting.quality:
            colour = _CORRELATED if sighting.by_correlation else _FOLLOWED
            half = (0.5 * sighting.width + 4.0, 0.5 * sighting.height + 4.0)
            corner = (round(sighting.column - half[0]), round(sighting.row - half[1]))
            opposite = (round(sighting.column + half[0]), round(sighting.row + half[1]))
            cv2.rectangle(shown, corner, opposite, colour, 1)
            x, y = (1e6 * error for error in error_rad)
            text += f"  x {x:+.1f} y {y:+.1f} urad  quality {sighting.quality}"
        elif sighting.state == State.FOLLOWING:
            text += "  not seen"
        cv2.putText(shown, text, (8, height - 10), cv2.FONT_HERSHEY_SIMPLEX, 0.5, _TEXT, 1, cv2.LINE_AA)
        self._add(_fitted(shown, self._size), picture.exposed_s)

    def close(self) -> None:
        """Completes the file."""
        if self._container is not None:
            self._container.mux(self._stream.encode())
            self._container.close()


def _fitted(picture: cv2.typing.MatLike, size: tuple[int, int]) -> cv2.typing.MatLike:
    """The whole picture, in the middle of one of `size` (columns, rows)."""
    height, width = picture.shape[:2]
    if (width, height) == size:
        return picture
    scale = min(size[0] / width, size[1] / height)
    inner = (max(1, round(scale * width)), max(1, round(scale * height)))
    left, top = (size[0] - inner[0]) // 2, (size[1] - inner[1]) // 2
    found = np.zeros((size[1], size[0], 3), dtype=np.uint8)
    found[top : top + inner[1], left : left + inner[0]] = cv2.resize(picture, inner, interpolation=cv2.INTER_AREA)
    return found
