# SPDX-License-Identifier: Apache-2.0
"""Destination of results: tables for people, JSON for programs; errors and progress to the error stream."""

from __future__ import annotations

import json
import re
import shutil
import sys
import textwrap
from collections.abc import Iterable, Sequence
from typing import Any, TextIO

from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn, TimeRemainingColumn
from rich.text import Text

from .table import columns_of, lines, needed

PIPED_WIDTH = 160
DEEPEST_HANG = 16


def wrapped(text: str, stream: TextIO) -> str:
    """Broken between words for a terminal, further lines below the value of "key value"; elsewhere unchanged."""
    if not stream.isatty():
        return text
    head = re.match(r"\s*\S+(?: \S+)*\s{2,}|\s*", text)
    hang = len(head.group(0)) if head else 0
    if hang > DEEPEST_HANG:
        hang = len(text) - len(text.lstrip()) + 2
    width = max(20, shutil.get_terminal_size().columns - 1)
    parts = textwrap.wrap(
        text, width, subsequent_indent=" " * hang, break_long_words=False, break_on_hyphens=False, drop_whitespace=True
    )
    return "\n".join(parts)


class Output:
    """Prints results once, in the requested form."""

    def __init__(self, as_json: bool) -> None:
        self.as_json = as_json
        self._blank = False
        """The last line of the output is a blank one."""
        self.console = Console(highlight=False, soft_wrap=True)
        self.errors = Console(stderr=True, highlight=False)

    def json(self, data: Any) -> None:
        """One JSON document (with --json only), or one line of it in a stream of them."""
        if self.as_json:
            print(json.dumps(data, default=_jsonable, ensure_ascii=False, allow_nan=False), flush=True)

    def say(self, text: str, style: str = "") -> None:
        """A line for people; nothing with --json."""
        if not self.as_json:
            self.console.print(Text(wrapped(text, sys.stdout), style=style), soft_wrap=True)
            self._blank = False

    def note(self, text: str) -> None:
        """A remark on the error stream, so that it is visible with --json (as an object of its own) and in pipes
        too."""
        if self.as_json:
            print(json.dumps({"note": text}, ensure_ascii=False), file=sys.stderr, flush=True)
        else:
            self.errors.print(Text(wrapped(text, sys.stderr), style="yellow"), soft_wrap=True)

    def table(self, columns: Iterable[str | Sequence[str]], rows: Iterable[Iterable[str]], title: str = "") -> None:
        """A table for people; a column is a title, or (title, "right")."""
        if self.as_json:
            return
        described = columns_of(columns, rows)
        width = self.console.width if sys.stdout.isatty() else max(PIPED_WIDTH, needed(described))
        if not self._blank:
            self.console.print()
        if title:
            self.say(title, style="bold")
        for line in lines(described, width):
            self.console.print(line, soft_wrap=True)
        self.console.print()
        self._blank = True

    def progress(self, time_left: bool = False) -> Progress:
        """A progress bar on the error stream, removed when done; shown in a terminal only."""
        left = [TextColumn("left"), TimeRemainingColumn()] if time_left else []
        return Progress(
            TextColumn("{task.description}"),
            BarColumn(),
            TextColumn("{task.percentage:>3.0f} %"),
            TimeElapsedColumn(),
            *left,
            console=self.errors,
            transient=True,
            disable=not self.errors.is_terminal,
        )


def _jsonable(value: Any) -> Any:
    if isinstance(value, bytes):
        return value.hex()
    if hasattr(value, "tolist"):
        return value.tolist()
    raise TypeError(f"{type(value)} cannot be written as JSON")
