# SPDX-License-Identifier: Apache-2.0
"""Faults in words: faults.json, which the build prints from the firmware's own fault table.

Numbers of faults never change their meaning, so the texts of another build are valid too. Codes that the CANopen stack
sends without a fault of the servo are here.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any

from ..errors import InputError
from ..show.text_file import json_of, read_text
from .parameter import AXES
from .schema import at_hand, faults_file, named_file

SOURCES = ("node", *AXES, "board", "store")
"""Of an EMCY message, byte 4."""

REGISTER_BITS = ("any", "current", "voltage", "temperature", "communication", "profile", "reserved", "manufacturer")

_CLASSES = {
    0x1000: "generic", 0x2000: "current", 0x3000: "voltage", 0x4000: "temperature", 0x5000: "hardware",
    0x6000: "software", 0x7000: "additional modules", 0x8000: "monitoring", 0x9000: "external", 0xF000: "device specific",
}  # fmt: skip
"""Error codes of CiA 301, table 26."""


@dataclass(frozen=True)
class Words:
    """Information for a person about an error."""

    name: str
    cause: str
    check: str
    cure: str
    clear: str


REACTIONS = {
    "tell": "Report only (EMCY and fault log); the axis continues.",
    "stop": "Stop: the speed loop brakes the axis as 605E selects, then the bridge is switched off.",
    "protect": "Protect: protection brakes with the full current, whatever gains, ramps and mode are; off at rest.",
    "brake": "Brake: the bridge shorts the motor, which brakes without sensors and loops; off after 2 s.",
    "cut": "Off: the bridge is switched off at once.",
}
"""The drive's action for each reaction of a fault."""


@dataclass(frozen=True)
class Fault(Words):
    """A row of faults.json; `limits` are sub-indices of 0x2060, `of` is "axis", "board" or "store"."""

    number: int
    code: int
    of: str
    reaction: str
    latency_ms: int
    timer: str
    limits: tuple[int, ...]
    detection: str
    when: str


_BY_ITSELF = "No action needed."

_STACK: dict[int, Words] = {
    0x8110: Words("CAN overrun", "Frames arrived faster than the node could read them.", "Measure the bus load.", "Lower the bus load.", _BY_ITSELF),
    0x8120: Words("CAN error passive", "Wiring, termination or bit rate.", "Measure 60 ohm between the two bus wires with all power off.", "Repair the bus.", _BY_ITSELF),
    0x8140: Words("recovered from bus-off", "Wiring, termination or bit rate.", "Measure 60 ohm between the two bus wires with all power off.", "Repair the bus.", _BY_ITSELF),
    0x8210: Words("PDO too short", "A master uses a different PDO mapping.", "Compare the master's mapping with 1600 to 1603.", "Use the same mapping in the master and the node.", _BY_ITSELF),
    0x8240: Words("SYNC with unexpected length", "The master's SYNC does not match 1019.", "Length of the frames with identifier 080.", "Set 1019 to match the master's SYNC.", _BY_ITSELF),
    0x8700: Words("SYNC time-out", "SYNC frames stopped.", "Frames with identifier 080 on the bus.", "Restart the master, or set 1006 to 0.", _BY_ITSELF),
    0x8701: Words("SYNC and clock differ", "The node's clock or the master's is 1 % off, or the master's SYNC does not have the period 1006.", "Measure the period of the frames with identifier 080.", "Set 1006 to the period of SYNC; replace the device whose clock is wrong.", _BY_ITSELF),
}  # fmt: skip
"""Codes of the CANopen stack that are not faults of the servo, or mean something else when they come from the node."""


@dataclass(frozen=True)
class FaultTable:
    """All faults by number, and name and unit of each column of a fault log entry; empty when no faults.json is there."""

    faults: dict[int, Fault]
    signals: tuple[tuple[str, str], ...]

    def words(self, code: int) -> list[Words]:
        """All meanings of a code."""
        found: list[Words] = [fault for fault in self.faults.values() if fault.code == code]
        return found + ([_STACK[code]] if code in _STACK else [])

    def meaning(self, code: int) -> str:
        """One or a few words for a code."""
        if code == 0:
            return "no error"
        names = [words.name for words in self.words(code)]
        return " or ".join(names) if names else f"{_CLASSES.get(code & 0xF000, 'unknown')} error"

    def reported(self, code: int, info: int) -> list[Words]:
        """Meaning of a message of EMCY or 1003: `info` is its detail and, in the upper byte, its source."""
        source, detail = info >> 8, info & 0xFF
        if 0 < source <= len(AXES) and detail in self.faults and self.faults[detail].code == code:
            return [self.faults[detail]]
        if source == 0 and code in _STACK:
            return [_STACK[code]]
        of = "axis" if 0 < source <= len(AXES) else SOURCES[source] if source < len(SOURCES) else ""
        own = [f for f in self.faults.values() if f.code == code and f.of == of]
        return list(own) or self.words(code)

    def name(self, number: int) -> str:
        """Of a fault's number."""
        return self.faults[number].name if number in self.faults else f"fault {number}"


NO_FAULTS = FaultTable({}, ())


def load_faults(path: Path) -> FaultTable:
    """Raises InputError when the file cannot be read or is no fault table."""
    content = json_of(read_text(path))
    try:
        faults = [_fault(row) for row in content["faults"]]
        signals = tuple((str(row["name"]), str(row["unit"])) for row in content["signals"])
    except (KeyError, TypeError, ValueError) as error:
        raise InputError(f"{path}: not a faults.json of the trackservo build ({error!r}).") from error
    return FaultTable({fault.number: fault for fault in faults}, signals)


def _fault(row: dict[str, Any]) -> Fault:
    values = {field.name: row[field.name] for field in fields(Fault)}
    return Fault(**values | {"limits": tuple(values["limits"])})


def find_faults(parameters: Iterable[Path | None]) -> FaultTable:
    """The first faults.json beside one of these parameters.json files, otherwise beside any known one, or NO_FAULTS."""
    for path in [*parameters, named_file(None), *at_hand()]:
        if path is None:
            continue
        try:
            return load_faults(faults_file(path))
        except InputError:
            continue
    return NO_FAULTS


def register_names(register: int) -> list[str]:
    """Kinds of errors in object 1001."""
    return [name for bit, name in enumerate(REGISTER_BITS) if register >> bit & 1]


def origin(code: int, info: int) -> str:
    """Source of an error of 1003: `info` is its detail (a node's id) and, in the upper byte, its source."""
    source, detail = info >> 8, info & 0xFF
    if source == 0:
        return f"node {detail & 0x7F}" if code == 0x8130 else ""
    return SOURCES[source] if source < len(SOURCES) else f"source {source}"
