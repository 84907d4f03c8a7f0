# SPDX-License-Identifier: Apache-2.0
"""A node on the bus: reads and writes its objects, and explains refusals to the user."""

from __future__ import annotations

import contextlib
import logging
import struct
import threading
import time
from pathlib import Path
from types import TracebackType
from typing import Any

import can
import canopen
from canopen.sdo.exceptions import SdoAbortedError, SdoCommunicationError

from .. import __version__
from ..errors import ConnectionFailed, InputError, NotVerified, Refused, SchemaMismatch
from ..objects.parameter import AXIS_SHIFT, Parameter, Value
from ..objects.schema import (
    ENVIRONMENT,
    NO_SCHEMA,
    Schema,
    carried_hash,
    find_schema,
    fingerprint,
    load_named,
    named_file,
    remember,
    search_places,
)
from .bus import BusAddress, bit_rate_of, open_bus, skipped_lines
from .interrupts import postponed
from .matched_sdo import MatchedNode
from .node_clock import TICKS, NodeClock
from .turns import Turns

SDO_TIMEOUT_S = 1.0
LATE_ANSWER_S = 0.2
"""After a failed write, a late answer comes within this time: the next write to the object must not take it."""
STORE_TIMEOUT_S = 5.0
HEARTBEAT_TIMEOUT_S = 1.0
HEARTBEATS_OF_NMT = 20
"""The node executes an NMT command within this many of its heartbeats (1017), or not at all."""

ABORTS: dict[int, str] = {
    0x05030000: "wrong toggle bit",
    0x05040000: "the device timed out during the transfer",
    0x05040001: "the device does not support this kind of transfer",
    0x05040004: "wrong CRC",
    0x06010000: "the device does not support this access",
    0x06010001: "the object is write-only",
    0x06010002: "the object is read-only",
    0x06020000: "the device has no such object",
    0x06040041: "the object cannot be mapped into a PDO",
    0x06040042: "the mapped objects do not fit into a PDO",
    0x06040043: "the values contradict each other",
    0x06060000: "hardware error, or the device cannot store this",
    0x06070010: "wrong length",
    0x06070012: "the value is too long",
    0x06070013: "the value is too short",
    0x06090011: "the device has no such sub-index",
    0x06090030: "the value is not allowed",
    0x06090031: "the value is above the upper limit",
    0x06090032: "the value is below the lower limit",
    0x08000000: "the device gives no reason",
    0x08000020: "the value could not be transferred or stored",
    0x08000021: "the device is under local control",
    0x08000022: "not possible in the present state of the device",
    0x08000024: "no data available",
}
"""SDO abort codes of CiA 301, table 22, as reasons."""

DEVICE_STATE = 0x08000022


def hexadecimal(index: int, sub: int) -> str:
    """0x2000:01."""
    return f"0x{index:04X}:{sub:02X}"


class _LossListener(can.Listener):
    """Keeps the receiving thread from printing a traceback when the bus disappears: the next transfer reports it."""

    def on_message_received(self, msg: can.Message) -> None:
        """Nothing to do."""

    def on_error(self, exc: Exception) -> None:
        """The thread that waits for an answer reports it."""


