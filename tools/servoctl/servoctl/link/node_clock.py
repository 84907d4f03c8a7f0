# SPDX-License-Identifier: Apache-2.0
"""The node's own clock: it times every wait, time-out and pace of the node.

A node's clock and the computer's agree, except for an emulated board, which runs as fast as its computer can, and for a
simulator with another pace. Object 3010:1 counts the node's ticks of 1 ms; a node without it is assumed to run at the
computer's time. The computer's clock decides only that a node is silent.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator

TICKS = (0x3010, 1)
_WRAP = 1 << 32
_SHORTEST_PAUSE_S = 1e-3


class NodeClock:
    """Seconds by the node's clock."""

    def __init__(self, read_ticks: Callable[[], int | None]) -> None:
        """`read_ticks` gives 3010:1, or None when the node has none."""
        self._read_ticks = read_ticks
        self._has_ticks = True
        self._ticks: int | None = None
        self._node_s = 0.0
        self._computer_s = 0.0

    def now(self) -> float:
        """From an unspecified start; takes an SDO transfer."""
        ticks = self._read_ticks() if self._has_ticks else None
        if ticks is None:
            self._has_ticks = False
            return time.monotonic()
        if self._ticks is None:
            self._computer_s = time.monotonic()
        else:
            passed = (ticks - self._ticks) % _WRAP
            self._node_s += 1e-3 * (passed if passed < _WRAP / 2 else ticks)  # after a reset it counts from 0
        self._ticks = ticks
        return self._node_s

    def sleep(self, seconds: float) -> None:
        """At least this long by the node's clock."""
        end = self.now() + seconds
        while (left_s := end - self.now()) > 0.0:
            time.sleep(max(left_s / max(1.0, self._pace()), _SHORTEST_PAUSE_S))

    def every(self, period_s: float, duration_s: float) -> Iterator[float]:
        """Yields the time since the start, s, about every `period_s` until `duration_s`; late ones are skipped, not
        made up for."""
        start = self.now()
        next_s = 0.0
        while True:
            passed = self.now() - start
            if passed < next_s:
                self.sleep(next_s - passed)
                passed = self.now() - start
            if passed >= duration_s:
                return
            yield passed
            next_s = (int(passed / period_s) + 1) * period_s

    def _pace(self) -> float:
        """Of the node's clock per the computer's, on average so far."""
        computer_s = time.monotonic() - self._computer_s
        return self._node_s / computer_s if self._has_ticks and computer_s > 0.0 else 1.0
