# SPDX-License-Identifier: Apache-2.0
"""Texts of files, in every form that editors write: by servoctl's reader, which all Python programs share."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from servoctl.show import text_file
from servoctl.errors import ServoctlError
from servoctl.show.text_file import TextFile

from .errors import InputError


def json_of(source: TextFile) -> Any:
    """Every fault is an `InputError`."""
    try:
        return text_file.json_of(source)
    except ServoctlError as error:
        raise InputError(str(error)) from error


def read_text(file: Path) -> TextFile:
    """Every fault is an `InputError`."""
    try:
        return text_file.read_text(file)
    except ServoctlError as error:
        raise InputError(str(error)) from error
