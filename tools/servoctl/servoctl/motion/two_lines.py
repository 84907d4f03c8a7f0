# SPDX-License-Identifier: Apache-2.0
"""Files with two-line elements: with or without name lines, of one satellite or several, as people and services write them."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from datetime import datetime
from pathlib import Path

from sgp4.api import Satrec, jday
from sgp4.io import compute_checksum

from ..errors import InputError
from ..show.text_file import TextFile, read_text

_LENGTH = 69
_ONE = re.compile(r"1 ([0-9A-Z ][0-9 ]{4}[UCS ] |.{58})", re.IGNORECASE)
"""Line 1 begins with the number of the satellite, in columns 3 to 7, and its class; a name may begin with "1 ", too."""
_TWO = re.compile(r"2 ([0-9A-Z ][0-9 ]{4} [0-9 ]|.{58})", re.IGNORECASE)
_FIELDS_ONE = ((18, 32),)
_FIELDS_TWO = ((8, 16), (17, 25), (26, 33), (34, 42), (43, 51), (52, 63))
"""Epoch; inclination, node, eccentricity, perigee, anomaly and mean motion: columns from 0, the end excluded."""
_DECIMAL, _POWER = re.compile(r" *[-+]?(\d+\.?\d*|\.\d+) *"), re.compile(r" *([-+]?\d+ *[-+ ]\d)? *")
_FIELDS_DRAG = ((33, 43, _DECIMAL), (44, 52, _POWER), (53, 61, _POWER))
"""First and second derivative of the mean motion, and drag, in line 1; 11606-4 is 0.11606e-4. sgp4 reads none behind a wrong one."""
_NUMBER = re.compile(r" *\d[\d ]*\.?\d* *| *\.\d+ *")
_TITLES = re.compile(r"\btime_m?s\b")
_SHOWN = 5
"""Names in a message."""


@dataclass(frozen=True)
class TwoLines:
    """Elements of one satellite; `line` is the number of line 1 in the file."""

    name: str
    path: Path
    line: int
    one: str
    two: str
    second: int
    """Number of line 2 in the file."""

    @property
    def number(self) -> str:
        """Of the catalogue."""
        return self.one[2:7].strip()

    def satrec(self) -> Satrec:
        """Checked elements; raises InputError with file and line."""
        for number, line in ((self.line, self.one), (self.second, self.two)):
            _check(f"{self.path}:{number}", line)
        if self.one[2:7] != self.two[2:7]:
            raise InputError(f"{self.path}:{self.second}: satellite {self.two[2:7]} differs from {self.one[2:7]} in line 1.")
        for number, line, fields in ((self.line, self.one, _FIELDS_ONE), (self.second, self.two, _FIELDS_TWO)):
            for begin, end in fields:
                if not _NUMBER.fullmatch(line[begin:end]):
                    raise InputError(f"{self.path}:{number}: '{line[begin:end]}' in columns {begin + 1} to {end} is no number: the line is damaged.")
        try:
            found = Satrec.twoline2rv(self.one, self.two)
        except ValueError as error:
            raise InputError(f"{self.path}:{self.line}: {error}.") from error
        if not math.isfinite(found.bstar):
            wrong = ((begin, end) for begin, end, form in _FIELDS_DRAG if not form.fullmatch(self.one[begin:end]))
            begin, end = next(wrong, _FIELDS_DRAG[-1][:2])
            raise InputError(f"{self.path}:{self.line}: '{self.one[begin:end]}' in columns {begin + 1} to {end} is no number: the line is damaged.")
        return found


def _check(place: str, line: str) -> None:
    if len(line) != _LENGTH:
        raise InputError(f"{place}: a line of elements has {_LENGTH} characters, this one has {len(line)}.")
    if not line.isascii():
        raise InputError(f"{place}: a line of elements has only ASCII characters, this one has others: the line is damaged.")
    if str(compute_checksum(line)) != line[-1]:
        raise InputError(f"{place}: the checksum is {line[-1]}, expected {compute_checksum(line)}: the line is damaged.")


def _lines(source: TextFile) -> Iterator[tuple[int, str]]:
    """Numbers and lines, without empty ones, comments and blanks around."""
    for number, line in source.lines():
        stripped = line.strip(" \t")
        if stripped and not stripped.startswith("#"):
            yield number, stripped


def is_elements(source: TextFile) -> bool:
    """A file with two-line elements, and not a CSV, which begins with its titles."""
    if source.path.suffix.lower() in (".tle", ".3le", ".2le"):
        return True
    lines = _lines(source)
    first = next(lines, (0, ""))[1]
    if _TITLES.search(first):
        return False
    return any((_ONE.match(line) or _TWO.match(line)) and "," not in line for line in (first, *(line for _, line in lines)))


def read_entries(file: Path | TextFile) -> list[TwoLines]:
    """All satellites of a file, not checked yet; raises InputError when there is none, or half of one."""
    source = read_text(file) if isinstance(file, Path) else file
    path, lines = source.path, list(_lines(source))
    entries = []
    for at, (number, line) in enumerate(lines):
        if not _ONE.match(line):
            if _TWO.match(line) and (at == 0 or not _ONE.match(lines[at - 1][1])):
                raise InputError(f"{path}:{number}: line 1 of the elements must come before, which begins with '1 '.")
            continue
        if at + 1 == len(lines) or not lines[at + 1][1].startswith("2 "):
            raise InputError(f"{path}:{number}: line 2 of the elements must follow, which begins with '2 '.")
        second, two = lines[at + 1]
        entries.append(TwoLines(_name(lines, at), path, number, line.upper(), two.upper(), second))
    if not entries:
        raise InputError(f"{path}:1: no line of elements begins with '1 '; expected a name, line 1 and line 2.")
    return entries


def _name(lines: Sequence[tuple[int, str]], at: int) -> str:
    """What stands before line 1, unless it is a line of elements; otherwise the number of the satellite."""
    before = lines[at - 1][1] if at else ""
    if before.startswith("0 "):
        before = before.removeprefix("0 ").strip()
    elif before == "0" or _ONE.match(before) or _TWO.match(before):
        before = ""
    return before or f"satellite {lines[at][1][2:7].strip()}"


def choose(entries: Sequence[TwoLines], wanted: str, when: datetime) -> TwoLines:
    """The first satellite, or the one with this number or name; of several elements of it, the newest ones at this time.

    Raises InputError when there is none, or when a part of a name is in several.
    """
    found = _matching(entries, wanted) if wanted else [entry for entry in entries if entry.number == entries[0].number]
    if not found:
        raise InputError(f"{entries[0].path}: has no satellite '{wanted}'; it has {_names(entries)}.")
    if len({entry.number for entry in found}) > 1:
        raise InputError(f"{entries[0].path}: '{wanted}' is a part of several names: {_names(found)}. Give more of one, or a number.")
    return found[0] if len(found) == 1 else min(found, key=lambda entry: abs(age_days(entry.satrec(), when)))


def _matching(entries: Sequence[TwoLines], wanted: str) -> list[TwoLines]:
    """By number, whole name, or part of a name."""
    text = wanted.strip().lower()
    for same in (
        lambda entry: text.lstrip("0") == entry.number.lower().lstrip("0"),
        lambda entry: text == entry.name.lower(),
        lambda entry: text in entry.name.lower(),
    ):
        found = [entry for entry in entries if same(entry)]
        if found:
            return found
    return []


def _names(entries: Sequence[TwoLines]) -> str:
    names = list(dict.fromkeys(entry.name for entry in entries))
    more = f" and {len(names) - _SHOWN} more" if len(names) > _SHOWN else ""
    return ", ".join(names[:_SHOWN]) + more


def age_days(elements: Satrec, when: datetime) -> float:
    """How old the elements are then."""
    whole, part = jday(when.year, when.month, when.day, when.hour, when.minute, float(when.second))
    return float(whole - elements.jdsatepoch + part - elements.jdsatepochF)
