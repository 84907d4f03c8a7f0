# SPDX-License-Identifier: Apache-2.0
"""Where pictures come from: a camera, a video file, a folder, a URL, or the simulator.

A thread reads; whoever takes pictures gets the newest one, so that a slow computer loses pictures instead of time.
"""

from __future__ import annotations

import queue
import socket
import threading
import time
from collections.abc import Iterator
from pathlib import Path
from typing import BinaryIO, Protocol, cast

import numpy as np

from .camera import CameraMode, CameraSource
from .errors import ImagerError
from .picture import Picture
from .still import StillSource, is_still
from .video import CONNECT_S, DEFAULT_RATE_HZ, StreamSource, VideoSource

FORMS = (
    "a camera's number (0) or device (/dev/video0), a video file, a folder of pictures, an rtsp:// or http:// address,"
    " or pgm-tcp:HOST:PORT"
)
SIMULATOR = "pgm-tcp:"
RECEIVE_BUFFER_BYTES = 1 << 18
"""About a picture: if we are late, the simulator drops pictures, and none waits here until it is old."""
LARGEST_SIDE_PX = 16384


class Source(Protocol):
    """`read` waits for the next picture; None: the source has ended properly."""

    node_clock: bool
    """Exposures are by the clock of the node instead of time.monotonic()."""
    rate_hz: float
    """Of a recording of its pictures."""
    waits: bool
    """For whoever takes its pictures, as a file may: none is skipped."""
    is_playlist: bool
    """Its pictures are in other files, which it names."""
    damage: str
    """A sentence on what was missing, when it has ended."""

    def read(self) -> Picture | None: ...

    def close(self) -> None: ...


class PgmSource:
    """Pictures of the simulator: PGM (P5), one after the other, with comment lines `picture` and `exposure_us`."""

    node_clock = True
    waits = False
    is_playlist = False
    damage = ""
    rate_hz = 50.0

    def __init__(self, host: str, port: int) -> None:
        self._name = f"{SIMULATOR}{host}:{port}"
        self._socket = socket.socket()
        self._socket.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, RECEIVE_BUFFER_BYTES)
        self._socket.settimeout(CONNECT_S)
        try:
            self._socket.connect((host, port))
        except OSError as error:
            raise ImagerError(
                f"{self._name}: no pictures there ({error.strerror or error}); is 'sim_host serve --video' running?"
            ) from error
        self._socket.settimeout(None)  # a simulator may stand still
        self._stream = cast(BinaryIO, self._socket.makefile("rb", buffering=1 << 16))

    def read(self) -> Picture | None:
        try:
            return read_pgm(self._stream)
        except (ValueError, OSError) as error:
            raise ImagerError(f"{self._name}: {error}.") from error

    def close(self) -> None:
        self._socket.shutdown(socket.SHUT_RDWR)
        self._socket.close()


def read_pgm(stream: BinaryIO) -> Picture | None:
    """The next picture; None at the end of the stream. Raises ValueError for anything but a PGM of 8 bits."""
    if not (magic := stream.readline()):
        return None
    if magic.strip() != b"P5":
        raise ValueError("the stream is not a sequence of PGM pictures (P5)")
    comments: dict[str, int] = {}
    numbers: list[int] = []
    while len(numbers) < 3:  # width, height, white
        if not (line := stream.readline()):
            raise ValueError("the stream ends within a picture")
        text = line.decode("ascii", errors="replace").strip()
        if text.startswith("#"):
            name, _, value = text[1:].strip().partition(" ")
            if value.isdigit():
                comments[name] = int(value)
        else:
            words = text.split()
            if not all(word.isdigit() for word in words):
                raise ValueError("a picture's size is not a number")
            numbers += map(int, words)
    width, height, white = numbers
    if white != 255 or not 1 <= width <= LARGEST_SIDE_PX or not 1 <= height <= LARGEST_SIDE_PX:
        raise ValueError(
            f"a picture of {width} x {height} with white {white}: expected grey levels of 8 bits and sides up to {LARGEST_SIDE_PX}"
        )
    if "exposure_us" not in comments:
        raise ValueError("a picture has no comment line '# exposure_us MICROSECONDS'")
    data = stream.read(width * height)
    if len(data) < width * height:
        return None  # the simulator has ended
    grey = np.frombuffer(data, dtype=np.uint8).reshape(height, width)
    return Picture(grey, comments.get("picture", 0), 1e-6 * comments["exposure_us"], time.monotonic())


def open_source(text: str, mode: CameraMode | None = None) -> Source:
    """`mode` is asked of a camera; its rate is also that of pictures in files of their own. Raises ImagerError, too, for
    a mode that the source cannot have."""
    mode = mode or CameraMode()
    if not text:
        raise ImagerError(f"the source is empty; expected {FORMS}.")
    if text.startswith(SIMULATOR):
        host, _, port = text[len(SIMULATOR) :].rpartition(":")
        if not (port.isascii() and port.isdigit()) or not 0 < int(port) < 65536:
            raise ImagerError(f"the source '{text}' has no valid port: expected pgm-tcp:HOST:PORT.")
        mode.refuse_all(text)
        return PgmSource(host or "127.0.0.1", int(port))
    if "://" in text:
        mode.refuse_all(text)
        return StreamSource(text, FORMS)
    path = Path(text)
    device = str(path.resolve() if text.startswith("/dev/") else text).removeprefix("/dev/video")  # /dev/v4l/by-id/... is a link
    if device.isascii() and device.isdigit():
        return CameraSource(int(device), text, mode, FORMS)
    if not path.exists():
        raise ImagerError(f"the video '{path}' does not exist; expected {FORMS}.")
    if is_still(path):
        mode.refuse_picture(text)
        return StillSource(path, mode.rate_hz or DEFAULT_RATE_HZ)
    if not path.is_file():
        raise ImagerError(f"the video '{path}' is not a file; expected {FORMS}.")
    mode.refuse_all(text)
    return VideoSource(path)


class NewestPicture:
    """Reads a source in a thread; iterating gives the newest picture each time, until the source ends."""

    def __init__(self, source: Source) -> None:
        self._source = source
        self._box: queue.Queue[Picture | Exception | None] = queue.Queue(maxsize=1)
        self._keep_all = source.waits
        self.skipped = 0
        self._stop = threading.Event()
        self._thread = threading.Thread(target=self._run, daemon=True)
        self._thread.start()

    def _run(self) -> None:
        while not self._stop.is_set():
            try:
                item: Picture | Exception | None = self._source.read()
            except Exception as error:  # the taker raises it
                item = error
            self._put(item)
            if not isinstance(item, Picture):
                return

    def _put(self, item: Picture | Exception | None) -> None:
        while not self._stop.is_set():
            try:
                self._box.put(item, timeout=0.1 if self._keep_all or not isinstance(item, Picture) else 0.0)
                return
            except queue.Full:
                if isinstance(item, Picture) and not self._keep_all:
                    try:
                        self._box.get_nowait()
                        self.skipped += 1
                    except queue.Empty:
                        pass

    def __iter__(self) -> Iterator[Picture]:
        while True:
            try:
                item = self._box.get(timeout=0.2)
            except queue.Empty:
                continue  # so that Ctrl-C is heard
            if isinstance(item, Exception):
                raise item
            if item is None:
                return
            yield item

    def close(self) -> None:
        """The source is not read any more."""
        self._stop.set()
        self._thread.join(timeout=1.0)
