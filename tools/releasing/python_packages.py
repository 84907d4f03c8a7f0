#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The Python packages that our wheels need, in the versions that are tested here.

    python_packages.py requirements SITE-PACKAGES WHEEL...      prints a requirements file with hashes: the wheels, and all that
                                                                they need, as tools/requirements.txt pins it

SITE-PACKAGES is that of build/venv, which tools/setup has filled from tools/requirements.txt.
"""

import email
import hashlib
import pathlib
import platform
import re
import sys
import zipfile
from collections.abc import Iterable
from importlib.metadata import Distribution

from packaging.requirements import Requirement
from packaging.utils import NormalizedName, canonicalize_name, parse_wheel_filename

from errors import ReleaseError, run

ROOT = pathlib.Path(__file__).resolve().parents[2]
PINS = ROOT / "tools/requirements.txt"
THIS_MACHINE = f"sys_platform == '{sys.platform}' and platform_machine == '{platform.machine()}'"
"""Where a wheel with a program belongs."""
PIN = re.compile(r"^(\S+)==(\S+) \\\n((?:    --hash=\S+(?: \\)?\n)+)", re.MULTILINE)


def needs_of_wheel(wheel: pathlib.Path) -> list[str]:
    """Its requirements, as its metadata has them."""
    with zipfile.ZipFile(wheel) as archive:
        name = next(name for name in archive.namelist() if name.endswith(".dist-info/METADATA"))
        return email.message_from_bytes(archive.read(name)).get_all("Requires-Dist") or []


def wanted_here(needs: Iterable[str]) -> set[NormalizedName]:
    """The names of those that this kind of machine needs, without extras."""
    requirements = [Requirement(need) for need in needs]
    return {canonicalize_name(need.name) for need in requirements if need.marker is None or need.marker.evaluate({"extra": ""})}


def closure(site: pathlib.Path, wheels: Iterable[pathlib.Path]) -> dict[NormalizedName, Distribution]:
    """All packages that the wheels need, by name; without the wheels' own."""
    wheels = list(wheels)
    ours = {canonicalize_name(parse_wheel_filename(wheel.name)[0]) for wheel in wheels}
    installed = {canonicalize_name(found.metadata["Name"]): found for found in Distribution.discover(path=[str(site)])}
    left = {name for wheel in wheels for name in wanted_here(needs_of_wheel(wheel))} - ours
    found: dict[NormalizedName, Distribution] = {}
    while left:
        name = left.pop()
        if name not in installed:
            raise ReleaseError(f"our wheels need {name}, which tools/requirements.txt does not have: add it to requirements.in.")
        found[name] = installed[name]
        left |= wanted_here(installed[name].requires or []) - found.keys() - ours
    return dict(sorted(found.items()))


def pins() -> dict[NormalizedName, tuple[str, str]]:
    """Version and lines of hashes of each package of tools/requirements.txt."""
    return {canonicalize_name(name): (version, hashes) for name, version, hashes in PIN.findall(PINS.read_text("utf-8"))}


def requirements(site: pathlib.Path, wheels: list[pathlib.Path]) -> str:
    """For pip install --require-hashes."""
    lines = []
    for wheel in sorted(wheels):
        ours, number, _, tags = parse_wheel_filename(wheel.name)
        marker = "" if any(tag.platform == "any" for tag in tags) else f" ; {THIS_MACHINE}"
        lines.append(f"{ours}=={number}{marker} \\\n    --hash=sha256:{hashlib.sha256(wheel.read_bytes()).hexdigest()}\n")
    pinned = pins()
    for name, found in closure(site, wheels).items():
        version, hashes = pinned.get(name, ("", ""))
        if version != found.version:
            raise ReleaseError(f"build/venv has {name} {found.version}, not what tools/requirements.txt pins: run tools/setup.")
        lines.append(f"{name}=={version} \\\n{hashes}")
    return "".join(lines)


def main(arguments: list[str]) -> None:
    match arguments:
        case ["requirements", site, *wheels] if wheels:
            print(requirements(pathlib.Path(site), list(map(pathlib.Path, wheels))), end="")
        case _:
            raise ReleaseError(str(__doc__))


if __name__ == "__main__":
    run(main)
