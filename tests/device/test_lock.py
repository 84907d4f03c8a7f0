# SPDX-License-Identifier: Apache-2.0
"""The lock of guarded values (3040): open for one channel, closed while an axis has torque, with a word of the owner."""

import struct

import pytest
from axis import PV, Axis
from master import abort_code

OPEN, WORD, DEVICE_STATE, BAD_VALUE = b"open", b"7 drums\0", 0x08000022, 0x06090030
OVER_SPEED, CURRENT_LIMIT = (0x2060, 1), (0x2055, 6)
SECOND_CHANNEL = (0x6A0, 0x6A1)


def real(value):
    return struct.pack("<f", value)


@pytest.fixture
def second(master):
    """The second SDO channel, for another client."""
    for sub, identifier in enumerate(SECOND_CHANNEL, 1):
        master.write(0x1201, sub, identifier, 4)
    sdo = master.node.add_sdo(*SECOND_CHANNEL)
    sdo.network = master.network
    return sdo


@pytest.mark.smoke
def test_the_lock_is_open_for_the_channel_that_opened_it_only(master, second):
    first = master.node.sdo
    assert abort_code(first, *OVER_SPEED, real(1.4)) == DEVICE_STATE
    assert abort_code(first, 0x3040, 1, OPEN) == 0
    assert abort_code(second, *OVER_SPEED, real(1.4)) == DEVICE_STATE
    assert abort_code(second, *CURRENT_LIMIT, real(15.0)) == DEVICE_STATE
    assert abort_code(first, *OVER_SPEED, real(1.4)) == 0
    assert abort_code(first, *CURRENT_LIMIT, real(15.0)) == 0
    assert abort_code(second, 0x2070, 1, b"\1") == DEVICE_STATE  # it would put the first one's motor data into force
    assert abort_code(first, 0x2070, 1, b"\1") == 0
    assert abort_code(first, 0x3040, 1, bytes(4)) == 0
    assert abort_code(first, 0x2070, 1, b"\3") == DEVICE_STATE  # undo
    assert abort_code(first, 0x1011, 1, b"load") == DEVICE_STATE


def test_guarded_values_do_not_change_while_an_axis_has_torque(master):
    first = master.node.sdo
    assert abort_code(first, 0x3040, 1, OPEN) == 0
    pitch = Axis(master, 0x800)
    pitch.switch_on(PV)
    assert abort_code(first, *OVER_SPEED, real(1.4)) == DEVICE_STATE
    pitch.command(0x00)
    pitch.wait_for_state("SWITCH ON DISABLED")
    master.wait_until(lambda: abort_code(first, *OVER_SPEED, real(1.4)) == 0)


def test_the_owners_word_replaces_the_known_one_and_wrong_words_delay_their_channel(master, second):
    first = master.node.sdo
    assert abort_code(first, 0x3040, 4, WORD) == DEVICE_STATE  # locked
    assert abort_code(first, 0x3040, 1, OPEN) == 0
    assert abort_code(first, 0x3040, 4, WORD) == 0
    try:
        assert abort_code(second, 0x3040, 1, OPEN) == BAD_VALUE
        assert abort_code(second, 0x3040, 3, WORD) == DEVICE_STATE  # delayed
        assert abort_code(first, 0x3040, 3, WORD) == 0
        assert master.sdo_abort(0x3040, 3) == master.sdo_abort(0x3040, 4) == 0x06010001  # nobody reads it
        assert master.number(0x3040, 5) == 1
    finally:
        assert abort_code(first, 0x3040, 3, WORD) == 0
        assert abort_code(first, 0x3040, 4, bytes(8)) == 0
    assert master.number(0x3040, 5) == 0
