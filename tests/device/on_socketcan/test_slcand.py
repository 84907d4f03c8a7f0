# SPDX-License-Identifier: Apache-2.0
"""Linux' own slcand makes a CAN interface from the simulator's terminal, as docs/can.md shows. Needs slcan in the
kernel."""

import os
import subprocess
import time

import can
import pytest
from device import Served
from master import DEAD_S


def wait_until(condition):
    """For the kernel and the interface, which have no node time."""
    end = time.monotonic() + DEAD_S
    while not condition():
        assert time.monotonic() < end, "it did not happen"
        time.sleep(0.005)


@pytest.fixture
def can0(vcan0):
    if os.environ.get("WITH_CAN") != "uml":
        pytest.skip("slcand's interface would be one of the machine, not of this run: only in User Mode Linux")
    served = Served("slcan-pty")
    slcand = subprocess.Popen(["slcand", "-F", "-o", "-c", "-s8", served.address, "can0"])
    wait_until(lambda: subprocess.run(["ip", "link", "set", "can0", "up"], capture_output=True).returncode == 0)
    yield "can0"
    slcand.terminate()
    slcand.wait(timeout=10)
    served.close()


def test_node_is_reached_over_slcand(can0):
    with can.Bus(interface="socketcan", channel=can0) as bus:
        subprocess.run(["cansend", can0, "000#0101"], check=True)
        seen = set()
        wait_until(lambda: seen.add(bus.recv(1).arbitration_id) or {0x701, 0x181, 0x281, 0x381, 0x481} <= seen)
        subprocess.run(["cansend", can0, "601#4000100000000000"], check=True)
        answers = []
        wait_until(lambda: (m := bus.recv(1)).arbitration_id == 0x581 and answers.append(bytes(m.data)) is None)
        assert answers == [bytes.fromhex("430010009201FFFF")]
