# SPDX-License-Identifier: Apache-2.0
"""Tables of numbers as text: a title line, then rows, with comma, semicolon or tab between the cells.

With semicolons or tabs, a comma within a cell is a decimal comma, as spreadsheets write it in half of the world. Lines that begin
with # and empty lines are skipped, also a first line `sep=;` for a spreadsheet. NumPy reads the rows; only when it cannot, or when
a number is none of a table, is each row looked at alone, to name the first bad one.
"""

from __future__ import annotations

import csv
import re
import warnings
from array import array
from collections.abc import Callable, Iterator, Sequence, Sized
from dataclasses import dataclass
from pathlib import Path
from typing import overload

import numpy as np
from numpy.typing import NDArray

from ..errors import InputError
from .text_file import TextFile, read_text

Real = NDArray[np.float64]

LARGEST = 1e12
"""Of a number, in its unit: beyond it, the computation would be inexact."""
_NUMBER = re.compile(r"\s*[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?\s*", re.ASCII)
_HINT = re.compile(r"sep=.", re.IGNORECASE)


def read_columns(path: Path) -> dict[str, Real]:
    """A CSV that a program of ours wrote, as columns by title; a cell may be nan. Raises InputError with file and line."""
    rows = [(number, line) for number, line in read_text(path).lines() if line.strip()]
    titles = [title.strip() for title in rows[0][1].split(",")] if rows else []
    del rows[:1]
    try:
        values = np.loadtxt((line for _, line in rows), delimiter=",", comments=None, ndmin=2) if rows else np.empty((0, len(titles)))
        good = values.shape[1] == len(titles) and not bool(np.any(np.isinf(values)))
    except ValueError:
        good = False
    if not good:
        raise InputError(_first_bad_row(path, titles, rows))
    return dict(zip(titles, values.T, strict=True))


def _first_bad_row(path: Path, titles: Sequence[str], rows: Sequence[tuple[int, str]]) -> str:
    for number, line in rows:
        cells = line.split(",")
        if len(cells) != len(titles):
            return f"{path}:{number}: {len(cells)} values, but the title line has {len(titles)} columns."
        for title, cell in zip(titles, cells, strict=True):
            if not (_NUMBER.fullmatch(cell) and np.isfinite(float(cell))) and cell.strip().lower() != "nan":
                return f"{path}:{number}: {title} is '{cell.strip()}', expected a number."
    return f"{path}: is not a table of numbers."


class Places(Sequence[str]):
    """FILE:LINE of each row; a text is made only of the one that is asked for."""

    def __init__(self, path: Path, lines: NDArray[np.uint32]) -> None:
        self._path = path
        self._lines = lines

    def __len__(self) -> int:
        return len(self._lines)

    @overload
    def __getitem__(self, row: int) -> str: ...
    @overload
    def __getitem__(self, row: slice) -> Places: ...
    def __getitem__(self, row: int | slice) -> str | Places:
        if isinstance(row, slice):
            return Places(self._path, self._lines[row])
        return f"{self._path}:{self._lines[row]}"


@dataclass(frozen=True)
class NumberTable:
    """A row of `values` per row of the file."""

    titles: Sequence[str]
    values: Real
    places: Places


def read_table(source: TextFile, check_titles: Callable[[str, Sequence[str]], Sized], what: str, most_rows: int) -> NumberTable:
    """`what` the file is (a trajectory); `check_titles` gets the place and the titles, and raises InputError.

    Raises InputError with file and line.
    """
    rows = _Rows(source, what, most_rows)
    if rows.titles is None:
        raise InputError(f"{source.path}:1: {what} needs a title line and at least two rows.")
    check_titles(f"{source.path}:{rows.title_line}", rows.titles)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", UserWarning)  # of no rows at all
            values = np.loadtxt(rows.texts(), delimiter=rows.separator, comments=None, ndmin=2, dtype=np.float64)
        good = values.shape[1] == len(rows.titles) and bool(np.all(np.abs(values) <= LARGEST))
    except ValueError:
        good = False
    if not good:
        values = rows.one_by_one()
    if len(values) < 2:
        line = rows.numbers[-1] if rows.numbers else rows.title_line
        raise InputError(f"{source.path}:{line}: {what} needs a title line and at least two rows.")
    return NumberTable(rows.titles, values, Places(source.path, np.array(rows.numbers, dtype=np.uint32)))


class _Rows:
    """The rows of a text, and what its title line says about them."""

    def __init__(self, source: TextFile, what: str, most_rows: int) -> None:
        self._source, self._what, self._most = source, what, most_rows
        self.numbers = array("I")
        """Of the lines that `texts` has given."""
        self.titles: list[str] | None = None
        self.separator = ","
        self.title_line = 1
        for number, line in source.lines():
            if _is_row(line) and not (number == 1 and _HINT.fullmatch(line.strip())):
                self.title_line = number
                self.separator = max(";\t,", key=line.count)
                self.titles = self._cells(number, line)
                return

    def _lines(self) -> Iterator[tuple[int, str]]:
        return ((number, line) for number, line in self._source.lines() if number > self.title_line and _is_row(line))

    def texts(self) -> Iterator[str]:
        """For NumPy: cells without quotes, numbers with a decimal point."""
        self.numbers = array("I")
        quoted, comma = '"' in self._source.text, self.separator != "," and "," in self._source.text
        for number, line in self._lines():
            if len(self.numbers) == self._most:
                raise InputError(
                    f"{self._source.path}:{number}: {self._what} of more than {self._most} rows cannot be used; leave out rows or split it."
                )
            self.numbers.append(number)
            if quoted and '"' in line:
                line = self.separator.join(self._cells(number, line))
            yield line.replace(",", ".") if comma else line

    def _cells(self, number: int, line: str) -> list[str]:
        try:
            return next(csv.reader([line], strict=True, delimiter=self.separator))
        except csv.Error as error:
            raise InputError(f"{self._source.path}:{number}: is not a row of a CSV file: {error}.") from error

    def one_by_one(self) -> Real:
        """The same rows, with the reason and the line of the first bad one."""
        self.numbers = array("I")
        found = array("d")
        titles = self.titles or []
        for number, line in self._lines():
            cells = self._cells(number, line)
            place = f"{self._source.path}:{number}"
            if len(cells) != len(titles):
                comma = "; a decimal comma needs semicolons or tabs between the cells" if self.separator == "," and len(cells) > len(titles) else ""
                raise InputError(f"{place}: {len(cells)} values, but the title line has {len(titles)} columns{comma}.")
            found.extend(self._number(place, title, cell) for title, cell in zip(titles, cells, strict=True))
            self.numbers.append(number)
        return np.array(found).reshape(-1, len(titles))

    def _number(self, place: str, title: str, text: str) -> float:
        plain = text if self.separator == "," else text.replace(",", ".")
        value = float(plain) if _NUMBER.fullmatch(plain) else np.nan
        if not np.abs(value) <= LARGEST:
            raise InputError(f"{place}: {title.strip()} is '{text.strip()}', expected a number from {-LARGEST:g} to {LARGEST:g}.")
        return value


def _is_row(line: str) -> bool:
    text = line.lstrip()
    return bool(text) and text[0] != "#"
