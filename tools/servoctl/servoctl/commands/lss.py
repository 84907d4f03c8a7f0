# SPDX-License-Identifier: Apache-2.0
"""lss: node ids and the bit rate, set over the bus (layer setting services, CiA 305)."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import asdict, dataclass
from typing import Any

import canopen
import click
from canopen.lss import LssError, LssMaster

from ..errors import ConnectionFailed, ExitCode, InputError, NotVerified, Refused
from ..link.bus import BIT_RATES, BusAddress, open_bus, parse_bus
from ..session import Session, common
from ..units import whole_number
from .quantity import Whole

ANSWER_S = 1.0
"""Of one node, or of the first of all: more than a store of the node id takes, on a busy computer, too."""
FASTSCAN_ANSWERS_S = (0.1, 0.3)
"""Of the first try, and of another one when it finds no node: no node answers about half of its hundred questions, so they
are short, and on a busy computer an answer may come too late."""
QUIET_S = 0.15
"""After the last of several answers."""
SWITCH_DELAY_MS = 500
"""Silence of every node before the bit rate changes, and again after it."""
BOOT_S = 2.0
MAX_NODES = 127
INDEX_OF_BIT_RATE = {1_000_000: 0, 500_000: 2, 250_000: 3, 125_000: 4}
TORQUE = 255


@dataclass(frozen=True)
class Identity:
    """Contents of object 1018, which LSS requires."""

    vendor: int = 0
    product: int = 0x54534456
    revision: int = 1
    serial: int = 0


@click.group()
def lss() -> None:
    """Set node ids and the bit rate over the bus (CiA 305).

    The nodes refuse changes while an axis has torque. A new node id is active at once; a stored one also after a
    restart. After 'lss rate', change the bit rate of the adapter and of all other devices as well.
    """


@contextmanager
def _master(session: Session, bitrate: int | None = None) -> Iterator[tuple[canopen.Network, LssMaster]]:
    """The bus, and the LSS master on it; leaves every node in the waiting state."""
    network = canopen.Network(bus=open_bus(parse_bus(session.bus), bitrate or session.bitrate))
    network.lss.RESPONSE_TIMEOUT = ANSWER_S
    with network.connect():
        try:
            yield network, network.lss
        finally:
            network.lss.send_switch_state_global(LssMaster.WAITING_STATE)


def _ask(what: str, request: Callable[[], Any]) -> Any:
    """The answer to an LSS request; raises the node's error in words."""
    try:
        return request()
    except LssError as error:
        reason = str(error)
        if "No LSS response" in reason:
            raise ConnectionFailed(f"no node answered while {what}.") from error
        if reason.endswith(str(TORQUE)):
            raise Refused(f"refused while {what}: an axis has torque; disable both axes first.") from error
        raise Refused(f"the node refused {what} ({reason}).") from error


def _ask_all(network: canopen.Network, what: str, request: bytes) -> None:
    """A request that every node answers; refused when one of them refuses.

    On a real bus equal answers may be one frame, so they are not counted: they are complete when the bus is quiet.
    """
    answers: list[bytes] = []

    def hear(_id: int, data: bytearray, _time: float) -> None:
        if data[0] == request[0]:
            answers.append(bytes(data))

    network.subscribe(LssMaster.LSS_RX_COBID, hear)
    try:
        network.send_message(LssMaster.LSS_TX_COBID, request.ljust(8, b"\0"))
        until = time.monotonic() + ANSWER_S
        heard = 0
        while time.monotonic() < until:
            time.sleep(0.01)
            if len(answers) > heard:
                heard = len(answers)
                until = time.monotonic() + QUIET_S
    finally:
        network.unsubscribe(LssMaster.LSS_RX_COBID, hear)
    if not answers:
        raise ConnectionFailed(f"no node answered while {what}.")
    refusals = sorted({answer[1] for answer in answers} - {0})
    if TORQUE in refusals:
        raise Refused(f"refused while {what}: an axis has torque; disable all axes of all nodes first.")
    if refusals:
        raise Refused(f"a node refused {what} (LSS error {refusals[0]}).")


def _check_free(node: int, present: set[int]) -> None:
    if node in present:
        raise InputError(f"node id {node} is already in use on this bus; 'servoctl scan' lists the nodes.")


def _number(master: LssMaster, node: int, store: bool) -> None:
    """Of the one node in the configuration state."""
    _ask(f"setting node id {node}", lambda: master.configure_node_id(node))
    if store:
        _ask("storing the node id", master.store_configuration)


def _wait_for_boot(network: canopen.Network, node: int) -> None:
    heard: list[int] = []
    network.subscribe(0x700 + node, lambda _id, data, _time: heard.append(data[0]))
    network.lss.send_switch_state_global(LssMaster.WAITING_STATE)
    until = time.monotonic() + BOOT_S
    while not heard and time.monotonic() < until:
        time.sleep(0.01)
    network.unsubscribe(0x700 + node)
    if not heard:
        raise NotVerified(f"node {node} sent nothing after it got its node id.")


def _find(master: LssMaster) -> Identity | None:
    """The next node without node id, which is then in the configuration state."""
    try:
        for answer_s in FASTSCAN_ANSWERS_S:
            master.RESPONSE_TIMEOUT = answer_s
            found, identity = master.fast_scan()
            if found:
                return Identity(*identity)
    finally:
        master.RESPONSE_TIMEOUT = ANSWER_S
    return None


