"""The node has one SDO server: the servoctl processes of one computer take turns at it, so that they may run side by side.

Each transfer is one turn. A long one, as the reading of a capture, waits until no servoctl is moving an axis, since a
motion must be watched all the time. Other programs know nothing of this; they must keep to PDOs meanwhile.
"""

from __future__ import annotations

import contextlib
import fcntl
import os
import tempfile
import time
import zlib
from collections.abc import Iterator
from pathlib import Path

SETTLE_S = 0.005
"""After somebody else's turn: the answer to them reaches us, too, and must be in before we ask."""


class Turns:
    """The turns at one node; files are those of the user, in the system's folder for such."""

    def __init__(self, bus: str, node_id: int) -> None:
        folder = Path(os.environ.get("XDG_RUNTIME_DIR") or tempfile.gettempdir())
        name = f"servoctl-{os.getuid()}-{zlib.crc32(bus.encode()):08x}-{node_id}"
        self._transfer = os.open(folder / f"{name}.lock", os.O_RDWR | os.O_CREAT | os.O_CLOEXEC, 0o600)
        self._motion = os.open(folder / f"{name}-motion.lock", os.O_RDWR | os.O_CREAT | os.O_CLOEXEC, 0o600)
        self._us = str(os.getpid()).ljust(10).encode()

    def close(self) -> None:
        """Ends our part; the files stay for the others."""
        os.close(self._transfer)
        os.close(self._motion)

    @contextlib.contextmanager
    def transfer(self) -> Iterator[None]:
        """One SDO transfer."""
        with _locked(self._transfer, fcntl.LOCK_EX):
            if os.pread(self._transfer, len(self._us), 0) != self._us:
                time.sleep(SETTLE_S)
                os.pwrite(self._transfer, self._us, 0)
            yield

    @contextlib.contextmanager
    def long_transfer(self) -> Iterator[None]:
        """One SDO transfer that may take seconds."""
        with _locked(self._motion, fcntl.LOCK_EX), self.transfer():
            yield

    @contextlib.contextmanager
    def motion(self) -> Iterator[None]:
        """While an axis moves: transfers are as ever, nobody's long one comes between."""
        with _locked(self._motion, fcntl.LOCK_SH):
            yield


@contextlib.contextmanager
def _locked(descriptor: int, how: int) -> Iterator[None]:
    fcntl.flock(descriptor, how)
    try:
        yield
    finally:
        fcntl.flock(descriptor, fcntl.LOCK_UN)
