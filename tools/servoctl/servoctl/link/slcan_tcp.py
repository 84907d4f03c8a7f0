# SPDX-License-Identifier: Apache-2.0
"""A CAN adapter over TCP with SLCAN, the simulator's default.

Protocol: Lawicel ASCII (t, T, r, R, S, O, L, C, Z). Reads whole buffers, so that it keeps up with a busy bus, and uses
the adapter's time stamps (Z1, 1 ms).
"""

from __future__ import annotations

import select
import socket
import threading
import time
from collections import deque
from typing import Any

import can

from .slcan_lines import LineReader
from .slcan_serial import message_of

_BIT_RATES = {125_000: "S4", 250_000: "S5", 500_000: "S6", 1_000_000: "S8"}
STAMP_PERIOD_S = 60.0
"""After this long the time stamps start over."""


RECEIVE_BUFFER_BYTES = 1 << 15
"""Small, so that a simulator that is faster than our reading detects it soon, and answers do not wait behind old
frames."""


class SlcanTcpBus(can.BusABC):
    """A python-can bus; frames carry seconds since connecting, by the adapter's clock."""

    def __init__(
        self,
        host: str,
        port: int,
        bitrate: int = 1_000_000,
        listen_only: bool = False,
        timeout_s: float = 3.0,
        **kwargs: Any,
    ) -> None:
        """`bitrate` in bit/s; raises OSError when no program listens at host:port."""
        self._socket = socket.create_connection((host, port), timeout=timeout_s)
        self._socket.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, RECEIVE_BUFFER_BYTES)
        self._socket.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        self._reader = LineReader()
        self._messages: deque[can.Message] = deque()
        self._send_lock = threading.Lock()
        self._first_stamp_s: float | None = None
        self._started_s = time.monotonic()
        self.channel_info = f"SLCAN at {host}:{port}"
        self._write(f"C\r{_BIT_RATES[bitrate]}\rZ1\r{'L' if listen_only else 'O'}\r")
        super().__init__(channel=f"{host}:{port}", **kwargs)

    def _write(self, text: str) -> None:
        with self._send_lock:
            try:
                self._socket.sendall(text.encode("ascii"))
            except OSError as error:
                raise can.CanOperationError(f"{self.channel_info}: connection lost") from error

    def send(self, msg: can.Message, timeout: float | None = None) -> None:
        """Sends one frame; `timeout` is not used, TCP takes what fits."""
        kind = ("R" if msg.is_remote_frame else "T") if msg.is_extended_id else ("r" if msg.is_remote_frame else "t")
        identifier = f"{msg.arbitration_id:08X}" if msg.is_extended_id else f"{msg.arbitration_id:03X}"
        data = "" if msg.is_remote_frame else bytes(msg.data).hex().upper()
        self._write(f"{kind}{identifier}{msg.dlc}{data}\r")

    def _recv_internal(self, timeout: float | None) -> tuple[can.Message | None, bool]:
        if not self._messages:
            ready, _, _ = select.select([self._socket], [], [], timeout)
            if ready:
                self._read()
        return (self._messages.popleft() if self._messages else None), False

    def _read(self) -> None:
        try:
            received = self._socket.recv(1 << 16)
        except OSError as error:
            raise can.CanOperationError(f"{self.channel_info}: connection lost") from error
        if not received:
            raise can.CanOperationError(f"{self.channel_info}: the other end closed the connection")
        self._messages.extend(message_of(line, self._time(line.stamp_ms)) for line in self._reader.take(received))

    @property
    def malformed(self) -> int:
        """Lines of the adapter that were skipped."""
        return self._reader.malformed

    def _time(self, stamp_ms: int | None) -> float:
        """Seconds since connecting; the host's clock gives the number of wraps of the stamp."""
        host_s = time.monotonic() - self._started_s
        if stamp_ms is None:
            return host_s
        stamp_s = stamp_ms / 1000.0
        if self._first_stamp_s is None:
            self._first_stamp_s = stamp_s - host_s
        since_s = stamp_s - self._first_stamp_s
        return since_s + STAMP_PERIOD_S * round((host_s - since_s) / STAMP_PERIOD_S)

    def fileno(self) -> int:
        """The socket, for select."""
        return self._socket.fileno()

    def shutdown(self) -> None:
        """Leaves the bus."""
        super().shutdown()
        try:
            self._socket.sendall(b"C\r")
        except OSError:
            pass
        self._socket.close()
