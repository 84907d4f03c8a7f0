# SPDX-License-Identifier: Apache-2.0
"""The page of the names by which servoctl knows the objects: made from servoctl's own description of the device.

Type, range and default are on the page of the objects, which the build prints; each name leads there.
"""

from __future__ import annotations

import re
import sys
from collections.abc import Callable
from pathlib import Path

PROJECT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(PROJECT / "tools" / "servoctl"))

from servoctl.objects.parameter import AXES, Parameter  # noqa: E402
from servoctl.objects.schema import CARRIED, load_schema  # noqa: E402

HEAD = """\
# Parameters by name

Every name that `servoctl get`, `set` and `explain` take, with its object. The objects page, to which the numbers lead,
has type, access, range and default. Names of an axis are those of azimuth: pitch has the same, with `pitch.` in place
of `azimuth.`, 0x800 higher.

The build of this site makes this page from servoctl's description of the device
(`tools/servoctl/servoctl/descriptions/parameters.json`).

"""
TABLE = "| name | object | unit | meaning |\n|---|---|---|---|\n"
COMMON = "others"


def sections_of(objects_page: str, slug: Callable[[str], str]) -> dict[int, str]:
    """Index of each object on the page of the objects, with the anchor of its section."""
    found, anchor = {}, ""
    for line in objects_page.splitlines():
        if line.startswith("## "):
            anchor = slug(line[3:])
        elif row := re.match(r"\| ([0-9A-F]{4}) \|", line):
            found[int(row[1], 16)] = anchor
    return found


def group_of(parameter: Parameter) -> str:
    """azimuth.speed_loop of azimuth.speed_loop.proportional_gain."""
    group = parameter.name.rpartition(".")[0]
    return f"{group}.{COMMON}" if group in AXES else group or COMMON


def page(slug: Callable[[str], str]) -> str:
    """Its Markdown. `slug` makes the anchor of a heading."""
    anchors = sections_of((PROJECT / "docs" / "can-objects.md").read_text(encoding="utf-8"), slug)
    rows = [each for each in load_schema(CARRIED) if each.axis != 1]
    groups: dict[str, list[str]] = {}
    for each in rows:
        if each.access == "const" and any(other.name.startswith(each.name + ".") for other in rows):
            continue  # only says how many entries its object has
        where = f"[{each.index:04X}:{each.sub}](can-objects.md#{anchors[each.index]})"
        meaning = (each.help or each.title).replace("|", "\\|")
        groups.setdefault(group_of(each), []).append(f"| `{each.name}` | {where} | {each.unit} | {meaning} |\n")
    return HEAD + "\n".join(f"## {name}\n\n{TABLE}{''.join(lines)}" for name, lines in sorted(groups.items()))
