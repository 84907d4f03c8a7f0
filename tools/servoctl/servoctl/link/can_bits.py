# SPDX-License-Identifier: Apache-2.0
"""Time of a classic CAN frame on the bus, in bits (ISO 11898-1): all fields with the stuff bits that its content needs, the
acknowledge slot, the end of frame and the gap of 3 bits after it. Without stuff bits these are 47 + 8 n for n bytes of data and
an 11-bit identifier, 67 + 8 n for a 29-bit one."""

from __future__ import annotations

import can

_UNSTUFFED = 13
"""CRC delimiter, acknowledge slot and delimiter, end of frame (7) and gap (3)."""
_CRC_BITS, _CRC_POLYNOMIAL = 15, 0x4599
_STUFFED_RUN = 5
_STATES = 2 * _STUFFED_RUN
"""Last bit, and how many of it came in a row (1 to 5)."""
_START = 0
"""One 0: a frame begins with one, after the 1 of the idle bus."""


def _crc_table() -> list[int]:
    table = []
    for byte in range(256):
        crc = byte << (_CRC_BITS - 8)
        for _ in range(8):
            crc = (crc << 1 ^ (_CRC_POLYNOMIAL if crc >> (_CRC_BITS - 1) & 1 else 0)) & 0x7FFF
        table.append(crc)
    return table


def _next(state: int, bit: int) -> tuple[int, int]:
    """State after a bit, and the number of stuff bits after it."""
    last, run = divmod(state, _STUFFED_RUN)
    run = run + 1 if bit == last else 0
    if run == _STUFFED_RUN - 1:
        return (1 - bit) * _STUFFED_RUN, 1
    return bit * _STUFFED_RUN + run, 0


def _stuff_table() -> list[list[tuple[int, int]]]:
    """By state and byte."""
    table = []
    for state in range(_STATES):
        row = []
        for byte in range(256):
            now, count = state, 0
            for place in range(7, -1, -1):
                now, stuffed = _next(now, byte >> place & 1)
                count += stuffed
            row.append((now, count))
        table.append(row)
    return table


_CRC, _STUFF = _crc_table(), _stuff_table()


def frame_bits(message: can.Message) -> int:
    """Of a data or remote frame, exact."""
    data = b"" if message.is_remote_frame else bytes(message.data)
    head, bits = _head(message)
    crc = 0
    for byte in head.to_bytes(5, "big") + data:  # leading zeros change nothing
        crc = (crc << 8 & 0x7FFF) ^ _CRC[crc >> (_CRC_BITS - 8) ^ byte]
    size = bits + 8 * len(data) + _CRC_BITS
    content = (head << 8 * len(data) | int.from_bytes(data, "big")) << _CRC_BITS | crc
    return size + _stuff_bits(content, size) + _UNSTUFFED


def _head(message: can.Message) -> tuple[int, int]:
    """The bits before the data, and their number."""
    remote, identifier, length = int(message.is_remote_frame), message.arbitration_id, min(message.dlc, 15)
    if not message.is_extended_id:
        return identifier << 7 | remote << 6 | length, 19
    return ((identifier >> 18) << 20 | 0b11 << 18 | identifier & 0x3FFFF) << 7 | remote << 6 | length, 39


def _stuff_bits(content: int, size: int) -> int:
    """The bits before the first whole byte are filled up with alternating ones, which need no stuff bit."""
    missing = -size % 8
    state, count = _START, 0
    for byte in (0b01010101 >> (8 - missing) << size | content).to_bytes((size + missing) // 8, "big"):
        state, stuffed = _STUFF[state][byte]
        count += stuffed
    return count
