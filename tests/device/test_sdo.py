# SPDX-License-Identifier: Apache-2.0
"""SDO server (1200h): expedited, segmented and block transfer, and every kind of refusal."""

import struct

import pytest

from device import NODE_ID

ABORT = 0x80
TOGGLE_WRONG, TIME_OUT, BAD_COMMAND, BAD_SEQUENCE, BAD_CRC = 0x05030000, 0x05040000, 0x05040001, 0x05040003, 0x05040004
FLOAT = struct.Struct("<f")


def code_of(answer):
    assert answer[0] == ABORT, answer.hex()
    return struct.unpack_from("<L", answer, 4)[0]


@pytest.mark.parametrize("index, sub, size", [
    (0x1000, 0, 4), (0x1001, 0, 1), (0x1018, 1, 4), (0x1017, 0, 2), (0x6041, 0, 2), (0x6061, 0, 1), (0x6064, 0, 4), (0x6502, 0, 4),
])  # fmt: skip
def test_expedited_upload_says_its_size(master, index, sub, size):
    answer = master.request(0x40, index & 0xFF, index >> 8, sub)
    assert answer[0] == 0x43 | (4 - size) << 2 and answer[1:4] == bytes([index & 0xFF, index >> 8, sub])
    assert answer[4 + size :] == b"\0" * (4 - size)


@pytest.mark.parametrize("index, sub, value, size", [
    (0x1017, 0, 250, 2), (0x1016, 2, 9 << 16 | 500, 4), (0x1029, 1, 1, 1), (0x6081, 0, 200000, 4), (0x607A, 0, -12345, 4),
    (0x6065, 0, 77777, 4), (0x6066, 0, 321, 2), (0x6881, 0, 100000, 4), (0x3000, 3, 7, 2),
])  # fmt: skip
def test_expedited_download_is_read_back(master, index, sub, value, size):
    master.write(index, sub, value, size)
    assert int.from_bytes(master.node.sdo.upload(index, sub), "little", signed=value < 0) == value


def test_expedited_download_without_a_size_takes_the_objects_own(master):
    assert master.request(0x22, 0x17, 0x10, 0, 0xFA, 0, 0xEE, 0xEE)[0] == 0x60
    assert master.number(0x1017) == 250


@pytest.mark.parametrize("value", [0.5, 720.0, 1e-3])
def test_real32_goes_there_and_back_bit_by_bit(master, value):
    master.node.sdo.download(0x2000, 1, FLOAT.pack(value))
    assert master.node.sdo.upload(0x2000, 1) == FLOAT.pack(value)


@pytest.mark.parametrize("index, sub", [(0x1008, 0), (0x100A, 0), (0x3002, 1), (0x3030, 3)])
def test_segmented_upload_of_a_string_has_the_length_that_it_announces(master, index, sub):
    with master.node.sdo[index][sub].open("rb") if sub else master.node.sdo[index].open("rb") as stream:
        announced = stream.raw.size if hasattr(stream, "raw") else stream.size
        data = stream.read()
    assert data and (announced is None or len(data) == announced) and data.decode("ascii").isprintable()


def test_segmented_download_of_a_short_value_counts_as_one(master):
    assert master.request(0x21, 0x17, 0x10, 0, 2, 0, 0, 0)[0] == 0x60
    assert master.request(0x00 | 5 << 1 | 1, 0x2C, 0x01)[0] == 0x20
    assert master.number(0x1017) == 300


def test_block_upload_and_segmented_upload_give_the_same(master):
    with master.node.sdo[0x3002][1].open("rb", block_transfer=True) as stream:
        by_block = stream.read()
    assert by_block == master.node.sdo.upload(0x3002, 1)


def test_block_upload_works_without_crc(master):
    with master.node.sdo[0x3002][2].open("rb", block_transfer=True, request_crc_support=False) as stream:
        assert stream.read() == master.node.sdo.upload(0x3002, 2)


def test_block_download_of_a_short_value_counts(master):
    with master.node.sdo[0x1016][1].open("wb", size=4, block_transfer=True) as stream:
        stream.write((7 << 16 | 400).to_bytes(4, "little"))
    assert master.number(0x1016, 1) == 7 << 16 | 400


