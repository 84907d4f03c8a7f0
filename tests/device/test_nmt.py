# SPDX-License-Identifier: Apache-2.0
"""NMT, boot-up and heartbeat (1016h, 1017h)."""

import pytest

from axis import PV, TPDO8, micro_rad
from device import NODE_ID

HEARTBEAT = 0x700 + NODE_ID
STOPPED, OPERATIONAL, PRE_OPERATIONAL = 4, 5, 127
START, STOP, ENTER_PRE_OPERATIONAL, RESET_NODE, RESET_COMMUNICATION = 1, 2, 128, 129, 130


def test_boot_up_comes_before_the_first_heartbeat(master):
    master.write(0x1017, 0, 0, 2)  # no heartbeat of the time before is still on its way
    master.reset()
    assert master.wait_for(HEARTBEAT, 2)[:2] == [b"\x00", b"\x7f"]


@pytest.mark.parametrize("command, state", [(START, OPERATIONAL), (STOP, STOPPED), (ENTER_PRE_OPERATIONAL, PRE_OPERATIONAL)])
def test_nmt_command_leads_to_its_state(master, command, state):
    master.node.nmt.send_command(command)
    master.wait_for_state(state)


@pytest.mark.parametrize("command, state", [(START, OPERATIONAL), (STOP, STOPPED)])
def test_nmt_command_to_all_nodes_counts(master, command, state):
    master.send(0, command, 0)
    master.wait_for_state(state)


@pytest.mark.parametrize("data", [(START, NODE_ID + 1), (START,), (START, NODE_ID, 0), (77, NODE_ID)])
def test_nmt_command_for_another_node_of_wrong_length_or_unknown_is_ignored(master, data):
    master.send(0, *data)
    master.pass_time(250)
    assert set(master.heard(HEARTBEAT)) == {bytes([PRE_OPERATIONAL])}


@pytest.mark.parametrize("command", [RESET_NODE, RESET_COMMUNICATION])
def test_nmt_reset_ends_in_a_boot_up_and_gives_the_communication_its_defaults(master, command):
    master.write(0x1015, 0, 77, 2)
    master.forget()
    master.node.nmt.send_command(command)
    assert b"\x00" in master.wait_for(HEARTBEAT, 2)
    assert master.number(0x1015) == 0


@pytest.mark.parametrize("command", [RESET_NODE, RESET_COMMUNICATION])
def test_nmt_reset_is_no_emergency_and_the_node_starts_once(master, command):
    """The work of a reset must not make the control task late, which would cause a reset by the watchdog."""
    for _ in range(5):
        master.node.nmt.send_command(command)
        master.wait_for(HEARTBEAT, 5)
        assert (master.heard(HEARTBEAT).count(b"\x00"), master.heard(0x80 + NODE_ID)) == (1, [])
        master.forget()


def test_nmt_reset_of_the_communication_leaves_the_application_alone(master):
    master.write(0x6081, 0, 123456, 4)
    master.reset_communication()
    assert master.number(0x6081) == 123456


def test_nmt_stopped_answers_no_sdo(master):
    master.node.nmt.send_command(STOP)
    master.wait_for_state(STOPPED)
    master.forget()
    master.send(0x600 + NODE_ID, 0x40, 0, 0x10, 0, 0, 0, 0, 0)
    master.wait_for(HEARTBEAT, 3)
    assert master.heard(0x580 + NODE_ID) == []


def test_nmt_stopped_sends_no_pdo(master):
    master.start()
    master.wait_for(0x380 + NODE_ID, 2)
    master.node.nmt.send_command(STOP)
    master.wait_for_state(STOPPED)
    master.forget()
    master.wait_for(HEARTBEAT, 3)
    assert master.heard(0x380 + NODE_ID) == []


def test_nmt_pre_operational_sends_no_pdo(master):
    master.wait_for(HEARTBEAT, 3)
    assert [master.heard(identifier + NODE_ID) for identifier in (0x180, 0x280, 0x380, 0x480)] == [[], [], [], []]


def test_1017_heartbeat_follows_the_producer_time(master):
    master.write(0x1017, 0, 20, 2)
    master.start()
    ticks = master.sample(TPDO8, [0x30100120])
    master.forget()
    count = len(master.wait_for(HEARTBEAT, 50))
    first, *_, last = (int.from_bytes(data, "little") for data in master.heard(ticks))
    assert abs((last - first) / 20 - count) <= 3


