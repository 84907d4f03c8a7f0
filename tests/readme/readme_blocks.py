# SPDX-License-Identifier: Apache-2.0
"""The commands of a README: the contents of its ```sh blocks, in order, and the comment before a block.

A block is preceded by nothing, or by one HTML comment that a reader does not see:

    <!-- run: background, ready: TEXT -->   a terminal of its own; it has begun when its output has a line with TEXT. The next
                                            background block, or the next headline of level 2, ends it with SIGINT
    <!-- run: instead: COMMAND -->          run COMMAND in place of the block, because: see REASONS
    <!-- run: hardware, on the emulated board: COMMAND -->
                                            needs a board; COMMAND does the same on the emulated one
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from enum import Enum

_MARK = re.compile(r"<!-- run: (?P<text>.*?) -->")
_FENCE = re.compile(r"^```(?P<language>\w*)$")
_INSTEAD_ALLOWED = ("./tools/test",)
"""The test of the README does not run itself; everything else is run, or needs hardware."""


class Kind(Enum):
    """How a block is run."""

    FOREGROUND = "foreground"
    BACKGROUND = "background"
    INSTEAD = "instead"
    HARDWARE = "hardware"


@dataclass(frozen=True)
class Block:
    """One ```sh block."""

    line: int
    """Line of its first command, from 1."""
    headline: str
    """Of level 2, above it."""
    kind: Kind
    commands: tuple[str, ...]
    """As printed, including comments; a continued line is one command."""
    detail: str = ""
    """The text that signals readiness, or the command that is run instead."""

    @property
    def to_run(self) -> tuple[str, ...]:
        return (self.detail,) if self.kind in (Kind.INSTEAD, Kind.HARDWARE) else self.commands


class ReadmeError(Exception):
    """The README cannot be run, with place and reason."""


def _commands(lines: list[str]) -> tuple[str, ...]:
    """Each command of a block; a backslash at the end continues it."""
    commands: list[str] = []
    open_command = ""
    for line in lines:
        open_command += line
        if line.endswith("\\"):
            open_command += "\n"
            continue
        if open_command.strip() and not open_command.lstrip().startswith("#"):
            commands.append(open_command)
        open_command = ""
    return tuple(commands)


def _kind_of(mark: str, line: int, commands: tuple[str, ...]) -> tuple[Kind, str]:
    if not mark:
        return Kind.FOREGROUND, ""
    for kind, pattern in (
        (Kind.BACKGROUND, r"background, ready: (.+)"),
        (Kind.INSTEAD, r"instead: (.+)"),
        (Kind.HARDWARE, r"hardware, on the emulated board: (.+)"),
    ):
        found = re.fullmatch(pattern, mark)
        if found is not None:
            if kind is Kind.INSTEAD and any(command.split()[0] not in _INSTEAD_ALLOWED for command in commands):
                raise ReadmeError(f"line {line}: only {', '.join(_INSTEAD_ALLOWED)} may run a different command than printed")
            return kind, found[1]
    raise ReadmeError(f"line {line}: '<!-- run: {mark} -->': expected background, instead or hardware")


def blocks_of(text: str) -> list[Block]:
    """All ```sh blocks. Raises ReadmeError for a mark that is unknown or that belongs to no block."""
    blocks: list[Block] = []
    headline, mark, mark_line = "", "", 0
    inside: str | None = None
    lines: list[str] = []
    first = 0
    for number, line in enumerate(text.splitlines(), 1):
        fence = _FENCE.match(line)
        if inside is not None:
            if line == "```":
                if inside == "sh":
                    commands = _commands(lines)
                    kind, detail = _kind_of(mark, first, commands)
                    blocks.append(Block(first, headline, kind, commands, detail))
                    mark = ""
                inside = None
            else:
                lines.append(line)
        elif fence is not None:
            inside, lines, first = fence["language"], [], number + 1
            if mark and inside != "sh":
                raise ReadmeError(f"line {mark_line}: the mark has no ```sh block after it")
        elif (found := _MARK.fullmatch(line.strip())) is not None:
            mark, mark_line = found["text"], number
        elif mark and line.strip():
            raise ReadmeError(f"line {mark_line}: the mark has no ```sh block after it")
        elif line.startswith("## "):
            headline = line[3:]
    if inside is not None or mark:
        raise ReadmeError(f"line {max(first - 1, mark_line)}: a block without an end, or a mark without a block")
    return blocks
