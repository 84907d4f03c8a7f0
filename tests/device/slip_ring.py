# SPDX-License-Identifier: Apache-2.0
"""The azimuth of a tracker with a slip ring: no end stops, and a position that wraps at 32 turns (607B)."""

import contextlib
import math

import pytest
from axis import Axis, micro_rad
from device import DEVICES, PROJECT
from master import Master

OPEN = 0x6E65706F
TURN = 2e7 * math.pi
RANGE_TURNS = 64
DEG_S = 60


@contextlib.contextmanager
def endless_axis(kind, speed, folder):
    """Its travel is not removed yet."""
    plant = folder / "endless.toml"
    text = (PROJECT / "sim_host/plants/tracker.toml").read_text()
    for line in ("end_stops_deg = [-280.0, 280.0]\n", "cable_stiffness_nm_rad = 0.1\n"):
        assert line in text
        text = text.replace(line, "", 1)
    plant.write_text(text)
    served = DEVICES[kind]("slcan-tcp:0", speed, "--plant", str(plant))
    master = Master(served.open_bus())
    master.start()
    master.node.sdo[0x3040][1].raw = OPEN
    axis = Axis(master, 0)
    axis.set(micro_rad(DEG_S + 5), 0x607F)
    axis.set(micro_rad(DEG_S), 0x6081)
    yield axis
    master.close()
    served.close()


def wrapped(counts):
    """As 6064 shows it."""
    return (counts / TURN + RANGE_TURNS / 2) % RANGE_TURNS * TURN - RANGE_TURNS / 2 * TURN


def remove_the_travel(axis):
    for index, sub, value in ((0x607D, 1, 0), (0x607D, 2, 0), (0x2060, 9, 0.0), (0x2060, 10, 0.0), (0x2060, 21, 1.0)):
        axis.set(value, index, sub)
    axis.wait_until(lambda: [axis.get(0x607B, sub) for sub in (1, 2)] == [-2010619298, 2010619298])


def be_seen_31_turns_away(axis, side):
    """It may be there by its travel, and has been seen there (2061:5): the way there in no time."""
    axis.set(side * 200.0, 0x2060, 10 if side > 0 else 9)
    axis.wait_until(lambda: axis.get(0x2061, 1) & 2)
    axis.set(side * 31, 0x2061, 5)
    axis.wait_until(lambda: axis.get(0x2061, 1) == 0)
    assert axis.get(0x6064) / TURN == pytest.approx(side * 31, abs=0.01)