def test_1017_heartbeat_of_0_is_none(master):
    master.write(0x1017, 0, 0, 2)
    master.forget()
    master.pass_time(300)
    assert master.heard(HEARTBEAT) == []


def test_1016_a_lost_producer_is_emergency_8130_and_clears_by_itself(master):
    master.write(0x1016, 1, 5 << 16 | 100, 4)
    master.send(0x705, 5)
    lost = master.wait_for(0x80 + NODE_ID)[0]
    assert lost[:3] == bytes([0x30, 0x81, 0x11])
    master.wait_for(0x80 + NODE_ID, 3)  # the node's own, and one of each drive, which stops without a master
    master.send(0x705, 5)
    assert master.wait_for(0x80 + NODE_ID, 4)[3][:2] == b"\0\0"


def test_1016_a_producer_that_was_never_heard_is_not_missed(master):
    master.write(0x1016, 1, 5 << 16 | 50, 4)
    master.pass_time(300)
    assert master.heard(0x80 + NODE_ID) == []


FAULT_HEARTBEAT = 24
PEER, BOOT_UP = 0x7E, 0


def turn_with_a_monitored_peer(master, azimuth, limit_ms):
    """Node 7E must send every `limit_ms`, from its first heartbeat on."""
    master.write(0x1016, 1, PEER << 16 | limit_ms, 4)
    azimuth.enable(PV)
    azimuth.set(micro_rad(2.0), 0x60FF)
    azimuth.wait_until(lambda: azimuth.rate_deg_s > 1.8)
    master.forget()


@pytest.mark.parametrize("behaviour, state", [(0, PRE_OPERATIONAL), (1, OPERATIONAL), (2, STOPPED)])
def test_1016_a_boot_up_of_a_monitored_node_is_its_loss(master, azimuth, behaviour, state):
    """77E#05, then 77E#00: the master has been reset. Its time, 60 s, is far from over."""
    master.write(0x1029, 1, behaviour, 1)
    turn_with_a_monitored_peer(master, azimuth, 60000)
    master.send(0x700 + PEER, OPERATIONAL)
    master.pass_time(200)
    assert master.heard(0x80 + NODE_ID) == []
    master.send(0x700 + PEER, BOOT_UP)
    if state != STOPPED:  # stopped, a node sends no emergency
        of_node, *of_axes = master.wait_for(0x80 + NODE_ID, 3)
        assert of_node[:5] == bytes([0x30, 0x81, 0x11, PEER, 0])
        assert {(data[:2], *data[3:5]) for data in of_axes} == {(b"\x30\x81", FAULT_HEARTBEAT, axis) for axis in (1, 2)}
    master.wait_for_state(state)
    master.start()
    azimuth.wait_for_state("FAULT", 2)
    azimuth.wait_for_standstill()
    assert [azimuth.get(index) for index in (0x603F, 0x683F)] == [0x8130, 0x8130]


def test_1016_a_boot_up_alone_starts_no_monitoring(master, azimuth):
    turn_with_a_monitored_peer(master, azimuth, 100)
    master.send(0x700 + PEER, BOOT_UP)
    master.pass_time(500)
    assert master.heard(0x80 + NODE_ID) == []
    assert (azimuth.state, azimuth.rate_deg_s) == ("OPERATION ENABLED", pytest.approx(2.0, abs=0.2))


def test_1016_the_same_producer_twice_is_refused(master):
    master.write(0x1016, 1, 5 << 16 | 100, 4)
    assert master.sdo_abort(0x1016, 2, (5 << 16 | 200).to_bytes(4, "little")) == 0x06040043


def lose_a_producer_in_operation(master):
    """Node 5 sends once, and must send again within 100 ms."""
    master.write(0x1016, 1, 5 << 16 | 100, 4)
    master.start()
    master.send(0x705, 5)


def test_1029_a_lost_producer_makes_it_pre_operational(master):
    lose_a_producer_in_operation(master)
    master.wait_for_state(PRE_OPERATIONAL)


def test_1029_1_a_lost_producer_changes_no_state(master):
    master.write(0x1029, 1, 1, 1)
    lose_a_producer_in_operation(master)
    master.wait_for(0x80 + NODE_ID)
    master.wait_for_state(OPERATIONAL)


def test_1029_2_a_lost_producer_makes_it_stopped(master):
    master.write(0x1029, 1, 2, 1)
    lose_a_producer_in_operation(master)
    master.wait_for_state(STOPPED)
