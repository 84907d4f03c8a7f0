# SPDX-License-Identifier: Apache-2.0
"""Files that commands write. None replaces a file of the user unless the option --overwrite asks for it, and none replaces
what the same command reads."""

from __future__ import annotations

import itertools
import os
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any, TypeVar

import click

from ..errors import InputError

F = TypeVar("F", bound=Callable[..., Any])

OVERWRITE = "--overwrite"


def overwrite_option(command: F) -> F:
    """Adds --overwrite, for commands that write files whose names the user gives."""
    return click.option(OVERWRITE, is_flag=True, help="Replace files that exist already.")(command)


def check_new(paths: Iterable[Path], overwrite: bool, option: str, inputs: Iterable[Path] = ()) -> None:
    """Raises InputError unless all `paths` can be written, and replace nothing that they must not. Call before anything moves.

    `option` is the one that names them, for the message; `inputs` are what the command reads: --overwrite does not count for
    those. Devices and pipes may be written always.
    """
    read = [path for path in inputs if path.exists()]
    for path in paths:
        if path.is_dir():
            raise InputError(f"{option}: '{path}' cannot be written: it is a folder. Give the name of a file.")
        if any(path.exists() and path.samefile(each) for each in read):
            raise InputError(f"{option}: '{path}' would be replaced, but this command reads it: give another name.")
        if path.is_file() and not overwrite:
            raise InputError(f"{option}: '{path}' exists already: give another name, or add {OVERWRITE} to replace it.")
        _check_folder(path, option)


def _check_folder(path: Path, option: str) -> None:
    """The nearest folder that exists must take new ones, and files."""
    folder = next(parent for parent in path.absolute().parents if parent.exists())
    if not folder.is_dir() or not os.access(folder, os.W_OK):
        raise InputError(f"{option}: '{path}' cannot be written: {folder} is not a folder that you may write.")


def unused(path: Path, *endings: str) -> Path:
    """`path`, or with -2, -3 and so on after its stem: neither it nor a file beside it with one of the endings exists."""
    for count in itertools.count(1):
        found = path if count == 1 else path.with_stem(f"{path.stem}-{count}")
        if not any(each.exists() for each in (found, *(found.with_suffix(ending) for ending in endings))):
            return found
    raise AssertionError  # count has no end
