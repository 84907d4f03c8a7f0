"""An axis without end stops beyond the range of its position: the encoder says where it is, 6064 by whole turns."""

import math
import struct

import pytest
from axis import ACKNOWLEDGED, ENABLE, NEW_SETPOINT, PP, PV, TARGET_REACHED, TPDO8, Axis, micro_rad, tenth_micro_rad
from device import PROJECT, Served
from master import Master

OPEN = 0x6E65706F
RELATIVE = 0x40
TURN = 2e7 * math.pi
DEG_S = 60
SPEED = 100

pytestmark = pytest.mark.simulator


@pytest.fixture
def endless(tmp_path):
    """The azimuth of a tracker with a slip ring, at many times real time."""
    plant = tmp_path / "endless.toml"
    text = (PROJECT / "sim_host/plants/tracker.toml").read_text()
    for line in ("end_stops_deg = [-280.0, 280.0]\n", "cable_stiffness_nm_rad = 0.1\n"):
        assert line in text
        text = text.replace(line, "", 1)
    plant.write_text(text)
    served = Served("slcan-tcp:0", "--plant", str(plant), "--speed", str(SPEED)).wait_until_ready()
    master = Master(served.open_bus())
    master.start()
    master.node.sdo[0x3040][1].raw = OPEN
    axis = Axis(master, 0)
    for index, sub, value in ((0x607D, 1, 0), (0x607D, 2, 0), (0x2060, 9, 0.0), (0x2060, 10, 0.0), (0x2060, 21, 1.0)):
        axis.set(value, index, sub)
    axis.set(micro_rad(DEG_S + 5), 0x607F)
    axis.set(micro_rad(DEG_S), 0x6081)
    yield axis
    master.close()
    served.close()


def true_counts(axis):
    """The turns that the encoder has made are counted from its 2^-32 turn, every 20 ms."""
    master, seen = axis.master, []
    identifier = master.sample(TPDO8, [0x21010420, 0x60640020])

    def hear(_identifier, data, _time):
        angle, position = struct.unpack("<Ll", data)
        turns = angle / 2**32 if not seen else seen[-1][0] + ((angle / 2**32 - seen[-1][0] + 0.5) % 1.0 - 0.5)
        seen.append((turns, position))

    master.network.subscribe(identifier, hear)
    return seen


def test_6064_is_the_true_angle_modulo_64_turns_and_moves_are_as_ordered(endless):
    assert [endless.get(0x607B, sub) for sub in (1, 2)] == [-2010619298, 2010619298]
    seen = true_counts(endless)
    endless.enable(PV)
    endless.set(micro_rad(-DEG_S), 0x60FF)
    endless.wait_until(lambda: abs(seen[-1][0]) > 34.5, 400)
    endless.set(0, 0x60FF)
    endless.wait_for_standstill(5)
    offset = round(seen[0][0] - seen[0][1] / TURN)
    for turns, position in seen:
        away = (position / TURN - (turns - offset) + 32) % 64 - 32
        assert abs(away) * TURN < 2 or abs(abs(away) - 64) * TURN < 2
    endless.set(PP, 0x6060)
    endless.wait_until(lambda: endless.get(0x6061) == PP)
    before = seen[-1][0]
    endless.set(tenth_micro_rad(-10), 0x607A)
    endless.command(ENABLE | NEW_SETPOINT | RELATIVE)
    endless.wait_until(lambda: endless.get(0x6041) & ACKNOWLEDGED)
    endless.command(ENABLE)
    endless.wait_until(lambda: endless.get(0x6041) & TARGET_REACHED, 5)
    endless.master.pass_time(200)
    assert 360 * (seen[-1][0] - before) == pytest.approx(-10, abs=0.05)
