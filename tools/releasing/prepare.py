#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Writes the number of the next version where people write it: CMakeLists.txt, CHANGELOG.md, docs/releases.md.

    prepare.py VERSION DATE      in the project's folder; writes all three files or none
"""

import json
import pathlib
import re
import subprocess

import changelog
import stored_sets
from errors import ReleaseError, run

NUMBER = re.compile(r"^(  VERSION )(\d+\.\d+\.\d+)$", re.MULTILINE)
DESCRIPTION = "tools/servoctl/servoctl/descriptions/parameters.json"


def number_of(version: str) -> tuple[int, ...]:
    """For comparisons."""
    if not re.fullmatch(r"(0|[1-9]\d*)(\.(0|[1-9]\d*)){2}", version) or len(version) > 15:
        raise ReleaseError(f"'{version}' is no version: expected MAJOR.MINOR.PATCH, for example 0.2.0.")
    return tuple(map(int, version.split(".")))


def git(*arguments: str) -> str:
    """What git prints."""
    return subprocess.run(["git", *arguments], check=True, capture_output=True, text=True).stdout


def stated(cmake: str) -> str:
    """The version of the tree."""
    found = NUMBER.search(cmake)
    if found is None:
        raise ReleaseError("CMakeLists.txt has no line 'VERSION MAJOR.MINOR.PATCH' in project().")
    return found[2]


def with_number(cmake: str, version: str) -> str:
    """CMakeLists.txt with it."""
    if number_of(version) < number_of(stated(cmake)):
        raise ReleaseError(f"version {version} is older than the tree's, {stated(cmake)}.")
    return NUMBER.sub(rf"\g<1>{version}", cmake, count=1)


def earlier_sets() -> dict[str, stored_sets.Rows]:
    """What the tagged versions store, the newest first."""
    tags = [tag for tag in git("tag", "--list", "v*").split() if re.fullmatch(r"v\d+\.\d+\.\d+", tag)]
    tags.sort(key=lambda tag: number_of(tag[1:]), reverse=True)
    return {tag[1:]: stored_sets.stored(json.loads(git("show", f"{tag}:{DESCRIPTION}"))) for tag in tags}


def main(arguments: list[str]) -> None:
    if len(arguments) != 2:
        raise ReleaseError(str(__doc__))
    version, date = arguments
    number_of(version)
    files = {name: pathlib.Path(name).read_text("utf-8") for name in ("CMakeLists.txt", "CHANGELOG.md", "docs/releases.md")}
    parameters = json.loads(pathlib.Path(DESCRIPTION).read_text("utf-8"))
    row = stored_sets.row(version, date, parameters, earlier_sets())
    changed = {
        "CMakeLists.txt": with_number(files["CMakeLists.txt"], version),
        "CHANGELOG.md": changelog.closed(files["CHANGELOG.md"], version, date),
        "docs/releases.md": stored_sets.with_row(files["docs/releases.md"], row),
    }
    for name, text in changed.items():
        pathlib.Path(name).write_text(text, "utf-8")


if __name__ == "__main__":
    run(main)
