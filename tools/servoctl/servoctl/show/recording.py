# SPDX-License-Identifier: Apache-2.0
"""Recordings of the live signals in MCAP files, for hours: written in a thread of their own, read in part or whole.

Each sample is one JSON message on the topic /samples, with the fields that its JSON schema names (azimuth_rate_deg_s), so
that other programs can read and plot the file. The time of a message counts from the beginning by the node's ticks. A file that was
not ended (power cut, full disk) is read up to its last whole chunk.
"""

from __future__ import annotations

import json
import queue
import re
import struct
import threading
import time
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from datetime import datetime, timezone
from pathlib import Path
from typing import TYPE_CHECKING, Any, BinaryIO

import numpy as np
from mcap.exceptions import McapError
from mcap.reader import NonSeekingReader, SeekingReader
from mcap.records import Channel, Message, Schema
from mcap.writer import CompressionType, Writer

from .. import __version__
from ..errors import InputError
from ..link.signal_stream import Samples, Signal
from ..objects.journal import state_folder

if TYPE_CHECKING:
    from pandas import DataFrame

TOPIC = "/samples"
CHUNK_BYTES = 1 << 17
"""Less than a second of samples, before compression: as much as a power cut can take."""
TICK_NS = 1_000_000
_WRAP = 1 << 32
_FORMAT = "signals"
_UNITS = {"°": "deg", "°/s": "deg_s", "N m": "nm", "µrad": "urad"}
Messages = Iterator[tuple[Schema | None, Channel, Message]]
_NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9_.-]*\.mcap")


def folder() -> Path:
    """Where the page keeps recordings."""
    return state_folder() / "recordings"


def find(name: str) -> Path:
    """A recording of the page by its name; raises InputError."""
    path = folder() / name
    if not _NAME.fullmatch(name) or not path.is_file():
        raise InputError(f"there is no recording '{name}'.")
    return path


def field_of(signal: Signal) -> str:
    """azimuth_rate_deg_s."""
    return f"{signal.name.replace(' ', '_')}_{_UNITS.get(signal.unit, signal.unit)}"


class MeasuredTime:
    """Times of ticks since the first one, in ns; a node that has started again continues one second later."""

    def __init__(self) -> None:
        self._last: int | None = None
        self._time_ns = 0

    def of(self, tick: int) -> int:
        """Of the next tick."""
        if self._last is not None:
            passed = (tick - self._last) % _WRAP
            self._time_ns += TICK_NS * passed if passed < _WRAP // 2 else 1000 * TICK_NS
        self._last = tick
        return self._time_ns


class Recorder:
    """Writes one file; `add` never waits for the disk."""

    def __init__(self, path: Path, signals: Iterable[Signal], period_ms: int, about: dict[str, Any]) -> None:
        """Begins; raises InputError when the file cannot be written. `about` are texts on the device."""
        self.path = path
        self.samples = 0
        self.error = ""
        self._written = 0
        """Samples of the chunks that the system has taken; a reader finds all of them."""
        self._fields = [field_of(signal) for signal in signals]
        self._queue: queue.Queue[Samples | None] = queue.Queue()
        self._times = MeasuredTime()
        self._begun_ns = time.time_ns()
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
            self._file: BinaryIO = path.open("xb")
        except OSError as error:
            raise InputError(f"{path}: cannot be written: {error.strerror}.") from error
        self._writer = Writer(self._file, chunk_size=CHUNK_BYTES, compression=CompressionType.ZSTD)
        self._channel = self._start(list(signals), period_ms, about)
        self._thread = threading.Thread(target=self._run, name="recording")
        self._thread.start()

    def _start(self, signals: list[Signal], period_ms: int, about: dict[str, Any]) -> int:
        writer = self._writer
        writer.start(library=f"servoctl {__version__}")
        described = [
            {"name": s.name, "axis": s.axis, "index": s.index, "unit": s.unit, "factor": s.factor, "plot": s.plot, "sub": s.sub, "kind": s.kind}
            for s in signals
        ]
        properties: dict[str, Any] = {field: {"type": "number", "description": s.unit} for field, s in zip(self._fields, signals, strict=True)}
        schema = {"type": "object", "properties": {"tick": {"type": "integer", "description": "ms, of the node"}, **properties}}
        number = writer.register_schema("trackservo.samples", "jsonschema", json.dumps(schema).encode())
        metadata = {_FORMAT: json.dumps(described), "period_ms": str(period_ms), **{key: str(value) for key, value in about.items()}}
        return writer.register_channel(TOPIC, "json", number, metadata)

    def add(self, samples: Samples) -> None:
        """What has come."""
        if not self.error:
            self._queue.put(samples)

    def close(self) -> None:
        """Writes what is left, and ends the file."""
        self._queue.put(None)
        self._thread.join()

    def _run(self) -> None:
        try:
            while (samples := self._queue.get()) is not None:
                self._write(samples)
            self._writer.finish()
        except OSError as error:
            self._fail(str(error.strerror))
        except Exception as error:  # noqa: BLE001 - the page shows it
            self._fail(f"internal error of servoctl: {error!r}")
        try:
            self._file.close()
        except OSError:
            pass  # the disk is full

    def _fail(self, why: str) -> None:
        self.samples = self._written
        left = f"The {self.samples} samples written before are readable." if self.samples else "No sample was written before."
        self.error = f"{self.path}: the recording has ended: {why}. {left}"

    def _write(self, samples: Samples) -> None:
        place = self._file.tell()
        for tick, row in zip(samples.ticks.tolist(), samples.values.T.astype(np.float64).tolist(), strict=True):
            stamp = self._begun_ns + self._times.of(tick)
            data = json.dumps({"tick": tick, **dict(zip(self._fields, row, strict=True))}).encode()
            self._writer.add_message(self._channel, stamp, data, stamp)
            self.samples += 1
            if (now := self._file.tell()) != place:  # a chunk was complete
                self._file.flush()
                self._written, place = self.samples, now


