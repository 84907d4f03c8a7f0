"""A servo on its own bus for each test, and python-canopen clients on that bus.

NODE_TEST_DEVICE selects the servo: `sim`, the simulator (sim_host serve), or `image`, the flashed image on the emulated
board (emulate_board). SIM_HOST, EMULATE_BOARD and TARGET_IMAGE name programs and image, NODE_DESCRIPTIONS the folder of
the EDS. CTest sets them; without them those of build/host and build/stm32g474 are used. NODE_TEST_BUS is
slcan-tcp:0 or, where it exists, socketcan:vcan0.
"""

import contextlib
import logging
import os
import pathlib
import subprocess
import time

import can
import canopen
import pytest
from canopen.profiles.p402 import BaseNode402

from drive import Axis

NODE_ID = 1
PROJECT = pathlib.Path(__file__).resolve().parents[2]
SIM_HOST = os.environ.get("SIM_HOST", str(PROJECT / "build/host/bin/sim_host"))
EMULATE_BOARD = os.environ.get("EMULATE_BOARD", str(PROJECT / "build/host/bin/emulate_board"))
IMAGE = os.environ.get("TARGET_IMAGE", str(PROJECT / "build/stm32g474/bin/trackservo.bin"))
SERVERS = {"sim": [SIM_HOST, "serve"], "image": [EMULATE_BOARD, IMAGE]}
DEVICE = os.environ.get("NODE_TEST_DEVICE", "sim")
if DEVICE not in SERVERS:
    raise SystemExit(f"NODE_TEST_DEVICE is '{DEVICE}': give one of {', '.join(SERVERS)}.")
DESCRIPTIONS = pathlib.Path(os.environ.get("NODE_DESCRIPTIONS", str(PROJECT / "build/host/share/trackservo")))
BUS = os.environ.get("NODE_TEST_BUS", "slcan-tcp:0")

# The test machines are shared: an answer may be late without an error.
canopen.sdo.SdoClient.RESPONSE_TIMEOUT = 2.0


class Served:
    """A servo, and the address of its bus."""

    def __init__(self, bus, *options, server=SERVERS["sim"]):
        self.process = subprocess.Popen(
            [*server, "--until-stdin-ends", "--bus", bus, *options], stdin=subprocess.PIPE, stdout=subprocess.PIPE,
            text=True)
        self.kind, self.address = self.next_end()

    def next_end(self):
        """Kind and address of a bus end, in the order of the --bus options."""
        return self.process.stdout.readline().strip().split(":", 1)

    @property
    def tcp(self):
        host, port = self.address.rsplit(":", 1)
        return host, int(port)

    def open_bus(self, **options):
        if self.kind == "socketcan":
            return can.Bus(interface="socketcan", channel=self.address, **options)
        return can.Bus(interface="slcan", channel=f"socket://{self.address}", bitrate=1000000, sleep_after_open=0,
                       **options)

    def close(self):
        self.process.stdin.close()
        assert self.process.wait(timeout=20) == 0  # otherwise the image has violated the chip's rules


@pytest.fixture
def descriptions():
    return DESCRIPTIONS


@pytest.fixture
def served():
    process = Served(BUS, server=SERVERS[DEVICE])
    assert process.process.stdout.readline() == "ready\n"
    yield process
    process.close()


@pytest.fixture
def connect(served):
    """Makes clients: each a network with its own, unmodified BaseNode402."""
    with contextlib.ExitStack() as clients:

        def make(**options):
            network = canopen.Network(bus=served.open_bus(**options))
            network.connect()
            clients.callback(network.disconnect)
            node = BaseNode402(NODE_ID, str(DESCRIPTIONS / "trackservo.eds"))
            network.add_node(node)
            return node

        yield make


def move_unsupervised(node):
    """The documented lines of docs/can.md: a client that does not speak while an axis turns."""
    node.sdo[0x6007].raw = 0
    node.sdo[0x6807].raw = 0


@pytest.fixture
def node(connect):
    """Operational; its axes turn on while the client is silent."""
    node = connect()
    move_unsupervised(node)
    node.nmt.wait_for_heartbeat(timeout=5)
    node.nmt.state = "OPERATIONAL"
    while node.nmt.wait_for_heartbeat(timeout=5) != "OPERATIONAL":
        pass
    return node


@pytest.fixture
def azimuth(node):
    return Axis(node, 0)


@pytest.fixture
def pitch(node):
    return Axis(node, 0x800)


@pytest.fixture
def report(capsys):
    """Prints a measured number, also when the test passes."""

    def show(text):
        with capsys.disabled():
            print(f"\n  {text}", end="", flush=True)

    return show


@pytest.fixture(autouse=True)
def no_warnings(caplog):
    """The client finds no errors, except those that a test provokes."""
    yield
    loud = [r.getMessage() for r in caplog.records if r.levelno >= logging.WARNING and r.name.startswith("canopen")]
    assert [m for m in loud if "Transfer aborted" not in m and "Data size has not been specified" not in m] == []
