# SPDX-License-Identifier: Apache-2.0
"""CiA 402: the power state machine by SDO and by PDO, stops and halt, with the masks of python-canopen's own profile."""

import struct

import pytest
from axis import ENABLE, HALT, NEW_SETPOINT, PP, PV, TARGET_REACHED, Axis, state_of, tenth_micro_rad
from device import NODE_ID, REAL_TIME

NMT_START, NMT_STOP = 1, 2
STOPPED, OPERATIONAL = 4, 5
AXES = pytest.mark.parametrize("shift", [0, 0x800], ids=["azimuth", "pitch"])


@pytest.fixture
def axis(node, master, shift):
    """Either axis, in operational."""
    return Axis(master, shift)


@pytest.fixture
def turning(axis):
    axis.turn(2.0, settle_s=0)
    axis.wait_until(lambda: abs(axis.rate_deg_s - 2.0) < 0.2)
    return axis


@AXES
def test_starts_in_switch_on_disabled_without_torque(axis):
    axis.wait_for_state("SWITCH ON DISABLED")
    assert not axis.get(0x6041) & TARGET_REACHED or axis.get(0x6061) == 0


TRANSITIONS = {
    "shutdown": ([], 0x06, "READY TO SWITCH ON"),
    "switch on": ([0x06], 0x07, "SWITCHED ON"),
    "enable operation": ([0x06, 0x07], 0x0F, "OPERATION ENABLED"),
    "switch on and enable at once": ([0x06], 0x0F, "OPERATION ENABLED"),
    "disable operation": ([0x06, 0x07, 0x0F], 0x07, "SWITCHED ON"),
    "shutdown from operation": ([0x06, 0x07, 0x0F], 0x06, "READY TO SWITCH ON"),
    "disable voltage from operation": ([0x06, 0x07, 0x0F], 0x00, "SWITCH ON DISABLED"),
    "disable voltage from switched on": ([0x06, 0x07], 0x00, "SWITCH ON DISABLED"),
    "shutdown from switched on": ([0x06, 0x07], 0x06, "READY TO SWITCH ON"),
    "quick stop from ready": ([0x06], 0x02, "SWITCH ON DISABLED"),
    "halt changes no state": ([0x06, 0x07, 0x0F], 0x010F, "OPERATION ENABLED"),
}


@AXES
@pytest.mark.parametrize("commands, controlword, expected", TRANSITIONS.values(), ids=TRANSITIONS)
def test_6040_transition(axis, commands, controlword, expected):
    names = {0x06: "READY TO SWITCH ON", 0x07: "SWITCHED ON", 0x0F: "OPERATION ENABLED"}
    axis.wait_for_state("SWITCH ON DISABLED")
    axis.set(PV, 0x6060)
    for word in commands:
        axis.command(word)
        axis.wait_for_state(names[word])
    axis.command(controlword)
    axis.wait_for_state(expected)


@pytest.mark.smoke
@pytest.mark.speed(0.5 * REAL_TIME)
def test_a_controlword_by_sdo_does_not_overtake_one_by_pdo(master, azimuth):
    """07 by RPDO1 and at once 06 by SDO: switched on, then ready; in the other order the axis would end switched on."""
    azimuth.set(0, 0x605C)  # disable operation at once
    azimuth.set(PV, 0x6060)
    for _ in range(10):
        for word, state in ((0x06, "READY TO SWITCH ON"), (0x07, "SWITCHED ON"), (0x0F, "OPERATION ENABLED")):
            azimuth.command(word)
            azimuth.wait_for_state(state)
        master.send(0x200 + NODE_ID, 0x07, 0x00, PV)
        azimuth.command(0x06)
        master.pass_time(20)
        assert azimuth.state == "READY TO SWITCH ON"


ENDS = {0: "SWITCH ON DISABLED", 1: "SWITCH ON DISABLED", 2: "SWITCH ON DISABLED", 5: "QUICK STOP ACTIVE", 6: "QUICK STOP ACTIVE"}


@pytest.mark.parametrize("words", [[0x02, 0x8F], [ENABLE | HALT, 0x02, 0x8F]], ids=["quick stop", "halt and quick stop"])
@pytest.mark.parametrize("option", [0, 1, pytest.param(2, marks=pytest.mark.smoke), 5, 6])
def test_605a_a_stop_is_not_undone_by_a_word_of_the_same_tick(azimuth, master, option, words):
    azimuth.set(option, 0x605A)
    azimuth.turn(5.0)
    for word in words:  # RPDO1 back to back
        master.send(0x200 + NODE_ID, *word.to_bytes(2, "little"), PV)
    azimuth.wait_for_state(ENDS[option])
    azimuth.wait_for_standstill()
    assert azimuth.state == ENDS[option]


