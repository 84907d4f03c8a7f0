# SPDX-License-Identifier: Apache-2.0
"""The device and its master, one of each for all tests of a process; each test begins with a reset of the node.

--device selects the servo (device.py), --bus the bus: slcan-tcp:0 or, where it exists, socketcan:vcan0.
Marks: `speed`: of node time, other than FAST, where the computer must send set-points in time or read every tick.
`power_on`: both axes are where they were at power-on. `simulator`: a test of the simulator alone. `smoke`: the few that run on the image in the small size.
`variants_on_image`: so many of the test's variants run on the image, except in the large size.
"""

import collections
import contextlib
import logging
import os

import pytest
from axis import Axis
from device import DESCRIPTIONS, DEVICES, FAST, REAL_TIME, Served
from master import Master

FAR_DEG = 20.0


def pytest_addoption(parser):
    parser.addoption("--device", choices=DEVICES, default="sim")
    parser.addoption("--bus", default="slcan-tcp:0")


def pytest_configure(config):
    for mark in ("speed", "power_on", "simulator", "smoke", "variants_on_image"):
        config.addinivalue_line("markers", mark)


def pytest_collection_modifyitems(config, items):
    """The tests of the simulator alone belong to the run on it; in the small size, few run on the image, and in the medium
    size not all variants."""
    if config.getoption("--device") == "sim":
        return
    size = os.environ.get("TESTS_SIZE", "medium")
    variants = collections.Counter()

    def is_of_this_run(item):
        limit = item.get_closest_marker("variants_on_image")
        variants[item.function] += 1
        too_many = limit is not None and size != "large" and variants[item.function] > limit.args[0]
        return not item.get_closest_marker("simulator") and not too_many and (size != "small" or bool(item.get_closest_marker("smoke")))

    chosen = [item for item in items if is_of_this_run(item)]
    config.hook.pytest_deselected(items=[item for item in items if item not in chosen])
    items[:] = chosen


class Bench:
    """The device in use and its master, made anew when another speed is needed or an axis is far from its start."""

    def __init__(self, make, bus):
        self.make, self.bus = make, bus
        self.device = self.master = self.speed = None

    def prepare(self, speed, fresh):
        if self.master is not None and speed == self.speed and not fresh:
            self.master.begin()
            self.master.reset()
            if all(abs(Axis(self.master, shift).angle_deg) < FAR_DEG for shift in (0, 0x800)):
                return
        self.close()
        self.device, self.speed = self.make(self.bus, speed), speed
        self.master = Master(self.device.open_bus())
        self.master.reset()

    def close(self):
        if self.master is not None:
            self.master.close()
            self.device.close()
            self.master = None


@pytest.fixture(scope="session")
def bench(pytestconfig):
    used = Bench(DEVICES[pytestconfig.getoption("--device")], pytestconfig.getoption("--bus"))
    yield used
    used.close()


@pytest.fixture
def master(bench, request):
    """Pre-operational, all objects as after power-on."""
    chosen = request.node.get_closest_marker("speed")
    usual = REAL_TIME if bench.bus.startswith("socketcan:") else FAST  # an interface drops what nobody reads in time
    bench.prepare(chosen.args[0] if chosen else usual, fresh=request.node.get_closest_marker("power_on") is not None)
    bench.master.forget()
    return bench.master


@pytest.fixture
def device(bench, master):
    return bench.device


@pytest.fixture
def connect(device):
    """Makes further masters on the bus."""
    with contextlib.ExitStack() as closing:

        def make(**options):
            other = Master(device.open_bus(**options))
            closing.callback(other.close)
            return other

        yield make


@pytest.fixture
def node(master):
    """Operational; its axes turn on while the client is silent (the documented lines of docs/can.md)."""
    master.node.sdo[0x6007].raw = 0
    master.node.sdo[0x6807].raw = 0
    master.node.nmt.state = "OPERATIONAL"
    master.wait_for_state(5)
    return master.node


@pytest.fixture
def azimuth(master, node):
    return Axis(master, 0)


@pytest.fixture
def pitch(master, node):
    return Axis(master, 0x800)


@pytest.fixture
def store(master):
    """For tests that store: the next test finds the defaults."""
    yield
    master.reset()
    master.node.sdo.download(0x1011, 1, b"load")


@pytest.fixture
def serve():
    """Starts simulators with options of their own, at FAST."""
    with contextlib.ExitStack() as closing:

        def start(*options, bus="slcan-tcp:0"):
            served = Served(bus, *([] if "--speed" in options else ["--speed", str(FAST)]), *options)
            closing.callback(lambda: served.process.stdin.closed or served.close())
            return served

        yield start


@pytest.fixture
def descriptions():
    return DESCRIPTIONS


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
