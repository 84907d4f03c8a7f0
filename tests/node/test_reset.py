"""Effects of a reset: a moving axis stops, commands are gone, stored values are back, and a fault is reported again."""

import threading
import time

import pytest

from drive import PP, PV, micro_rad, wait_until

MASTER = 0x7E
SAVE, LOAD = 0x65766173, 0x64616F6C
ALL, COMMUNICATION, APPLICATION = 1, 2, 3
FOLLOWING, BUS = 0x8611, 0x8100


def reset(node, command):
    """canopen's wait_for_bootup misses a message that comes before the call."""
    booted = threading.Event()
    identifier = 0x700 + node.id

    def hear(_identifier, data, _time):
        if data == b"\0":
            booted.set()

    node.network.subscribe(identifier, hear)
    node.nmt.state = command
    assert booted.wait(5)
    node.network.unsubscribe(identifier, hear)
    time.sleep(0.05)


def reset_node(node):
    reset(node, "RESET")


def reset_communication(node):
    reset(node, "RESET COMMUNICATION")


def test_reset_of_the_communication_stops_an_axis_that_turns(node, azimuth):
    azimuth.turn(1.0)
    reset_communication(node)
    wait_until(lambda: abs(azimuth.rate_deg_s) < 0.05, 1)
    wait_until(lambda: azimuth.state == "FAULT", 1)
    assert azimuth.get(0x603F) == BUS


def test_reset_of_the_communication_leaves_an_axis_without_power_alone(node, azimuth):
    reset_communication(node)
    time.sleep(0.1)
    assert azimuth.state == "SWITCH ON DISABLED"
    assert node.sdo[0x1001].raw == 0


def test_reset_of_the_node_forgets_every_command_and_target(node, azimuth):
    azimuth.turn(1.0, settle_s=0.2)
    azimuth.set(123456, 0x607F)
    azimuth.node.sdo[0x2100][5].raw = 7
    azimuth.node.sdo[0x3000][3].raw = 9
    reset_node(node)
    assert [azimuth.get(index) for index in (0x6040, 0x6060, 0x60FF, 0x603F)] == [0, 0, 0, 0]
    assert azimuth.get(0x607F) == 1000000
    assert azimuth.node.sdo[0x2100][5].raw == 1
    assert azimuth.node.sdo[0x3000][3].raw == 1
    assert azimuth.state == "SWITCH ON DISABLED"


def fail_to_follow(axis):
    axis.enable(PP)
    axis.set(0, 0x6066)
    axis.set(1, 0x6065)  # a window of 1e-7 rad, at once
    wait_until(lambda: axis.state == "FAULT", 2)


def test_the_same_fault_is_reported_again_after_a_reset(node, azimuth):
    for _ in range(2):
        fail_to_follow(azimuth)
        wait_until(lambda: node.sdo[0x1001].raw != 0, 1)
        assert node.sdo[0x1003][1].raw & 0xFFFF == FOLLOWING
        reset_node(node)
        assert node.sdo[0x1001].raw == 0
    fail_to_follow(azimuth)
    reset_communication(node)
    wait_until(lambda: node.sdo[0x1001].raw != 0, 1)  # still in fault: reported again
    assert azimuth.get(0x603F) == FOLLOWING


def store_other_values(node, axis):
    """A gain 10 % up, another speed limit, another heartbeat; returns the former gain."""
    kp = axis.get(0x2000, 1)
    axis.set(1.1 * kp, 0x2000, 1)
    axis.set(1, 0x2070, 1)
    axis.set(654321, 0x607F)
    node.sdo[0x1017].raw = 50
    node.sdo[0x1010][ALL].raw = SAVE
    return kp


def test_gains_drive_and_communication_are_stored_and_come_back(node, azimuth):
    kp = store_other_values(node, azimuth)
    azimuth.set(600000, 0x607F)
    node.sdo[0x1017].raw = 70
    reset_node(node)
    assert azimuth.get(0x2000, 1) == pytest.approx(1.1 * kp)
    assert azimuth.get(0x607F) == 654321
    assert node.sdo[0x1017].raw == 50


def test_one_group_is_stored_without_the_other(node, azimuth):
    azimuth.set(654321, 0x607F)
    node.sdo[0x1017].raw = 50
    node.sdo[0x1010][COMMUNICATION].raw = SAVE
    reset_node(node)
    assert (azimuth.get(0x607F), node.sdo[0x1017].raw) == (1000000, 50)


def test_load_brings_the_defaults_back_at_the_next_reset(node, azimuth):
    kp = store_other_values(node, azimuth)
    node.sdo[0x1011][ALL].raw = LOAD
    assert azimuth.get(0x2000, 1) == pytest.approx(1.1 * kp)  # until then nothing changes
    assert azimuth.get(0x2070, 2) == 2  # but it no longer equals the stored values
    reset_node(node)
    assert azimuth.get(0x2000, 1) == pytest.approx(kp)
    assert (azimuth.get(0x607F), node.sdo[0x1017].raw) == (1000000, 100)
    assert azimuth.get(0x2070, 2) == 0


def test_a_stored_monitoring_of_the_master_is_there_after_a_reset(node, azimuth):
    node.sdo[0x1016][1].raw = MASTER << 16 | 200
    node.sdo[0x1010][COMMUNICATION].raw = SAVE
    reset_node(node)
    node.network.send_message(0x700 + MASTER, [5])
    azimuth.turn(1.0, settle_s=0.0)
    wait_until(lambda: azimuth.state == "FAULT", 2)
    assert azimuth.get(0x603F) == 0x8130


def test_a_target_of_before_does_not_turn_the_axis_after_a_reset(node, azimuth):
    azimuth.turn(1.0, settle_s=0.2)
    reset_node(node)
    azimuth.enable(PV)
    time.sleep(0.5)
    assert abs(azimuth.rate_deg_s) < 0.1
    azimuth.set(micro_rad(1.0), 0x60FF)
    wait_until(lambda: azimuth.rate_deg_s > 0.9, 1)
