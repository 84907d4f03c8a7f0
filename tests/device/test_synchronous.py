# SPDX-License-Identifier: Apache-2.0
"""A master like ros2_canopen: boots the node by SDO, maps all its objects into synchronous PDOs, and drives both axes
by them.

Controlword and targets take effect at the following SYNC, actual values come with each SYNC. Halt (bit 8) is set
while there is no target, in every state.
"""

import math
import struct

import pytest
from axis import CSP, CSV, HALT, micro_rad, state_of, tenth_micro_rad
from device import REAL_TIME

PERIOD_MS = 100  # the node waits for three: a busy computer may be late
TRANSITIONS = ((0x06, "READY TO SWITCH ON"), (0x07, "SWITCHED ON"), (0x0F, "OPERATION ENABLED"))
pytestmark = pytest.mark.speed(0.5 * REAL_TIME)


class Channel:
    """One axis of the master: sent values, and those received with the last SYNC."""

    def __init__(self):
        self.controlword, self.mode, self.position, self.velocity = HALT, 0, 0, 0
        self.statusword = self.display = self.actual_position = self.actual_velocity = 0
        self.seen = 0
        self.start = 0

    @property
    def state(self):
        return state_of(self.statusword)


class SyncMaster:
    """SYNC every period of the node, then the RPDOs that the next SYNC puts into effect."""

    def __init__(self, master):
        self.master, self.node = master, master.node
        self.channels = [Channel(), Channel()]
        self.syncs = 0
        self.path = None  # time in s -> (position offset, velocity) of both axes
        self.path_cycles = 0
        self.with_sync = True
        self.boot()
        self.map_pdos()
        self.node.network.subscribe(0x281, lambda _id, data, _time: self.take(0, data))
        self.node.network.subscribe(0x381, lambda _id, data, _time: self.take(1, data))

    def cycle(self):
        if self.with_sync:
            self.node.network.send_message(0x080, b"")
            self.syncs += 1
        self.send_targets()

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
            self.node.sdo[0x60C2 + shift][1].raw = PERIOD_MS
        self.remap(self.node.rpdo[3], [0x60FF, 0x68FF])
        self.remap(self.node.tpdo[4], [0x606C, 0x686C])
        self.node.tpdo[1].enabled = False
        self.node.tpdo[1].save()

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
                offset, channel.velocity = self.path(1e-3 * PERIOD_MS * self.path_cycles)
                channel.position = round(channel.start + offset)
            data = struct.pack("<Hbi", channel.controlword, channel.mode, channel.position)
            self.node.network.send_message(0x201 + 0x100 * axis, data)
        self.path_cycles += 1
        self.node.network.send_message(0x401, struct.pack("<ii", *(round(c.velocity) for c in self.channels)))

    def wait(self, condition, within_s=2.0):
        self.master.wait_until(lambda: all(condition(channel) for channel in self.channels), within_s)

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
        self.path, self.path_cycles = path, 0
        for channel in self.channels:
            channel.controlword = 0x0F
        self.master.pass_time(1000 * seconds)

    def disable(self):
        for channel in self.channels:
            channel.controlword = HALT
        self.wait(lambda channel: channel.state == "SWITCH ON DISABLED")


@pytest.fixture
def ros2(master, node):
    running = SyncMaster(master)
    with master.every(PERIOD_MS, running.cycle):
        running.wait(lambda channel: channel.seen > 5)
        yield running
        running.disable()


def test_csp_on_both_axes_follows_positions_that_come_with_sync(ros2, azimuth, pitch, report):
    ros2.enable(CSP)
    # 1 degree in 2 s, from rest to rest
    ros2.follow(lambda t: (tenth_micro_rad(0.5 * (1 - math.cos(math.pi * min(t, 2.0) / 2))), 0), 2.5)
    for channel in ros2.channels:
        assert channel.state == "OPERATION ENABLED"
        assert channel.actual_position - channel.start == pytest.approx(tenth_micro_rad(1.0), abs=tenth_micro_rad(0.01))
    seen = [channel.seen / ros2.syncs for channel in ros2.channels]
    report(f"{ros2.syncs} SYNCs, answered {seen[0]:.3f} and {seen[1]:.3f}")
    assert all(share == pytest.approx(1.0, abs=0.03) for share in seen)
    assert azimuth.get(0x603F) == pitch.get(0x603F) == 0


def test_csv_on_both_axes_follows_velocities_that_come_with_sync_only(ros2, azimuth, pitch):
    ros2.enable(CSV)
    ros2.follow(lambda t: (0, micro_rad(min(1.0, t))), 1.5)
    assert azimuth.mean_rate_deg_s() == pytest.approx(1.0, rel=0.03)
    assert pitch.mean_rate_deg_s() == pytest.approx(1.0, rel=0.03)
    ros2.with_sync = False
    azimuth.wait_for_standstill(1)  # without SYNC the set-points stop, and the axis stops
    assert azimuth.state == "OPERATION ENABLED"
    ros2.with_sync = True
    ros2.wait(lambda channel: channel.state == "OPERATION ENABLED")


def test_fault_is_reset_by_pdo_with_halt_set(master, ros2, azimuth):
    ros2.enable(CSP)
    master.node.nmt.state = "STOPPED"
    master.wait_for_state(4)
    master.start()
    ros2.wait(lambda channel: channel.state == "FAULT")
    assert azimuth.get(0x603F) == 0x8100
    for channel in ros2.channels:
        channel.controlword = HALT
    master.pass_time(3 * PERIOD_MS)
    for channel in ros2.channels:
        channel.controlword = 0x80 | HALT
    ros2.wait(lambda channel: channel.state == "SWITCH ON DISABLED")
    ros2.enable(CSP)
