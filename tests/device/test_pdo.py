# SPDX-License-Identifier: Apache-2.0
"""PDO (1400h to 1A07h) and SYNC (1005h, 1006h, 1019h)."""

import struct

import pytest

from device import NODE_ID

OFF = 0x80000000
RPDO = (0x200, 0x300, 0x400, 0x500)
TPDO = (0x180, 0x280, 0x380, 0x480)
FURTHER = (0x67F, 0x68B, 0x697, 0x6A3)
"""TPDO5 to TPDO8, off by default."""
UNMAPPABLE, TOO_LONG, NO_OBJECT, STATE = 0x06040041, 0x06040042, 0x06020000, 0x08000022


def configure(master, pdo, *, kind=None, objects=None, identifier=None, event_ms=None, inhibit_100us=None):
    """The order of CiA 301: off, changed, on. `pdo` is 0x1400 + n or 0x1800 + n."""
    before = master.number(pdo, 1)
    master.write(pdo, 1, before | OFF, 4)
    if objects is not None:
        master.write(pdo + 0x200, 0, 0, 1)
        for sub, entry in enumerate(objects, 1):
            master.write(pdo + 0x200, sub, entry, 4)
        master.write(pdo + 0x200, 0, len(objects), 1)
    for sub, value, size in ((2, kind, 1), (3, inhibit_100us, 2), (5, event_ms, 2)):
        if value is not None:
            master.write(pdo, sub, value, size)
    master.write(pdo, 1, before & ~OFF if identifier is None else before & 0x40000000 | identifier, 4)


@pytest.mark.parametrize("n", range(4))
def test_default_identifiers_are_those_of_the_predefined_set(master, n):
    assert master.number(0x1400 + n, 1) & 0x7FF == RPDO[n] + NODE_ID
    assert master.number(0x1800 + n, 1) & 0x7FF == TPDO[n] + NODE_ID


@pytest.mark.parametrize("n", range(4))
def test_tpdo5_to_8_are_off_and_sent_when_they_are_set_up(master, n):
    identifier = FURTHER[n] + NODE_ID
    assert master.number(0x1804 + n, 1) == OFF | 0x40000000 | identifier
    assert master.number(0x1A04 + n, 0) == 0
    master.start()
    master.forget()
    master.pass_time(50)
    assert master.heard(identifier) == []
    configure(master, 0x1804 + n, kind=255, objects=[0x30100120, 0x60640020], event_ms=1, inhibit_100us=0)
    master.forget()
    ticks = [struct.unpack("<L", data[:4])[0] for data in master.wait_for(identifier, 50)]
    assert [later - earlier for earlier, later in zip(ticks, ticks[1:])] == [1] * (len(ticks) - 1)


