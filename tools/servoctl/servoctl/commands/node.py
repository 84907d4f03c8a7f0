# SPDX-License-Identifier: Apache-2.0
"""scan, info and state: the nodes on the bus, their identity, and whether their axes are enabled."""

from __future__ import annotations

import time
from typing import Any

import canopen
import click

from ..drive.axis_state import read_axis
from ..drive.drive import Drive
from ..drive.silent_stop import silent_stop_age_s, silent_stop_text
from ..errors import ExitCode, InputError
from ..gains.tuning import set_state
from ..link.bus import open_bus, parse_bus
from ..link.device import Device
from ..objects.fault_table import find_faults
from ..objects.parameter import AXES
from ..objects.restrictions import BANKS_AS_NEEDED
from ..session import Session, common

SCAN_LISTEN_S = 1.0


@click.command(short_help="List the nodes on the bus.")
@click.option("--passive", is_flag=True, help="Listen only; send no requests.")
@common
def scan(session: Session, passive: bool) -> int:
    """List the nodes on the bus. Exit code 1 if there are none."""
    address = parse_bus(session.bus)
    network = canopen.Network(bus=open_bus(address, session.bitrate, listen_only=passive))
    states: dict[int, str] = {}
    with network.connect():
        for node in range(1, 128):
            network.subscribe(
                0x700 + node, lambda identifier, data, _t: states.update({identifier - 0x700: _nmt(data)})
            )
        with session.out.errors.status("listening"):
            if not passive:
                network.scanner.search()
            time.sleep(SCAN_LISTEN_S)
        present = sorted(network.scanner.nodes)
    found = [_describe(session, node, states.get(node, "unknown"), passive) for node in present]
    session.out.json(found)
    if not found:
        session.out.say(f"no node answers on {address}.")
        return int(ExitCode.DIFFERENT)
    session.out.table(
        [("node", "right"), "name", "state", "software", ("serial", "right"), "axes"],
        [
            (
                str(f["node"]),
                f["name"] or "",
                f["state"],
                f["software"] or "",
                str(f["serial"] or ""),
                ", ".join(f["axes"]),
            )
            for f in found
        ],
    )
    return 0


def _nmt(data: bytes | bytearray) -> str:
    names = {0: "boot-up", 4: "stopped", 5: "operational", 127: "pre-operational"}
    return names.get(data[0] & 0x7F, "unknown") if data else "unknown"


def _describe(session: Session, node: int, state: str, passive: bool) -> dict[str, Any]:
    empty: dict[str, Any] = {"node": node, "name": None, "state": state, "software": None, "serial": None, "axes": []}
    if passive:
        return empty
    with session.connect(node) as device:
        try:
            identity = device.identity()
            axes = [name for axis, name in enumerate(AXES) if device.has_axis(axis)]
        except Exception:  # noqa: BLE001 - a foreign node may answer anything
            return empty
    return empty | {key: identity[key] for key in ("name", "software", "serial")} | {"axes": axes}


@click.command(short_help="Show versions, parameter sets and state of the node.")
@common
def info(session: Session) -> None:
    """Show versions, schema, parameter sets and state of the node.

    Angles are those of the device: without a limited travel from -32 to 32 turns (607B), with a jump of 64 turns at the ends.
    """
    with session.connect() as device:
        data = device.identity()
        data["nmt"] = device.nmt_state()
        schema = device.any_schema
        data["parameters"] = str(schema.source) if schema.source else None
        data["schema_fits"] = device.schema_fits
        data["option_bytes"] = _option_bytes(device)
        data["axes"] = [
            _read_axis(device, axis) | _set_data(device, axis) for axis in range(len(AXES)) if device.has_axis(axis)
        ]
        mismatch = "" if device.schema_fits else device.mismatch
    out = session.out
    out.json(data)
    hexes = {"device_type", "schema", "vendor", "product", "revision"}
    for key, value in data.items():
        if key != "axes" and value is not None:
            shown = (
                f"0x{value:08X}"
                if key in hexes
                else ("yes" if value is True else "no" if value is False else str(value))
            )
            out.say(f"{key.replace('_', ' '):14} {shown}")
    show_axes(session, data["axes"])
    for axis in data["axes"]:
        if "active_crc" in axis:
            stored = (
                "as stored" if not axis["differs_from_stored"] else f"not stored (stored: {axis['stored_crc']:08X})"
            )
            staged = "; staged values are not active" if axis["staged"] else ""
            out.say(f"{axis['axis']:8} set {axis['active_crc']:08X}, {stored}{staged}")
    if mismatch:
        out.note(mismatch)


