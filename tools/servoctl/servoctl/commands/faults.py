"""faults: what is wrong now, what was wrong before, and what to do about it."""

from __future__ import annotations

from typing import Any

import click

from ..device import Device
from ..parameter import AXES
from ..power import state_of
from ..session import Session, common

_NODE = "node"

CODES: dict[int, tuple[str, str, str]] = {
    0x0000: ("no error", "", ""),
    0x2310: ("continuous over-current", "the load or the friction needs more than the current limit", "look at 6077 and at the current limit of the motor"),
    0x2320: ("short circuit", "winding or bridge", "switch off, measure the winding"),
    0x3110: ("mains over-voltage", "braking feeds the supply", "lower the deceleration 6084 and 6085"),
    0x3210: ("DC link over-voltage", "braking feeds the supply", "lower the deceleration 6084 and 6085"),
    0x3220: ("DC link under-voltage", "the supply is off or too weak", "check the supply"),
    0x4210: ("over-temperature of the device", "load or cooling", "let it cool"),
    0x4310: ("over-temperature of the drive", "load or cooling", "let it cool"),
    0x5530: ("non-volatile memory", "the store is damaged", "store again; replace the board if it comes back"),
    0x6100: ("internal software", "the control task did not keep its deadline, or a check failed", "read the fault log, report it"),
    0x6320: ("parameter error", "the parameters contradict each other", "servoctl restore a gains file that is known to be good"),
    0x7300: ("sensor", "encoder or gyro gave no usable sample", "check its cable and supply, then reset"),
    0x7305: ("encoder", "the encoder gave no usable sample", "check its cable and supply, then reset"),
    0x8100: ("communication", "the bus or the master stopped the node", "make the node operational, then reset"),
    0x8110: ("CAN overrun", "frames came faster than they were read", "lower the bus load"),
    0x8120: ("CAN error passive", "wiring, termination or bit rate", "check both terminators (60 ohm between the wires)"),
    0x8130: ("heartbeat lost", "a master that the node watches (1016) has gone", "start it again, or clear its entry in 1016, then reset"),
    0x8140: ("bus-off recovered", "wiring, termination or bit rate", "check both terminators (60 ohm between the wires)"),
    0x8210: ("PDO too short", "a master sends another mapping", "compare the master's PDO mapping with 1600 to 1603"),
    0x8240: ("SYNC of unexpected length", "counter in SYNC does not fit 1019", "set 1019 as the master sends it"),
    0x8250: ("RPDO time-out", "set-points stopped coming", "start the master again, or set the RPDO's event timer, then reset"),
    0x8400: ("velocity error", "the axis does not follow the set-point", "check torque limit, load and gains"),
    0x8611: ("following error", "the axis is further from its set-point than 6065 for longer than 6066", "check torque limit, load and gains; widen 6065 if the profile is too fast"),
    0x8612: ("position limit", "the joint angle is beyond 607D", "move back, check 607D"),
    0x8700: ("SYNC time-out", "SYNC stopped coming", "start the master again, or set 1006 to 0"),
}  # fmt: skip
"""Error codes of CiA 301 table 26 and CiA 402-2: meaning, usual cause, cure."""

_CLASSES = {
    0x1000: "generic", 0x2000: "current", 0x3000: "voltage", 0x4000: "temperature", 0x5000: "hardware",
    0x6000: "software", 0x7000: "additional modules", 0x8000: "monitoring", 0x9000: "external", 0xF000: "device specific",
}  # fmt: skip

REGISTER_BITS = ("any", "current", "voltage", "temperature", "communication", "profile", "reserved", "manufacturer")


def meaning(code: int) -> str:
    """One or a few words for an error code."""
    if code in CODES:
        return CODES[code][0]
    return f"{_CLASSES.get(code & 0xF000, 'unknown')} error"


def explain_code(text: str) -> dict[str, str] | None:
    """Meaning, cause and cure of an error code typed as 0x8611 or 8611h; None when it is no such code."""
    plain = text.lower().removeprefix("0x").removesuffix("h")
    if len(plain) != 4 or any(c not in "0123456789abcdef" for c in plain) or int(plain, 16) not in CODES:
        return None
    code = int(plain, 16)
    named, cause, cure = CODES[code]
    return {"code": f"{code:04X}", "meaning": named, "cause": cause, "cure": cure}


