"""A borrowed PDO: mapped as needed, with an identifier of its own, and restored afterwards.

Meanwhile a listener that knows the default mapping receives nothing instead of wrong values, and no frames of other
masters come in.
"""

from __future__ import annotations

from .device import Device

_OFF = 0x80000000
_FIRST_IDENTIFIER, _LAST_IDENTIFIER = 0x680, 0x6DF
"""Identifiers 680 to 6DF are free in CANopen's predefined set."""
_PER_NODE = 3


def borrowed_identifiers(node_id: int) -> tuple[int, int, int]:
    """Three identifiers for the borrowed PDOs of one node; the first has the highest priority."""
    first = _FIRST_IDENTIFIER + _PER_NODE * (node_id % ((_LAST_IDENTIFIER + 1 - _FIRST_IDENTIFIER) // _PER_NODE))
    return first, first + 1, first + 2


class PdoLoan:
    """One PDO with a mapping of ours until `give_back`."""

    def __init__(self, device: Device, communication: int, mapping: int) -> None:
        """`communication` 0x1400 + n or 0x1800 + n, `mapping` 0x1600 + n or 0x1A00 + n."""
        self._device = device
        self._communication = communication
        self._mapping = mapping
        self._has_inhibit = communication >= 0x1800
        self._before: tuple[int, int, int, int, list[int]] | None = None

    def take(self, identifier: int, objects: list[int], event_ms: int) -> None:
        """Maps `objects` (0xIIIISSLL), sent or taken at once, a TPDO also every `event_ms`."""
        device = self._device
        cob_id = device.read_int(self._communication, 1)
        if _FIRST_IDENTIFIER <= cob_id & 0x7FF <= _LAST_IDENTIFIER:
            self._before = self._defaults()
            self._configure(identifier, 255, 0, event_ms, objects)
            return
        count = device.read_int(self._mapping, 0)
        self._before = (
            cob_id,
            device.read_int(self._communication, 2),
            device.read_int(self._communication, 3) if self._has_inhibit else 0,
            device.read_int(self._communication, 5),
            [device.read_int(self._mapping, sub) for sub in range(1, count + 1)],
        )
        self._configure(identifier, 255, 0, event_ms, objects)

    def _defaults(self) -> tuple[int, int, int, int, list[int]]:
        """The PDO's defaults: a killed program has left our mapping, and the former one is unknown."""
        schema = self._device.schema

        def default(index: int, sub: int) -> int:
            found = schema.by_index(index, sub)
            return found.default if found is not None and isinstance(found.default, int) else 0

        count = default(self._mapping, 0)
        return (
            default(self._communication, 1) + self._device.node_id,
            default(self._communication, 2),
            self._slow_down(default(self._communication, 3)) if self._has_inhibit else 0,
            default(self._communication, 5),
            [default(self._mapping, sub) for sub in range(1, count + 1)],
        )

    def _slow_down(self, inhibit_100us: int) -> int:
        """A default inhibit time, which is that of 1 Mbit/s, at the bus' bit rate."""
        kbit_s = int.from_bytes(self._device.try_upload(0x3050, 2) or b"", "little")
        return inhibit_100us * 1000 // kbit_s if kbit_s else inhibit_100us

    def give_back(self) -> None:
        """Restores everything as before `take`."""
        if self._before is not None:
            self._configure(*self._before)
            self._before = None

    def _configure(self, cob_id: int, kind: int, inhibit_100us: int, event_ms: int, objects: list[int]) -> None:
        device = self._device
        device.write_int(self._communication, 1, device.read_int(self._communication, 1) | _OFF, 4)
        device.write_int(self._mapping, 0, 0, 1)
        for sub, mapped in enumerate(objects, 1):
            device.write_int(self._mapping, sub, mapped, 4)
        device.write_int(self._mapping, 0, len(objects), 1)
        device.write_int(self._communication, 2, kind, 1)
        if self._has_inhibit:
            device.write_int(self._communication, 3, inhibit_100us, 2)
        device.write_int(self._communication, 5, event_ms, 2)
        device.write_int(self._communication, 1, cob_id, 4)
