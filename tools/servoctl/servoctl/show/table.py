# SPDX-License-Identifier: Apache-2.0
"""Tables that fit the terminal: a number, a name or an index is never broken, texts break between words.

Where a row is too wide for one line, the name gets a line of its own above the rest; if there are still too many
columns, they are shown in several tables below one another.
"""

from __future__ import annotations

import textwrap
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass

from rich.cells import cell_len
from rich.text import Text

GAP = 2
"""Blanks between columns."""
EDGE = 1
"""Blanks before the first column."""
INDENT = 2
"""More blanks where the name stands above."""
NAME = "name"
"""The column that may get a line of its own."""
UNBROKEN = (NAME, "index", "time", "signal")
HEAD = "bold"


@dataclass(frozen=True)
class Column:
    """A title and its cells; numbers are at the right and never broken. A title's no-break spaces hold words together."""

    title: str
    right: bool
    cells: Sequence[str]

    @property
    def least(self) -> int:
        """Width below which an unbreakable cell would be broken."""
        unbroken = self.right or self.title in UNBROKEN
        cells = self.cells if unbroken else [word for cell in self.cells for word in cell.split(" ")]
        return max((cell_len(text) for text in [*self.title.split(" "), *cells]), default=0)

    @property
    def most(self) -> int:
        """Width that needs no second line."""
        return max(cell_len(text) for text in [self.title, *self.cells])


def columns_of(titles: Iterable[str | Sequence[str]], rows: Iterable[Iterable[str]]) -> list[Column]:
    """A title is a text, or (text, "right")."""
    heads = [(title, "left") if isinstance(title, str) else (title[0], title[1]) for title in titles]
    cells: list[Sequence[str]] = list(zip(*[list(row) for row in rows], strict=True)) or [() for _ in heads]
    return [Column(title, side == "right", each) for (title, side), each in zip(heads, cells, strict=True)]


def needed(columns: Sequence[Column]) -> int:
    """Width of a line that breaks nothing."""
    return EDGE + sum(column.least for column in columns) + GAP * (len(columns) - 1)


def lines(columns: Sequence[Column], width: int) -> Iterator[Text]:
    """The printed lines, in a terminal of `width` columns; wider only where one column alone is."""
    names = [column for column in columns if column.title == NAME]
    others = [column for column in columns if column.title != NAME]
    if needed(columns) <= width:
        yield from _plain(columns, width)
    elif names and others and INDENT + needed(others) <= width:
        yield from _stacked(names[0], others, width - INDENT)
    else:
        yield from _split(columns, width)


def _widths(columns: Sequence[Column], width: int) -> list[int]:
    """Of each column: the columns that need least get their full width first."""
    found = [column.least for column in columns]
    spare = max(0, width - needed(columns))
    for n in sorted(range(len(columns)), key=lambda n: columns[n].most - columns[n].least):
        more = min(columns[n].most - found[n], spare)
        found[n] += more
        spare -= more
    return found


def _plain(columns: Sequence[Column], width: int) -> Iterator[Text]:
    measured = _widths(columns, width)
    yield from _head(columns, measured)
    for n in range(len(columns[0].cells)):
        yield from _row(columns, [column.cells[n] for column in columns], measured)


def _stacked(name: Column, others: Sequence[Column], width: int) -> Iterator[Text]:
    """The head, then for each row its name and below it, indented, the other cells."""
    measured = _widths(others, width)
    yield Text(" " * EDGE + name.title, HEAD)
    yield from _head(others, measured, INDENT)
    for n, text in enumerate(name.cells):
        yield Text(" " * EDGE + text)
        yield from _row(others, [column.cells[n] for column in others], measured, INDENT)


def _split(columns: Sequence[Column], width: int) -> Iterator[Text]:
    """The first column is repeated in each of the tables."""
    block = [columns[0]]
    for column in columns[1:]:
        if len(block) > 1 and needed([*block, column]) > width:
            yield from _plain(block, width)
            yield Text()
            block = [columns[0]]
        block.append(column)
    yield from _plain(block, width)


def _head(columns: Sequence[Column], measured: Sequence[int], indent: int = 0) -> Iterator[Text]:
    for line in _row(columns, [column.title for column in columns], measured, indent, low=True):
        yield Text(line.plain, HEAD)
    yield Text(" " * (EDGE + indent) + "─" * (sum(measured) + GAP * (len(measured) - 1)))


def _row(
    columns: Sequence[Column], cells: Sequence[str], measured: Sequence[int], indent: int = 0, low: bool = False
) -> Iterator[Text]:
    """As many lines as the longest cell needs; short cells are at the top, or `low` at the bottom."""
    wrapped = [
        textwrap.wrap(cell, width, break_long_words=False, break_on_hyphens=False) or [""]
        for cell, width in zip(cells, measured, strict=True)
    ]
    height = max(len(parts) for parts in wrapped)
    for parts in wrapped:
        missing = [""] * (height - len(parts))
        parts[:] = [*missing, *parts] if low else [*parts, *missing]
    for n in range(height):
        padded = [_pad(parts[n], width, column.right) for column, parts, width in zip(columns, wrapped, measured, strict=True)]
        yield Text((" " * (EDGE + indent) + (" " * GAP).join(padded)).rstrip())


def _pad(text: str, width: int, right: bool) -> str:
    blanks = " " * (width - cell_len(text))
    return blanks + text if right else text + blanks
