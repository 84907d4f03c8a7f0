# SPDX-License-Identifier: Apache-2.0
"""Limits as a master sees them: moves towards the hard end of the travel, 607F = "no limit", limits in any order."""

import math

import canopen
import pytest
from axis import ACKNOWLEDGED, PP, PV

OPEN = 0x6E65706F
INTERNAL_LIMIT = 1 << 11
COUNTS_PER_RAD = 1e7


def unlock(node):
    node.sdo[0x3040][1].raw = OPEN


def confine(axis, room_rad):
    """Hard ends this far on either side of the axis' position, and no software limit before them."""
    here = axis.get(0x6064) / COUNTS_PER_RAD
    axis.set(0, 0x607D, 1)
    axis.set(0, 0x607D, 2)
    axis.set(here - room_rad, 0x2060, 9)
    axis.set(here + room_rad, 0x2060, 10)
    return here - room_rad, here + room_rad


def outwards(axis, mode, direction, rate, end_rad):
    axis.set(rate, 0x6081)
    axis.set(rate, 0x607F)
    axis.enable(mode)
    if mode == PP:
        axis.set(round((end_rad + 0.5 * direction) * COUNTS_PER_RAD), 0x607A)
        axis.command(0x1F)
        axis.wait_until(lambda: axis.get(0x6041) & ACKNOWLEDGED)
        axis.command(0x0F)
    else:
        axis.set(direction * rate, 0x60FF)


@pytest.mark.variants_on_image(2)
@pytest.mark.parametrize("mode", [PP, PV])
@pytest.mark.parametrize("rate", [100_000, 350_000, 1_000_000])
def test_a_move_to_the_hard_end_stops_inside_with_bit_11(master, node, azimuth, pitch, report, mode, rate):
    """12 tries with the other parameters: each ended in fault 8612, 0.3 to 3.8 mrad outside."""
    unlock(node)
    moves = []
    for axis, middle_deg in ((azimuth, 0.0), (pitch, 37.5)):  # between its end stops: it moves towards it
        direction = 1 if math.degrees(axis.get(0x6064) / COUNTS_PER_RAD) < middle_deg else -1
        ends = confine(axis, 0.25)
        moves.append((axis, direction, ends[1] if direction > 0 else ends[0]))
    for axis, direction, end in moves:  # limits change only while both axes are off
        outwards(axis, mode, direction, rate, end)
    master.pass_time(0.25e9 / rate + 2500)
    for axis, direction, end in moves:
        left_mrad = 1e3 * direction * (end - axis.get(0x6064) / COUNTS_PER_RAD)
        statusword = axis.get(0x6041)
        report(f"mode {mode}, {rate} urad/s: {left_mrad:.2f} mrad left")
        assert axis.get(0x603F) == 0
        assert axis.state == "OPERATION ENABLED"
        assert 0 < left_mrad < 7
        assert statusword & INTERNAL_LIMIT


def test_607f_of_ffffffff_is_no_limit_and_no_fault(azimuth):
    """The usual value for "no limit" caused fault 7300 at enable."""
    azimuth.set(0xFFFFFFFF, 0x607F)
    azimuth.turn(20.0)
    assert azimuth.get(0x603F) == 0
    assert azimuth.rate_deg_s == pytest.approx(20.0, abs=0.5)
    azimuth.set(0x7FFFFFFF, 0x60FF)
    azimuth.wait_until(lambda: azimuth.get(0x6041) & INTERNAL_LIMIT, 1)
    azimuth.wait_until(lambda: azimuth.rate_deg_s == pytest.approx(68.75, abs=1.0), 3)  # 80 % of 2060:1
    assert azimuth.state == "OPERATION ENABLED"
    azimuth.command(0x06)


@pytest.mark.parametrize("order", [(15, 16), (16, 15)])
def test_voltage_limits_are_written_in_either_order(node, azimuth, order):
    new = {15: 70.0, 16: 90.0}  # both above the former over-voltage limit of 60 V
    unlock(node)
    for sub in order:
        azimuth.set(new[sub], 0x2060, sub)
    assert {sub: azimuth.get(0x2060, sub) for sub in new} == new
    assert azimuth.get(0x2060, 18) == 0


def test_limits_that_contradict_each_other_wait_and_are_not_stored(master, node, azimuth):
    unlock(node)
    azimuth.set(60.5, 0x2060, 15)  # above the over-voltage limit
    assert azimuth.get(0x2060, 18) == 1
    with pytest.raises(canopen.SdoAbortedError) as refused:
        node.store(1)
    assert refused.value.code == 0x06040043
    azimuth.enable(PV)  # the former limits are in effect: with 60.5 V it would not switch on
    with pytest.raises(canopen.SdoAbortedError):
        azimuth.set(36.0, 0x2060, 15)  # it has torque
    azimuth.command(0x00)
    azimuth.wait_for_state("SWITCH ON DISABLED", 1)
    master.pass_time(10)
    azimuth.set(36.0, 0x2060, 15)
    assert azimuth.get(0x2060, 18) == 0
