# SPDX-License-Identifier: Apache-2.0
"""Connections to the bus: slcan-tcp:HOST:PORT, slcan:/dev/ttyACM0 and socketcan:can0."""

from __future__ import annotations

import errno
import json
import logging
import os
import socket
import subprocess
from dataclasses import dataclass

import can

from ..errors import ConnectionFailed, InputError
from .slcan_serial import SlcanSerialBus
from .slcan_tcp import SlcanTcpBus

ENVIRONMENT = "SERVOCTL_BUS"
FORMS = "slcan-tcp:HOST:PORT, slcan:/dev/ttyACM0 or socketcan:can0"
IP_TIMEOUT_S = 2.0
BIT_RATES = (125_000, 250_000, 500_000, 1_000_000)


@dataclass(frozen=True)
class BusAddress:
    """A parsed --bus: kind, and channel as that kind names it."""

    kind: str
    channel: str

    def __str__(self) -> str:
        return f"{self.kind}:{self.channel}"

    @property
    def place(self) -> str:
        """The same for every spelling of a bus on this computer."""
        if self.kind != "slcan-tcp":
            return f"{self.kind}:{os.path.realpath(self.channel)}" if self.kind == "slcan" else str(self)
        host, _, port = self.channel.rpartition(":")
        try:
            return f"{self.kind}:{socket.gethostbyname(host)}:{port}"
        except OSError:
            return str(self)


def parse_bus(text: str | None) -> BusAddress:
    """Raises InputError with the remedy."""
    if not text:
        raise InputError(f"no bus given: add --bus or set {ENVIRONMENT} to {FORMS}.")
    kind, _, channel = text.partition(":")
    if kind not in ("slcan-tcp", "slcan", "slcan-pty", "socketcan") or not channel:
        raise InputError(f"invalid bus '{text}': expected {FORMS}.")
    if kind == "slcan-tcp":
        host, _, port = channel.rpartition(":")
        if not (port.isascii() and port.isdigit()) or not 0 < int(port) < 65536:
            raise InputError(f"the bus '{text}' has no valid port: expected slcan-tcp:HOST:PORT.")
        channel = f"{host or '127.0.0.1'}:{port}"
    return BusAddress("slcan" if kind == "slcan-pty" else kind, channel)


def open_bus(address: BusAddress, bitrate: int = 1_000_000, listen_only: bool = False) -> can.BusABC:
    """Opens the bus at `bitrate` bit/s (SocketCAN: as configured in the system); raises ConnectionFailed."""
    logging.getLogger("can").setLevel(logging.ERROR)
    try:
        if address.kind == "slcan-tcp":
            host, _, port = address.channel.rpartition(":")
            return SlcanTcpBus(host, int(port), bitrate, listen_only)
        if address.kind == "slcan":
            return SlcanSerialBus(address.channel, bitrate, listen_only)
        return can.Bus(interface="socketcan", channel=address.channel)
    except (OSError, can.CanError, can.CanInterfaceNotImplementedError, ValueError) as error:
        raise ConnectionFailed(f"{address}: {_reason(address, error)}") from error


def bit_rate_of(address: BusAddress, option: int) -> int | None:
    """In bit/s: of an adapter what --bitrate says, which sets it; of a SocketCAN interface what the system reports. None for one
    that has none, such as vcan."""
    return _interface_bit_rate(address.channel) if address.kind == "socketcan" else option


def _interface_bit_rate(interface: str) -> int | None:
    command = ["ip", "-details", "-json", "link", "show", "dev", interface]
    try:
        done = subprocess.run(command, stdin=subprocess.DEVNULL, capture_output=True, text=True, timeout=IP_TIMEOUT_S)
        rate = json.loads(done.stdout)[0]["linkinfo"]["info_data"]["bittiming"]["bitrate"]
    except (OSError, subprocess.SubprocessError, ValueError, LookupError, TypeError):
        return None
    return rate if isinstance(rate, int) and rate > 0 else None


def skipped_lines(bus: can.BusABC | None) -> str:
    """How many lines of an SLCAN adapter were no frames, as the end of a sentence; the first one is often cut."""
    count = getattr(bus, "malformed", 0)
    return f" {count} lines of the adapter were cut or wrong and were skipped." if count > 1 else ""


def _reason(address: BusAddress, error: Exception) -> str:
    number = getattr(error, "errno", None)
    if isinstance(error, ConnectionRefusedError):
        return "connection refused; is the simulator ('sim_host serve') running?"
    if isinstance(error, TimeoutError):
        return "no connection within 3 s."
    if address.kind == "socketcan" and number == errno.EAFNOSUPPORT:
        return "this kernel does not support CAN; load the module can_raw, or use slcan-tcp."
    if address.kind == "socketcan" and number == errno.ENODEV:
        return f"no such interface: {address.channel}; 'ip link show type can' lists the CAN interfaces."
    return f"cannot be opened: {error}."
