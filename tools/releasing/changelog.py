#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The sections of CHANGELOG.md.

    changelog.py notes CHANGELOG.md VERSION      prints what the section of VERSION says; refuses a changelog without it
"""

import pathlib
import re

from errors import ReleaseError, run

HEAD = re.compile(r"^## \[(?P<name>[^\]]+)\](?: - (?P<date>\S+))?$", re.MULTILINE)
UNRELEASED = "Unreleased"


def sections(text: str) -> dict[str, tuple[str | None, str]]:
    """Date and text of each version, the newest first."""
    heads = list(HEAD.finditer(text))
    ends = [head.start() for head in heads[1:]] + [len(text)]
    return {head["name"]: (head["date"], text[head.end():end].strip()) for head, end in zip(heads, ends, strict=True)}


def notes(text: str, version: str) -> str:
    """What a closed section says."""
    date, said = sections(text).get(version, (None, ""))
    if not said or not date or not re.fullmatch(r"\d{4}-\d\d-\d\d", date):
        raise ReleaseError(
            f"CHANGELOG.md has no section '## [{version}] - YYYY-MM-DD' with text: tools/release --prepare {version} closes it."
        )
    return said


def closed(text: str, version: str, date: str) -> str:
    """The changelog with what was not released yet as this version."""
    known = sections(text)
    if version in known:
        raise ReleaseError(f"CHANGELOG.md has version {version} already: choose the next one.")
    if not known.get(UNRELEASED, ("", ""))[1]:
        raise ReleaseError(f"CHANGELOG.md says nothing below '## [{UNRELEASED}]': there is nothing to release.")
    return text.replace(f"## [{UNRELEASED}]\n", f"## [{UNRELEASED}]\n\n## [{version}] - {date}\n", 1)


def main(arguments: list[str]) -> None:
    match arguments:
        case ["notes", file, version]:
            print(notes(pathlib.Path(file).read_text("utf-8"), version))
        case _:
            raise ReleaseError(str(__doc__))


if __name__ == "__main__":
    run(main)
