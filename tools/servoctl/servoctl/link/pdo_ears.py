# SPDX-License-Identifier: Apache-2.0
"""Where `monitor` and `log` hear a node: with its present PDO mappings, read by SDO, or passively with those as delivered."""

from __future__ import annotations

import abc
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import can

from ..drive.silent_stop import CODE, silent_stop_age_s
from ..errors import ConnectionFailed, InputError
from ..objects.parameter import AXES
from ..objects.schema import NO_SCHEMA, Schema, need_schema
from .bus import BusAddress, open_bus
from .device import Device
from .listener import Listener
from .pdo_mapping import Mappings, default_mappings, read_mappings

AGAIN_S = 1.0
"""Least time between two readings, and after somebody's last write to a TPDO."""
SILENT_S = 10.0
"""The same after a reading without an answer, which takes two seconds."""


def assumed(schema: Schema, node_id: int) -> Mappings:
    """As delivered; raises InputError when there are none."""
    found = default_mappings(schema, node_id)
    if not found:
        raise InputError(f"{schema.origin} describes no TPDO.")
    return found


def mappings_text(mappings: Mappings) -> str:
    """181: 6041, 6061; 281: 606C."""
    return "; ".join(f"{identifier & 0x1FFFFFFF:X}: {mapping.text}" for identifier, mapping in mappings.items()) or "none"


class Ear(abc.ABC):
    """One node; `note` is why the mappings are assumed ones, empty if they were read."""

    def __init__(self, listener: Listener, note: str = "") -> None:
        self.listener = listener
        self.note = note

    @property
    def mapping(self) -> str:
        """For --json."""
        return "assumed" if self.note else "read"

    @property
    def warning(self) -> str:
        """The note with the mappings that are assumed; empty if they were read."""
        return f"{self.note} That as delivered is assumed: {mappings_text(self.listener.mappings)}." if self.note else ""

    @abc.abstractmethod
    def recv(self, timeout_s: float) -> can.Message | None:
        """The next frame of the bus; raises can.CanError when it is lost."""


class _PassiveEar(Ear):
    def __init__(self, bus: can.BusABC, listener: Listener, note: str) -> None:
        super().__init__(listener, note)
        self._bus = bus

    def recv(self, timeout_s: float) -> can.Message | None:
        return self._bus.recv(timeout_s)


class _ReadingEar(Ear):
    """Reads the mappings at its start, and again when they may have changed."""

    def __init__(self, device: Device, description: Path | None) -> None:
        super().__init__(Listener(device.node_id, {}, can_read=True))
        self._device = device
        self._description = description
        self._reader = can.BufferedReader()
        self._read_s = 0.0
        if device.network.notifier is not None:
            device.network.notifier.add_listener(self._reader)
        self._read()
        if not self.note:
            self._read_silent_stops()

    def recv(self, timeout_s: float) -> can.Message | None:
        if self._may_read():
            self._read()
        message = self._reader.get_message(timeout_s)
        if message is None:
            self._device.network.check()
        return message

    def _may_read(self) -> bool:
        """A node that boots is configured first: its PDOs, or its heartbeat, say that this is over."""
        heard, now = self.listener, time.monotonic()
        due = heard.doubtful or (heard.to_read and (heard.withheld > 0 or heard.state == "operational"))
        if self.note:  # it did not answer
            due = heard.state == "operational" and (heard.heartbeat_s or 0.0) > self._read_s
        return due and now - max(self._read_s, heard.configured_s) >= (SILENT_S if self.note else AGAIN_S)

    def _read(self) -> None:
        try:
            self.listener.use(read_mappings(self._device, self._schema()))
            self.note = ""
        except ConnectionFailed as error:
            self.listener.use(assumed(need_schema(self._description), self.listener.node_id))
            self.note = f"the PDO mapping could not be read: {error}"
        self._read_s = time.monotonic()

    def _read_silent_stops(self) -> None:
        """Their EMCY came before this ear."""
        for axis in filter(self._device.has_axis, range(len(AXES))):
            age_s = silent_stop_age_s(self._device, axis)
            if age_s is not None:
                register = self._device.read_int(0x1001)
                self.listener.emergencies.append((time.time() - age_s, CODE, register))

    def _schema(self) -> Schema:
        """That of the device, otherwise the best known one: objects of CiA 402 are the same in each."""
        found = self._device.any_schema
        return need_schema(self._description) if found is NO_SCHEMA else found


@contextmanager
def hear(address: BusAddress, node_id: int, bitrate: int, description: Path | None, passive: bool) -> Iterator[Ear]:
    """An ear within a `with` block; a `passive` one sends nothing, and opens the adapter as listen-only if it can."""
    if passive:
        schema = need_schema(description)
        listener = Listener(node_id, assumed(schema, node_id))
        with open_bus(address, bitrate, listen_only=True) as bus:
            yield _PassiveEar(bus, listener, "the PDO mapping was not read because of --passive.")
        return
    with Device(address, node_id, description, bitrate) as device:
        yield _ReadingEar(device, description)