@pytest.mark.parametrize("n", range(4))
def test_tpdo_is_sent_in_operational_with_the_length_of_its_mapping(master, n):
    bits = sum(master.number(0x1A00 + n, sub) & 0xFF for sub in range(1, master.number(0x1A00 + n, 0) + 1))
    master.start()
    master.forget()
    assert {len(data) for data in master.wait_for(TPDO[n] + NODE_ID, 2)} == {bits // 8}


def test_tpdo_by_event_timer_comes_as_often_as_it_says(master):
    configure(master, 0x1800, kind=255, objects=[0x30100120], event_ms=10, inhibit_100us=0)
    master.start()
    master.forget()
    ticks = [struct.unpack("<L", data)[0] for data in master.wait_for(TPDO[0] + NODE_ID, 100)]
    assert {later - earlier for earlier, later in zip(ticks, ticks[1:])} == {10}


def test_tpdo_by_event_keeps_its_inhibit_time(master):
    configure(master, 0x1800, kind=255, objects=[0x30100120], event_ms=10, inhibit_100us=500)
    master.start()
    master.forget()
    ticks = [struct.unpack("<L", data)[0] for data in master.wait_for(TPDO[0] + NODE_ID, 10)]
    assert min(later - earlier for earlier, later in zip(ticks, ticks[1:])) >= 50


@pytest.mark.parametrize("kind", [1, 3])
def test_tpdo_of_a_cyclic_type_comes_with_every_nth_sync(master, kind):
    configure(master, 0x1800, kind=kind, objects=[0x10010008])
    master.start()
    master.forget()
    for _ in range(12):
        master.network.sync.transmit()
        master.pass_time(3)
    assert len(master.heard(TPDO[0] + NODE_ID)) == 12 // kind


def test_tpdo_of_type_0_comes_with_a_sync_after_a_change(master):
    configure(master, 0x1800, kind=0, objects=[0x30100120])
    master.start()
    master.forget()
    master.pass_time(30)
    assert master.heard(TPDO[0] + NODE_ID) == []
    master.network.sync.transmit()
    master.wait_for(TPDO[0] + NODE_ID)


def test_rpdo_by_event_counts_at_once(master):
    master.start()
    master.send(RPDO[2] + NODE_ID, *struct.pack("<ll", 17453, -17453))
    master.pass_time(5)
    assert master.number(0x60FF) == 17453 and master.number(0x68FF) == 0x100000000 - 17453


def test_rpdo_counts_in_operational_only(master):
    master.send(RPDO[2] + NODE_ID, *struct.pack("<ll", 17453, 0))
    master.pass_time(5)
    assert master.number(0x60FF) == 0


def test_rpdo_of_type_1_waits_for_sync(master):
    configure(master, 0x1402, kind=1)
    master.start()
    master.send(RPDO[2] + NODE_ID, *struct.pack("<ll", 17453, 0))
    master.pass_time(5)
    assert master.number(0x60FF) == 0
    master.network.sync.transmit()
    master.pass_time(5)
    assert master.number(0x60FF) == 17453


def test_rpdo_that_is_too_short_is_emergency_8210_and_changes_nothing(master):
    master.start()
    master.send(RPDO[2] + NODE_ID, 1, 2, 3)
    assert master.wait_for(0x80 + NODE_ID)[0][:2] == b"\x10\x82"
    assert master.number(0x60FF) == 0


def enable_azimuth(master):
    """In mode pv, by RPDO1."""
    master.start()
    for controlword in (6, 7, 0xF):
        master.send(RPDO[0] + NODE_ID, controlword, 0, 3)
        master.pass_time(10)
    assert master.number(0x6041) & 0x6F == 0x27


def test_rpdo_with_a_refused_value_is_emergency_8200_and_a_stop_in_it_is_obeyed(master):
    enable_azimuth(master)
    master.forget()
    master.send(RPDO[0] + NODE_ID, 0xF, 0, 2)  # mode 2 is not supported
    assert master.wait_for(0x80 + NODE_ID)[0] == bytes([0x00, 0x82, 0x11, 1, 0, 0x60, 0x60, 0])
    assert master.number(0x6041) & 0x6F == 0x27
    master.send(RPDO[0] + NODE_ID, 0, 0, 2)  # disable voltage
    master.pass_time(10)
    assert master.number(0x6041) & 0x4F == 0x40 and master.number(0x6060) == 3
    master.send(RPDO[0] + NODE_ID, 0, 0, 3)
    assert master.wait_for(0x80 + NODE_ID, 2)[1][:3] == bytes(3)


def test_rpdo_that_is_too_short_stops_the_axis_if_it_contains_a_stop(master):
    enable_azimuth(master)
    master.send(RPDO[0] + NODE_ID, 0, 0)  # RPDO1 of CiA 402: no mode
    assert master.wait_for(0x80 + NODE_ID)[0][:2] == b"\x10\x82"
    assert master.number(0x6041) & 0x4F == 0x40


def test_rpdo_that_stays_out_is_emergency_8250(master):
    configure(master, 0x1402, event_ms=50)
    master.start()
    master.send(RPDO[2] + NODE_ID, *bytes(8))
    assert master.wait_for(0x80 + NODE_ID)[0][:2] == b"\x50\x82"
    master.pass_time(250)
    assert master.heard(0x700 + NODE_ID)[-1] == b"\x05"  # no communication error of 1029:1 (CiA 301, 7.5.2.32)


IDENTIFIERS = [0x082, 0x0A5, 0x100, 0x182, 0x2A5, 0x3FF, 0x57F, 0x580, 0x680, 0x6A5, 0x6DF]


@pytest.mark.parametrize("identifier", IDENTIFIERS, ids=lambda identifier: f"{identifier:03X}")
def test_rpdo_is_heard_under_every_identifier_that_the_object_takes(master, identifier):
    if master.sdo_abort(0x1402, 1, (OFF | identifier).to_bytes(4, "little")) != 0:
        assert master.number(0x1402, 1) & 0x7FF == RPDO[2] + NODE_ID
        pytest.fail(f"{identifier:03X} may be a PDO's (CiA 301, restricted identifiers), and is refused")
    configure(master, 0x1402, identifier=identifier)
    master.start()
    master.send(identifier, *struct.pack("<ll", 4242, 0))
    master.pass_time(5)
    assert master.number(0x60FF) == 4242


@pytest.mark.parametrize("identifier", IDENTIFIERS, ids=lambda identifier: f"{identifier:03X}")
def test_sync_is_heard_under_every_identifier_that_1005_takes(master, identifier):
    configure(master, 0x1802, identifier=0x7FF & (TPDO[2] + NODE_ID + 0x10))
    configure(master, 0x1800, kind=1, objects=[0x10010008])
    master.write(0x1005, 0, identifier, 4)
    master.start()
    master.forget()
    for _ in range(3):
        master.send(identifier)
        master.pass_time(3)
    assert len(master.heard(TPDO[0] + NODE_ID)) == 3


@pytest.mark.parametrize("identifier", [0x000, 0x001, 0x07F, 0x101, 0x180, 0x581, 0x5FF, 0x601, 0x67F, 0x6E0, 0x701, 0x7E5, 0x7FF],
                         ids=lambda identifier: f"{identifier:03X}")  # fmt: skip
def test_pdo_refuses_a_restricted_identifier(master, identifier):
    master.write(0x1402, 1, master.number(0x1402, 1) | OFF, 4)
    assert master.sdo_abort(0x1402, 1, identifier.to_bytes(4, "little")) == 0x06090030


@pytest.mark.parametrize("index, identifier", [
    (0x1005, 0x201), (0x1005, 0x181), (0x1005, 0x081), (0x1402, 0x080), (0x1402, 0x181), (0x1402, 0x081), (0x1802, 0x080),
    (0x1802, 0x201), (0x1802, 0x281), (0x1802, 0x081), (0x1804, 0x181), (0x1807, 0x481), (0x1014, 0x080), (0x1014, 0x201), (0x1014, 0x181),
], ids=lambda number: f"{number:X}")  # fmt: skip
def test_an_identifier_that_another_service_has_is_refused(master, index, identifier):
    sub = 0 if index in (0x1005, 0x1014) else 1
    if index != 0x1005:
        master.write(index, sub, master.number(index, sub) | OFF, 4)
    assert master.sdo_abort(index, sub, identifier.to_bytes(4, "little")) == 0x06040043


def test_pdo_refuses_to_move_while_it_is_on(master):
    assert master.sdo_abort(0x1402, 1, (0x3A5).to_bytes(4, "little")) in (0x06090030, STATE)


def test_mapping_refuses_to_change_while_the_pdo_is_on(master):
    assert master.sdo_abort(0x1A00, 0, b"\0") == STATE


@pytest.mark.parametrize("entry, code", [(0x60410010, UNMAPPABLE), (0x5FFF0008, NO_OBJECT), (0x10000020, UNMAPPABLE)],
                         ids=["6041h is read only", "5FFFh is unknown", "1000h"])  # fmt: skip
def test_rpdo_mapping_refuses_what_cannot_be_mapped(master, entry, code):
    master.write(0x1402, 1, master.number(0x1402, 1) | OFF, 4)
    master.write(0x1602, 0, 0, 1)
    assert master.sdo_abort(0x1602, 1, entry.to_bytes(4, "little")) == code


def test_an_object_cannot_be_received_twice_in_a_frame(master):
    """6040 and 6040: a stop in the first would be lost. 6040 and 6840 are two objects, and dummies are none."""
    master.write(0x1402, 1, master.number(0x1402, 1) | OFF, 4)
    master.write(0x1602, 0, 0, 1)
    for sub, entry in enumerate((0x60400010, 0x68400010, 0x00050008, 0x00050008), 1):
        master.write(0x1602, sub, entry, 4)
    master.write(0x1602, 0, 4, 1)
    master.write(0x1602, 0, 0, 1)
    master.write(0x1602, 2, 0x60400010, 4)
    assert master.sdo_abort(0x1602, 0, b"\x02") == UNMAPPABLE


def test_mapping_refuses_more_than_8_bytes(master):
    master.write(0x1802, 1, master.number(0x1802, 1) | OFF, 4)
    master.write(0x1A02, 0, 0, 1)
    for sub, entry in enumerate((0x60640020, 0x606C0020, 0x60410010), 1):
        master.write(0x1A02, sub, entry, 4)
    assert master.sdo_abort(0x1A02, 0, b"\x03") == TOO_LONG


def test_mapping_by_python_canopens_own_pdo_save(master):
    node = master.node
    node.tpdo.read()
    node.tpdo[1].clear()
    node.tpdo[1].add_variable(0x6064, 0)
    node.tpdo[1].add_variable(0x606C, 0)
    node.tpdo[1].enabled = True
    node.tpdo[1].save()
    assert [master.number(0x1A00, sub) for sub in range(3)] == [2, 0x60640020, 0x606C0020]
    master.start()
    master.forget()
    assert len(master.wait_for(TPDO[0] + NODE_ID)[0]) == 8


def test_1006_a_sync_that_stays_out_is_emergency_8700(master):
    master.write(0x1006, 0, 20000, 4)
    master.start()
    master.network.sync.transmit()
    assert master.wait_for(0x80 + NODE_ID)[0][:2] == b"\x00\x87"


def test_1019_a_sync_of_the_wrong_length_is_emergency_8240(master):
    master.write(0x1019, 0, 10, 1)
    master.start()
    master.send(0x80)
    assert master.wait_for(0x80 + NODE_ID)[0][:2] == b"\x40\x82"


def test_1019_refuses_to_change_while_1006_has_a_period(master):
    master.write(0x1006, 0, 20000, 4)
    assert master.sdo_abort(0x1019, 0, b"\x0a") == STATE
