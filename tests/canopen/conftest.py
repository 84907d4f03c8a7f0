# SPDX-License-Identifier: Apache-2.0
"""A test node on a bus of its own for each test, and python-canopen clients on that bus.

CANOPEN_TEST_NODE and PRINT_TEST_EDS name the two programs; CTest sets them.
"""

import logging
import os
import subprocess

import can
import canopen
import pytest
from servoctl.link.slcan_tcp import SlcanTcpBus  # python-can's own reads byte by byte

NODE_ID = 5

# The test machines are shared: an answer may be late without an error.
canopen.sdo.SdoClient.RESPONSE_TIMEOUT = 2.0


class TestNode:
    """The program canopen_test_node, and the address of its bus."""

    __test__ = False

    def __init__(self):
        self.process = subprocess.Popen(
            [os.environ["CANOPEN_TEST_NODE"], str(NODE_ID)],
            stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True,
        )
        ends = [self.process.stdout.readline().strip() for _ in range(2)]
        self.port = int(ends[0].rsplit(":", 1)[1])
        self.pty = ends[1].split(":", 1)[1]

    def open_bus(self, channel=None):
        if channel is None:
            return SlcanTcpBus("127.0.0.1", self.port)
        return can.Bus(interface="slcan", channel=channel, bitrate=1000000, sleep_after_open=0)

    def close(self):
        self.process.stdin.close()
        assert self.process.wait(timeout=10) == 0


@pytest.fixture(scope="session")
def eds(tmp_path_factory):
    path = tmp_path_factory.mktemp("eds") / "test_device.eds"
    path.write_bytes(subprocess.run([os.environ["PRINT_TEST_EDS"]], stdout=subprocess.PIPE, check=True).stdout)
    return str(path)


@pytest.fixture
def test_node():
    node = TestNode()
    yield node
    node.close()


@pytest.fixture
def connect(test_node, eds):
    """Makes clients: each is a network with the node in it."""
    networks = []

    def make(channel=None):
        network = canopen.Network(bus=test_node.open_bus(channel))
        network.connect()
        network.add_node(NODE_ID, eds)
        networks.append(network)
        return network

    yield make
    for network in networks:
        network.disconnect()


@pytest.fixture
def network(connect):
    return connect()


@pytest.fixture
def node(network):
    node = network[NODE_ID]
    node.nmt.wait_for_heartbeat(timeout=2)
    return node


@pytest.fixture(autouse=True)
def no_warnings(caplog):
    yield
    loud = [r.getMessage() for r in caplog.records if r.levelno >= logging.WARNING and r.name.startswith("canopen")]
    expected = [m for m in loud if "Transfer aborted" in m or "Data size has not been specified" in m]
    assert loud == expected
