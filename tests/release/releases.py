# SPDX-License-Identifier: Apache-2.0
"""Two clones in different folders, each with a release of the same commit: what is checked out here, made version 99.0.0."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

PROJECT = Path(__file__).resolve().parents[2]
VERSION, DATE = "99.0.0", "2026-01-02"
WORKFLOW = PROJECT / ".github/workflows/release.yml"
IDENTITY = {
    **{f"GIT_{who}_{what}": value for who in ("AUTHOR", "COMMITTER") for what, value in (("NAME", "x"), ("EMAIL", "x@example.invalid"))},
    "GIT_AUTHOR_DATE": f"{DATE}T00:00:00Z",
    "GIT_COMMITTER_DATE": f"{DATE}T00:00:00Z",
}


def run(folder: Path, *command: str | Path, **environment: str) -> subprocess.CompletedProcess[str]:
    """A command in a folder, without the git repository of who calls us."""
    clean = {name: value for name, value in os.environ.items() if not name.startswith("GIT_")}
    return subprocess.run(
        [str(word) for word in command], cwd=folder, env=clean | IDENTITY | environment, capture_output=True, text=True, check=False
    )


def must(folder: Path, *command: str | Path, **environment: str) -> str:
    """The same, of a command that must succeed."""
    done = run(folder, *command, **environment)
    assert done.returncode == 0, (command, done.stdout[-2000:], done.stderr[-2000:])
    return done.stdout


def clone(source: Path, folder: Path) -> Path:
    """With what tools/setup has installed here."""
    folder.parent.mkdir(parents=True, exist_ok=True)
    must(folder.parent, "git", "clone", "--quiet", "--no-local", source, folder)
    (folder / "build").mkdir()
    for name in ("venv", "release-venv"):
        (folder / "build" / name).symlink_to(PROJECT / "build" / name)
    for name in ("third_party/uplot", "tools/servoctl/servoctl/ui/page/uplot"):
        shutil.copytree(PROJECT / name, folder / name)
    return folder


def commit_version(folder: Path) -> None:
    """As --prepare and a commit, without the build that renews the generated files: of them, the number is all that changes."""
    before = re.search(r"^  VERSION (\S+)$", (folder / "CMakeLists.txt").read_text("utf-8"), re.MULTILINE)[1]
    changes = folder / "CHANGELOG.md"
    changes.write_text(changes.read_text("utf-8").replace("## [Unreleased]\n", "## [Unreleased]\n\n- A release to test.\n", 1), "utf-8")
    must(folder, sys.executable, "-B", "tools/releasing/prepare.py", VERSION, DATE)
    for file in folder.glob("tools/*/*/**/version.txt"):
        file.write_text(f"{VERSION}\n", "ascii")
    page = folder / "docs/can-objects.md"
    page.write_text(page.read_text("utf-8").replace(f'"{before}"', f'"{VERSION}"'), "utf-8")
    must(folder, "git", "commit", "--quiet", "--all", "--message", f"Version {VERSION}")


def step_of_workflow(name: str) -> str:
    """The command of a step of the workflow."""
    return re.search(rf"- name: {re.escape(name)}\n +run: (.*)$", WORKFLOW.read_text("utf-8"), re.MULTILINE)[1]


def make(folder: Path) -> Path:
    """As the workflow makes it of a tag, but for the packages that it downloads."""
    command = step_of_workflow("Make the release").replace("--wheelhouse ", "")
    must(folder, "bash", "-c", command, GITHUB_REF_NAME=f"v{VERSION}")
    return folder / f"build/release/trackservo-{VERSION}"
