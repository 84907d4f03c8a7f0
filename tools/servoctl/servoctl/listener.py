"""A node's own messages: heartbeats, PDOs in the default mapping, emergencies. Nothing is sent.

The mapping is that of parameters.json; a program that maps a PDO differently must give it another identifier, as `step`
and `bode` do.
"""

from __future__ import annotations

import time
from collections import deque
from dataclasses import dataclass, field

import can

from .can_bits import frame_bits
from .errors import InputError
from .parameter import Parameter, Value
from .schema import Schema

_OFF = 0x80000000


@dataclass
class Observed:
    """A value and its arrival time, s of the monotonic clock."""

    value: Value
    time_s: float


@dataclass
class Listener:
    """Collects the messages of one node."""

    node_id: int
    schema: Schema
    values: dict[Parameter, Observed] = field(default_factory=dict)
    state: str = "unknown"
    heartbeat_s: float | None = None
    emergencies: deque[tuple[float, int, int]] = field(default_factory=lambda: deque(maxlen=8))
    frames: int = 0
    bits: int = 0

    def __post_init__(self) -> None:
        self.mappings = default_mappings(self.schema, self.node_id)
        if not self.mappings:
            raise InputError(f"{self.schema.origin} describes no TPDO.")

    def take(self, message: can.Message) -> dict[Parameter, Value]:
        """One frame of the bus; returns the values in it."""
        if message.is_error_frame:
            return {}
        self.frames += 1
        self.bits += frame_bits(message)
        if message.is_remote_frame or message.is_extended_id:
            return {}
        now = time.monotonic()
        data = bytes(message.data)
        if message.arbitration_id == 0x700 + self.node_id and data:
            names = {0: "boot-up", 4: "stopped", 5: "operational", 127: "pre-operational"}
            self.state = names.get(data[0] & 0x7F, "unknown")
            self.heartbeat_s = now
        elif message.arbitration_id == 0x80 + self.node_id and len(data) >= 3:
            self.emergencies.append((time.time(), int.from_bytes(data[:2], "little"), data[2]))
        elif message.arbitration_id in self.mappings:
            return self._unpack(self.mappings[message.arbitration_id], data, now)
        return {}

    def _unpack(self, mapping: list[Parameter], data: bytes, now: float) -> dict[Parameter, Value]:
        found: dict[Parameter, Value] = {}
        offset = 0
        for parameter in mapping:
            size = parameter.bits // 8
            if offset + size > len(data):
                break
            found[parameter] = parameter.decode(data[offset : offset + size])
            self.values[parameter] = Observed(found[parameter], now)
            offset += size
        return found


def default_mappings(schema: Schema, node_id: int) -> dict[int, list[Parameter]]:
    """Objects in each TPDO that is on by default, by identifier."""
    found: dict[int, list[Parameter]] = {}
    for n in range(512):
        cob = schema.by_index(0x1800 + n, 1)
        count = schema.by_index(0x1A00 + n, 0)
        if cob is None or count is None or not isinstance(cob.default, int) or not isinstance(count.default, int):
            break
        if cob.default & _OFF or count.default == 0:
            continue
        mapping: list[Parameter] = []
        for sub in range(1, count.default + 1):
            entry = schema.by_index(0x1A00 + n, sub)
            mapped = entry.default if entry is not None and isinstance(entry.default, int) else 0
            parameter = schema.by_index(mapped >> 16, mapped >> 8 & 0xFF)
            if parameter is None:
                break
            mapping.append(parameter)
        found[(cob.default & 0x7FF) + node_id] = mapping
    return found
