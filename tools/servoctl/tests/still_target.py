# SPDX-License-Identifier: Apache-2.0
"""A camera for devices that have none: a client that sends frames of a still target, from the measured joint angles.

It hears the angles in TPDO4 (6064 of both axes, every 20 ms as delivered), or in another frame that holds them, and sends what a pinhole camera on these joints would see,
with the age of the angles, as docs/can.md describes.
"""

from __future__ import annotations

import math
import struct
import threading
import time
from collections import deque
from types import TracebackType

from servoctl.link.bus import open_bus, parse_bus

POSITIONS_ID = 0x481
FRAME_S = 0.02
SURE = 100


class StillTarget:
    """Sends frames within a `with` block; the target is at fixed joint angles, in degrees."""

    def __init__(
        self, bus: str, identifier: int, azimuth_deg: float, pitch_deg: float, positions_id: int = POSITIONS_ID
    ) -> None:
        self._bus = open_bus(parse_bus(bus))
        self._identifier = identifier
        self._positions_id = positions_id
        self._azimuth, self._pitch = math.radians(azimuth_deg), math.radians(pitch_deg)
        self.roll_deg = 0.0
        """Of the picture, with that it measures: counter-clockwise of what a right one would."""
        self.mirrored = False
        """Its x, before it is turned."""
        self.count_rad = 1e-6
        self.older_angles = 0
        """It is older than it states by so many frames of the angles: node time, however slow the device is."""
        self._past: deque[tuple[float, float]] = deque(maxlen=64)
        self.visible = True
        self.impossible = False
        """Every frame has a quality above 100 %."""
        self._end = threading.Event()
        self._thread = threading.Thread(target=self._run, daemon=True)

    def __enter__(self) -> StillTarget:
        self._thread.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._end.set()
        self._thread.join()
        self._bus.shutdown()

    def _run(self) -> None:
        import can

        counter, sent_s = 0, 0.0
        while not self._end.is_set():
            message = self._bus.recv(0.1)
            if message is None or message.arbitration_id != self._positions_id or len(message.data) != 8:
                continue
            heard_s = time.monotonic()
            azimuth, pitch = self._before(*(counts * 1e-7 for counts in struct.unpack("<ii", message.data)))
            if heard_s - sent_s < 0.9 * FRAME_S:
                continue
            x, y, inside = self._place(azimuth, pitch)
            counter = (counter + 1) % 256
            quality = 200 if self.impossible else SURE if inside and self.visible else 0
            frame = struct.pack("<hhHBB", x, y, 100, quality, counter)  # 1 ms old
            self._bus.send(can.Message(arbitration_id=self._identifier, data=frame, is_extended_id=False))
            sent_s = heard_s

    def _before(self, azimuth: float, pitch: float) -> tuple[float, float]:
        """The joint angles `older_angles` frames ago."""
        self._past.append((azimuth, pitch))
        return self._past[max(0, len(self._past) - 1 - self.older_angles)]

    def _place(self, azimuth: float, pitch: float) -> tuple[int, int, bool]:
        """Counts along rows and columns, and whether the target is in the picture."""
        turn = self._azimuth - azimuth
        ahead = math.cos(self._pitch) * math.cos(turn) * math.cos(pitch) + math.sin(self._pitch) * math.sin(pitch)
        left = math.cos(self._pitch) * math.sin(turn)
        up = math.sin(self._pitch) * math.cos(pitch) - math.cos(self._pitch) * math.cos(turn) * math.sin(pitch)
        if ahead <= 0.0 or max(abs(left), abs(up)) > 0.011 * ahead:
            return 0, 0, False
        x, y = (-left if self.mirrored else left) / ahead, up / ahead
        turn = math.radians(self.roll_deg)
        return (
            round((math.cos(turn) * x - math.sin(turn) * y) / self.count_rad),
            round((math.sin(turn) * x + math.cos(turn) * y) / self.count_rad),
            True,
        )
