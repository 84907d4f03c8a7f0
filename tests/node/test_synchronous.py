"""A master like ros2_canopen: boots the node by SDO, maps all its objects into synchronous PDOs, and drives both axes
by them.

Controlword and targets take effect at the following SYNC, actual values come with each SYNC. Halt (bit 8) is set
while there is no target, in every state.
"""

import math
import struct
import threading
import time

import pytest

from drive import CSP, CSV, STATES, micro_rad

PERIOD_S = 0.01
HALT = 0x100
TRANSITIONS = ((0x06, "READY TO SWITCH ON"), (0x07, "SWITCHED ON"), (0x0F, "OPERATION ENABLED"))


class Channel:
    """One axis of the master: sent values, and those received with the last SYNC."""

    def __init__(self):
        self.controlword, self.mode, self.position, self.velocity = HALT, 0, 0, 0
        self.statusword = self.display = self.actual_position = self.actual_velocity = 0
        self.seen = 0
        self.start = 0

    @property
    def state(self):
        return next((name for name, (mask, value) in STATES.items() if self.statusword & mask == value), None)


class SyncMaster:
    """SYNC every 10 ms, then the RPDOs that the next SYNC puts into effect."""

    def __init__(self, node):
        self.node = node
        self.channels = [Channel(), Channel()]
        self.syncs = 0
        self.path = None  # time in s -> (position offset, velocity) of both axes
        self.path_start = 0.0
        self.running = False
        self.thread = threading.Thread(target=self.run)
        self.boot()
        self.map_pdos()
        node.network.subscribe(0x281, lambda _id, data, _time: self.take(0, data))
        node.network.subscribe(0x381, lambda _id, data, _time: self.take(1, data))

    def boot(self):
        assert self.node.sdo[0x1000].raw & 0xFFFF == 402
        assert all(self.node.sdo[0x1018][sub].raw is not None for sub in range(1, 5))

    def map_pdos(self):
        """Per axis RPDO: controlword, mode, target of position. RPDO 3: both velocities. TPDO: measured values."""
        self.node.tpdo.read()
        self.node.rpdo.read()
        for n, shift in ((1, 0), (2, 0x800)):
            self.remap(self.node.rpdo[n], [0x6040 + shift, 0x6060 + shift, 0x607A + shift])
            self.remap(self.node.tpdo[n + 1], [0x6041 + shift, 0x6061 + shift, 0x6064 + shift])
            self.node.sdo[0x60C2 + shift][1].raw = round(1000 * PERIOD_S)
        self.remap(self.node.rpdo[3], [0x60FF, 0x68FF])
        self.remap(self.node.tpdo[4], [0x606C, 0x686C])
        for n in (1,):
            self.node.tpdo[n].enabled = False
            self.node.tpdo[n].save()

    @staticmethod
    def remap(pdo, objects):
        pdo.clear()
        for index in objects:
            pdo.add_variable(index)
        pdo.trans_type, pdo.enabled = 1, True
        pdo.save()

    def take(self, axis, data):
        channel = self.channels[axis]
        channel.statusword, channel.display, channel.actual_position = struct.unpack("<Hbi", data)
        channel.seen += 1

    def send_targets(self):
        for axis, channel in enumerate(self.channels):
            if self.path is not None:
                offset, channel.velocity = self.path(time.monotonic() - self.path_start)
                channel.position = round(channel.start + offset)
            data = struct.pack("<Hbi", channel.controlword, channel.mode, channel.position)
            self.node.network.send_message(0x201 + 0x100 * axis, data)
        self.node.network.send_message(0x401, struct.pack("<ii", *(round(c.velocity) for c in self.channels)))

    def run(self):
        next_sync = time.monotonic()
        while self.running:
            self.node.network.send_message(0x080, b"")
            self.syncs += 1
            self.send_targets()
            next_sync += PERIOD_S
            time.sleep(max(0.0, next_sync - time.monotonic()))

    def __enter__(self):
        self.running = True
        self.thread.start()
        return self

    def __exit__(self, *_):
        self.running = False
        self.thread.join()

    def wait(self, condition, timeout_s=2.0):
        end = time.monotonic() + timeout_s
        while not all(condition(channel) for channel in self.channels):
            assert time.monotonic() < end, [(c.state, c.display) for c in self.channels]
            time.sleep(PERIOD_S)

    def enable(self, mode):
        """Both axes by PDO alone, Halt set while moving; the target is the axis' position until the path begins."""
        for channel in self.channels:
            channel.mode = mode
        self.wait(lambda channel: channel.display == mode)
        for controlword, state in TRANSITIONS:
            for channel in self.channels:
                channel.position = channel.actual_position
                channel.controlword = controlword | HALT
            self.wait(lambda channel, state=state: channel.state == state)

    def follow(self, path, seconds):
        for channel in self.channels:
            channel.start = channel.position = channel.actual_position
        self.path, self.path_start = path, time.monotonic()
        for channel in self.channels:
            channel.controlword = 0x0F
        time.sleep(seconds)

    def disable(self):
        for channel in self.channels:
            channel.controlword = HALT
        self.wait(lambda channel: channel.state == "SWITCH ON DISABLED")


