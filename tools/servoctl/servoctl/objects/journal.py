# SPDX-License-Identifier: Apache-2.0
"""The record of every write: one JSON object per line, with the old and the new value, and a backup before each store.

Folder: SERVOCTL_STATE, else $XDG_STATE_HOME/servoctl, else ~/.local/state/servoctl.
"""

from __future__ import annotations

import errno
import json
import os
import shutil
import uuid
from dataclasses import asdict, dataclass
from datetime import datetime, timezone
from pathlib import Path

from ..errors import InputError
from .parameter import Value

ROOM_BYTES = 1 << 17
"""For the lines of all parameters of both axes."""


@dataclass(frozen=True)
class Entry:
    """One write; `old` and `new` as read from the device before and after, in `unit`."""

    time: str
    transaction: str
    command: str
    node: int
    serial: int
    name: str
    index: int
    sub: int
    old: Value | None
    new: Value | None
    unit: str
    undoes: str = ""


def state_folder() -> Path:
    """Folder of journal and backups."""
    named = os.environ.get("SERVOCTL_STATE")
    if named:
        return Path(named)
    return Path(os.environ.get("XDG_STATE_HOME") or Path.home() / ".local" / "state") / "servoctl"


def now() -> str:
    """UTC, to the second, as ISO 8601."""
    return datetime.now(timezone.utc).strftime("%Y-%m-%dT%H:%M:%SZ")


class Journal:
    """The journal of one device, identified by node id and serial number."""

    def __init__(self, node: int, serial: int) -> None:
        self.node = node
        self.serial = serial
        self.path = state_folder() / f"journal-{node}-{serial:08x}.jsonl"

    def new_transaction(self) -> str:
        """A name for writes that belong together and are undone together."""
        return uuid.uuid4().hex[:12]

    def need(self) -> None:
        """Raises InputError when nothing can be added: call it before a write that will be noted."""
        try:
            self.path.parent.mkdir(parents=True, exist_ok=True)
            with self.path.open("a", encoding="utf-8"):
                pass
            if shutil.disk_usage(self.path.parent).free < ROOM_BYTES:
                raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        except OSError as error:
            raise InputError(f"{self.path}: the journal cannot be written: {error.strerror}. Nothing was changed.") from error

    def add(self, entry: Entry) -> None:
        """Appends one line, at once on disk."""
        try:
            self.path.parent.mkdir(parents=True, exist_ok=True)
            with self.path.open("a", encoding="utf-8") as file:
                file.write(json.dumps(asdict(entry)) + "\n")
                file.flush()
                os.fsync(file.fileno())
        except OSError as error:
            raise InputError(f"{self.path}: the journal cannot be written: {error.strerror}.") from error

    def entries(self) -> list[Entry]:
        """All lines, oldest first; a torn last line (power cut) is left out."""
        try:
            lines = self.path.read_text(encoding="utf-8").splitlines()
        except FileNotFoundError:
            return []
        except OSError as error:
            raise InputError(f"{self.path}: the journal cannot be read: {error.strerror}.") from error
        except UnicodeDecodeError as error:
            raise InputError(f"{self.path}: the journal is not UTF-8: servoctl did not write all of it.") from error
        found: list[Entry] = []
        for number, line in enumerate(lines, 1):
            try:
                found.append(Entry(**json.loads(line)))
            except (json.JSONDecodeError, TypeError) as error:
                if number != len(lines):
                    raise InputError(f"{self.path}:{number}: not a line of the journal.") from error
        return found

    def last_undoable(self) -> list[Entry]:
        """The newest transaction that changed something and has not been undone, in the order of its writes."""
        undone = {entry.undoes for entry in self.entries() if entry.undoes}
        open_entries = [e for e in self.entries() if not e.undoes and e.transaction not in undone and e.old != e.new]
        open_entries = [e for e in open_entries if e.old is not None]
        return [e for e in open_entries if e.transaction == open_entries[-1].transaction] if open_entries else []

    def backup_path(self) -> Path:
        """A new file for a backup, named by the time."""
        stamp = datetime.now(timezone.utc).strftime("%Y%m%dT%H%M%S.%fZ")
        return state_folder() / "backups" / f"node{self.node}-{self.serial:08x}-{stamp}.toml"
