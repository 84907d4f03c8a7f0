# SPDX-License-Identifier: Apache-2.0
"""What the node does when its master falls silent: 6007, and the heartbeat consumer 1016."""

import json

import pytest
from axis import PP, Axis, micro_rad
from device import NODE_ID, REAL_TIME

SLOW = micro_rad(2.0)
EMERGENCY = 0x80 + NODE_ID
PEER = 0x7E
NODE_ITSELF, AZIMUTH, PITCH = range(3)  # sources of an emergency, byte 4 of its message


@pytest.fixture
def supervised(master):
    """Azimuth as delivered: 6007 is 3, stop without a fault."""
    master.start()
    return Axis(master, 0)


def turn(axis):
    axis.switch_on(3)
    axis.set(SLOW, 0x60FF)
    axis.master.forget()


@pytest.mark.smoke
@pytest.mark.parametrize("shift", [0, 0x800], ids=["azimuth", "pitch"])
def test_an_axis_stops_without_a_fault_when_its_master_is_silent_for_1_s(master, descriptions, shift):
    faults = json.loads((descriptions / "faults.json").read_text())["faults"]
    number = next(fault["number"] for fault in faults if fault["name"] == "master silent")
    master.start()
    axis = Axis(master, shift)
    turn(axis)
    master.be_silent(8)
    assert master.heard(EMERGENCY) == []
    master.be_silent(16)
    (emergency,) = master.heard(EMERGENCY)
    assert emergency[:2] == b"\x01\x81" and tuple(emergency[3:5]) == (number, AZIMUTH if shift == 0 else PITCH)
    assert axis.state == "SWITCH ON DISABLED" and axis.get(0x6041) & 0x80
    assert axis.get(0x603F) == 0 and abs(axis.rate_deg_s) < 0.3
    turn(axis)
    axis.wait_until(lambda: axis.get(0x6041) & 0x80 == 0)
    assert axis.state == "OPERATION ENABLED"


@pytest.mark.speed(REAL_TIME)
def test_a_master_that_speaks_keeps_the_axis_turning(master, supervised):
    turn(supervised)
    master.pass_time(2500)
    assert supervised.state == "OPERATION ENABLED"
    assert supervised.rate_deg_s == pytest.approx(2.0, abs=0.2)


def test_6007_of_0_lets_the_axis_turn_on(master, supervised):
    supervised.set(0, 0x6007)
    turn(supervised)
    master.be_silent(25)
    assert supervised.state == "OPERATION ENABLED"
    assert supervised.rate_deg_s == pytest.approx(2.0, abs=0.2)


def test_6007_of_1_is_a_fault(master, supervised):
    supervised.set(1, 0x6007)
    turn(supervised)
    master.be_silent(20)
    assert supervised.get(0x603F) == 0x8101 and supervised.state in ("FAULT", "FAULT REACTION ACTIVE")


def test_a_move_by_pp_stops_before_its_target(master, supervised):
    start = supervised.angle_deg
    supervised.set(SLOW, 0x6081)
    supervised.set(supervised.get(0x6064) + 3490659, 0x607A)  # 20 deg
    supervised.switch_on(PP)
    supervised.command(0x1F)
    master.be_silent(25)
    assert 1.0 < supervised.angle_deg - start < 4.5 and supervised.state == "SWITCH ON DISABLED"


def beat(master, seconds):
    """Heartbeats of the peer, each with a heartbeat of the node: every 100 ms by its own clock, and nothing else."""
    for _ in range(round(10 * seconds)):
        master.send(0x700 + PEER, 5)
        master.be_silent(1)


def test_a_heartbeat_keeps_the_axis_turning_and_its_loss_is_a_fault_that_ends_with_it(master, azimuth, pitch, report):
    azimuth.set(3, 0x6007)
    turn(azimuth)
    azimuth.node.emcy.log.clear()
    azimuth.node.sdo[0x1016][1].raw = PEER << 16 | 1000
    beat(master, 2.5)
    assert azimuth.state == "OPERATION ENABLED"
    assert azimuth.rate_deg_s == pytest.approx(2.0, abs=0.2)
    master.forget()
    master.wait_for(EMERGENCY)
    silent = len(master.heard(0x700 + NODE_ID))
    report(f"8130 with heartbeat {silent} of the node after the last one of its master")
    assert 9 <= silent <= 11
    azimuth.wait_for_state("FAULT", 1)
    azimuth.wait_for_standstill(0.3)
    assert (azimuth.get(0x606B), azimuth.get(0x603F), pitch.get(0x603F)) == (0, 0x8130, 0x8130)
    master.wait_for_state(127)
    assert {(error.data[1], error.code) for error in azimuth.node.emcy.log} == {
        (NODE_ITSELF, 0x8130), (AZIMUTH, 0x8130), (PITCH, 0x8130)}
    assert master.number(0x1003, 1) & 0xFFFF == 0x8130
    azimuth.node.sdo[0x1016][1].raw = 0
    azimuth.node.sdo[0x1016][1].raw = PEER << 16 | 5000
    master.send(0x700 + PEER, 5)
    master.wait_until(lambda: master.number(0x1001) == 0x11)  # the master is back, the axes are in fault
    master.start()
    for axis in azimuth, pitch:
        axis.command(0)
        axis.command(0x80)
    azimuth.wait_for_state("SWITCH ON DISABLED")
    assert azimuth.get(0x603F) == 0
    azimuth.turn(1.0)
    assert azimuth.mean_rate_deg_s() == pytest.approx(1.0, rel=0.03)
    assert master.number(0x1001) == 0 and azimuth.node.emcy.active == []