def tenth_micro_rad(degrees):
    return math.radians(degrees) * 1e7


@pytest.fixture
def master(node):
    with SyncMaster(node) as running:
        running.wait(lambda channel: channel.seen > 5)
        yield running
        running.disable()


def test_csp_on_both_axes_follows_positions_that_come_with_sync(master, azimuth, pitch, report):
    master.enable(CSP)
    # 1 degree in 2 s, from rest to rest
    master.follow(lambda t: (tenth_micro_rad(0.5 * (1 - math.cos(math.pi * min(t, 2.0) / 2))), 0), 2.5)
    for channel in master.channels:
        assert channel.state == "OPERATION ENABLED"
        assert channel.actual_position - channel.start == pytest.approx(tenth_micro_rad(1.0), abs=tenth_micro_rad(0.01))
    seen = [channel.seen / master.syncs for channel in master.channels]
    report(f"{master.syncs} SYNCs, answered {seen[0]:.3f} and {seen[1]:.3f}")
    assert all(share == pytest.approx(1.0, abs=0.03) for share in seen)
    assert azimuth.get(0x603F) == pitch.get(0x603F) == 0


def test_csv_on_both_axes_follows_velocities_that_come_with_sync(master, azimuth, pitch):
    master.enable(CSV)
    master.follow(lambda t: (0, micro_rad(min(1.0, t))), 1.5)
    assert azimuth.mean_rate_deg_s() == pytest.approx(1.0, rel=0.03)
    assert pitch.mean_rate_deg_s() == pytest.approx(1.0, rel=0.03)
    master.follow(lambda t: (0, 0), 0.5)
    assert abs(azimuth.mean_rate_deg_s(0.2)) < 0.01


def test_targets_count_only_when_sync_comes(node, master, azimuth):
    master.enable(CSV)
    master.follow(lambda t: (0, micro_rad(1.0)), 1.0)
    master.running = False
    master.thread.join()
    for _ in range(50):
        master.send_targets()
        time.sleep(PERIOD_S)
    assert abs(azimuth.rate_deg_s) < 0.05  # without SYNC the set-points stop, and the axis stops
    assert azimuth.state == "OPERATION ENABLED"
    master.running = True
    master.thread = threading.Thread(target=master.run)
    master.thread.start()


def test_fault_is_reset_by_pdo_with_halt_set(node, master, azimuth):
    master.enable(CSP)
    node.nmt.state = "STOPPED"
    time.sleep(0.3)
    node.nmt.state = "OPERATIONAL"
    master.wait(lambda channel: channel.state == "FAULT")
    assert azimuth.get(0x603F) == 0x8100
    for channel in master.channels:
        channel.controlword = HALT
    time.sleep(3 * PERIOD_S)
    for channel in master.channels:
        channel.controlword = 0x80 | HALT
    master.wait(lambda channel: channel.state == "SWITCH ON DISABLED")
    master.enable(CSP)
