#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The table of docs/releases.md: which version keeps which stored set. A set of another version is matched by index,
sub-index and type (docs/decisions/parameter-store.md, 0016), so two descriptions of the device tell what becomes of it.

    stored_sets.py check docs/releases.md VERSION parameters.json      refuses a page whose row does not fit the build
"""

import json
import pathlib
import re
from collections.abc import Mapping
from typing import Any

from errors import ReleaseError, run

HEAD = "| version | date | dictionary (3030:2) | stored values | a set that an earlier version stored |\n|---|---|---|---|---|\n"
ROW = re.compile(r"^\| (\d+\.\d+\.\d+) \| (\S+) \| ([0-9A-F]{8}) \| (\d+) \| (.*) \|$", re.MULTILINE)

Rows = frozenset[tuple[int, int, str]]


def stored(parameters: Mapping[str, Any]) -> Rows:
    """Index, sub-index and type of each stored value."""
    return frozenset((row["index"], row["sub"], row["type"]) for row in parameters["objects"] if row.get("stored"))


def schema_hash(parameters: Mapping[str, Any]) -> str:
    """As the table has it."""
    return f"{int(parameters['schema_hash']):08X}"


def fate(before: Rows, now: Rows) -> str:
    """What a device with `now` does with a set of `before`."""
    dropped, missing = len(before - now), len(now - before)
    if not dropped and not missing:
        return "kept"
    values = [f"{dropped} values dropped"] * bool(dropped) + [f"{missing} new values at their defaults"] * bool(missing)
    return f"kept, {' and '.join(values)}"


def row(version: str, date: str, parameters: Mapping[str, Any], earlier: Mapping[str, Rows]) -> str:
    """Of a new version; `earlier`: those before it."""
    now = stored(parameters)
    fates = [f"{name}: {fate(rows, now)}" for name, rows in earlier.items()]
    return f"| {version} | {date} | {schema_hash(parameters)} | {len(now)} | {'; '.join(fates) or 'the first release'} |\n"


def with_row(page: str, new: str) -> str:
    """The page with a row more, as the first one."""
    if page.count(HEAD) != 1:
        raise ReleaseError("docs/releases.md has no table of stored sets with the known head.")
    return page.replace(HEAD, HEAD + new)


def check(page: str, version: str, parameters: Mapping[str, Any]) -> None:
    """Refuses a page without a row of this version, or with a row of another device."""
    rows = {found[0]: found for found in ROW.findall(page)}
    if version not in rows:
        raise ReleaseError(f"docs/releases.md has no row for version {version}: tools/release --prepare {version} adds it.")
    wanted = (schema_hash(parameters), str(len(stored(parameters))))
    if rows[version][2:4] != wanted:
        raise ReleaseError(
            f"docs/releases.md says of version {version}: dictionary {rows[version][2]} with {rows[version][3]} stored values,"
            f" but the build has {wanted[0]} with {wanted[1]}."
        )


def main(arguments: list[str]) -> None:
    match arguments:
        case ["check", page, version, parameters]:
            check(pathlib.Path(page).read_text("utf-8"), version, json.loads(pathlib.Path(parameters).read_text("utf-8")))
        case _:
            raise ReleaseError(str(__doc__))


if __name__ == "__main__":
    run(main)
