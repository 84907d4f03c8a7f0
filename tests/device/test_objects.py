# SPDX-License-Identifier: Apache-2.0
"""Identity, emergency, objects of CiA 301 (1000h to 1018h) and the drives' own objects."""

import json
import struct

import pytest

from axis import TPDO8
from device import DESCRIPTIONS, NODE_ID

EMERGENCY = 0x80 + NODE_ID


def test_1000_says_several_devices(master):
    """Two drives in one node: FFFF in the upper half, each drive's own type at 67FFh and 6FFFh (CiA 301, 7.5.2.1)."""
    assert master.number(0x1000) == 0xFFFF0192


@pytest.mark.parametrize("index", [0x67FF, 0x6FFF], ids=["67FF", "6FFF"])
def test_device_type_of_each_drive(master, index):
    assert master.number(index) & 0xFFFF == 0x0192


def test_1001_is_0_without_an_error(master):
    assert master.number(0x1001) == 0


def test_1003_keeps_the_newest_error_first_and_forgets_on_0(master):
    master.write(0x1003, 0, 0, 1)
    master.write(0x1016, 1, 5 << 16 | 50, 4)
    master.send(0x705, 5)
    master.wait_for(EMERGENCY, 3)
    assert master.number(0x1003, 0) == 3 and master.number(0x1003, 1) & 0xFFFF == 0x8130
    master.write(0x1003, 0, 0, 1)
    assert master.number(0x1003, 0) == 0 and master.sdo_abort(0x1003, 1) == 0x08000024


FORMATS = {"REAL32": "<f", "INTEGER8": "<b", "UNSIGNED8": "<B", "UNSIGNED16": "<H", "UNSIGNED32": "<L"}


BRAKE_TIMES_S = {24: 0.02, 25: 0.03}  # 2060 on the simulator, which has the brakes of tracker.toml


@pytest.mark.power_on
def test_every_object_of_the_axes_starts_with_its_printed_default(master, pytestconfig):
    """2000 to 2FFF: parameters.json has each axis' own default, the EDS those of its integers.

    The simulator designs its gains when it starts: the last bits of a float may depend on the C library. Its machine has
    holding brakes; the product's default is none.
    """
    objects = json.loads((DESCRIPTIONS / "parameters.json").read_text())["objects"]
    rows = [row for row in objects if 0x2000 <= row["index"] < 0x3000 and row["access"] == "rw"]
    assert len(rows) > 2 * 60
    for row in rows:
        index, sub = row["index"], row["sub"]
        (value,) = struct.unpack(FORMATS[row["type"]], master.node.sdo.upload(index, sub))
        has_brake = pytestconfig.getoption("--device") == "sim" and index & ~0x800 == 0x2060 and sub in BRAKE_TIMES_S
        expected = BRAKE_TIMES_S[sub] if has_brake else row["default"]
        assert value == pytest.approx(expected, rel=1e-5), f"{index:04X}:{sub} {row['name']}"
        in_eds = master.node.object_dictionary.get_variable(index, sub).default
        assert row["type"] == "REAL32" or value == in_eds, f"{index:04X}:{sub} in the EDS"


def clock_us(master):
    return master.node.sdo[0x1013].raw


def test_1013_counts_us(master):
    master.start()
    pairs = [struct.unpack("<LL", frame) for frame in master.record(TPDO8, [0x10130020, 0x30100120], 25)]
    passed_us, passed_ms = (pairs[-1][n] - pairs[0][n] & 0xFFFFFFFF for n in (0, 1))
    assert passed_us == pytest.approx(1000 * passed_ms, abs=1000)


@pytest.mark.parametrize("value", [0, 123456789, 0xFFFFFF00], ids=["0", "any", "wraps"])
def test_1013_is_set_by_a_write(master, value):
    """CiA 301, 7.5.2.16: high-resolution time stamp, us."""
    tick = master.ticks_ms()
    master.node.sdo[0x1013].raw = value
    read = clock_us(master)
    assert (read - value) & 0xFFFFFFFF < 1000 * (master.ticks_ms() - tick) + 2000


def test_1013_can_be_mapped_in_both_directions(master):
    """A time producer's PDO sets it; a TPDO sends it."""
    for communication, mapping, cob_id in ((0x1402, 0x1602, 0x401), (0x1802, 0x1A02, 0x381)):
        master.write(communication, 1, 0x80000000 | cob_id, 4)
        master.write(mapping, 0, 0, 1)
        master.write(mapping, 1, 0x10130020, 4)
        master.write(mapping, 0, 1, 1)
        master.write(communication, 1, cob_id, 4)
    master.start()
    master.send(0x401, *(0x10000000).to_bytes(4, "little"))
    tick = master.ticks_ms()
    master.forget()
    sent = int.from_bytes(master.wait_for(0x381)[0], "little")
    assert 0 <= sent - 0x10000000 < 1000 * (master.ticks_ms() - tick) + 20000


def test_1014_moves_the_emergencies(master):
    master.write(0x1014, 0, 0x80000000 | EMERGENCY, 4)
    master.write(0x1014, 0, 0x0A7, 4)
    master.write(0x1016, 1, 5 << 16 | 50, 4)
    master.send(0x705, 5)
    master.wait_for(0x0A7)
    assert master.heard(EMERGENCY) == []


def test_1014_refuses_to_move_while_it_is_on(master):
    assert master.sdo_abort(0x1014, 0, (0x0A7).to_bytes(4, "little")) == 0x08000022


def test_1018_has_four_numbers_and_a_product(master):
    assert master.number(0x1018, 0) == 4 and master.number(0x1018, 2) != 0


@pytest.mark.parametrize("sub", [1, 2, 3])
def test_1010_and_1011_say_that_they_act_on_command(master, sub):
    assert master.number(0x1010, sub) == 1 and master.number(0x1011, sub) == 1


def test_1200_names_the_default_channel(master):
    assert (master.number(0x1200, 1), master.number(0x1200, 2)) == (0x600 + NODE_ID, 0x580 + NODE_ID)


@pytest.mark.parametrize("shift", [0, 0x800], ids=["azimuth", "pitch"])
@pytest.mark.parametrize("index, value", [(0x6502, 0x103A5), (0x60A8, 0xF9100000), (0x60A9, 0xFA100300)], ids=["6502", "60A8", "60A9"])
def test_constant_object_of_a_drive(master, shift, index, value):
    assert master.number(index + shift) == value


@pytest.mark.parametrize("shift", [0, 0x800], ids=["azimuth", "pitch"])
def test_6086_names_a_ramp_that_is_there_and_refuses_others(master, shift):
    kind = master.number(0x6086 + shift)
    master.write(0x6086 + shift, 0, kind, 2)
    assert master.sdo_abort(0x6086 + shift, 0, (0x7FFF).to_bytes(2, "little")) in (0x06090030, 0x06090031)
    assert master.number(0x6086 + shift) == kind