@pytest.mark.parametrize("synchronous", [False, True])
def test_a_weaker_stop_of_the_same_tick_does_not_undo_a_stop(azimuth, master, synchronous):
    """A halt after a quick stop, in a frame that is too short, or replaced before the SYNC; then 0F."""
    if synchronous:
        master.write(0x1400, 2, 1, 1)
    azimuth.turn(5.0)
    for word, mode in ((0x02, [PV]), (ENABLE | HALT, [PV] if synchronous else []), (ENABLE, [PV])):
        master.send(0x200 + NODE_ID, *word.to_bytes(2, "little"), *mode)
    if synchronous:
        master.send(0x80)
    azimuth.wait_for_state("SWITCH ON DISABLED")
    azimuth.wait_for_standstill()
    assert azimuth.state == "SWITCH ON DISABLED"


def test_an_nmt_stop_is_not_undone_by_a_start_of_the_same_tick(azimuth, master):
    azimuth.turn(5.0)
    for command in (NMT_STOP, NMT_START):
        master.send(0, command, NODE_ID)
    master.wait_for_state(OPERATIONAL)
    azimuth.wait_for_state("FAULT")
    azimuth.wait_for_standstill()
    assert azimuth.get(0x603F) == 0x8100


def test_edges_of_bits_4_and_7_within_a_tick_count(azimuth, master):
    """RPDO1 back to back: 80 and 00 reset a fault, 1F and 0F give a set-point. The words before and after are the same."""
    azimuth.switch_on(PP)
    master.node.nmt.send_command(NMT_STOP)
    master.wait_for_state(STOPPED)
    master.start()
    azimuth.wait_for_state("FAULT")
    azimuth.command(0x00)
    master.pass_time(20)
    for word in (0x80, 0x00):
        master.send(0x200 + NODE_ID, word, 0x00, PP)
    azimuth.wait_for_state("SWITCH ON DISABLED")
    azimuth.enable(PP)
    target = azimuth.get(0x6064) + tenth_micro_rad(1.0)
    azimuth.set(target, 0x607A)
    for word in (ENABLE | NEW_SETPOINT, ENABLE):
        master.send(0x200 + NODE_ID, word, 0x00, PP)
    azimuth.wait_until(lambda: azimuth.get(0x6062) == target, 5)


@AXES
def test_6040_enable_operation_from_switch_on_disabled_does_nothing(axis, master):
    axis.command(ENABLE)
    master.pass_time(50)
    assert axis.state == "SWITCH ON DISABLED"


@AXES
def test_605d_halt_stops_and_lets_go_on(turning):
    turning.command(ENABLE | HALT)
    turning.wait_until(lambda: abs(turning.rate_deg_s) < 0.05 and turning.get(0x6041) & TARGET_REACHED)
    assert turning.state == "OPERATION ENABLED"
    assert turning.mean_rate_deg_s(0.2) == pytest.approx(0.0, abs=0.02)
    turning.command(ENABLE)
    turning.wait_until(lambda: abs(turning.rate_deg_s - 2.0) < 0.2)


@AXES
def test_605a_6_quick_stop_holds_and_16_goes_on(turning):
    turning.set(6, 0x605A)
    turning.command(0x0B)
    turning.wait_for_state("QUICK STOP ACTIVE")
    turning.wait_for_standstill(0.5)
    assert turning.state == "QUICK STOP ACTIVE"
    turning.command(ENABLE)
    turning.wait_for_state("OPERATION ENABLED")
    turning.wait_until(lambda: abs(turning.rate_deg_s - 2.0) < 0.2)


@AXES
def test_quick_stop_ends_with_the_axis_off(turning):
    turning.command(0x02)
    turning.wait_for_state("SWITCH ON DISABLED", 0.5)
    turning.wait_for_standstill(0.3)  # friction removes the rest of the loop's lag


@AXES
def test_nmt_stop_takes_the_torque_away_and_a_fault_reset_needs_a_rising_edge(master, axis):
    axis.switch_on(PV)
    for _ in range(2):  # the second time the bit is still set: it must not reset by its level
        master.node.nmt.send_command(0x02)
        master.wait_for_state(4)
        master.start()
        axis.wait_for_state("FAULT")
        assert axis.get(0x603F) == 0x8100
        axis.command(0x00)
        master.pass_time(3)  # an edge needs a tick between the two
        axis.command(0x80)
        axis.wait_for_state("SWITCH ON DISABLED")
        assert axis.get(0x603F) == 0


@pytest.mark.smoke
def test_6040_by_rpdo_leads_to_operation_and_6041_by_tpdo_is_what_sdo_reads(master, azimuth):
    for controlword, state in ((0x06, "READY TO SWITCH ON"), (0x07, "SWITCHED ON"), (0x0F, "OPERATION ENABLED")):
        master.send(0x200 + NODE_ID, controlword, 0, PV)
        azimuth.wait_for_state(state)
    master.forget()
    assert state_of(struct.unpack_from("<H", master.wait_for(0x180 + NODE_ID)[-1])[0]) == azimuth.state
