# SPDX-License-Identifier: Apache-2.0
"""The objects of the device: read from parameters.json, which the build prints from the firmware's own table.

servoctl includes the file of the firmware that it was released with (descriptions/, updated by `tools/update-docs
dictionary`). Others are found in builds around the current folder, or given with --parameters; a file that fitted a
device is kept. Only the schema hash (0x3030:2) decides which file belongs to a device.

Names are derived from it and do not change: axis, object and entry, as in azimuth.speed_loop.proportional_gain.
"""

from __future__ import annotations

import contextlib
import functools
import os
import re
import zlib
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from canopen.objectdictionary import ObjectDictionary, ODArray, ODRecord, ODVariable, datatypes

from ..errors import InputError
from ..show.text_file import json_of, read_text
from .parameter import AXES, TYPES, Parameter
from .suggestions import suggest

ENVIRONMENT = "SERVOCTL_PARAMETERS"
CARRIED = Path(__file__).resolve().parents[1] / "descriptions" / "parameters.json"
"""The description of the firmware that this servoctl was released with; faults.json is beside it."""


@dataclass(frozen=True)
class Schema:
    """All objects of one kind of device, and the hash that identifies the device (None: unknown)."""

    source: Path | None
    product: str
    hash: int | None
    parameters: tuple[Parameter, ...]
    text: str = field(default="", repr=False, compare=False)
    """Of the file, which may have been a pipe."""

    def __iter__(self) -> Iterator[Parameter]:
        return iter(self.parameters)

    def by_index(self, index: int, sub: int) -> Parameter | None:
        """The object at an index, or None."""
        return next((p for p in self.parameters if (p.index, p.sub) == (index, sub)), None)

    def find(self, text: str, axis: str | None = None) -> Parameter:
        """The object of a name, of INDEX or of INDEX:SUB; raises InputError with suggestions.

        `axis` completes a name that does not begin with one. A name may also be any ending of the full one that is
        unique.
        """
        at = parse_index(text)
        if at is not None:
            found = self.by_index(*at)
            if found is None:
                raise InputError(f"no object 0x{at[0]:04X}:{at[1]:02X} in {self.origin}.")
            return found
        wanted = text.strip().lower().replace("-", "_").replace(" ", "_")
        names = {p.name: p for p in self.parameters}
        for candidate in (wanted, f"{axis}.{wanted}"):
            if candidate in names:
                return names[candidate]
        endings = [n for n in names if n.endswith("." + wanted) and (axis is None or n.startswith(axis + "."))]
        if len(endings) == 1:
            return names[endings[0]]
        if endings:
            raise InputError(
                f"'{text}' is ambiguous: {_listed(endings)}. Give the full name{'' if axis else ' or --axis'}."
            )
        raise InputError(f"unknown parameter '{text}'{self._suggest(wanted, axis)}")

    def select(self, patterns: Iterable[str], axis: str | None = None) -> list[Parameter]:
        """The readable objects of names, and of groups such as "azimuth.speed_loop" or "speed_loop" with an axis."""
        chosen: dict[tuple[int, int], Parameter] = {}
        for pattern in patterns:
            group = self.group(pattern, axis)
            for parameter in group or [self.find(pattern, axis)]:
                chosen[parameter.index, parameter.sub] = parameter
        return list(chosen.values())

    def group(self, name: str, axis: str | None = None) -> list[Parameter]:
        """The objects below a name, e.g. all of "azimuth.speed_loop"; empty when there is no such group."""
        wanted = name.strip().lower().replace("-", "_")
        for prefix in (wanted, f"{axis}.{wanted}"):
            found = [p for p in self.parameters if p.name.startswith(prefix + ".")]
            if found:
                return found
        return [] if axis else [p for p in self.parameters if any(p.name.startswith(f"{a}.{wanted}.") for a in AXES)]

    @property
    def tunable(self) -> list[Parameter]:
        """Contents of a gains file."""
        return [p for p in self.parameters if p.tunable]

    @property
    def origin(self) -> str:
        """Origin of the schema, for messages."""
        return str(self.source) if self.source else "the standard objects"

    def object_dictionary(self) -> ObjectDictionary:
        """The same objects for python-canopen, so that its own tools work without the EDS."""
        dictionary = ObjectDictionary()
        by_index: dict[int, list[Parameter]] = {}
        for parameter in self.parameters:
            by_index.setdefault(parameter.index, []).append(parameter)
        for index, rows in sorted(by_index.items()):
            if len(rows) == 1 and rows[0].sub == 0:
                dictionary.add_object(_variable(rows[0]))
                continue
            record: ODRecord | ODArray = ODRecord(rows[0].title, index)
            for row in rows:
                record.add_member(_variable(row))
            dictionary.add_object(record)
        return dictionary

    def _suggest(self, wanted: str, axis: str | None) -> str:
        close = suggest(wanted, self.parameters, axis)
        return f"; did you mean {_listed(close)}?" if close else "; 'servoctl explain' lists all names."