_OPTION_BYTES = {
    BANKS_AS_NEEDED: "DBANK or BFB2: the flash has other banks than the image needs; no torque, and nothing is stored",
    0x10: "SRAM_PE: no parity of the RAM",
    0x20: "WRP1A: the image is not write-protected",
}


def _option_bytes(device: Device) -> str | None:
    """Those of the board's chip that are not as the image needs them (3061:1)."""
    status = device.try_upload(0x3061, 1)
    if status is None:
        return None
    missing = [text for bit, text in _OPTION_BYTES.items() if not int.from_bytes(status, "little") & bit]
    return "; ".join(missing) or "as needed"


def _set_data(device: Device, axis: int) -> dict[str, Any]:
    state = set_state(device, axis)
    if state is None:
        return {}
    return {
        "active_crc": state.active_crc,
        "stored_crc": state.stored_crc,
        "staged": state.staged_differs,
        "differs_from_stored": state.active_differs_from_stored,
    }


def _read_axis(device: Device, axis: int) -> dict[str, Any]:
    return read_axis(device, axis) | {"silent_stop_age_s": silent_stop_age_s(device, axis)}


def show_axes(session: Session, axes: list[dict[str, Any]]) -> None:
    """A table of the result of `_read_axis`, and why an axis was stopped."""

    def shown(value: float | None, places: int) -> str:
        return "–" if value is None else f"{value:.{places}f}"

    columns = [
        "axis",
        "state",
        "mode",
        ("angle °", "right"),
        ("rate °/s", "right"),
        ("torque %", "right"),
        "error",
        "flags",
    ]
    rows = [
        (a["axis"], a["state"], a["mode"], shown(a["position_deg"], 4), shown(a["rate_deg_s"], 4), shown(a["torque_percent"], 1),
         f"{a['error']:04X}" if a["error"] else "", ", ".join(a["flags"]))
        for a in axes
    ]  # fmt: skip
    session.out.table(columns, rows)
    for a in axes:
        if a["silent_stop_age_s"] is not None:
            session.out.note(silent_stop_text(a["axis"], a["silent_stop_age_s"], find_faults([session.parameters])))


ACTIONS = ("enable", "disable", "quick-stop", "reset")


@click.command(short_help="Show the axes' states; enable, disable, reset a fault.")
@click.argument("words", nargs=-1, metavar="[AXIS] [enable|disable|quick-stop|reset]")
@click.option("--axis", type=click.Choice(AXES), help="The axis, if it is not given as an argument.")
@common
def state(session: Session, words: tuple[str, ...], axis: str | None) -> None:
    """Show the state of the axes, or change the state of one: enable, disable, quick-stop, reset (a fault).

    Angles are those of the device: without a limited travel from -32 to 32 turns (607B), with a jump of 64 turns at the ends.
    """
    action = None
    for word in words:
        if word in AXES and axis in (None, word):
            axis = word
        elif word in ACTIONS and action is None:
            action = word
        else:
            raise InputError(f"'{word}' is neither an axis ({', '.join(AXES)}) nor an action ({', '.join(ACTIONS)}).")
    if action and axis is None:
        raise InputError(f"'{action}' needs an axis: {' or '.join(AXES)}.")
    with session.connect() as device:
        if action and axis:
            drive = Drive(device, AXES.index(axis))
            {
                "enable": drive.enable,
                "disable": drive.disable,
                "quick-stop": drive.quick_stop,
                "reset": drive.reset_fault,
            }[action]()
        shown = [AXES.index(axis)] if axis else range(len(AXES))
        axes = [_read_axis(device, a) for a in shown if device.has_axis(a)]
        nmt = device.nmt_state()
    session.out.json({"node": session.node, "nmt": nmt, "axes": axes})
    session.out.say(f"node {session.node} is {nmt}")
    show_axes(session, axes)