@lss.command(short_help="Find nodes without a node id and assign ids.")
@click.option(
    "--first", type=Whole(1, 127), help="Assign node ids to the nodes found, beginning with this one."
)
@click.option(
    "--store/--no-store", default=True, help="Store the node ids, so that they survive a restart (default: --store)."
)
@common
def scan(session: Session, first: int | None, store: bool) -> int:
    """Find nodes without a node id (fastscan) and assign ids with --first. Exit code 1 if none is found."""
    rows: list[dict[str, Any]] = []
    with _master(session) as (network, master), session.out.errors.status("scanning"):
        present = set() if first is None else _present(network)
        for n in range(MAX_NODES):
            identity = _find(master)
            if identity is None:
                break
            node = None if first is None else first + n
            if node is not None:
                if node > MAX_NODES:
                    raise InputError(f"node id {node} is above {MAX_NODES}; use a value lower than --first {first}.")
                _check_free(node, present)
                _number(master, node, store)
                _wait_for_boot(network, node)
            rows.append({"node": node} | asdict(identity))
    session.out.json(rows)
    if not rows:
        session.out.say(f"no unconfigured node answers on {parse_bus(session.bus)}.")
        return int(ExitCode.DIFFERENT)
    session.out.table(
        [("node", "right"), "vendor", "product", "revision", "serial"],
        [
            (str(r["node"] or "–"), *(f"0x{r[key]:08X}" for key in ("vendor", "product", "revision", "serial")))
            for r in rows
        ],
    )
    return 0


@lss.command(name="id")
@click.argument("new_id", type=Whole(1, 127))
@click.option(
    "--serial",
    type=whole_number,
    metavar="NUMBER",
    help="Serial number (1018:4) of the node, if several nodes have the same node id.",
)
@click.option(
    "--store/--no-store", default=True, help="Store the node id, so that it survives a restart (default: --store)."
)
@common
def set_id(session: Session, new_id: int, serial: int | None, store: bool) -> None:
    """Change the node id of the node given by --node or --serial."""
    identity = _identity(session) if serial is None else Identity(serial=serial)
    with _master(session) as (network, master):
        who = f"switching the node with serial number 0x{identity.serial:08X}"
        _ask(who, lambda: master.send_switch_state_selective(*asdict(identity).values()))
        old = _ask("asking for its node id", master.inquire_node_id)
        if old != new_id:
            _check_free(new_id, _present(network))
        _number(master, new_id, store)
        if 1 <= old <= MAX_NODES and old != new_id:
            master.send_switch_state_global(LssMaster.WAITING_STATE)
            network.send_message(0, bytes([0x82, old]))  # NMT: reset communication
        if old != new_id:
            _wait_for_boot(network, new_id)
    session.out.json({"node": new_id, "was": old, "stored": store} | asdict(identity))
    session.out.say(f"node {old if old <= MAX_NODES else 'without id'} is now node {new_id}.")


def _identity(session: Session) -> Identity:
    with session.connect() as device:
        numbers = [device.try_upload(0x1018, sub) for sub in range(1, 5)]
    if any(number is None for number in numbers):
        raise ConnectionFailed(f"node {session.node} does not report its identity (object 1018).")
    return Identity(*(int.from_bytes(number or b"", "little") for number in numbers))


def _present(network: canopen.Network) -> set[int]:
    network.scanner.reset()
    network.scanner.search()
    time.sleep(0.5)
    return set(network.scanner.nodes)


def _bit_rate(network: canopen.Network, node: int) -> int:
    """In effect, in bit/s (3050:2)."""
    kbit_s = network.add_node(node, canopen.ObjectDictionary()).sdo.upload(0x3050, 2)
    return int.from_bytes(kbit_s, "little") * 1000


def _bit_timing(bit_rate: int) -> bytes:
    return bytes([0x13, 0, INDEX_OF_BIT_RATE[bit_rate], 0, 0, 0, 0, 0])


@lss.command()
@click.argument("bit_rate", type=click.Choice([str(rate) for rate in BIT_RATES]))
@click.option(
    "--store/--no-store", default=True, help="Store the bit rate, so that it survives a restart (default: --store)."
)
@common
def rate(session: Session, bit_rate: str, store: bool) -> None:
    """Change the bit rate of all nodes on the bus at once."""
    new = int(bit_rate)
    address = parse_bus(session.bus)
    with _master(session) as (network, master):
        before = _present(network)
        if not before:
            raise ConnectionFailed(f"no node answers at {session.bitrate} bit/s on {address}.")
        in_force = _bit_rate(network, min(before))
        master.send_switch_state_global(LssMaster.CONFIGURATION_STATE)
        try:
            _ask_all(network, f"setting {new} bit/s", _bit_timing(new))
        except Refused:  # nodes that accepted it restore the old one, so that no later store persists it
            network.send_message(LssMaster.LSS_TX_COBID, _bit_timing(in_force))
            raise
        if store:
            _ask_all(network, "storing the bit rate", bytes([0x17]))
        master.activate_bit_timing(SWITCH_DELAY_MS)
    time.sleep(2.2 * SWITCH_DELAY_MS / 1000.0)
    lost = _lost(session, address, new, before)
    if lost:
        raise NotVerified(f"node {', '.join((str(node) for node in sorted(lost)))} does not answer at {new} bit/s.")
    session.out.json({"bit_rate": new, "stored": store, "nodes": sorted(before)})
    session.out.say(
        f"{len(before)} of {len(before)} nodes use {new} bit/s; from now on call servoctl with --bitrate {new}."
    )


def _lost(session: Session, address: BusAddress, bit_rate: int, before: set[int]) -> set[int]:
    if address.kind == "socketcan":
        interface = address.channel
        session.out.note(
            f"not checked: set the interface to the new bit rate, e.g. ip link set {interface} down; ip link set"
            f" {interface} up type can bitrate {bit_rate}"
        )
        return set()
    with _master(session, bit_rate) as (network, _):
        return before - _present(network)