def register_names(register: int) -> list[str]:
    """Kinds of errors that object 1001 tells."""
    return [name for bit, name in enumerate(REGISTER_BITS) if register >> bit & 1]


def origin(code: int, info: int) -> str:
    """Where an error of 1003 came from: `info` is its detail (a node's id) and, in the upper byte, its source."""
    source, detail = info >> 8, info & 0xFF
    if source == 0:
        return f"node {detail & 0x7F}" if code == 0x8130 else ""
    return AXES[source - 1] if source <= len(AXES) else f"source {source}"


def read_faults(device: Device) -> dict[str, Any]:
    """Error register, history and the state of each axis, as the device has them."""
    history = []
    count = device.try_upload(0x1003, 0)
    for sub in range(1, (count[0] if count else 0) + 1):
        value = device.read_int(0x1003, sub)
        history.append(
            {"code": value & 0xFFFF, "info": value >> 16, "meaning": meaning(value & 0xFFFF),
             "origin": origin(value & 0xFFFF, value >> 16)}
        )  # fmt: skip
    axes = []
    for axis, name in enumerate(AXES):
        if device.has_axis(axis):
            code = device.try_upload(0x603F + 0x800 * axis)
            axes.append(
                {
                    "axis": name,
                    "state": state_of(device.axis_int(axis, 0x6041)),
                    "code": int.from_bytes(code, "little") if code else 0,
                    "meaning": meaning(int.from_bytes(code, "little") if code else 0),
                }
            )
    return {"register": device.read_int(0x1001), "axes": axes, "history": history, "log": read_log(device)}


def read_log(device: Device) -> list[dict[str, Any]]:
    """The fault log 0x3020 by the names that the device's table gives it; empty for a device that has none."""
    rows = [
        p for p in device.any_schema if 0x3020 <= p.index < 0x3030 and p.sub > 0 and p.readable and p.type != "DOMAIN"
    ]
    found = []
    for parameter in rows if device.schema_fits else []:
        data = device.try_upload(parameter.index, parameter.sub)
        if data is not None:
            found.append({"name": parameter.name, "value": parameter.decode(data), "unit": parameter.unit})
    return found


@click.command()
@click.option("--clear", is_flag=True, help="Forget the history (1003); faults that are active stay.")
@common
def faults(session: Session, clear: bool) -> None:
    """Show active faults and the history of errors, with cause and cure.

    The history (1003) is what the device remembers since it started: the last eight, without times. A fault log with
    times and values (3020) is shown where the device has one.
    """
    with session.connect() as device:
        if clear:
            device.write_int(0x1003, 0, 0, 1)
        found = read_faults(device)
    out = session.out
    out.json(found)
    kinds = ", ".join(register_names(found["register"])) or "none"
    out.say(f"error register 1001: {found['register']:02X} ({kinds})")
    for axis in found["axes"]:
        out.say(f"{axis['axis']:8} {axis['state']}; 603F = {axis['code']:04X}, {axis['meaning']}")
    if found["history"]:
        rows = [
            (str(i), f"{h['code']:04X}", h["meaning"], h["origin"]) for i, h in enumerate(found["history"], 1)
        ]
        out.table([("", "right"), "code", "meaning", "from"], rows, "since the start, newest first")
    else:
        out.say("no error since the start, or the history was cleared.")
    if found["log"]:
        out.table(
            ["fault log", ("value", "right"), "unit"], [(e["name"], str(e["value"]), e["unit"]) for e in found["log"]]
        )
    active = {a["code"] for a in found["axes"] if a["code"]}
    for code in sorted((active or {h["code"] for h in found["history"][:1]}) & set(CODES)):
        _, cause, cure = CODES[code]
        when = "active" if code in active else "the last one; no axis has a fault now"
        out.say(f"{code:04X} ({when}): usual cause: {cause}. Cure: {cure}.")
