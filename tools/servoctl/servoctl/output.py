"""Where results go: tables for people, JSON for programs; errors and progress to the error stream."""

from __future__ import annotations

import json
import sys
from collections.abc import Iterable, Sequence
from typing import Any

from rich import box
from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn, TimeRemainingColumn
from rich.table import Table
from rich.text import Text

PIPED_WIDTH = 100


class Output:
    """Prints results once, in the form that was asked for."""

    def __init__(self, as_json: bool) -> None:
        self.as_json = as_json
        piped = None if sys.stdout.isatty() else PIPED_WIDTH
        self.console = Console(highlight=False, width=piped, soft_wrap=False)
        self.errors = Console(stderr=True, highlight=False)

    def json(self, data: Any) -> None:
        """One JSON document (with --json only), or one line of it in a stream of them."""
        if self.as_json:
            print(json.dumps(data, default=_jsonable, ensure_ascii=False, allow_nan=False), flush=True)

    def say(self, text: str, style: str = "") -> None:
        """A line for people; nothing with --json."""
        if not self.as_json:
            self.console.print(Text(text, style=style), soft_wrap=True)

    def note(self, text: str) -> None:
        """A remark on the error stream, so that it is seen with --json and in pipes, too."""
        self.errors.print(Text(text, style="yellow"), soft_wrap=True)

    def table(self, columns: Iterable[str | Sequence[str]], rows: Iterable[Iterable[str]], title: str = "") -> None:
        """A table for people; a column is a title, or (title, "right")."""
        if self.as_json:
            return
        table = Table(
            box=box.SIMPLE_HEAD, title=title or None, title_justify="left", title_style="bold", pad_edge=False
        )
        for column in columns:
            name, justify = (column, "left") if isinstance(column, str) else (column[0], column[1])
            table.add_column(
                name,
                justify="right" if justify == "right" else "left",
                overflow="fold",
                no_wrap=name == "name",  # to be copied
            )
        for row in rows:
            table.add_row(*(Text(cell) for cell in row))
        self.console.print(table)

    def progress(self, time_left: bool = False) -> Progress:
        """A bar on the error stream, gone when done; shown in a terminal only."""
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
    raise TypeError(f"{type(value)} has no JSON form")
