# SPDX-License-Identifier: Apache-2.0
"""A full bus leaves the axis alone: foreign frames, and frames on the node's own identifiers that mean nothing."""

import re
import select
import signal
import socket
import struct
import threading
import time

import pytest
from axis import TPDO8, Axis, micro_rad
from master import DEAD_S, Master

pytestmark = pytest.mark.simulator
HEARTBEAT, EMERGENCY = 0x701, 0x081
SECONDS = 2


class Listener:
    """Reads SLCAN faster than python-can, for a bus that is full."""

    def __init__(self, address):
        self.socket = socket.create_connection(address)
        self.socket.sendall(b"C\rS8\rL\r")

    def listen(self, heartbeats):
        """Frames by identifier until so many heartbeats of the node have come: one every 100 ms by its own clock."""
        text, end, searched, left = bytearray(), time.monotonic() + DEAD_S, 0, heartbeats
        while left > 0:
            assert time.monotonic() < end, "no heartbeats"
            if select.select([self.socket], [], [], 0.1)[0]:
                text += self.socket.recv(1 << 16)
            while left > 0 and (found := text.find(b"t7011", searched)) >= 0:
                searched, left = found + 1, left - 1
        frames = {}
        for line in re.findall(rb"t([0-9A-F]{3})[0-8]([0-9A-F]*)\r", bytes(text)):
            frames.setdefault(int(line[0], 16), []).append(bytes.fromhex(line[1].decode()))
        return frames

    def close(self):
        self.socket.close()


class Flood:
    """Keeps the bus full until closed."""

    def __init__(self, address, lines):
        self.socket = socket.create_connection(address)
        self.socket.sendall(b"C\rS8\rO\r")
        self.lines = b"".join(lines) * 20
        self.running = True
        self.thread = threading.Thread(target=self.run)
        self.thread.start()

    def run(self):
        self.socket.setblocking(False)
        waiting = b""
        while self.running:
            waiting = waiting or self.lines
            readable, writable, _ = select.select([self.socket], [self.socket], [], 0.1)
            if readable:
                self.socket.recv(1 << 16)
            if writable:
                waiting = waiting[self.socket.send(waiting):]

    def close(self):
        self.running = False
        self.thread.join()
        self.socket.close()


@pytest.fixture
def flooded(serve):
    """Frames by identifier while azimuth turns at 1 deg/s and the bus is full of other frames."""

    def run(lines):
        served = serve("--speed", "1").wait_until_ready()
        master = Master(served.open_bus())
        azimuth = Axis(master, 0)
        master.start()
        azimuth.turn(1.0)
        assert master.sample(TPDO8, [0x30100120, 0x606C0020]) == 0x6A4
        master.close()  # python-can could not read that fast
        listener, flood = Listener(served.tcp), Flood(served.tcp, lines)
        try:
            listener.listen(5)
            return listener.listen(10 * SECONDS)
        finally:
            flood.close()
            listener.close()

    return run


def expect_an_undisturbed_axis(heard):
    ticks_ms, rates = zip(*(struct.unpack("<Ll", frame) for frame in heard[0x6A4]), strict=True)
    assert {later - earlier for earlier, later in zip(ticks_ms, ticks_ms[1:])} == {20}  # none is lost, none is late
    assert len(heard[HEARTBEAT]) == pytest.approx((ticks_ms[-1] - ticks_ms[0]) / 100, abs=1)
    assert set(heard[HEARTBEAT]) == {b"\5"}
    assert sum(rates) / len(rates) == pytest.approx(micro_rad(1.0), rel=0.03)
    assert max(abs(rate - micro_rad(1.0)) for rate in rates) < micro_rad(0.1)


def test_full_bus_of_foreign_frames_leaves_axis_and_heartbeat_alone(flooded, report):
    heard = flooded([b"t%03X8%016X\r" % (0x702 + i, i * 0x1122334455667788 % (1 << 64)) for i in range(0xFD)])
    foreign = sum(len(frames) for cob_id, frames in heard.items() if cob_id > HEARTBEAT)
    report(f"flood: {foreign / SECONDS:.0f} foreign frames per second of the node")
    assert foreign / SECONDS > 2000
    expect_an_undisturbed_axis(heard)
    assert EMERGENCY not in heard


def test_flood_of_the_nodes_own_identifiers_does_not_stop_the_axis(flooded, report):
    """Wrong lengths on RPDOs, unknown NMT commands, SDO frames without meaning, heartbeats of others."""
    heard = flooded([b"t2010\r", b"t201100\r", b"t00027F01\r", b"t000101\r", b"t6014FFFFFFFF\r",
                     b"t6018FFFFFFFFFFFFFFFF\r", b"t08020000\r", b"t77F105\r", b"t40145500AA00\r"])
    report(f"own identifiers: {sum(map(len, heard.values())) / SECONDS:.0f} frames per second of the node")
    assert len(heard[0x77F]) / SECONDS > 200
    expect_an_undisturbed_axis(heard)


def test_frames_of_a_client_that_leaves_at_once_reach_the_node(serve):
    """150 frames and NMT start while the server is busy elsewhere: the connection is gone before it looks."""
    served = serve("--speed", "1").wait_until_ready()
    served.process.send_signal(signal.SIGSTOP)
    with socket.create_connection(served.tcp) as client:
        client.sendall(b"C\rS8\rO\r" + 150 * b"t7FF0\r" + b"t00020101\rC\r")
    served.process.send_signal(signal.SIGCONT)
    master = Master(served.open_bus())
    master.wait_for_state(5)
    master.close()
    served.close()
