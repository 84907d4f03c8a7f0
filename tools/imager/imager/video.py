# SPDX-License-Identifier: Apache-2.0
"""Pictures of a video file or of a stream on the network, decoded by FFmpeg (PyAV) with all their bits and their times."""

from __future__ import annotations

import threading
import time
from collections.abc import Iterator
from pathlib import Path

import av
import numpy as np

from .errors import ImagerError
from .picture import Grey, Picture

CONNECT_S = 3.0
SILENCE_S = 5.0
"""Without a picture for so long, the source is broken."""
DEFAULT_RATE_HZ = 25.0
_SLOWEST_HZ, _FASTEST_HZ = 1e-3, 1e3
"""A file that states another rate states none."""
LATE_S = 0.1
"""A reader that is later than this moves all that follows: the rest of the file is not played in haste."""
_GREYS = ((8, "gray"), (10, "gray10le"), (12, "gray12le"), (14, "gray14le"))
_MOST_BITS = "gray16le"


def _grey(frame: av.VideoFrame, name: str) -> Grey:
    """Full range, with as many bits as the video has, turned as it is meant to be seen."""
    bits = max(component.bits for component in frame.format.components)
    form = next((form for most, form in _GREYS if bits <= most), _MOST_BITS)
    try:
        plane = frame.reformat(format=form).planes[0]
    except (ValueError, av.error.FFmpegError) as error:
        raise ImagerError(f"'{name}' has pixels of the form {frame.format.name}, which cannot be made grey; convert it.") from error
    kind = np.dtype(np.uint8 if bits <= 8 else "<u2")
    rows = np.frombuffer(memoryview(plane), kind).reshape(-1, plane.line_size // kind.itemsize)[: frame.height, : frame.width]
    grey: Grey = np.ascontiguousarray(np.rot90(rows, round(frame.rotation / 90)))
    return grey


PLAYLISTS = {"concat", "dash", "hls", "imf", "webm_dash_manifest"}
"""FFmpeg's names of the formats whose files name others."""


class _Decoder:
    """Frames of the first video stream; damaged packets are left out and counted."""

    def __init__(self, container: av.container.InputContainer) -> None:
        """Raises IndexError when it has no pictures."""
        self.container = container
        self.stream = container.streams.video[0]
        rate = float(self.stream.average_rate or 0)
        self.rate_hz = rate if _SLOWEST_HZ <= rate <= _FASTEST_HZ else DEFAULT_RATE_HZ
        self.is_playlist = not PLAYLISTS.isdisjoint(container.format.name.split(","))
        self.packets = self.damaged = 0

    def frames(self) -> Iterator[av.VideoFrame]:
        """Until the file ends or the network is silent."""
        try:
            for packet in self.container.demux(self.stream):
                self.packets += packet.size > 0
                try:
                    yield from packet.decode()
                except av.error.InvalidDataError:
                    self.damaged += 1
        except av.error.FFmpegError:
            return


class VideoSource:
    """A file, played as its own times say: each picture is exposed when it is due."""

    node_clock = False
    waits = True

    def __init__(self, file: Path) -> None:
        self._file = file
        try:
            self._decoder = _Decoder(av.open(str(file)))
        except (av.error.FFmpegError, IndexError) as error:
            raise ImagerError(f"'{file}' is not a video that FFmpeg can read; convert it, for example to MP4 or AVI.") from error
        self._decoder.stream.thread_type = "AUTO"
        self.rate_hz = self._decoder.rate_hz
        self.is_playlist = self._decoder.is_playlist
        self._frames = self._decoder.frames()
        self.damage = ""
        self._start_s: float | None = None
        """Of time.monotonic(), at time 0 of the file."""
        self._file_s = 0.0
        self._number = 0

    def read(self) -> Picture | None:
        """The next picture, when it is due; None at the end."""
        frame = next(self._frames, None)
        if frame is None:
            if self._number == 0:
                raise ImagerError(f"the video '{self._file}' has no picture that can be decoded; is the file complete?")
            self.damage = self._damage()
            return None
        grey = _grey(frame, str(self._file))
        next_s = self._file_s + 1.0 / self.rate_hz if self._number else 0.0
        time_s = next_s if frame.time is None else float(frame.time)
        self._file_s = time_s if not self._number or time_s > self._file_s else next_s
        self._number += 1
        exposed_s = self._wait()
        return Picture(grey, self._number, exposed_s, time.monotonic(), self._file_s)

    def _damage(self) -> str:
        """What is missing, as far as the file says how many pictures it has."""
        most, good = max(self._decoder.stream.frames, self._decoder.packets), self._decoder.packets - self._decoder.damaged
        return f"the video '{self._file}' is damaged: {most - good} of its {most} pictures cannot be decoded." if good < most else ""

    def _wait(self) -> float:
        """Until the picture is due; returns when it was."""
        now_s = time.monotonic()
        if self._start_s is None or now_s > self._start_s + self._file_s + LATE_S:
            self._start_s = now_s - self._file_s
        due_s = self._start_s + self._file_s
        time.sleep(max(0.0, due_s - now_s))
        return due_s

    def close(self) -> None:
        """The file is not read any more."""
        self._decoder.container.close()


class StreamSource:
    """A network camera: its pictures are exposed when they arrive, and the last one never ends well."""

    node_clock = False
    waits = False
    damage = ""

    def __init__(self, address: str, forms: str) -> None:
        self._name = address
        options = {"rtsp_transport": "tcp"} if address.startswith("rtsp:") else {}
        try:
            self._decoder = _Decoder(av.open(address, options=options, timeout=(CONNECT_S, SILENCE_S)))
        except (av.error.FFmpegError, IndexError) as error:
            raise ImagerError(f"the stream '{address}' cannot be opened; expected {forms}.") from error
        self.rate_hz = self._decoder.rate_hz
        self.is_playlist = self._decoder.is_playlist
        self._frames = self._decoder.frames()
        self._number = 0
        self._reading = threading.Lock()

    def read(self) -> Picture | None:
        """Waits for the next picture."""
        with self._reading:
            frame = next(self._frames, None)
        if frame is None:
            raise ImagerError(f"'{self._name}' gives no more pictures; check its cable or network, then start again.")
        now_s = time.monotonic()
        self._number += 1
        return Picture(_grey(frame, self._name), self._number, now_s, now_s)

    def close(self) -> None:
        """Ends the connection; while a thread waits for a picture, the end of the program does."""
        if self._reading.acquire(timeout=0.1):
            self._decoder.container.close()
