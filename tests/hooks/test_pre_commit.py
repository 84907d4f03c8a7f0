# SPDX-License-Identifier: Apache-2.0
"""The hooks of .pre-commit-config.yaml: green on this tree, on the files that ./tools/test checks, and red on a mistake."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
PRE_COMMIT = ROOT / "build/venv/bin/pre-commit"


def hooks(folder: Path, *arguments: str, skip: str = "") -> subprocess.CompletedProcess[str]:
    environment = {name: value for name, value in os.environ.items() if not name.startswith("GIT_")}
    environment["PRE_COMMIT_HOME"] = str(ROOT / "build/pre-commit")
    environment["SKIP"] = skip
    return subprocess.run(
        [PRE_COMMIT, "run", "--all-files", "--color=never", *arguments],
        cwd=folder, env=environment, capture_output=True, text=True, check=False,
    )  # fmt: skip


def committed(function: str) -> int:
    """How many files of a list of tools/lib/checks.sh git knows."""
    script = f"source tools/lib/common.sh; source tools/lib/checks.sh; git ls-files -- $({function}) | wc -l"
    return int(subprocess.run(["bash", "-euc", script], cwd=ROOT, capture_output=True, text=True, check=True).stdout)


def test_the_hooks_are_green_on_the_files_that_tools_test_checks():
    done = hooks(ROOT, "--verbose")
    assert done.returncode == 0, done.stdout
    assert f"\n{committed('our_sources')} files are formatted.\n" in done.stdout
    assert f"\nNothing found in {committed('our_scripts')} scripts.\n" in done.stdout


@pytest.fixture
def repository(tmp_path):
    """A repository with the hooks, whose index takes files by `add`."""
    for name in (".pre-commit-config.yaml", ".clang-format"):
        shutil.copy(ROOT / name, tmp_path / name)
    shutil.copytree(ROOT / "tools/lib", tmp_path / "tools/lib")
    (tmp_path / "build").mkdir()
    (tmp_path / "build/venv").symlink_to((ROOT / "build/venv").resolve())
    subprocess.run(["git", "init", "--quiet"], cwd=tmp_path, check=True)
    return tmp_path


MISTAKES = {
    "format": ("firmware/wrong.c", "int  spaced ;\n", "firmware/wrong.c"),
    "scripts": ("tools/wrong.sh", "#!/bin/bash\necho $1\n", "SC2086"),
}


@pytest.mark.parametrize("hook", MISTAKES)
def test_a_mistake_turns_its_hook_red(repository, hook):
    name, text, reported = MISTAKES[hook]
    (repository / name).parent.mkdir(exist_ok=True)
    (repository / name).write_text(text)
    subprocess.run(["git", "add", name, ".pre-commit-config.yaml"], cwd=repository, check=True)
    failed = hooks(repository, skip="includes")  # it reads the whole tree
    assert failed.returncode == 1 and reported in failed.stdout
    assert re.findall(r"hook id: (\w+)", failed.stdout) == [hook]
