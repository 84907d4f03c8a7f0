# SPDX-License-Identifier: Apache-2.0
"""Error frames of the CAN controller, and an interface that goes down and up. Needs vcan0.

A vcan has no wire that could fail, but it passes on error frames that can-utils sends like a driver.
"""

import subprocess
import time

import pytest

pytestmark = pytest.mark.usefixtures("vcan0")
PASSIVE = "20000004#0020000000000000"  # CAN_ERR_CRTL, transmitter error passive
ACTIVE = "20000004#0040000000000000"  # CAN_ERR_CRTL, error active again
BUS_OFF = "20000040#0000000000000000"
RESTARTED = "20000100#0000000000000000"


def send(frame):
    subprocess.run(["cansend", "vcan0", frame], check=True)


def test_error_passive_is_reported_and_taken_back(master, node, azimuth):
    azimuth.turn(1.0)
    send(PASSIVE)
    master.wait_until(lambda: [reported.code for reported in node.emcy.active] == [0x8120], 2)
    assert node.emcy.active[0].register & 0x11 == 0x11
    assert azimuth.state == "OPERATION ENABLED"
    send(ACTIVE)
    master.wait_until(lambda: node.emcy.active == [], 2)
    assert node.sdo[0x1001].raw == 0
    assert node.sdo[0x1003][1].raw & 0xFFFF == 0x8120


def test_bus_off_is_reported_when_the_bus_is_back(master, node):
    master.forget()
    send(BUS_OFF)
    time.sleep(0.2)  # no frame meanwhile: one would prove that bus off is over
    send(RESTARTED)
    assert [int.from_bytes(data[:2], "little") for data in master.wait_for(0x081, 2)] == [0x8140, 0]
    # 0x1029:1 has its default: a communication error ends OPERATIONAL.
    master.wait_for_state(127)
    assert node.sdo[0x1003][1].raw & 0xFFFF == 0x8140
    assert node.sdo[0x1000].raw == 0xFFFF0192


def test_traffic_proves_that_bus_off_is_over_where_the_driver_does_not_say_so(master, node):
    master.forget()
    send(BUS_OFF)
    send("123#00")
    assert master.wait_for(0x081)[0][:2] == b"\x40\x81"


def test_interface_that_went_down_is_taken_up_again(bench, master, connect):
    master.close()
    subprocess.run(["ip", "link", "set", "vcan0", "down"], check=True)
    time.sleep(0.5)
    subprocess.run(["ip", "link", "set", "vcan0", "up"], check=True)
    again = connect()
    again.wait_for_state(127)
    assert again.number(0x1003, 1) & 0xFFFF == 0x8140
    bench.close()  # its master has left
