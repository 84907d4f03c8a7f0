# SPDX-License-Identifier: Apache-2.0
"""Frames in what an SLCAN adapter sends (Lawicel ASCII), tolerant of what adapters do differently.

Lines end with CR, LF or BEL (an error answer), or with several of them. NUL and other bytes that are no printable ASCII are
dropped. A line that begins as a frame or as the rest of one, but is none, is skipped and counted: it was cut at the connect,
or the adapter has lost a part of it.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass

_ENDS = bytes.maketrans(b"\n\a", b"\r\r")
_JUNK = bytes(byte for byte in range(256) if not 0x21 <= byte <= 0x7E and byte not in b"\r\n\a")
_FRAME = re.compile(rb"(?:([tr])([0-7][0-9A-Fa-f]{2})|([TR])([01][0-9A-Fa-f]{7}))([0-8])([0-9A-Fa-f]*)")
_PIECE = re.compile(rb"(?!F[0-9A-F]{2}$)[tTrR0-9a-fA-F]")
"""How frames and their rests begin. Answers (z, Z, V, N, the status F and two digits) and others are no errors."""
_STAMPS = (0, 4, 8)
"""Digits of the time stamp after the data; one of 8 has no agreed unit."""
LONGEST = 64
"""Bytes of a line, more than those of any frame."""


@dataclass(frozen=True)
class Line:
    """A frame; `stamp_ms` is the time of the adapter, which starts over each minute, if it sends that."""

    identifier: int
    extended: bool
    remote: bool
    length: int
    data: bytes
    stamp_ms: int | None


def parse_line(line: bytes) -> Line | None:
    """None for a line that is no whole frame."""
    found = _FRAME.fullmatch(line)
    if found is None:
        return None
    kind, identifier, length, rest = found[1] or found[3], found[2] or found[4], int(found[5]), found[6]
    end = 0 if kind in b"rR" else 2 * length
    if len(rest) - end not in _STAMPS:
        return None
    stamp = int(rest[end:], 16) if len(rest) - end == 4 else None
    return Line(int(identifier, 16), kind in b"TR", kind in b"rR", length, bytes.fromhex(rest[:end].decode()), stamp)


class LineReader:
    """Takes bytes as they come, in any pieces."""

    def __init__(self) -> None:
        self.malformed = 0
        """Lines that were skipped."""
        self._rest = b""

    def take(self, received: bytes) -> Iterator[Line]:
        """The frames that are complete now."""
        *lines, rest = (self._rest + received.translate(_ENDS, _JUNK)).split(b"\r")
        self._rest = rest[:LONGEST]
        for line in lines:
            frame = parse_line(line)
            if frame is not None:
                yield frame
            elif _PIECE.match(line):
                self.malformed += 1
