# SPDX-License-Identifier: Apache-2.0
"""The gains file: TOML, one table for each group of parameters, each value in the unit after it.

It is the reference: `diff` shows where a device differs, `restore` makes the device equal to it. Comments and order of
an existing file are preserved when it is saved again.
"""

from __future__ import annotations

import os
import re
import stat
import sys
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import tomlkit
from tomlkit.exceptions import TOMLKitError
from tomlkit.items import Item, Table

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

from ..errors import InputError
from ..objects.journal import now
from ..objects.parameter import Parameter, Value
from ..objects.schema import Schema
from ..show.output_files import unused
from ..show.text_file import read_text
from ..units import number

DEVICE_TABLE = "device"
MAX_BYTES = 100_000
"""Of a gains file: some times what it needs."""
_PLACE = re.compile(r" \(at (?:line (\d+), column \d+|end of document)\)$")


@dataclass(frozen=True)
class GainsFile:
    """Contents of a file: values by parameter, and the device that it was saved from."""

    path: Path
    values: dict[Parameter, Value]
    device: dict[str, Any]


def read_gains(path: Path, schema: Schema) -> GainsFile:
    """Raises InputError with file, line and remedy."""
    return parse_gains(read_text(path, MAX_BYTES).text, path, schema)


def parse_gains(text: str, path: Path, schema: Schema) -> GainsFile:
    """The contents of a file; raises InputError with file, line and remedy."""
    try:
        content = tomllib.loads(text)
    except (ValueError, RecursionError) as error:  # also a number of too many digits, too many brackets
        raise InputError(_invalid(path, text, error)) from error
    device = content.pop(DEVICE_TABLE, {})
    values: dict[Parameter, Value] = {}
    for name, value in _flatten(content):
        place = f"{path}:{_line_of(text, name)}"
        try:
            parameter = _tunable(schema, name)
            values[parameter] = parameter.check(_scalar(value, parameter))
        except InputError as error:
            raise InputError(f"{place}: {error}") from None
    if not values:
        raise InputError(f"{path}: contains no gains; 'servoctl save {path}' writes such a file.")
    return GainsFile(path, values, device if isinstance(device, dict) else {})


def _invalid(path: Path, text: str, error: Exception) -> str:
    """With the line, the last one if the error has none."""
    found = _PLACE.search(str(error))
    line = found[1] if found and found[1] else text.rstrip("\n").count("\n") + 1
    return f"{path}:{line}: invalid TOML: {_PLACE.sub('', str(error)).rstrip('.')}."


def _scalar(value: Any, parameter: Parameter) -> Value:
    """A number or a text; what is neither, as it may stand in the file, for the message that it is not a number."""
    if isinstance(value, bool) and parameter.type != "BOOLEAN":
        return str(value).lower()
    return value if isinstance(value, int | float | str) else str(value)


def _tunable(schema: Schema, name: str) -> Parameter:
    parameter = schema.find(name)
    if parameter.name != name:
        raise InputError(f"'{name}' must be written in full: {parameter.name}.")
    if not parameter.tunable:
        raise InputError(f"{name} is not a gain: it is read-only or cannot be stored.")
    return parameter


def _flatten(content: Mapping[str, Any], prefix: str = "") -> Iterator[tuple[str, Any]]:
    for key, value in content.items():
        if isinstance(value, dict):
            yield from _flatten(value, f"{prefix}{key}.")
        else:
            yield f"{prefix}{key}", value


def _line_of(text: str, name: str) -> int:
    """The line where a dotted name gets its value; 1 when it is not found."""
    table = ""
    for number_of_line, line in enumerate(text.split("\n"), 1):
        head = re.match(r"\s*\[([^\[\]]+)\]", line)
        if head:
            table = head.group(1).strip() + "."
        key = re.match(r"\s*([\w.\-]+)\s*=", line)
        if key and table + key.group(1) == name:
            return number_of_line
    return 1


def write_gains(path: Path, values: Mapping[Parameter, Value], device: Mapping[str, Any]) -> None:
    """Writes a new file, or updates the values of an existing one and preserves its comments and order."""
    try:
        old = read_text(path, MAX_BYTES).text if path.exists() else ""
        document = tomlkit.parse(old) if old else tomlkit.document()
    except (TOMLKitError, ValueError, RecursionError) as error:
        raise InputError(f"{path}: exists, but is not a gains file that servoctl can update: {error}.") from error
    _replace(path, _filled(document, not old, values, device))


def gains_text(values: Mapping[Parameter, Value], device: Mapping[str, Any]) -> str:
    """The contents of a new file."""
    return _filled(tomlkit.document(), True, values, device)


def _filled(document: Any, new: bool, values: Mapping[Parameter, Value], device: Mapping[str, Any]) -> str:
    if new:
        document.add(tomlkit.comment("Gains, written by servoctl. The unit follows each value."))
        document.add(
            tomlkit.comment(
                "'servoctl diff FILE' compares a device with this file, 'servoctl restore FILE' writes it to a device."
            )
        )
        document.add(tomlkit.nl())
    about = _table(document, DEVICE_TABLE)
    for key, value in {"saved": now(), **device}.items():
        if value is not None:
            about[key] = value
    for parameter, value in sorted(values.items(), key=lambda pair: pair[0].name.count(".")):
        *tables, key = parameter.name.split(".")
        table = _table(document, *tables)
        if key in table and table[key].unwrap() == value:
            continue
        trivia = table[key].trivia.comment if key in table and isinstance(table[key], Item) else ""
        table[key] = value
        item = table[key]
        if isinstance(item, Item):
            item.comment(trivia.lstrip("# ") or _comment(parameter)) if (trivia or _comment(parameter)) else None
    return tomlkit.dumps(document)


def _table(document: Any, *names: str) -> Any:
    table = document
    for name in names:
        if name not in table:
            added: Table = tomlkit.table()
            table[name] = added
        table = table[name]
    return table


def _comment(parameter: Parameter) -> str:
    parts = [parameter.unit, parameter.limits().replace("…", "to"), parameter.help]
    return "; ".join(part for part in parts if part)


def _replace(path: Path, text: str) -> None:
    """All or nothing: a power cut leaves the old file or the new one. A link stays one, and a file keeps its mode."""
    try:
        place = path.resolve()
        place.parent.mkdir(parents=True, exist_ok=True)
        temporary = unused(place.with_name(place.name + ".part"))
        with temporary.open("x", encoding="utf-8") as file:
            file.write(text)
            file.flush()
            os.fsync(file.fileno())
        if place.exists():
            temporary.chmod(stat.S_IMODE(place.stat().st_mode))
        temporary.replace(place)
    except OSError as error:
        raise InputError(f"{path}: cannot be written: {error.strerror}.") from error


def describe_difference(parameter: Parameter, device: Value | None, file: Value | None) -> str:
    """One line for people."""
    return f"{parameter.name}: device {number(device)}, file {number(file)} {parameter.unit}".rstrip()
