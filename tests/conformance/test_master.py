"""What the node expects of its master: that it speaks while an axis turns (6007), and that it unlocks guarded values
(3040). Unmodified python-canopen, on the simulator and on the emulated board."""

import struct

import canopen
import pytest
from conftest import NODE_ID
from test_drive import PV, command, enable, rate_rad_s, state, wait_until

SLOW = 34907  # 2 deg/s
EMERGENCY, HEARTBEAT = 0x80 + NODE_ID, 0x700 + NODE_ID
OPEN, WORD, DEVICE_STATE, BAD_VALUE = b"open", b"7 drums\0", 0x08000022, 0x06090030
OVER_SPEED, CURRENT_LIMIT = (0x2060, 1), (0x2055, 6)
SECOND_CHANNEL = (0x6A0, 0x6A1)


def real(value):
    return struct.pack("<f", value)


def turn(master, axis):
    enable(master, axis, PV)
    master.forget()
    master.write(0x60FF + axis, 0, SLOW, 4)


def be_silent(master, heartbeats):
    """For so many heartbeats of the node, 100 ms each by its own clock: nothing is sent."""
    master.wait_for(HEARTBEAT, heartbeats, timeout_s=30)


@pytest.mark.parametrize("axis", [0, 0x800], ids=["azimuth", "pitch"])
def test_an_axis_stops_without_a_fault_when_the_master_is_silent(master, axis):
    master.start()
    turn(master, axis)
    be_silent(master, 8)
    assert master.heard(EMERGENCY) == []
    be_silent(master, 16)
    emergency = master.heard(EMERGENCY)[0]
    assert emergency[:2] == b"\x01\x81" and emergency[4] == (1 if axis == 0 else 2)
    assert state(master, axis) == "SWITCH ON DISABLED" and master.number(0x6041 + axis) & 0x80
    assert master.number(0x603F + axis) == 0 and abs(rate_rad_s(master, axis)) < 0.005


def test_6007_of_0_lets_the_axis_turn_on(master):
    master.start()
    master.write(0x6007, 0, 0, 2)
    turn(master, 0)
    be_silent(master, 25)
    assert state(master, 0) == "OPERATION ENABLED" and rate_rad_s(master, 0) == pytest.approx(0.0349, abs=0.005)
    command(master, 0, 0x00, "SWITCH ON DISABLED")


def test_6007_of_1_is_a_fault(master):
    master.start()
    master.write(0x6007, 0, 1, 2)
    turn(master, 0)
    be_silent(master, 20)
    assert master.number(0x603F) == 0x8101 and state(master, 0) in ("FAULT", "FAULT REACTION ACTIVE")


@pytest.fixture
def second(master):
    """The second SDO channel, for another client."""
    for sub, identifier in enumerate(SECOND_CHANNEL, 1):
        master.write(0x1201, sub, identifier, 4)
    sdo = master.node.add_sdo(*SECOND_CHANNEL)
    sdo.network = master.network
    return sdo


def abort_of(sdo, place, data):
    try:
        sdo.download(*place, data)
    except canopen.SdoAbortedError as refusal:
        return refusal.code
    return 0


def test_the_lock_is_open_for_the_channel_that_opened_it_only(master, second):
    first = master.node.sdo
    assert abort_of(first, OVER_SPEED, real(1.4)) == DEVICE_STATE
    assert abort_of(first, (0x3040, 1), OPEN) == 0
    assert abort_of(second, OVER_SPEED, real(1.4)) == DEVICE_STATE
    assert abort_of(second, CURRENT_LIMIT, real(15.0)) == DEVICE_STATE
    assert abort_of(first, OVER_SPEED, real(1.4)) == 0
    assert abort_of(first, CURRENT_LIMIT, real(15.0)) == 0
    assert abort_of(second, (0x2070, 1), b"\1") == DEVICE_STATE  # it would put the first one's motor data into force
    assert abort_of(first, (0x2070, 1), b"\1") == 0
    assert abort_of(first, (0x3040, 1), bytes(4)) == 0
    assert abort_of(first, (0x2070, 1), b"\3") == DEVICE_STATE  # undo
    assert abort_of(first, (0x1011, 1), b"load") == DEVICE_STATE


def test_guarded_values_do_not_change_while_an_axis_has_torque(master):
    first = master.node.sdo
    assert abort_of(first, (0x3040, 1), OPEN) == 0
    enable(master, 0x800, PV)
    assert abort_of(first, OVER_SPEED, real(1.4)) == DEVICE_STATE
    command(master, 0x800, 0x00, "SWITCH ON DISABLED")
    wait_until(master, lambda: abort_of(first, OVER_SPEED, real(1.4)) == 0)


def test_the_owners_word_replaces_the_known_one_and_wrong_words_delay_their_channel(master, second):
    first = master.node.sdo
    assert abort_of(first, (0x3040, 4), WORD) == DEVICE_STATE  # locked
    assert abort_of(first, (0x3040, 1), OPEN) == 0
    assert abort_of(first, (0x3040, 4), WORD) == 0
    try:
        assert abort_of(second, (0x3040, 1), OPEN) == BAD_VALUE
        assert abort_of(second, (0x3040, 3), WORD) == DEVICE_STATE  # delayed
        assert abort_of(first, (0x3040, 3), WORD) == 0
        assert master.sdo_abort(0x3040, 3) == master.sdo_abort(0x3040, 4) == 0x06010001  # nobody reads it
        assert master.number(0x3040, 5) == 1
    finally:
        assert abort_of(first, (0x3040, 3), WORD) == 0
        assert abort_of(first, (0x3040, 4), bytes(8)) == 0
    assert master.number(0x3040, 5) == 0