REFUSED = {
    "unknown object, read": (0x5FFF, 0, None, 0x06020000),
    "unknown object, written": (0x5FFF, 0, b"\0", 0x06020000),
    "unknown parameter, written": (0x20F0, 9, b"\0", 0x06020000),
    "unknown sub-index": (0x1018, 9, None, 0x06090011),
    "unknown sub-index, written": (0x2000, 7, b"\0\0\0\0", 0x06090011),
    "unknown sub-index of a variable": (0x1000, 1, None, 0x06090011),
    "1000h is constant": (0x1000, 0, b"\0\0\0\0", 0x06010002),
    "1018h:4 is read only": (0x1018, 4, b"\0\0\0\0", 0x06010002),
    "6041h is read only": (0x6041, 0, b"\0\0", 0x06010002),
    "6502h is read only": (0x6502, 0, b"\0\0\0\0", 0x06010002),
    "2070h:2 is read only": (0x2070, 2, b"\0\0\0\0", 0x06010002),
    "3040h:1 is write only": (0x3040, 1, None, 0x06010001),
    "1017h, too long": (0x1017, 0, b"\0\0\0\0", 0x06070012),
    "1017h, too short": (0x1017, 0, b"\0", 0x06070013),
    "6081h, too short": (0x6081, 0, b"\0\0", 0x06070013),
    "2000h:1, too short": (0x2000, 1, b"\0\0", 0x06070013),
    "2000h:1, a byte too short": (0x2000, 1, b"\0\0\0", 0x06070013),
    "2000h:1, too long": (0x2000, 1, b"\0" * 8, 0x06070012),
    "2070h:1, too long": (0x2070, 1, b"\1\0", 0x06070012),
    "1016h:1, beyond its range": (0x1016, 1, b"\xff\xff\xff\xff", 0x06090031),
    "1019h is never 1": (0x1019, 0, b"\x01", 0x06090030),
    "1029h:1, beyond its range": (0x1029, 1, b"\x09", 0x06090031),
    "3000h:9, below its range": (0x3000, 9, b"\x00", 0x06090032),
    "1010h:1, not the word": (0x1010, 1, b"load", 0x08000020),
    "1011h:1, not the word": (0x1011, 1, b"save", 0x08000020),
    "1003h:0 is written with 0 only": (0x1003, 0, b"\x01", 0x06090030),
    "6060h, a mode that is not there": (0x6060, 0, b"\x05", 0x06090030),
    "6060h, a mode of others": (0x6060, 0, b"\x04", 0x06090030),
    "6060h, above its range": (0x6060, 0, b"\x0b", 0x06090031),
    "6060h, below its range": (0x6060, 0, b"\xfe", 0x06090032),
    "605Ah, an option that is not there": (0x605A, 0, b"\x03\x00", 0x06090030),
    "6083h is never 0": (0x6083, 0, b"\0\0\0\0", 0x06090032),
    "2000h:1, not a number": (0x2000, 1, FLOAT.pack(float("nan")), 0x06090030),
    "2000h:1, infinite": (0x2000, 1, FLOAT.pack(float("inf")), 0x06090031),
    "2000h:1, below its range": (0x2000, 1, FLOAT.pack(-1.0), 0x06090032),
    "2060h:1, locked": (0x2060, 1, FLOAT.pack(2.0), 0x08000022),
}


@pytest.mark.parametrize("index, sub, data, code", REFUSED.values(), ids=REFUSED)
def test_refusal_has_its_code_and_changes_nothing(master, index, sub, data, code):
    readable = data is not None and master.sdo_abort(index, sub) == 0
    before = master.node.sdo.upload(index, sub) if readable else None
    assert master.sdo_abort(index, sub, data) == code
    if readable:
        assert master.node.sdo.upload(index, sub) == before


def test_a_wrong_toggle_bit_ends_the_upload(master):
    assert master.request(0x40, 0x08, 0x10, 0)[0] == 0x41
    assert code_of(master.request(0x70)) == TOGGLE_WRONG


def test_a_segment_without_a_transfer_is_refused(master):
    assert code_of(master.request(0x60)) == BAD_COMMAND


@pytest.mark.parametrize("command", [0xE0, 0xFF])
def test_an_unknown_command_is_refused(master, command):
    assert code_of(master.request(command, 0x00, 0x10, 0)) == BAD_COMMAND


def test_an_abort_of_the_client_is_not_answered_and_frees_the_server(master):
    assert master.request(0x40, 0x08, 0x10, 0)[0] == 0x41
    master.forget()
    master.send(0x600 + NODE_ID, 0x80, 0x08, 0x10, 0, 0, 0, 4, 5)
    assert master.request(0x40, 0x00, 0x10, 0)[0] == 0x43
    assert len(master.heard(0x580 + NODE_ID)) == 1


def test_a_client_that_falls_silent_is_reported(master):
    assert master.request(0x21, 0x17, 0x10, 0, 2, 0, 0, 0)[0] == 0x60
    assert code_of(master.wait_for(0x580 + NODE_ID, 2)[1]) == TIME_OUT
    assert master.number(0x1017) == 100


def test_a_block_download_with_a_wrong_crc_changes_nothing(master):
    assert master.request(0xC6, 0x17, 0x10, 0, 2, 0, 0, 0)[0] & 0xE0 == 0xA0
    assert master.request(0x81, 0x2C, 0x01)[0] & 0xE0 == 0xA0
    assert code_of(master.request(0xC1 | 5 << 2, 0x12, 0x34)) == BAD_CRC
    assert master.number(0x1017) == 100


@pytest.mark.parametrize("length", [0, 1, 7])
def test_a_request_of_fewer_than_8_bytes_is_ignored(master, length):
    master.send(0x600 + NODE_ID, *([0x40, 0x00, 0x10, 0, 0, 0, 0, 0][:length]))
    master.wait_for(0x700 + NODE_ID, 2)
    assert master.heard(0x580 + NODE_ID) == []


def test_every_object_of_the_eds_is_there_with_its_access(master):
    wrong, checked = [], 0
    for entry in master.node.object_dictionary.values():
        if entry.index < 0x1000:
            continue  # types to fill a mapping
        for variable in [entry] if not hasattr(entry, "values") else entry.values():
            code = master.sdo_abort(variable.index, variable.subindex)
            expected = {0x06010001} if variable.access_type == "wo" else {0, 0x08000024, 0x08000022}
            checked += 1
            if code not in expected:
                wrong.append(f"{variable.index:04X}:{variable.subindex} {variable.access_type} {code:08X}")
    assert wrong == [] and checked > 400
