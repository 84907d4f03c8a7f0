# SPDX-License-Identifier: Apache-2.0
"""A borrowed PDO: mapped as needed, with an identifier of its own, and restored afterwards.

Meanwhile a listener that knows the default mapping receives nothing instead of wrong values, and no frames of other
masters come in.
"""

from __future__ import annotations

from .device import Device

_OFF = 0x80000000
_NO_REQUEST = 0x40000000
_FREE_IDENTIFIERS = range(0x680, 0x6E0)
"""Free in CANopen's predefined set."""
_BORROWED_IDENTIFIERS = range(0x6B0, 0x6E0)
"""Those below are the defaults of TPDO5 to TPDO8 (docs/decisions/canopen.md)."""
_PER_NODE = 4
_NODES = len(_BORROWED_IDENTIFIERS) // _PER_NODE
_FIRST_FURTHER_TPDO = 0x1804
_TPDOS = 8
_RPDOS = 4


def borrowed_identifiers(node_id: int, count: int = _PER_NODE) -> tuple[int, ...]:
    """Up to four identifiers for the borrowed PDOs of one node; the first has the highest priority."""
    first = _BORROWED_IDENTIFIERS.start + (node_id - 1) % _NODES
    return tuple(first + _NODES * n for n in range(count))


def restore_left_over(device: Device) -> None:
    """Gives all PDOs that have one of the node's borrowed identifiers their defaults: a program that was killed has left them, and
    the node accepts each identifier once. Call it when no other program of ours streams."""
    for communication, mapping in (*((0x1800 + n, 0x1A00 + n) for n in range(_TPDOS)), *((0x1400 + n, 0x1600 + n) for n in range(_RPDOS))):
        data = device.try_upload(communication, 1)
        if data is not None and int.from_bytes(data, "little") & ~_OFF in borrowed_identifiers(device.node_id):
            PdoLoan(device, communication, mapping).reset()


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
        if self._is_left_over(cob_id & 0x7FF):
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

    def _is_left_over(self, identifier: int) -> bool:
        """Borrowed by a program that was killed; before TPDO5 to TPDO8 existed, with any of the free identifiers."""
        return identifier in (_BORROWED_IDENTIFIERS if self._communication >= _FIRST_FURTHER_TPDO else _FREE_IDENTIFIERS)

    def _defaults(self) -> tuple[int, int, int, int, list[int]]:
        """The PDO's defaults: a killed program has left our mapping, and the former one is unknown."""
        if not self._device.schema_fits:
            return self._unknown(), 255, 0, 0, []
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

    def _unknown(self) -> int:
        """Identifier of a PDO whose defaults are not at hand: that of the predefined set or of a further TPDO, and off."""
        n = self._communication & 0x1FF
        if not self._has_inhibit:
            return _OFF | 0x200 + 0x100 * n + self._device.node_id
        base = 0x180 + 0x100 * n if n < _FIRST_FURTHER_TPDO & 0x1FF else 0x67F + _NODES * (n - (_FIRST_FURTHER_TPDO & 0x1FF))
        return _OFF | _NO_REQUEST | base + self._device.node_id

    def _slow_down(self, inhibit_100us: int) -> int:
        """A default inhibit time, which is that of 1 Mbit/s, at the bus' bit rate."""
        kbit_s = int.from_bytes(self._device.try_upload(0x3050, 2) or b"", "little")
        return inhibit_100us * 1000 // kbit_s if kbit_s else inhibit_100us

    def reset(self) -> None:
        """To the defaults."""
        self._configure(*self._defaults())

    def move_to(self, device: Device) -> None:
        """The same node, connected anew: what was borrowed is given back there."""
        self._device = device

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
