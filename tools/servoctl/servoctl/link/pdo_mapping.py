# SPDX-License-Identifier: Apache-2.0
"""What is in each TPDO of a node: read from it (1800 and 1A00 and those after), or as parameters.json has it as delivered."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from ..objects.parameter import Parameter, Value
from ..objects.schema import Schema
from .device import Device

TPDO_COMMUNICATION, TPDO_MAPPING = 0x1800, 0x1A00
_MOST = 512
_OFF = 0x80000000
EXTENDED = 0x20000000
_MOST_ENTRIES = 64


@dataclass(frozen=True)
class Entry:
    """A mapped object; without `parameter` it has no known name or another size."""

    parameter: Parameter | None
    index: int
    sub: int
    bits: int


@dataclass(frozen=True)
class Mapping:
    """Objects of one TPDO, in order."""

    entries: tuple[Entry, ...]

    @property
    def size(self) -> int:
        """Bytes of its frames."""
        return (sum(entry.bits for entry in self.entries) + 7) // 8

    @property
    def parameters(self) -> list[Parameter]:
        """Those with a name."""
        return [entry.parameter for entry in self.entries if entry.parameter is not None]

    @property
    def text(self) -> str:
        """6041, 6061."""
        return ", ".join(f"{entry.index:04X}" + (f":{entry.sub}" if entry.sub else "") for entry in self.entries)

    def decode(self, data: bytes) -> dict[Parameter, Value]:
        """Values of a frame of this size."""
        found: dict[Parameter, Value] = {}
        content, offset = int.from_bytes(data, "little"), 0
        for entry in self.entries:
            if entry.parameter is not None:
                value = content >> offset & ((1 << entry.bits) - 1)
                found[entry.parameter] = entry.parameter.decode(value.to_bytes((entry.bits + 7) // 8, "little"))
            offset += entry.bits
        return found


Mappings = dict[int, Mapping]
"""By identifier; bit 29 is set in those of 29 bits."""


def _mapping(schema: Schema, mapped: Iterable[int]) -> Mapping:
    """From the values of 1A00 and others, 0xIIIISSLL."""

    def entry(value: int) -> Entry:
        index, sub, bits = value >> 16, value >> 8 & 0xFF, value & 0xFF
        parameter = schema.by_index(index, sub)
        return Entry(parameter if parameter is not None and parameter.bits == bits else None, index, sub, bits)

    return Mapping(tuple(entry(value) for value in mapped))


def default_mappings(schema: Schema, node_id: int) -> Mappings:
    """Of each TPDO that is on as delivered."""

    def default(index: int, sub: int) -> int | None:
        found = schema.by_index(index, sub)
        return found.default if found is not None and isinstance(found.default, int) else None

    found: Mappings = {}
    for n in range(_MOST):
        cob_id, count = default(TPDO_COMMUNICATION + n, 1), default(TPDO_MAPPING + n, 0)
        if cob_id is None or count is None:
            break
        if not cob_id & _OFF and count:
            mapped = (default(TPDO_MAPPING + n, sub) or 0 for sub in range(1, count + 1))
            found[(cob_id & 0x7FF) + node_id] = _mapping(schema, mapped)
    return found


def read_mappings(device: Device, schema: Schema) -> Mappings:
    """Of each TPDO that is on now; raises ConnectionFailed."""
    found: Mappings = {}
    for n in range(_MOST):
        data = device.try_upload(TPDO_COMMUNICATION + n, 1)
        if data is None:
            break
        cob_id = int.from_bytes(data, "little")
        count = 0 if cob_id & _OFF else _read(device, TPDO_MAPPING + n, 0)
        if 0 < count <= _MOST_ENTRIES:
            mapped = [_read(device, TPDO_MAPPING + n, sub) for sub in range(1, count + 1)]
            found[cob_id & (EXTENDED | 0x1FFFFFFF if cob_id & EXTENDED else 0x7FF)] = _mapping(schema, mapped)
    return found


def _read(device: Device, index: int, sub: int) -> int:
    return int.from_bytes(device.try_upload(index, sub) or b"", "little")
