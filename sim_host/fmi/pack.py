#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Packs a unit: pack.py FMU DESCRIPTION SYSTEM LIBRARY PLANTS LICENSE [LICENSES]. Run by the build.

PLANTS is the folder of plant files, LICENSES that with the texts for what others wrote. The same contents give the same bytes.
"""

import pathlib
import sys
import zipfile

OTHERS = b"\nWhat others wrote in this unit is under the licences that README.txt lists.\n"


def main(fmu: str, description: str, system: str, library: str, plants: str, own: str, others: str = "") -> None:
    """Arguments as above."""
    files = {"modelDescription.xml": pathlib.Path(description).read_bytes()}
    files[f"binaries/{system}/{pathlib.Path(library).name}"] = pathlib.Path(library).read_bytes()
    files |= {f"resources/plants/{file.name}": file.read_bytes() for file in pathlib.Path(plants).glob("*.toml")}
    files["documentation/licenses/license.txt"] = pathlib.Path(own).read_bytes() + (OTHERS if others else b"")
    if others:
        files |= {f"documentation/licenses/{file.name}": file.read_bytes() for file in pathlib.Path(others).iterdir()}
    with zipfile.ZipFile(fmu, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, content in sorted(files.items()):
            archive.writestr(zipfile.ZipInfo(name, (1980, 1, 1, 0, 0, 0)), content, zipfile.ZIP_DEFLATED)


if __name__ == "__main__":
    main(*sys.argv[1:])
