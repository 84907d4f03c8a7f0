"""CiA 402: the power state machine by SDO and by PDO, modes, stops, halt, with the masks of python-canopen's own
profile."""

import struct

import pytest
from canopen.profiles.p402 import State402

from conftest import NODE_ID

PV, PP, CSV = 3, 1, 9
NAMES = {mask_value: name for name, mask_value in State402.SW_MASK.items()}
AXES = pytest.mark.parametrize("axis", [0, 0x800], ids=["azimuth", "pitch"])


def state(master, axis):
    word = master.number(0x6041 + axis)
    return next(name for (mask, value), name in NAMES.items() if word & mask == value)


def command(master, axis, controlword, expected):
    master.write(0x6040 + axis, 0, controlword, 2)
    for _ in range(400):
        if state(master, axis) == expected:
            return
        master.pass_time(5)
    assert state(master, axis) == expected


def enable(master, axis, mode):
    master.write(0x6060 + axis, 0, mode, 1)
    command(master, axis, 0x06, "READY TO SWITCH ON")
    command(master, axis, 0x07, "SWITCHED ON")
    command(master, axis, 0x0F, "OPERATION ENABLED")


def rate_rad_s(master, axis):
    return 1e-6 * struct.unpack("<l", master.node.sdo.upload(0x606C + axis, 0))[0]


def wait_until(master, condition):
    for _ in range(600):
        if condition():
            return
        master.pass_time(5)
    assert condition()


@AXES
def test_starts_in_switch_on_disabled_without_torque(master, axis):
    wait_until(master, lambda: state(master, axis) == "SWITCH ON DISABLED")
    assert not master.number(0x6041 + axis) & 0x0400 or master.number(0x6061 + axis) == 0


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
    "quick stop from operation": ([0x06, 0x07, 0x0F], 0x02, "SWITCH ON DISABLED"),
    "halt changes no state": ([0x06, 0x07, 0x0F], 0x010F, "OPERATION ENABLED"),
}


@AXES
@pytest.mark.parametrize("commands, controlword, expected", TRANSITIONS.values(), ids=TRANSITIONS)
def test_6040_transition(master, axis, commands, controlword, expected):
    names = {0x06: "READY TO SWITCH ON", 0x07: "SWITCHED ON", 0x0F: "OPERATION ENABLED"}
    wait_until(master, lambda: state(master, axis) == "SWITCH ON DISABLED")
    master.write(0x6060 + axis, 0, PV, 1)
    for word in commands:
        command(master, axis, word, names[word])
    command(master, axis, controlword, expected)


@AXES
def test_6040_enable_operation_from_switch_on_disabled_does_nothing(master, axis):
    master.write(0x6040 + axis, 0, 0x0F, 2)
    master.pass_time(50)
    assert state(master, axis) == "SWITCH ON DISABLED"


@AXES
@pytest.mark.parametrize("mode", [1, 3, 8, 9, 10])
def test_6060_mode_is_displayed(master, axis, mode):
    master.write(0x6060 + axis, 0, mode, 1)
    wait_until(master, lambda: master.number(0x6061 + axis) == mode)


@AXES
def test_60ff_profile_velocity_turns_and_reports_the_target(master, axis):
    enable(master, axis, PV)
    master.write(0x60FF + axis, 0, 50000, 4)
    wait_until(master, lambda: bool(master.number(0x6041 + axis) & 0x0400))
    wait_until(master, lambda: abs(rate_rad_s(master, axis) - 0.05) < 0.005)
    master.write(0x60FF + axis, 0, 0, 4)
    wait_until(master, lambda: abs(rate_rad_s(master, axis)) < 0.005)


@AXES
def test_605d_halt_stops_and_lets_go_on(master, axis):
    enable(master, axis, PV)
    master.write(0x60FF + axis, 0, 50000, 4)
    wait_until(master, lambda: abs(rate_rad_s(master, axis) - 0.05) < 0.005)
    master.write(0x6040 + axis, 0, 0x010F, 2)
    wait_until(master, lambda: abs(rate_rad_s(master, axis)) < 0.005)
    master.write(0x6040 + axis, 0, 0x000F, 2)
    wait_until(master, lambda: abs(rate_rad_s(master, axis) - 0.05) < 0.005)


@AXES
def test_605a_6_quick_stop_holds_and_16_goes_on(master, axis):
    master.write(0x605A + axis, 0, 6, 2)
    enable(master, axis, PV)
    master.write(0x60FF + axis, 0, 50000, 4)
    wait_until(master, lambda: abs(rate_rad_s(master, axis) - 0.05) < 0.005)
    command(master, axis, 0x0B, "QUICK STOP ACTIVE")
    wait_until(master, lambda: abs(rate_rad_s(master, axis)) < 0.005)
    command(master, axis, 0x0F, "OPERATION ENABLED")


@AXES
def test_607a_profile_position_acknowledges_and_arrives(master, axis):
    enable(master, axis, PP)
    start = struct.unpack("<l", master.node.sdo.upload(0x6064 + axis, 0))[0]
    master.write(0x607A + axis, 0, start + 200000, 4)
    master.write(0x6040 + axis, 0, 0x3F, 2)
    wait_until(master, lambda: bool(master.number(0x6041 + axis) & 0x1000))
    master.write(0x6040 + axis, 0, 0x2F, 2)
    wait_until(master, lambda: bool(master.number(0x6041 + axis) & 0x0400))
    arrived = struct.unpack("<l", master.node.sdo.upload(0x6064 + axis, 0))[0]
    assert abs(arrived - start - 200000) < 2000


@AXES
def test_nmt_stop_takes_the_torque_away_and_a_fault_reset_needs_a_rising_edge(master, axis):
    enable(master, axis, PV)
    master.node.nmt.send_command(0x02)
    master.wait_for_state(4)
    master.node.nmt.send_command(0x80)
    master.wait_for_state(127)
    wait_until(master, lambda: state(master, axis) == "FAULT")
    assert master.number(0x603F + axis) != 0
    master.write(0x6040 + axis, 0, 0x00, 2)
    command(master, axis, 0x80, "SWITCH ON DISABLED")


def test_6040_by_rpdo_leads_to_operation(master):
    master.start()
    master.send(0x200 + NODE_ID, 0x06, 0, PV)
    wait_until(master, lambda: state(master, 0) == "READY TO SWITCH ON")
    master.send(0x200 + NODE_ID, 0x07, 0, PV)
    wait_until(master, lambda: state(master, 0) == "SWITCHED ON")
    master.send(0x200 + NODE_ID, 0x0F, 0, PV)
    wait_until(master, lambda: state(master, 0) == "OPERATION ENABLED")


def test_6041_by_tpdo_is_what_sdo_reads(master):
    master.start()
    master.forget()
    assert struct.unpack_from("<H", master.wait_for(0x180 + NODE_ID)[-1])[0] == master.number(0x6041)
