# SPDX-License-Identifier: Apache-2.0
"""Text files of users, as editors and spreadsheets on Windows, macOS and Linux write them.

UTF-8 with or without its mark, UTF-16 and UTF-32 with theirs; what is no UTF-8 is Latin-1, which comments may be in. Lines end with
LF, CR LF or CR. A pipe is read as a file is.
"""

from __future__ import annotations

import codecs
import json
import math
import os
import stat
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any, BinaryIO, NoReturn

from ..errors import InputError

MAX_BYTES = 200_000_000
"""Of a file that is read as a whole, unless its reader wants less."""
_MARKS = (
    (codecs.BOM_UTF32_LE, "utf-32"), (codecs.BOM_UTF32_BE, "utf-32"), (codecs.BOM_UTF8, "utf-8-sig"),
    (codecs.BOM_UTF16_LE, "utf-16"), (codecs.BOM_UTF16_BE, "utf-16"),
)  # fmt: skip
"""In this order: the mark of UTF-32 begins as one of UTF-16."""
_BLOCK = 1 << 20
_MOST_DIGITS = 300
"""Of a whole number: a float can still hold it."""


@dataclass(frozen=True)
class TextFile:
    """A file and its text, whose lines end with LF."""

    path: Path
    text: str

    def lines(self) -> Iterator[tuple[int, str]]:
        """Each line without its end, with its number; a large text is never split as a whole."""
        number = begin = 0
        while begin < len(self.text):
            end = self.text.find("\n", begin + _BLOCK) + 1 or len(self.text)
            block = self.text[begin:end].split("\n")
            if not block[-1]:
                block.pop()
            yield from enumerate(block, number + 1)
            number += len(block)
            begin = end


def read_text(path: Path, most_bytes: int = MAX_BYTES) -> TextFile:
    """Raises InputError for what cannot be read, is larger, or is no text."""
    return text_of(path, read_bytes(path, most_bytes))


def text_of(path: Path, data: bytes) -> TextFile:
    """The same for the contents of a file that somebody else has read."""
    text = _decoded(path, data).lstrip("\ufeff")  # a second mark: some programs add one to each file
    del data
    if "\r" in text:
        text = text.replace("\r\n", "\n").replace("\r", "\n")
    text = text.rstrip("\0\x1a")  # padding, and the end of a file of DOS
    if "\0" in text:
        line = text.count("\n", 0, text.index("\0")) + 1
        raise InputError(f"{path}:{line}: has a NUL character: it is no text file, or UTF-16 without a byte order mark; save it as UTF-8.")
    return TextFile(path, text)


def json_of(source: TextFile) -> Any:
    """Raises InputError, with the line of what is no JSON; numbers that are not finite are none."""
    try:
        return json.loads(source.text, parse_constant=_no_number, parse_float=_finite, parse_int=_whole)
    except json.JSONDecodeError as error:
        raise InputError(f"{source.path}:{error.lineno}: invalid JSON: {error.msg}.") from error
    except (ValueError, RecursionError) as error:
        raise InputError(f"{source.path}: invalid JSON: {error}.") from error


def _no_number(text: str) -> NoReturn:
    raise ValueError(f"{text} is not a number that JSON allows")


def _finite(text: str) -> float:
    value = float(text)
    return value if math.isfinite(value) else _no_number(text)


def _whole(text: str) -> int:
    return int(text) if len(text) < _MOST_DIGITS else _no_number(f"{text[:12]}...")


def read_bytes(path: Path, most_bytes: int = MAX_BYTES) -> bytes:
    """Of a file or pipe; raises InputError for what cannot be read or is larger."""
    try:
        with path.open("rb") as file:
            mode = os.fstat(file.fileno()).st_mode
            if not (stat.S_ISREG(mode) or stat.S_ISFIFO(mode) or stat.S_ISSOCK(mode)):
                raise InputError(f"{path}: is not a file.")
            size = os.fstat(file.fileno()).st_size if stat.S_ISREG(mode) else 0
            _check_size(path, size, most_bytes)
            data = _at_most(file, size, most_bytes)
    except IsADirectoryError as error:
        raise InputError(f"{path}: is not a file.") from error
    except OSError as error:
        raise InputError(f"{path}: cannot be read: {error.strerror}.") from error
    _check_size(path, len(data), most_bytes)
    return data


def _at_most(file: BinaryIO, size: int, most_bytes: int) -> bytes:
    """The whole of a file or pipe of perhaps this size, or somewhat more than is allowed."""
    parts = [file.read(size)]
    read = len(parts[0])
    while read <= most_bytes and (part := file.read(_BLOCK)):
        parts.append(part)
        read += len(part)
    return b"".join(parts) if len(parts) > 1 else parts[0]


def _check_size(path: Path, size: int, most_bytes: int) -> None:
    if size > most_bytes:
        raise InputError(f"{path}: has more than {most_bytes / 1e6:g} MB, which is the most that can be read.")


def _decoded(path: Path, data: bytes) -> str:
    for mark, code in _MARKS:
        if data.startswith(mark):
            try:
                return data.decode(code)
            except UnicodeDecodeError as error:
                begin = data[: error.start].decode(code, errors="replace")
                line = 1 + max(begin.count("\n"), begin.count("\r"))
                raise InputError(f"{path}:{line}: is not {code.upper().removesuffix('-SIG')}, although its byte order mark says so; save it as UTF-8.") from error
    try:
        return data.decode("utf-8")
    except UnicodeDecodeError:
        return data.decode("latin-1")