class Device:
    """One node, open for use in a `with` block; times in s."""

    def __init__(
        self, address: BusAddress, node_id: int, schema_file: Path | None = None, bitrate: int = 1_000_000
    ) -> None:
        """Opens the bus; raises ConnectionFailed or, for a bad parameters.json, InputError."""
        self.address = address
        self.node_id = node_id
        self.access_word: str | None = None
        """Of its lock (0x3040), if the user has given one."""
        self.stopped = threading.Event()
        """Set by a stop from another thread: until it is cleared, no axis is enabled here."""
        self.given_up = ""
        """Why no transfer is tried any more."""
        self._schema_file = schema_file
        self._schema: Schema | None = None
        self.reported_hash: int | None = None
        self._firmware = ""  # version of a device whose objects are unknown
        self.bit_rate = bit_rate_of(address, bitrate)
        """In bit/s; None if it is unknown."""
        self.network = canopen.Network(bus=open_bus(address, bitrate))
        logging.getLogger("canopen").setLevel(logging.CRITICAL)
        self.network.listeners.append(_LossListener())  # type: ignore[arg-type]  # any can.Listener will do
        self.network.connect()
        self.node = MatchedNode(node_id, canopen.ObjectDictionary())
        self.network.add_node(self.node)
        self.node.sdo.RESPONSE_TIMEOUT = SDO_TIMEOUT_S
        self.opened_s = time.monotonic()
        self.turns = Turns(address.place, node_id)
        self.clock = NodeClock(self._ticks)

    def __enter__(self) -> Device:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def close(self) -> None:
        """Leaves the bus."""
        try:
            self.network.disconnect()
        except (can.CanError, OSError):
            pass  # the bus disappeared first
        self.turns.close()

    def give_up(self, why: str) -> None:
        """Every later transfer fails at once, with this sentence: of a node that is silent, or whose bus is lost, each of
        the steps that end a motion would wait for an answer. An empty sentence ends this."""
        self.given_up = why

    def _need_answers(self) -> None:
        if self.given_up:
            raise ConnectionFailed(self.given_up)

    # --- objects by index -----------------------------------------------------------------------------------------

    def upload(self, index: int, sub: int = 0, name: str = "") -> bytes:
        """Reads an object's bytes; repeats once when the first answer is late or lost."""
        self._need_answers()
        try:
            with self.turns.transfer(), postponed():
                try:
                    return bytes(self.node.sdo.upload(index, sub))
                except SdoCommunicationError:
                    return bytes(self.node.sdo.upload(index, sub))
        except (SdoAbortedError, SdoCommunicationError, can.CanError, OSError) as error:
            raise self._explain("read", index, sub, name, error) from error

    def upload_block(self, index: int, sub: int = 0, name: str = "") -> bytes:
        """Reads a long object by block transfer."""
        self._need_answers()
        try:
            with (
                self.turns.long_transfer(),
                postponed(),
                self.node.sdo.open(index, sub, "rb", block_transfer=True) as stream,
            ):
                return bytes(stream.read())
        except (SdoAbortedError, SdoCommunicationError, can.CanError, OSError) as error:
            raise self._explain("read", index, sub, name, error) from error

    def download(self, index: int, sub: int, data: bytes, name: str = "", timeout_s: float = SDO_TIMEOUT_S) -> None:
        """Writes an object's bytes."""
        self._need_answers()
        sdo = self.node.sdo
        sdo.RESPONSE_TIMEOUT = timeout_s
        try:
            with self.turns.transfer(), postponed():
                try:
                    sdo.download(index, sub, data)
                except SdoCommunicationError:
                    time.sleep(LATE_ANSWER_S)
                    raise
        except (SdoAbortedError, SdoCommunicationError, can.CanError, OSError) as error:
            raise self._explain("write", index, sub, name, error) from error
        finally:
            sdo.RESPONSE_TIMEOUT = SDO_TIMEOUT_S

    def read_int(self, index: int, sub: int = 0, signed: bool = False) -> int:
        """An integer of any length."""
        return int.from_bytes(self.upload(index, sub), "little", signed=signed)

    def write_int(self, index: int, sub: int, value: int, size: int) -> None:
        """An integer of `size` bytes; negative ones as two's complement. Raises InputError when it needs more."""
        if not -(1 << (8 * size - 1)) <= value < 1 << (8 * size):
            raise InputError(f"{hexadecimal(index, sub)}: {value} does not fit into {size} bytes.")
        self.download(index, sub, (value & ((1 << (8 * size)) - 1)).to_bytes(size, "little"))

    def try_upload(self, index: int, sub: int = 0) -> bytes | None:
        """The bytes, or None when the device has no such object or no data for it."""
        try:
            return self.upload(index, sub)
        except Refused:
            return None

    def _explain(self, what: str, index: int, sub: int, name: str, error: Exception) -> Exception:
        place = f"{name} ({hexadecimal(index, sub)})" if name else hexadecimal(index, sub)
        if isinstance(error, SdoAbortedError):
            reason = ABORTS.get(error.code, "unknown abort code")
            return Refused(
                f"{place} could not be {'read' if what == 'read' else 'written'}: {reason} (SDO abort"
                f" {error.code:08X}).",
                error.code,
            )
        if isinstance(error, SdoCommunicationError) and "No SDO response" in str(error):
            return ConnectionFailed(
                f"node {self.node_id} does not answer on {self.address}: is it switched on, and is {self.node_id}"
                f" its node id? 'servoctl scan' lists the nodes.{skipped_lines(self.network.bus)}"
            )
        return ConnectionFailed(f"{place} could not be {'read' if what == 'read' else 'written'}: {error}.")

    # --- objects by parameter -------------------------------------------------------------------------------------

    def read(self, parameter: Parameter) -> Value:
        """The value that the device has."""
        if not parameter.readable:
            raise InputError(f"{parameter.name} ({parameter.where}) is write-only.")
        if parameter.type == "DOMAIN":
            return self.upload_block(parameter.index, parameter.sub, parameter.name)
        return parameter.decode(self.upload(parameter.index, parameter.sub, parameter.name))

    def write(self, parameter: Parameter, value: Value) -> None:
        """Writes and reads back; raises NotVerified when the device then has another value."""
        if not parameter.writable:
            raise InputError(f"{parameter.name} ({parameter.where}) is read-only.")
        data = parameter.encode(value)
        self.download(parameter.index, parameter.sub, data, parameter.name)
        if parameter.readable and parameter.type != "DOMAIN":
            found = self.read(parameter)
            if found != parameter.decode(data):
                raise NotVerified(f"{parameter.name}: wrote {value!r}, but the device has {found!r}.")

    # --- schema ---------------------------------------------------------------------------------------------------

    @property
    def schema(self) -> Schema:
        """The objects of this device; raises SchemaMismatch when no parameters.json has its hash."""
        schema = self.any_schema
        if not self.schema_fits:
            raise SchemaMismatch(self.mismatch)
        return schema

    @property
    def any_schema(self) -> Schema:
        """The named parameters.json, whether it fits or not, or one that fits; empty when there is none."""
        if self._schema is None:
            self._schema = self._choose_schema()
        return self._schema

    @property
    def schema_fits(self) -> bool:
        """There is a schema, and the hashes agree, or one of the two is unknown: then the user has named the file."""
        schema = self.any_schema
        if schema is NO_SCHEMA:
            return False
        return self.reported_hash is None or schema.hash is None or schema.hash == self.reported_hash

    @property
    def mismatch(self) -> str:
        """The message about a schema that does not fit: the hashes, the searched places, the remedy."""
        if self.reported_hash is None:
            reported = "the device reports no schema hash (0x3030:2), so the names of its objects are unknown"
        else:
            reported = f"the names of the device's objects are unknown: its schema hash is {self.reported_hash:08X}"
        if self.any_schema is not NO_SCHEMA:
            mine = f"{self.any_schema.hash:08X}" if self.any_schema.hash is not None else "none"
            known = f"the hash of {self.any_schema.origin} is {mine}"
        else:
            known = f"servoctl {__version__} includes {carried_hash()}; searched without success: {search_places()}"
        other = f", version {self._firmware}" if self._firmware not in ("", __version__) else ""
        return (
            f"{reported}; {known}. Give the parameters.json of its firmware's build with --parameters FILE (or {ENVIRONMENT}), or"
            f" use the servoctl of that firmware{other}, or flash the image of servoctl's release, {__version__}. Without it scan,"
            " info, state, move, scope, faults and objects by index work, as in 'get 0x2000:1 --type REAL32'."
        )

    def _choose_schema(self) -> Schema:
        reported = self.try_upload(0x3030, 2)
        self.reported_hash = int.from_bytes(reported, "little") if reported else None
        named = named_file(self._schema_file)
        chosen = load_named(named) if named else find_schema(self.reported_hash)
        if chosen.hash == self.reported_hash:
            remember(chosen)
        else:
            self._firmware = (self.try_upload(0x100A) or b"").decode("ascii", errors="replace").rstrip("\0")
        return chosen

    # --- the node -------------------------------------------------------------------------------------------------

    def identity(self) -> dict[str, Any]:
        """Names, versions and numbers of the device, as it reports them."""

        def text(index: int, sub: int = 0) -> str | None:
            data = self.try_upload(index, sub)
            return None if data is None else data.rstrip(b"\0").decode("ascii", errors="replace")

        def whole(index: int, sub: int = 0) -> int | None:
            data = self.try_upload(index, sub)
            return None if data is None else int.from_bytes(data, "little")

        return {
            "node": self.node_id,
            "bus": str(self.address),
            "device_type": self.read_int(0x1000),
            "name": text(0x1008),
            "hardware": text(0x1009),
            "software": text(0x100A),
            "firmware": text(0x3030, 1),
            "git": text(0x3030, 3),
            "schema": whole(0x3030, 2),
            "vendor": whole(0x1018, 1),
            "product": whole(0x1018, 2),
            "revision": whole(0x1018, 3),
            "serial": whole(0x1018, 4),
            "heartbeat_ms": whole(0x1017),
        }

    def serial_number(self) -> int:
        """0x1018:4; 0 when the device has none."""
        data = self.try_upload(0x1018, 4)
        return int.from_bytes(data, "little") if data else 0

    def nmt_state(self, timeout_s: float = HEARTBEAT_TIMEOUT_S) -> str:
        """The state in the next heartbeat; "unknown" when none comes within `timeout_s` by the node's clock."""
        if self.given_up:
            return "unknown"
        with contextlib.suppress(canopen.nmt.NmtError):
            return str(self.node.nmt.wait_for_heartbeat(timeout_s)).lower()
        try:
            if self.try_upload(0x1017) in (None, b"\0\0"):
                return "unknown"  # it sends none
            begun = self.clock.now()
            while self.clock.now() - begun < timeout_s:
                with contextlib.suppress(canopen.nmt.NmtError):
                    return str(self.node.nmt.wait_for_heartbeat(timeout_s)).lower()
        except ConnectionFailed:
            pass  # silent, or stopped and without heartbeat
        return "unknown"

    def _ticks(self) -> int | None:
        data = self.try_upload(*TICKS)
        return None if data is None else int.from_bytes(data, "little")

    def pace(self, seconds: float = 0.1) -> float:
        """Time of the node's clock per the computer's: about 1, except for an emulated board or a simulator."""
        start, start_s = self.clock.now(), time.monotonic()
        time.sleep(seconds)
        return (self.clock.now() - start) / (time.monotonic() - start_s)

    def set_nmt(self, state: str) -> None:
        """Commands an NMT state and waits for a heartbeat with it."""
        self.node.nmt.send_command({"operational": 0x01, "stopped": 0x02, "pre-operational": 0x80}[state])
        for _ in range(HEARTBEATS_OF_NMT):
            reported = self.nmt_state()
            if reported == state:
                return
            if reported == "unknown":
                raise ConnectionFailed(
                    f"node {self.node_id} was commanded to become {state}, but sends no heartbeat to confirm it:"
                    " is 1017 set to 0?"
                )
        raise ConnectionFailed(
            f"node {self.node_id} did not become {state} within {HEARTBEATS_OF_NMT} of its heartbeats."
        )

    def fingerprint(self) -> int:
        """The schema's hash, or one of our own when the file has none."""
        return self.any_schema.hash if self.any_schema.hash is not None else fingerprint(self.any_schema)

    # --- CiA 402 objects of an axis -------------------------------------------------------------------------------

    def axis_int(self, axis: int, index: int, sub: int = 0, signed: bool = False) -> int:
        """An integer object of an axis; `index` is the first axis'."""
        return self.read_int(index + AXIS_SHIFT * axis, sub, signed)

    def axis_write(self, axis: int, index: int, value: int, size: int, sub: int = 0) -> None:
        """Writes an integer object of an axis; `index` is the first axis'."""
        self.write_int(index + AXIS_SHIFT * axis, sub, value, size)

    def axis_real(self, axis: int, index: int, sub: int) -> float:
        """A REAL32 object of an axis."""
        return float(struct.unpack("<f", self.upload(index + AXIS_SHIFT * axis, sub))[0])

    def has_axis(self, axis: int) -> bool:
        """Whether the node has a CiA 402 axis there."""
        return self.try_upload(0x6041 + AXIS_SHIFT * axis) is not None