NO_SCHEMA = Schema(None, "", None, ())
"""Stands for a file that was not found."""


def _listed(names: list[str]) -> str:
    shown = names[:4]
    text = shown[0] if len(shown) == 1 else ", ".join(shown[:-1]) + " or " + shown[-1]
    return text if len(names) <= 4 else f"{', '.join(shown)} or {len(names) - 4} others"


def parse_index(text: str) -> tuple[int, int] | None:
    """(index, sub-index) of 0x2000:1, 2000h:1 or 6041, or None when the text is no index. Sub-indices: 0x or decimal."""
    match = re.fullmatch(r"\s*(?:0x([0-9a-fA-F]{1,4})|([0-9][0-9a-fA-F]{3})h?)(?:[:/.](0x[0-9a-fA-F]{1,2}|[0-9]{1,3}))?\s*", text)
    if match is None:
        return None
    sub = int(match.group(3), 0) if match.group(3) else 0
    return (int(match.group(1) or match.group(2), 16), sub) if sub <= 255 else None


def _variable(parameter: Parameter) -> ODVariable:
    variable = ODVariable(parameter.title, parameter.index, parameter.sub)
    variable.data_type = getattr(datatypes, parameter.type)
    variable.access_type = parameter.access
    variable.unit = parameter.unit
    setattr(variable, "default", parameter.default)  # noqa: B010 - canopen says int, and takes any value
    variable.pdo_mappable = parameter.rpdo or parameter.tpdo
    variable.description = parameter.help
    return variable


def load_schema(path: Path) -> Schema:
    """Reads a parameters.json; raises InputError naming file and reason."""
    read = read_text(path)
    content: dict[str, Any] = json_of(read)
    try:
        rows = content["objects"]
        heads = {int(row["index"]): str(row["name"]) for row in rows if row["sub"] == 0}
        titles = [_dotted(row, heads) for row in rows]
        parameters = tuple(_parameter(row, name) for row, name in zip(rows, _unique(titles, rows), strict=True))
        return Schema(path, str(content.get("product", "")), _hash_of(content), parameters, read.text)
    except (AttributeError, KeyError, TypeError, ValueError) as error:
        raise InputError(f"{path}: not a parameters.json of the trackservo build ({error!r}).") from error


def load_named(path: Path) -> Schema:
    """The same for a file that the user has named: what is no file, as a pipe, is read only once."""
    return load_schema(path) if path.is_file() else _load_once(path)


@functools.cache
def _load_once(path: Path) -> Schema:
    return load_schema(path)


def _hash_of(content: dict[str, Any]) -> int | None:
    """The hash that the build wrote; device object 0x3030:2 is compared with it."""
    reported = content.get("schema_hash", content.get("hash"))
    return int(reported, 0) if isinstance(reported, str) else int(reported) if reported is not None else None


def _parameter(row: dict[str, Any], name: str) -> Parameter:
    if row["type"] not in TYPES:
        raise ValueError(f"unknown type {row['type']}")
    return Parameter(
        name=name,
        title=row["name"],
        index=row["index"],
        sub=row["sub"],
        type=row["type"],
        access=row["access"],
        unit=row.get("unit", ""),
        low=row.get("low"),
        high=row.get("high"),
        default=row.get("default"),
        stored=row.get("stored", False),
        rpdo=row.get("rpdo", False),
        tpdo=row.get("tpdo", False),
        guarded=row.get("guarded", False),
        help=row.get("help", ""),
    )


def _words(text: str) -> list[str]:
    return [word for word in re.split(r"[^0-9a-z]+", text.lower()) if word]


def _dotted(row: dict[str, Any], heads: dict[int, str]) -> str:
    """axis.object.entry: words of the entry that only repeat the object's are left out."""
    entry, axis = _without_axis(_words(row["name"]))
    if row["index"] not in heads or row["name"] == heads[row["index"]]:
        parts = ["_".join(entry)] if row["sub"] == 0 else ["_".join(entry), str(row["sub"])]
    else:
        head, _ = _without_axis(_words(heads[row["index"]]))
        parts = ["_".join(head), "_".join(_without_head(entry, head))]
    return ".".join([axis, *parts] if axis else parts)


def _without_axis(words: list[str]) -> tuple[list[str], str]:
    return (words[1:], words[0]) if len(words) > 1 and words[0] in AXES else (words, "")


