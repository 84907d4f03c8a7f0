# SPDX-License-Identifier: Apache-2.0
"""Homing of an axis in an unknown turn, with python-canopen's own homing()."""

import math

import pytest

pytestmark = pytest.mark.power_on  # azimuth is at 0

RESTRICTIONS, POSITION_UNKNOWN = (0x2061, 1), 2
HOMING = 0x6098
OPEN = 0x6E65706F


@pytest.fixture
def lost(master, node):
    """The azimuth at 0 with a travel of -279 to 361 degrees: it may be at 360 as well."""
    node.sdo[0x3040][1].raw = OPEN
    node.sdo[0x2060][10].raw = math.radians(361.0)
    master.wait_until(lambda: node.sdo[0x2061][1].raw & POSITION_UNKNOWN, 2)
    node.setup_402_state_machine()
    return node


def test_motion_excludes_the_other_turn(master, lost):
    lost.sdo[HOMING].raw = -2  # 0 becomes 6.8: 366.8 would be beyond the travel
    assert not lost.is_homed()
    assert lost.homing(timeout=30)
    assert lost.sdo[0x2061][1].raw == 0
    assert lost.is_homed()
    master.pass_time(1000)
    assert 6.0 < math.degrees(lost.sdo[0x6064].raw * 1e-7) < 9.0


@pytest.mark.parametrize("method", [35, 37])
def test_what_was_seen_is_confirmed(lost, method):
    lost.sdo[0x607C].raw = round(math.radians(355.0) * 1e7)
    lost.sdo[HOMING].raw = method
    assert lost.homing(timeout=10)
    assert lost.sdo[0x2061][1].raw == 0
    assert math.degrees(lost.sdo[0x6064].raw * 1e-7) == pytest.approx(360.0, abs=1.0)


def test_nothing_seen_is_an_error(lost):
    lost.sdo[HOMING].raw = 37
    assert not lost.homing(timeout=10)
    assert lost.sdo[0x6041].raw & 0x3400 == 0x2400
    assert lost.sdo[0x2061][1].raw & POSITION_UNKNOWN


def test_a_known_turn_is_home_at_once(node):
    node.setup_402_state_machine()
    node.sdo[HOMING].raw = -1
    before = node.sdo[0x6064].raw
    assert node.homing(timeout=5)
    assert abs(node.sdo[0x6064].raw - before) < 1e5
