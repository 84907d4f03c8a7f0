# SPDX-License-Identifier: Apache-2.0
"""The fault log 0x3020: the last faults of axes and board, each with the samples of its axis in the ticks before it.

0x3020: 1 count, 2 command, 3 and up the entries, newest first. Their bytes are described in
firmware/node/objects/fault_objects.h.
"""

from __future__ import annotations

import csv
import math
import re
import struct
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ..errors import NotVerified
from ..link.device import Device
from ..units import TICK_S
from .fault_table import FaultTable
from .parameter import AXES, shortest

LOG_OBJECT, COUNT, COMMAND, FIRST_ENTRY = 0x3020, 1, 2, 3
OWNERS = (*AXES, "board")
"""Of an entry, byte 5."""
FORGET = 1
_HEAD = struct.Struct("<IBBBB")
_ATTEMPTS = 5


@dataclass(frozen=True)
class LogEntry:
    """One fault; `of` is one of OWNERS, `samples` are rows of the signals, one per tick, None for NaN, the last of
    `tick`."""

    tick: int
    age_s: float
    fault: int
    name: str
    of: str
    signals: tuple[tuple[str, str], ...]
    samples: tuple[tuple[float | None, ...], ...]

    def ticks(self) -> list[int]:
        """Number of the tick of each row."""
        return [(self.tick - age) & 0xFFFFFFFF for age in reversed(range(len(self.samples)))]


@dataclass(frozen=True)
class FaultLog:
    """The entries, newest first; `count` of them were written since the log was cleared."""

    count: int
    entries: tuple[LogEntry, ...]


def read_log(device: Device, table: FaultTable) -> FaultLog | None:
    """None for a node without a fault log. A fault that comes meanwhile shifts the entries: then all are read again."""
    if device.try_upload(LOG_OBJECT, COUNT) is None:
        return None
    room = device.read_int(LOG_OBJECT) + 1 - FIRST_ENTRY
    for _ in range(_ATTEMPTS):
        count = device.read_int(LOG_OBJECT, COUNT)
        data = [device.upload_block(LOG_OBJECT, FIRST_ENTRY + n, "fault log") for n in range(min(count, room))]
        now = device.read_int(0x3010, 1)
        if device.read_int(LOG_OBJECT, COUNT) == count:
            return FaultLog(count, tuple(parse_entry(entry, now, table) for entry in data))
    raise NotVerified(f"the fault log could not be read: new faults occurred during all {_ATTEMPTS} attempts.")


def parse_entry(data: bytes, now: int, table: FaultTable) -> LogEntry:
    """An entry from its bytes; `now` is the number of the present tick. Raises NotVerified when the bytes are none."""
    if len(data) < _HEAD.size:
        raise NotVerified(f"invalid fault log entry: {len(data)} bytes; expected at least {_HEAD.size}.")
    tick, fault, owner, rows, columns = _HEAD.unpack_from(data)
    size = _HEAD.size + 4 * rows * columns
    if len(data) != size:
        raise NotVerified(f"invalid fault log entry: {len(data)} bytes; expected {size}.")
    values = [_number(value) for (value,) in struct.iter_unpack("<f", data[_HEAD.size :])]
    signals = table.signals if len(table.signals) == columns else tuple((f"signal_{n}", "") for n in range(1, columns + 1))
    return LogEntry(
        tick=tick,
        age_s=((now - tick) & 0xFFFFFFFF) * TICK_S,
        fault=fault,
        name=table.name(fault),
        of=OWNERS[owner] if owner < len(OWNERS) else f"source {owner}",
        signals=signals,
        samples=tuple(tuple(values[row * columns : (row + 1) * columns]) for row in range(rows)),
    )


def _number(value: float) -> float | None:
    return shortest(value) if math.isfinite(value) else None


def clear_log(device: Device) -> None:
    """Clears all entries, on a node that has a log."""
    if device.try_upload(LOG_OBJECT, COUNT) is not None:
        device.write_int(LOG_OBJECT, COMMAND, FORGET, 1)


def snapshot_files(log: FaultLog, folder: Path) -> dict[Path, LogEntry]:
    """The file for each entry that has samples, which are those of axes."""

    def name_of(number: int, entry: LogEntry) -> str:
        return f"fault-{number}-{entry.of}-{re.sub(r'[^a-z0-9]+', '-', entry.name.lower())}.csv"

    return {folder / name_of(number, entry): entry for number, entry in enumerate(log.entries, 1) if entry.samples}


def write_snapshots(log: FaultLog, folder: Path) -> list[Path]:
    """One CSV for each entry of an axis, a row for each tick; an empty cell is no number."""
    folder.mkdir(parents=True, exist_ok=True)
    files = snapshot_files(log, folder)
    for path, entry in files.items():
        with path.open("w", encoding="utf-8", newline="") as file:
            writer = csv.writer(file)
            writer.writerow(["tick", *(_titled(signal) for signal in entry.signals)])
            writer.writerows([tick, *row] for tick, row in zip(entry.ticks(), entry.samples, strict=True))
    return list(files)


def _titled(signal: tuple[str, str]) -> str:
    """Head of a column."""
    name, unit = signal
    return f"{name} ({unit})" if unit else name


def as_json(log: FaultLog) -> dict[str, Any]:
    """For --json."""
    entries = [
        {
            "tick": e.tick, "age_s": round(e.age_s, 3), "fault": e.fault, "name": e.name, "of": e.of,
            "signals": [{"name": name, "unit": unit} for name, unit in e.signals], "samples": e.samples,
        }
        for e in log.entries
    ]  # fmt: skip
    return {"count": log.count, "entries": entries}
