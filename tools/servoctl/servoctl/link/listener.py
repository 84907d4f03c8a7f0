# SPDX-License-Identifier: Apache-2.0
"""A node's own messages: heartbeats, PDOs and emergencies, as they come. Nothing is sent here.

PDOs are decoded with the mappings of `pdo_mapping`. A frame whose length does not fit its mapping is counted, not decoded.
`to_read` says that the mappings may have changed: then no PDO is decoded until `use` brings those that are in force.
"""

from __future__ import annotations

import time
from collections import deque
from dataclasses import dataclass, field

import can

from ..objects.parameter import Parameter, Value
from .can_bits import frame_bits
from .pdo_mapping import EXTENDED, TPDO_COMMUNICATION, TPDO_MAPPING, Mappings

_STATES = {0: "boot-up", 4: "stopped", 5: "operational", 127: "pre-operational"}
_PDOS = 0x200
"""Objects 1800 to 19FF, and 1A00 to 1BFF."""
_DOWNLOADS = (1, 6)
"""SDO requests that begin to write, upper three bits of the first byte."""


@dataclass
class Observed:
    """A value and its arrival time, s of the monotonic clock."""

    value: Value
    time_s: float


@dataclass
class Misfit:
    """Frames of a PDO with `length` bytes, where its mapping has `expected`."""

    length: int
    expected: int
    frames: int = 0


@dataclass
class Listener:
    """Collects the messages of one node."""

    node_id: int
    mappings: Mappings
    can_read: bool = False
    """Somebody reads the mappings when `to_read` says so."""
    values: dict[Parameter, Observed] = field(default_factory=dict)
    misfits: dict[int, Misfit] = field(default_factory=dict)
    """By identifier."""
    state: str = "unknown"
    heartbeat_s: float | None = None
    emergencies: deque[tuple[float, int, int]] = field(default_factory=lambda: deque(maxlen=8))
    frames: int = 0
    bits: int = 0
    to_read: bool = False
    doubtful: bool = False
    """A frame did not fit: the mappings may have changed, but most of them fit."""
    withheld: int = 0
    """PDOs that came since `to_read`."""
    configured_s: float = 0.0
    """When somebody last wrote to a TPDO's objects, s of the monotonic clock."""

    def take(self, message: can.Message) -> dict[Parameter, Value]:
        """One frame of the bus; returns the values in it."""
        if message.is_error_frame:
            return {}
        self.frames += 1
        self.bits += frame_bits(message)
        if message.is_remote_frame:
            return {}
        identifier, data = message.arbitration_id | (EXTENDED if message.is_extended_id else 0), bytes(message.data)
        if identifier == 0x700 + self.node_id and data:
            self._take_heartbeat(_STATES.get(data[0] & 0x7F, "unknown"))
        elif identifier == 0x80 + self.node_id and len(data) >= 3:
            self.emergencies.append((time.time(), int.from_bytes(data[:2], "little"), data[2]))
        elif identifier == 0x600 + self.node_id and len(data) >= 4:
            self._take_request(data)
        elif identifier in self.mappings:
            return self._take_pdo(identifier, data)
        return {}

    def use(self, mappings: Mappings) -> None:
        """From now on; values of objects that are in none of them are forgotten."""
        self.mappings = mappings
        self.to_read = self.doubtful = False
        self.withheld = 0
        self.misfits.clear()
        known = {parameter for mapping in mappings.values() for parameter in mapping.parameters}
        self.values = {parameter: observed for parameter, observed in self.values.items() if parameter in known}

    def _take_heartbeat(self, state: str) -> None:
        self.state = state
        self.heartbeat_s = time.monotonic()
        self.to_read |= self.can_read and state != "operational"

    def _take_request(self, data: bytes) -> None:
        """Somebody else's."""
        index = int.from_bytes(data[1:3], "little")
        if data[0] >> 5 in _DOWNLOADS and TPDO_COMMUNICATION <= index < TPDO_MAPPING + _PDOS:
            self.configured_s = time.monotonic()
            self.to_read |= self.can_read

    def _take_pdo(self, identifier: int, data: bytes) -> dict[Parameter, Value]:
        mapping = self.mappings[identifier]
        if self.to_read:
            self.withheld += 1
            return {}
        if len(data) != mapping.size:
            self._take_misfit(identifier, len(data))
            return {}
        found, now = mapping.decode(data), time.monotonic()
        self.values.update({parameter: Observed(value, now) for parameter, value in found.items()})
        return found

    def _take_misfit(self, identifier: int, length: int) -> None:
        mapping = self.mappings[identifier]
        misfit = self.misfits.setdefault(identifier, Misfit(length, mapping.size))
        misfit.length = length
        misfit.frames += 1
        self.doubtful = self.can_read
        for parameter in mapping.parameters:
            self.values.pop(parameter, None)