def _without_head(entry: list[str], head: list[str]) -> list[str]:
    """Drops leading words of the entry that are the beginning or the end of the head: the longest such run."""
    for length in range(min(len(entry) - 1, len(head)), 0, -1):
        if entry[:length] in (head[:length], head[-length:]):
            return entry[length:]
    return entry


def _unique(names: list[str], rows: list[dict[str, Any]]) -> list[str]:
    """Where two objects would share a name, the index distinguishes them."""
    seen: dict[str, int] = {}
    for name in names:
        seen[name] = seen.get(name, 0) + 1
    return [
        name if seen[name] == 1 else f"{name}_{row['index']:04x}_{row['sub']}"
        for name, row in zip(names, rows, strict=True)
    ]


def fingerprint(schema: Schema) -> int:
    """A CRC of names, types and indices, to distinguish files that carry no hash."""
    rows = [f"{p.index:04X}:{p.sub:02X} {p.type} {p.access} {p.name}" for p in schema.parameters]
    return zlib.crc32("\n".join(rows).encode())


def named_file(explicit: Path | None) -> Path | None:
    """The parameters.json that the user has named: by option, or in the environment."""
    return named_file_of(explicit, ENVIRONMENT)


def named_file_of(explicit: Path | None, environment: str) -> Path | None:
    """A file that is named by option, or in the environment."""
    return explicit or (Path(os.environ[environment]) if os.environ.get(environment) else None)


def find_schema(reported_hash: int | None) -> Schema:
    """The known file with a device's hash, or NO_SCHEMA, as for a device that reports none; skips broken files."""
    for path in candidates(None) if reported_hash is not None else ():
        try:
            schema = load_schema(path)
        except InputError:
            continue
        if schema.hash == reported_hash:
            return schema
    return NO_SCHEMA


def carried_hash() -> str:
    """The hash of the description included in servoctl, for messages."""
    try:
        return f"{load_schema(CARRIED).hash or 0:08X}"
    except InputError:
        return "none"


def search_places() -> str:
    """Places that `candidates` searches besides servoctl's own description, for messages."""
    folders = " and ".join(str(folder) for folder in dict.fromkeys(starts()))
    return f"build/*/share/trackservo in {folders} and the folders above them, and {cache_folder()}"


def need_schema(explicit: Path | None) -> Schema:
    """The best known file, for callers without a device."""
    return load_named(candidates(explicit)[0])


def starts() -> tuple[Path, Path]:
    """Folders around which builds are searched: here, and the folder of servoctl."""
    return (Path.cwd(), Path(__file__).resolve().parent)


def candidates(explicit: Path | None) -> list[Path]:
    """Possible places of parameters.json, best first: option, environment, then those that the user has not named."""
    named = named_file(explicit)
    return at_hand() if named is None else [named]


def at_hand() -> list[Path]:
    """Every parameters.json that the user has not named, best first: builds around this folder, servoctl's own, those
    used before."""
    found: list[Path] = []
    for start in starts():
        for folder in (start, *start.parents):
            found += sorted(folder.glob("build/*/share/trackservo/parameters.json"))
            found += [folder / "share/trackservo/parameters.json"]
    found += [CARRIED, *sorted(cache_folder().glob("*.json"))]
    return [path for path in dict.fromkeys(found) if path == CARRIED or path.is_file()]


def cache_folder() -> Path:
    """Copies of files of other firmware that fitted a device, so that they need not be named again."""
    return Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "servoctl" / "parameters"


def faults_file(parameters: Path) -> Path:
    """The faults.json of the build that made a parameters.json."""
    if parameters.parent == cache_folder():
        return cache_folder().parent / "faults" / parameters.name
    return parameters.with_name("faults.json")


def remember(schema: Schema) -> None:
    """Keeps copies of a file whose hash a device has confirmed, as it was read, and of its faults.json; a folder that
    cannot be written is no error."""
    if schema.source is None or schema.hash is None or schema.source.parent in (cache_folder(), CARRIED.parent):
        return
    kept = cache_folder() / f"{schema.hash:08x}.json"
    _keep(schema.text, kept)
    faults = faults_file(schema.source)
    if faults.is_file():
        with contextlib.suppress(InputError):
            _keep(read_text(faults).text, faults_file(kept))


def _keep(text: str, copy: Path) -> None:
    """Whole or not at all: a full disk leaves the old copy."""
    with contextlib.suppress(OSError):
        copy.parent.mkdir(parents=True, exist_ok=True)
        new = copy.with_suffix(f".{os.getpid()}")
        try:
            new.write_text(text, encoding="utf-8")
            new.replace(copy)
        finally:
            new.unlink(missing_ok=True)