@dataclass(frozen=True)
class Recording:
    """Samples of a file: time since its beginning (s), and a row of values per signal in its unit."""

    signals: tuple[Signal, ...]
    period_ms: int
    about: dict[str, str]
    begun: datetime
    time_s: np.ndarray[Any, np.dtype[np.float64]]
    samples: Samples
    whole: bool
    """False when the file was not ended."""

    def column(self, name: str) -> np.ndarray[Any, np.dtype[np.float32]]:
        """Values of the signal with this name; raises InputError."""
        for row, signal in enumerate(self.signals):
            if signal.name == name:
                return np.asarray(self.samples.values[row])
        raise InputError(f"no signal '{name}' in this recording; it has {', '.join(signal.name for signal in self.signals)}.")

    def frame(self) -> DataFrame:
        """A row per sample over time in s, with columns such as azimuth_rate_deg_s. Needs pandas."""
        from .frames import recording_frame

        return recording_frame(self)


def read(path: Path, from_s: float = 0.0, seconds: float = float("inf")) -> Recording:
    """A part of a file, or all of it; raises InputError when it is no recording of servoctl."""
    rows: list[list[float]] = []
    ticks: list[int] = []
    stamps: list[int] = []
    described: dict[str, str] | None = None
    fields: list[str] = []
    first_ns: int | None = None
    whole = True
    try:
        with path.open("rb") as file:
            part = _part(file, from_s, seconds) if 0.0 < from_s and seconds < float("inf") else None
            try:
                if part is not None:
                    first_ns, described, messages = part
                    fields = [field_of(signal) for signal in _signals(described)]
                else:
                    messages = _all(file)
                for _schema, channel, message in messages:
                    if described is None:
                        described = channel.metadata
                        fields = [field_of(signal) for signal in _signals(described)]
                    first_ns = message.log_time if first_ns is None else first_ns
                    at_s = 1e-9 * (message.log_time - first_ns)
                    if at_s < from_s:
                        continue
                    if at_s >= from_s + seconds:
                        break
                    found = json.loads(message.data)
                    ticks.append(found["tick"])
                    stamps.append(message.log_time - first_ns)
                    rows.append([found[field] for field in fields])
            except (McapError, struct.error, EOFError, ValueError, KeyError):
                whole = False
    except OSError as error:
        raise InputError(f"{path}: cannot be read: {error.strerror}.") from error
    if described is None or first_ns is None:
        raise InputError(f"{path}: not a recording of servoctl, or it has no samples.")
    values = np.array(rows, dtype=np.float32).reshape(len(rows), len(fields)).T
    return Recording(
        tuple(_signals(described)), int(described["period_ms"]),
        {key: value for key, value in described.items() if key not in (_FORMAT, "period_ms")},
        datetime.fromtimestamp(1e-9 * first_ns, timezone.utc), 1e-9 * np.array(stamps, dtype=np.float64),
        Samples(np.array(ticks, dtype=np.uint32), values), whole,
    )  # fmt: skip


def _all(file: BinaryIO) -> Messages:
    """In the order in which they are in the file, which need not have an end."""
    return NonSeekingReader(file).iter_messages(topics=[TOPIC], log_time_order=False)


def _part(file: BinaryIO, from_s: float, seconds: float) -> tuple[int, dict[str, str], Messages] | None:
    """The first sample's time, what describes the samples, and those of a part, by the index at the end of the file: an hour before them costs nothing.

    None, and the file at its beginning, when it was not ended.
    """
    reader = SeekingReader(file)
    try:
        summary = reader.get_summary()
    except (McapError, struct.error, EOFError, ValueError, OSError):  # the last one: shorter than its end
        summary = None
    channels = summary.channels.values() if summary is not None else ()
    described = next((channel.metadata for channel in channels if channel.topic == TOPIC), None)
    if summary is None or summary.statistics is None or described is None:
        file.seek(0)
        return None
    first_ns = summary.statistics.message_start_time
    from_ns = first_ns + int(1e9 * from_s)
    return first_ns, described, reader.iter_messages(topics=[TOPIC], starting_at=from_ns, ending_before=from_ns + int(1e9 * seconds))


def _signals(described: dict[str, str]) -> list[Signal]:
    return [Signal(**each) for each in json.loads(described[_FORMAT])]
