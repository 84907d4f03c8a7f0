# SPDX-License-Identifier: Apache-2.0
"""Gains are staged, checked together and applied as a whole; a refused set changes nothing."""

import math
import struct

import canopen
import pytest

from axis import APPLY, DIRTY, REVERT, STAGED, UNDO

KP = (0x2000, 1)
COMMAND = (0x2070, 1)
FLAGS = (0x2070, 2)
RESULT = (0x2070, 3)
ACTIVE_CRC = (0x2070, 4)
STORED_CRC = (0x2070, 5)
REFUSED, REFUSED_LOW, REFUSED_HIGH, REFUSED_BOUND = ((0x2070, sub) for sub in (6, 7, 8, 9))
COULOMB, BREAKAWAY = (0x2030, 7), (0x2030, 8)


def abort_of(action):
    with pytest.raises(canopen.SdoAbortedError) as caught:
        action()
    return caught.value.code


def parameters(axis):
    """All staged values and the state objects, as bytes."""
    values = {}
    for index in (0x2000, 0x2010, 0x2011, 0x2020, 0x2030, 0x2040, 0x2050, 0x2055, 0x2070):
        for sub in range(1, axis.get(index, 0) + 1):
            values[index, sub] = axis.node.sdo.upload(index + axis.shift, sub)
    return values


def test_a_gain_is_staged_applied_and_undone_while_the_axis_turns(azimuth):
    azimuth.turn(1.0)
    kp, crc = azimuth.get(*KP), azimuth.get(*ACTIVE_CRC)
    assert azimuth.get(*FLAGS) == 0
    azimuth.set(1.3 * kp, *KP)
    assert (azimuth.get(*FLAGS), azimuth.get(*ACTIVE_CRC)) == (STAGED, crc)
    azimuth.set(APPLY, *COMMAND)
    assert (azimuth.get(*FLAGS), azimuth.get(*RESULT)) == (DIRTY, 0)
    assert azimuth.get(*ACTIVE_CRC) != crc
    assert azimuth.get(*STORED_CRC) == crc
    assert azimuth.mean_rate_deg_s() == pytest.approx(1.0, rel=0.03)
    azimuth.set(UNDO, *COMMAND)
    assert azimuth.get(*KP) == kp
    assert (azimuth.get(*FLAGS), azimuth.get(*ACTIVE_CRC)) == (0, crc)
    azimuth.set(UNDO, *COMMAND)  # twice is a redo
    assert azimuth.get(*KP) == pytest.approx(1.3 * kp)
    assert azimuth.state == "OPERATION ENABLED"
    assert azimuth.mean_rate_deg_s() == pytest.approx(1.0, rel=0.03)


def test_revert_forgets_what_is_staged(azimuth):
    before = parameters(azimuth)
    azimuth.set(100.0, *KP)
    azimuth.set(0, 0x2020, 1)
    azimuth.set(REVERT, *COMMAND)
    after = parameters(azimuth)
    assert after.pop(COMMAND) == b"\x02"
    before.pop(COMMAND)
    assert after == before


def test_pitch_has_gains_of_its_own(azimuth, pitch):
    kp = azimuth.get(*KP)
    pitch.set(2 * pitch.get(*KP), *KP)
    pitch.set(APPLY, *COMMAND)
    assert pitch.get(*FLAGS) == DIRTY
    assert (azimuth.get(*KP), azimuth.get(*FLAGS)) == (kp, 0)


def test_inconsistent_set_is_refused_whole(azimuth):
    azimuth.turn(1.0)
    azimuth.set(1.3 * azimuth.get(*KP), *KP)
    azimuth.set(0.5 * azimuth.get(*COULOMB), *BREAKAWAY)  # Ts below Tc
    before = parameters(azimuth)
    assert abort_of(lambda: azimuth.set(APPLY, *COMMAND)) == 0x06040043
    after = parameters(azimuth)
    assert after.pop(RESULT) == struct.pack("<I", 3)  # why
    assert after.pop(REFUSED) == struct.pack("<I", 0x20300800)  # which, and what would be right
    assert struct.unpack("<f", after.pop(REFUSED_LOW)) == pytest.approx([azimuth.get(*COULOMB)])
    assert struct.unpack("<f", after.pop(REFUSED_HIGH)) == (1e4,)
    assert after.pop(REFUSED_BOUND) == struct.pack("<I", 0x20300700)
    for key in (RESULT, REFUSED, REFUSED_LOW, REFUSED_HIGH, REFUSED_BOUND):
        before.pop(key)
    assert after == before
    assert azimuth.get(*FLAGS) == STAGED
    assert azimuth.mean_rate_deg_s() == pytest.approx(1.0, rel=0.03)


def test_refused_values_change_nothing(azimuth):
    before = parameters(azimuth)
    for bad, code in ((math.nan, 0x06090030), (math.inf, 0x06090031), (-math.inf, 0x06090032),
                      (1.1e6, 0x06090031), (-0.1, 0x06090032)):
        assert abort_of(lambda: azimuth.set(bad, *KP)) == code, bad
    assert abort_of(lambda: azimuth.set(2, 0x2020, 1)) == 0x06090031
    assert abort_of(lambda: azimuth.set(5, *COMMAND)) == 0x06090031
    assert parameters(azimuth) == before
