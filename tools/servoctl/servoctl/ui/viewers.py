# SPDX-License-Identifier: Apache-2.0
"""The open pages: one may command, the others view; any of them may stop."""

from __future__ import annotations

import asyncio
import contextlib
import itertools
import json
import math
import struct
import time
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any

from ..errors import MotionError

QUEUE = 64
"""Messages that wait for a slow page; more samples are dropped, and its plot has a gap."""


@dataclass(eq=False)
class Viewer:
    """One page."""

    number: int
    name: str
    joined: float = field(default_factory=time.time)
    queue: asyncio.Queue[str | bytes] = field(default_factory=lambda: asyncio.Queue(QUEUE))
    last_event: int = 0
    dropped: int = 0
    """Samples that this page did not get, because it was behind."""
    _waits: int = 0

    @contextlib.contextmanager
    def reads(self, most: int) -> Iterator[None]:
        """While it waits for a reading; raises MotionError when it waits for `most` others."""
        if self._waits >= most:
            raise MotionError(f"this page waits for {most} answers already: ask again when they are there.")
        self._waits += 1
        try:
            yield
        finally:
            self._waits -= 1

    def send(self, message: dict[str, Any]) -> None:
        """Text; the oldest message gives way. JSON has no NaN and no infinity: null."""
        try:
            self._put(json.dumps(message, allow_nan=False))
        except ValueError:
            self._put(json.dumps(_finite(message)))

    def send_samples(self, data: bytes) -> None:
        """Left out and counted when the page is behind."""
        if self.queue.qsize() < QUEUE // 2:
            self._put(data)
        else:
            self._count(data)

    def _put(self, message: str | bytes) -> None:
        if self.queue.full():
            self._make_room()
        self.queue.put_nowait(message)

    def _make_room(self) -> None:
        """The oldest samples or state give way, not an answer or an event that somebody waits for; without any of them, the
        oldest message."""
        waiting = [self.queue.get_nowait() for _ in range(self.queue.qsize())]
        oldest = next((n for n, each in enumerate(waiting) if isinstance(each, bytes) or each.startswith('{"state"')), 0)
        self._count(waiting.pop(oldest))
        for each in waiting:
            self.queue.put_nowait(each)

    def _count(self, message: str | bytes) -> None:
        """The samples of a message that is not sent; their number is its first word."""
        if isinstance(message, bytes):
            self.dropped += int(struct.unpack_from("<I", message)[0])


class Viewers:
    """All of them, and who commands."""

    def __init__(self) -> None:
        self.all: list[Viewer] = []
        self.commander: Viewer | None = None
        self.since = 0.0
        self._numbers = itertools.count(1)

    def join(self, name: str) -> Viewer:
        """A new page."""
        viewer = Viewer(next(self._numbers), name)
        self.all.append(viewer)
        return viewer

    def part(self, viewer: Viewer) -> bool:
        """A page is gone; True when it commanded."""
        self.all.remove(viewer)
        return self.release(viewer)

    def take(self, viewer: Viewer, silent: bool = False) -> None:
        """It commands from now on; raises MotionError while another one does that is not `silent`."""
        if self.commander not in (None, viewer) and not silent:
            raise MotionError(f"{self.describe()}: ask there to release it.")
        self.commander, self.since = viewer, time.time()

    def release(self, viewer: Viewer) -> bool:
        """True when it commanded."""
        if self.commander is not viewer:
            return False
        self.commander = None
        return True

    def need(self, viewer: Viewer) -> None:
        """Raises MotionError unless it commands."""
        if self.commander is not viewer:
            who = f" {self.describe()}." if self.commander else ""
            raise MotionError(f"this page only views; take command first.{who}")

    def describe(self) -> str:
        """Who commands."""
        if self.commander is None:
            return "nobody commands"
        clock = time.strftime("%H:%M", time.localtime(self.since))
        return f"page {self.commander.number} ({self.commander.name}) commands since {clock}"

    def data(self, of: Viewer) -> dict[str, Any]:
        """For a page."""
        return {
            "you": of.number, "dropped": of.dropped, "commander": self.commander.number if self.commander else None, "text": self.describe(),
            "viewers": [{"number": v.number, "name": v.name} for v in self.all],
        }  # fmt: skip


def _finite(value: Any) -> Any:
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    if isinstance(value, dict):
        return {key: _finite(entry) for key, entry in value.items()}
    return [_finite(entry) for entry in value] if isinstance(value, list | tuple) else value
