# SPDX-License-Identifier: Apache-2.0
"""Runs the page START.md of a release, line by line, on a Debian without other packages: no compiler, no checkout.

    build/venv/bin/python tests/release/run_start.py build/release/trackservo-VERSION [--keep]

As tests/readme/run_readme.py runs the README. If the release has the archive of Python packages (--wheelhouse), pip gets no
index. The output of each command is in build/readme/NN-*.log.
"""

from __future__ import annotations

import argparse
import shutil
import subprocess
import sys
import time
from pathlib import Path

PROJECT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(PROJECT / "tests/readme"))

import run_readme  # noqa: E402
from readme_blocks import blocks_of  # noqa: E402


def make_root(root: Path, release: Path) -> None:
    """A bare Debian with the release at the reader's place."""
    shutil.rmtree(root, ignore_errors=True)
    subprocess.run([str(run_readme.BARE_ROOT), "make", str(root)], check=True)
    shutil.copytree(release, root / run_readme.CLONE.lstrip("/"))


def follow(root: Path, release: Path) -> bool:
    """Whether every command of the page has succeeded."""
    reader = run_readme.Reader(root, {}, on_first_server=lambda: None, page="START.md")
    blocks = blocks_of((release / "START.md").read_text("utf-8"))
    try:
        for house in release.glob("trackservo-wheelhouse-*.tar.gz"):
            name = house.name.removesuffix(".tar.gz")
            reader.prepare(f"tar -xf {house.name} && export PIP_NO_INDEX=1 PIP_FIND_LINKS={run_readme.CLONE}/{name}")
        for previous, block in zip([None, *blocks], blocks, strict=False):
            reader.follow(block, previous)
    except run_readme.Failed:
        print(run_readme.last_lines_of(reader.log, 40))
        return False
    finally:
        reader.close()
    return True


def main() -> int:
    arguments = argparse.ArgumentParser(description=(__doc__ or "").split("\n", maxsplit=1)[0])
    arguments.add_argument("release", type=Path, help="folder of a release")
    arguments.add_argument("--keep", action="store_true", help="keep the created root afterwards")
    options = arguments.parse_args()
    root = PROJECT / "build/bare-root-release"
    run_readme.LOGS.mkdir(parents=True, exist_ok=True)
    make_root(root, options.release)
    started = time.monotonic()
    good = follow(root, options.release)
    print(f"{'passed' if good else 'FAILED'} after {time.monotonic() - started:.0f} s", flush=True)
    if not options.keep:
        shutil.rmtree(root)
    return 0 if good else 1


if __name__ == "__main__":
    sys.exit(main())
