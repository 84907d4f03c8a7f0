#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""What others wrote and a release contains: third_party.toml with the versions of this machine.

    parts.py licences COMPONENT FOLDER      copies the licence texts of the parts of image, programs, emulator, units or identify
"""

import dataclasses
import glob
import pathlib
import re
import shutil
import subprocess
import tomllib
from typing import Any

from errors import ReleaseError, run

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parents[1]
DOC = pathlib.Path("/usr/share/doc")


@dataclasses.dataclass(frozen=True)
class Part:
    """One of third_party.toml. `purl`: type and name of its package, for example ("deb", "libfmt-dev")."""

    name: str
    version: str
    purl: tuple[str, str]
    licence: str
    text: pathlib.Path | None
    within: tuple[str, ...]


def output_of(*command: str) -> str:
    """Raises ReleaseError if it fails."""
    try:
        return subprocess.run(command, check=True, capture_output=True, text=True).stdout.strip()
    except (OSError, subprocess.CalledProcessError) as error:
        raise ReleaseError(f"'{' '.join(command)}' failed: ./tools/setup release installs what is missing.") from error


def debian_package(entry: dict[str, Any]) -> str:
    """By its name, or by a file in it."""
    if "debian" in entry:
        return str(entry["debian"])
    named = str(entry["debian_of"])
    file = pathlib.Path(named if named.startswith("/") else output_of("g++", f"-print-file-name={named}")).resolve()
    return output_of("dpkg-query", "--search", str(file)).split(":")[0]


def pinned(file: pathlib.Path, pattern: str) -> str:
    """The version that a file of this repository pins."""
    found = re.search(pattern, file.read_text("utf-8"), re.MULTILINE)
    if found is None:
        raise ReleaseError(f"{file.relative_to(ROOT)} pins no version by '{pattern}'.")
    return found[1]


def text_file(pattern: str) -> pathlib.Path:
    """The file of this machine, or of this checkout if it is relative."""
    for found in glob.glob(str(ROOT / pattern)):
        return pathlib.Path(found)
    raise ReleaseError(f"there is no {pattern}, a licence text: ./tools/setup release installs what is missing.")


def part(entry: dict[str, Any]) -> Part:
    """An entry of the table, with its version here."""
    text = text_file(entry["text"]) if "text" in entry else None
    if "pypi" in entry:
        version = pinned(ROOT / "tools" / entry.get("pinned_in", "requirements.txt"), rf"^{re.escape(entry['pypi'])}==(\S+)")
        purl = ("pypi", str(entry["pypi"]))
    elif "npm" in entry:
        version = pinned(ROOT / "tools/lib/uplot.sh", r"^uplot_version=(\S+)$")
        purl = ("npm", str(entry["npm"]))
    else:
        package = debian_package(entry)
        version = output_of("dpkg-query", "--show", "--showformat=${Version}", package)
        purl, text = ("deb", package), DOC / package / "copyright"
    return Part(entry["name"], version, purl, entry["licence"], text, tuple(entry["within"]))


def all_parts() -> list[Part]:
    """In the order of the table."""
    return [part(entry) for entry in tomllib.loads((HERE / "third_party.toml").read_text("utf-8"))["part"]]


def copy_licences(component: str, folder: pathlib.Path) -> None:
    """The texts of what is within a component, and a list of them."""
    folder.mkdir(parents=True, exist_ok=True)
    lines = []
    for found in all_parts():
        if component in found.within and found.text is not None:
            name = f"{found.purl[1]}.txt"
            shutil.copyfile(found.text, folder / name)
            lines.append(f"{found.name} {found.version}: {found.licence}; {name}\n")
    (folder / "README.txt").write_text("What others wrote is under these licences:\n\n" + "".join(lines), "utf-8")


def main(arguments: list[str]) -> None:
    match arguments:
        case ["licences", component, folder]:
            copy_licences(component, pathlib.Path(folder))
        case _:
            raise ReleaseError(str(__doc__))


if __name__ == "__main__":
    run(main)
