"""The servo from a CANopen master's side: only python-canopen, on the simulator and on the emulated board.

SIM_HOST, EMULATE_BOARD, TARGET_IMAGE and NODE_DESCRIPTIONS name the programs, the image and the folder of the EDS.
CTest sets them; without them those of the build folders are used. CONFORMANCE_DEVICES (default "simulator board")
selects the devices.
"""

from __future__ import annotations

import logging
import os
import pathlib
import struct
import subprocess
import threading
import time

import can
import canopen
import pytest

NODE_ID = 1
PROJECT = pathlib.Path(__file__).resolve().parents[2]
SIM_HOST = os.environ.get("SIM_HOST", str(PROJECT / "build/host/bin/sim_host"))
EMULATE_BOARD = os.environ.get("EMULATE_BOARD", str(PROJECT / "build/host/bin/emulate_board"))
IMAGE = os.environ.get("TARGET_IMAGE", str(PROJECT / "build/stm32g474/bin/trackservo.bin"))
DESCRIPTIONS = pathlib.Path(os.environ.get("NODE_DESCRIPTIONS", str(PROJECT / "build/host/share/trackservo")))
DEVICES = os.environ.get("CONFORMANCE_DEVICES", "simulator board").split()

# The test machines are shared: an answer may be late without an error.
canopen.sdo.SdoClient.RESPONSE_TIMEOUT = 3.0


class Device:
    """A served node in a process of its own."""

    def __init__(self, kind: str) -> None:
        self.kind = kind
        program = {"simulator": [SIM_HOST, "serve"], "board": [EMULATE_BOARD, IMAGE]}[kind]
        self._process = subprocess.Popen(
            [*program, "--until-stdin-ends", "--bus", "slcan-tcp:0"],
            stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True, cwd=PROJECT,
        )  # fmt: skip
        assert self._process.stdout is not None
        self._address = self._process.stdout.readline().strip().split(":", 1)[1]
        assert self._process.stdout.readline().strip() == "ready"

    def open_bus(self) -> can.BusABC:
        return can.Bus(interface="slcan", channel=f"socket://{self._address}", bitrate=1000000, sleep_after_open=0)

    def close(self) -> int:
        assert self._process.stdin is not None
        self._process.stdin.close()
        return self._process.wait(timeout=20)


class Master:
    """A master with the node in its network, and the frames that it receives."""

    def __init__(self, bus: can.BusABC) -> None:
        self.network = canopen.Network(bus=bus)
        self.network.connect()
        self.node = self.network.add_node(NODE_ID, str(DESCRIPTIONS / "trackservo.eds"))
        self._heard: list[tuple[int, bytes]] = []
        self._changed = threading.Condition()
        for identifier in range(0x800):
            self.network.subscribe(identifier, self._hear)

    def _hear(self, identifier: int, data: bytearray, _time: float) -> None:
        with self._changed:
            self._heard.append((identifier, bytes(data)))
            self._changed.notify_all()

    def forget(self) -> None:
        with self._changed:
            self._heard.clear()

    def heard(self, identifier: int) -> list[bytes]:
        """The frames since `forget`."""
        with self._changed:
            return [data for heard, data in self._heard if heard == identifier]

    def wait_for(self, identifier: int, count: int = 1, timeout_s: float = 10.0) -> list[bytes]:
        """At least `count` frames since `forget`."""
        end = time.monotonic() + timeout_s
        while len(frames := self.heard(identifier)) < count:
            with self._changed:
                self._changed.wait(0.05)
            assert time.monotonic() < end, f"{len(frames)} of {count} frames {identifier:03X} within {timeout_s} s"
        return frames

    def send(self, identifier: int, *data: int) -> None:
        self.network.send_message(identifier, bytes(data))

    def request(self, *request: int) -> bytes:
        """An SDO request byte by byte, and the next answer."""
        before = len(self.heard(0x580 + NODE_ID))
        self.send(0x600 + NODE_ID, *bytes(request).ljust(8, b"\0"))
        return self.wait_for(0x580 + NODE_ID, before + 1)[before]

    def pass_time(self, ms: int) -> None:
        """Of the node: 3010:1 counts its ms."""
        start = self.ticks_ms()
        while (self.ticks_ms() - start) & 0xFFFFFFFF < ms:
            time.sleep(0.002)

    def ticks_ms(self) -> int:
        return struct.unpack("<L", self.node.sdo.upload(0x3010, 1))[0]

    def sdo_abort(self, index: int, sub: int, data: bytes | None = None) -> int:
        """The abort code of a download (an upload without `data`); 0: not refused."""
        try:
            if data is None:
                self.node.sdo.upload(index, sub)
            else:
                self.node.sdo.download(index, sub, data)
        except canopen.SdoAbortedError as refusal:
            return refusal.code
        return 0

    def number(self, index: int, sub: int = 0) -> int:
        return int.from_bytes(self.node.sdo.upload(index, sub), "little")

    def write(self, index: int, sub: int, value: int, size: int) -> None:
        self.node.sdo.download(index, sub, value.to_bytes(size, "little", signed=value < 0))

    def reset(self) -> None:
        """All objects as after power-on; the boot-up message has come."""
        self.forget()
        self.node.nmt.send_command(0x81)
        end = time.monotonic() + 10
        while b"\0" not in self.heard(0x700 + NODE_ID):
            time.sleep(0.01)
            assert time.monotonic() < end, "no boot-up message"

    def start(self) -> None:
        self.node.nmt.send_command(0x01)
        self.wait_for_state(5)

    def wait_for_state(self, state: int) -> None:
        """The next heartbeats show it."""
        self.forget()
        end = time.monotonic() + 10
        while bytes([state]) not in self.heard(0x700 + NODE_ID):
            time.sleep(0.01)
            assert time.monotonic() < end, f"no heartbeat with state {state}"

    def close(self) -> None:
        self.network.disconnect()


@pytest.fixture(scope="session", params=DEVICES)
def device(request):
    served = Device(request.param)
    yield served
    assert served.close() == 0  # the emulated board: the image followed the chip's rules


@pytest.fixture(scope="session")
def session_master(device):
    master = Master(device.open_bus())
    yield master
    master.close()


@pytest.fixture
def master(session_master):
    """Pre-operational, all objects as after power-on."""
    session_master.reset()
    session_master.forget()
    return session_master


@pytest.fixture(autouse=True)
def no_warnings(caplog):
    """The client finds no errors, except those that a test provokes."""
    yield
    loud = [r.getMessage() for r in caplog.records if r.levelno >= logging.WARNING and r.name.startswith("canopen")]
    assert [m for m in loud if "Transfer aborted" not in m and "Data size has not been specified" not in m] == []
