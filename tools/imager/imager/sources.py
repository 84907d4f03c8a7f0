"""Where pictures come from: a camera, a video file, a URL, or the simulator.

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

import cv2
import numpy as np

from .errors import ImagerError
from .picture import Grey, Picture

FORMS = "a camera's number (0) or device (/dev/video0), a video file, an rtsp:// or http:// address, or pgm-tcp:HOST:PORT"
SIMULATOR = "pgm-tcp:"
CONNECT_S = 3.0
RECEIVE_BUFFER_BYTES = 1 << 18
"""About a picture: if we are late, the simulator drops pictures, and none waits here until it is old."""
LARGEST_SIDE_PX = 16384
SILENCE_S = 5.0
"""Without a picture for so long, the source is broken."""
_BUFFERED_STAMP_S = 1.0
"""A driver's time stamp that is further from now is not one of our clock."""


class Source(Protocol):
    """`read` waits for the next picture; None: the source has ended properly."""

    node_clock: bool
    """Exposures are by the clock of the node instead of time.monotonic()."""
    rate_hz: float
    """Of a recording of its pictures."""

    def read(self) -> Picture | None: ...

    def close(self) -> None: ...


def _grey(picture: cv2.typing.MatLike) -> Grey:
    if picture.ndim == 3:
        picture = cv2.cvtColor(picture, cv2.COLOR_BGR2GRAY)
    if picture.dtype != np.uint8:
        picture = cv2.normalize(picture, np.empty(0), 0, 255, cv2.NORM_MINMAX, cv2.CV_8U)
    return np.asarray(picture, dtype=np.uint8)


def _rate(capture: cv2.VideoCapture) -> float:
    rate = capture.get(cv2.CAP_PROP_FPS)
    return rate if 1.0 <= rate <= 1000.0 else 25.0


class CaptureSource:
    """A camera or a URL: pictures come by themselves, and the last one never ends well."""

    node_clock = False

    def __init__(self, address: int | str, name: str, what: str) -> None:
        self._name = name
        self._capture = cv2.VideoCapture()
        backend = cv2.CAP_V4L2 if isinstance(address, int) else cv2.CAP_FFMPEG
        settings = [] if isinstance(address, int) else [
            cv2.CAP_PROP_OPEN_TIMEOUT_MSEC, int(1e3 * CONNECT_S), cv2.CAP_PROP_READ_TIMEOUT_MSEC, int(1e3 * SILENCE_S),
        ]  # fmt: skip
        if isinstance(address, int):
            opened = self._capture.open(address, backend)
        else:
            opened = self._capture.open(address, backend, settings)
        if not opened:
            raise ImagerError(f"{what} '{name}' cannot be opened; expected {FORMS}.")
        self.rate_hz = _rate(self._capture)
        self._number = 0

    def read(self) -> Picture | None:
        if not self._capture.grab():
            raise ImagerError(f"'{self._name}' gives no more pictures; check its cable or network, then start again.")
        now = time.monotonic()
        stamp = 1e-3 * self._capture.get(cv2.CAP_PROP_POS_MSEC)  # of V4L2: the driver's, by the same clock
        exposed = stamp if 0.0 <= now - stamp < _BUFFERED_STAMP_S else now
        good, picture = self._capture.retrieve()
        if not good:
            raise ImagerError(f"'{self._name}' gives a picture that cannot be decoded; choose another pixel format.")
        self._number += 1
        return Picture(_grey(picture), self._number, exposed, now)

    def close(self) -> None:
        self._capture.release()


class VideoSource:
    """A file, played at its own frame rate: each picture is exposed when it is due."""

    node_clock = False

    def __init__(self, file: Path) -> None:
        if not file.is_file():
            what = "is not a file" if file.exists() else "does not exist"
            raise ImagerError(f"the video '{file}' {what}; expected {FORMS}.")
        self._file = file
        self._capture = cv2.VideoCapture(str(file), cv2.CAP_FFMPEG)
        if not self._capture.isOpened():
            raise ImagerError(f"'{file}' is not a video that OpenCV can read; convert it, for example to MP4 or AVI.")
        self.rate_hz = _rate(self._capture)
        self._start_s: float | None = None
        self._number = 0

    def read(self) -> Picture | None:
        good, picture = self._capture.read()
        if not good:
            if self._number == 0:
                raise ImagerError(f"the video '{self._file}' has no picture that can be decoded; is the file complete?")
            return None
        if self._start_s is None:
            self._start_s = time.monotonic()
        due = self._start_s + self._number / self.rate_hz
        time.sleep(max(0.0, due - time.monotonic()))
        self._number += 1
        return Picture(_grey(picture), self._number, time.monotonic(), time.monotonic())

    def close(self) -> None:
        self._capture.release()


class PgmSource:
    """Pictures of the simulator: PGM (P5), one after the other, with comment lines `picture` and `exposure_us`."""

    node_clock = True
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


def open_source(text: str) -> Source:
    """Raises ImagerError."""
    if not text:
        raise ImagerError(f"the source is empty; expected {FORMS}.")
    if text.startswith(SIMULATOR):
        host, _, port = text[len(SIMULATOR) :].rpartition(":")
        if not port.isdigit() or not 0 < int(port) < 65536:
            raise ImagerError(f"the source '{text}' has no valid port: expected pgm-tcp:HOST:PORT.")
        return PgmSource(host or "127.0.0.1", int(port))
    if "://" in text:
        return CaptureSource(text, text, "the stream")
    device = text.removeprefix("/dev/video")
    if device.isdigit():
        return CaptureSource(int(device), text, "the camera")
    return VideoSource(Path(text))


class NewestPicture:
    """Reads a source in a thread; iterating gives the newest picture each time, until the source ends."""

    def __init__(self, source: Source, keep_all: bool = False) -> None:
        """`keep_all`: the source waits for whoever takes its pictures, as a video file may."""
        self._source = source
        self._box: queue.Queue[Picture | Exception | None] = queue.Queue(maxsize=1)
        self._keep_all = keep_all
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
