# SPDX-License-Identifier: Apache-2.0
"""Steps that an interrupt must not cut short: a transfer, bringing an axis to rest, restoring borrowed objects."""

from __future__ import annotations

import contextlib
import signal
import threading
from collections.abc import Iterator
from typing import Any


@contextlib.contextmanager
def _handled_by(handler: Any) -> Iterator[None]:
    if threading.current_thread() is not threading.main_thread():
        yield  # only the main thread gets signals
        return
    before: dict[signal.Signals, Any] = {s: signal.signal(s, handler) for s in (signal.SIGINT, signal.SIGTERM)}
    try:
        yield
    finally:
        for number, handler_before in before.items():
            signal.signal(number, handler_before)


@contextlib.contextmanager
def deaf() -> Iterator[None]:
    """Within a `with` block Ctrl-C and SIGTERM are ignored."""
    with _handled_by(signal.SIG_IGN):
        yield


@contextlib.contextmanager
def postponed() -> Iterator[None]:
    """Ctrl-C and SIGTERM that come within a `with` block take effect at its end.

    If an SDO transfer is abandoned before its answer arrives, the next one takes that answer for its own.
    """
    came: list[int] = []
    try:
        with _handled_by(lambda number, _frame: came.append(number)):
            yield
    finally:
        if came:
            signal.raise_signal(came[0])
