# SPDX-License-Identifier: Apache-2.0
"""tools/test --changed: which steps a change selects, and since when it counts. The lists are those of tools/lib/changed.sh."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
GATE = re.search(r"^gate_steps=\(([^)]*)\)$", (ROOT / "tools/test").read_text(encoding="utf-8"), re.MULTILINE)[1].split()


def git(folder: Path, *arguments: str) -> str:
    identity = ["-c", "user.name=x", "-c", "user.email=x@example.invalid"]
    environment = {name: value for name, value in os.environ.items() if not name.startswith("GIT_")}
    return subprocess.run(
        ["git", *identity, *arguments], cwd=folder, env=environment, capture_output=True, text=True, check=True
    ).stdout.strip()


def changed(folder: Path, *arguments: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(["tools/test", "--changed", *arguments], cwd=folder, capture_output=True, text=True, check=False)


def write(folder: Path, *names: str) -> None:
    for name in names:
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        with (folder / name).open("a", encoding="utf-8") as file:
            file.write("# changed\n")


def commit(folder: Path) -> None:
    git(folder, "add", ".")
    git(folder, "commit", "--quiet", "--message=x")


@pytest.fixture
def repository(tmp_path):
    """A repository with tools/test alone, whose set-up stops it: nothing is run."""
    (tmp_path / "tools").mkdir()
    shutil.copy(ROOT / "tools/test", tmp_path / "tools/test")
    shutil.copytree(ROOT / "tools/lib", tmp_path / "tools/lib")
    (tmp_path / "tools/setup").write_text("#!/bin/bash\nexit 1\n")
    (tmp_path / "tools/setup").chmod(0o755)
    git(tmp_path, "init", "--quiet", "--initial-branch=main")
    commit(tmp_path)
    return tmp_path


def chosen(output: str) -> dict[str, str]:
    """Each step, of the gate and of the depth, with its reason."""
    return dict(re.findall(r"^  (\S+)  +(.*)$", output, re.MULTILINE))


def test_a_file_of_no_known_place_selects_the_whole_gate(repository):
    write(repository, "new_folder/file.xyz")
    assert set(GATE) <= set(chosen(changed(repository).stdout))


def test_a_page_selects_its_tests_alone(repository):
    write(repository, "docs/can.md")
    pages = {step: "docs/can.md" for step in ("socketcan", "site")}
    assert chosen(changed(repository).stdout) == {"short": "docs/can.md (only these tests: test_docs)", **pages}


def test_a_line_of_firmware_leaves_out_the_tests_without_a_servo(repository):
    write(repository, "firmware/control/biquad.c", "tests/judges/new.py")
    reason = chosen(changed(repository).stdout)["short"]
    assert reason.endswith("(without the tests with the label without_servo, but with these: plant_against_mujoco)")
    write(repository, "firmware/control/biquad.h")
    assert "(" not in chosen(changed(repository).stdout)["short"]


def test_committed_uncommitted_new_deleted_and_renamed_files_count(repository):
    write(repository, "tools/report/old.py", "tests/canopen/gone.py", "tools/misra/edited")
    commit(repository)
    git(repository, "switch", "--quiet", "--create", "work")
    write(repository, "docs/images/committed.png")
    commit(repository)
    (repository / "tests/command_line").mkdir()
    git(repository, "mv", "tools/report/old.py", "tests/command_line/renamed.py")
    (repository / "tests/canopen/gone.py").unlink()
    write(repository, "tools/misra/edited", "tests/judges/new.py")
    reasons = chosen(changed(repository).stdout)
    assert reasons["short"].endswith("(only these tests: canopen_client command_line plant_against_mujoco test_docs)")
    assert reasons["python"] == "tools/report/old.py" and reasons["lint"] == "tools/misra/edited"


def test_what_main_has_got_since_does_not_count(repository):
    git(repository, "switch", "--quiet", "--create", "work")
    git(repository, "switch", "--quiet", "main")
    write(repository, "CMakeLists.txt")
    commit(repository)
    git(repository, "switch", "--quiet", "work")
    write(repository, "LICENSE")
    for base in ([], ["main"]):
        done = changed(repository, *base)
        assert done.returncode == 0 and done.stdout.count("  none\n") == 2


def test_without_main_the_gate_runs(repository):
    git(repository, "branch", "--move", "main", "other")
    assert "There is no branch main to compare with: running the gate." in changed(repository).stdout


@pytest.mark.parametrize(("arguments", "reported"), [
    (["nowhere"], "test: 'nowhere' is no commit with a common history: name one, for example --changed HEAD~3.\n"),
    (["HEAD", "short"], "test: --changed takes one commit and no steps.\n"),
])  # fmt: skip
def test_a_wrong_base_is_one_error(repository, arguments, reported):
    failed = changed(repository, *arguments)
    assert failed.returncode == 1 and failed.stderr == reported and failed.stdout == ""
