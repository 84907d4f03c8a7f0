"""tools/test --changed: which steps and tests a change of each file selects. The tables are those of tools/lib/changed.sh."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]


def text_of(name: str) -> str:
    return (ROOT / name).read_text(encoding="utf-8")


STEPS = re.search(r"^full_steps=\(([^)]*)\)$", text_of("tools/test"), re.MULTILINE)[1].split()


def git(folder: Path, *arguments: str) -> str:
    identity = ["-c", "user.name=x", "-c", "user.email=x@example.invalid"]
    environment = {name: value for name, value in os.environ.items() if not name.startswith("GIT_")}
    return subprocess.run(
        ["git", *identity, *arguments], cwd=folder, env=environment, capture_output=True, text=True, check=True
    ).stdout.strip()


def changed(folder: Path, *base: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(["tools/test", "--changed", *base], cwd=folder, capture_output=True, text=True, check=False)


def write(folder: Path, *names: str) -> None:
    for name in names:
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        with (folder / name).open("a", encoding="utf-8") as file:
            file.write("# changed\n")


@pytest.fixture
def repository(tmp_path):
    """A repository with tools/test alone, whose set-up stops it: nothing is run."""
    (tmp_path / "tools").mkdir()
    shutil.copy(ROOT / "tools/test", tmp_path / "tools/test")
    shutil.copytree(ROOT / "tools/lib", tmp_path / "tools/lib")
    (tmp_path / "tools/setup").write_text("#!/bin/bash\nexit 1\n")
    (tmp_path / "tools/setup").chmod(0o755)
    git(tmp_path, "init", "--quiet", "--initial-branch=main")
    git(tmp_path, "add", ".")
    git(tmp_path, "commit", "--quiet", "--message=first")
    return tmp_path


def chosen(output: str) -> dict[str, str]:
    """Each step with its reason."""
    return dict(re.findall(r"^  (\S+)  +(.*)$", output, re.MULTILINE))


def steps_for(repository: Path, *names: str) -> set[str]:
    write(repository, *names)
    return set(chosen(changed(repository).stdout))


SELECTED = {
    "firmware/control/lugre.c": {"firmware", "host", "asan", "coverage", "attack", "fuzz", "cortex-m4", "image", "tidy", "cppcheck",
                                 "format"},
    "firmware/control/tests/test_lugre.c": {"firmware", "host", "asan", "coverage", "cortex-m4", "format"},
    "hal/hal.h": {"firmware", "host", "image", "cortex-m4", "servoctl-image"},
    "hal/stm32g474/clock.c": {"image", "host", "servoctl-image", "check", "tidy", "cppcheck"},
    "sim_host/simulator/plant/lugre.cpp": {"host", "asan", "attack", "tidy", "check", "servoctl", "cortex-m4", "format"},
    "sim_host/plants/tracker.toml": {"host", "asan", "fuzz", "check"},
    "tools/servoctl/servoctl/main.py": {"servoctl", "servoctl-image", "socketcan", "host"},
    "tests/fuzz/fuzz_sdo_server.c": {"fuzz", "format"},
    "tools/misra/check": {"cppcheck"},
}
NOT_SELECTED = {
    "firmware/control/lugre.c": {"scripts"},
    "firmware/control/tests/test_lugre.c": {"attack", "image", "fuzz", "check", "servoctl", "python"},
    "hal/stm32g474/clock.c": {"coverage", "asan", "fuzz", "cortex-m4", "python"},
    "sim_host/simulator/plant/lugre.cpp": {"coverage", "image", "cppcheck", "scripts"},
    "tools/servoctl/servoctl/main.py": {"coverage", "image", "asan", "format"},
    "tests/fuzz/fuzz_sdo_server.c": {"host", "asan", "attack", "check"},
}


@pytest.mark.parametrize("name", SELECTED)
def test_a_file_selects_what_it_can_affect(repository, name):
    steps = steps_for(repository, name)
    assert SELECTED[name] & set(STEPS) <= steps
    assert not NOT_SELECTED.get(name, set()) & steps


@pytest.mark.parametrize("name", ["CMakeLists.txt", "firmware/CMakeLists.txt", "cmake/X.cmake", "tools/setup", "tools/lib/common.sh",
                                  "tools/requirements.txt", "new_folder/file.xyz", "tests/new_folder/file.py"])  # fmt: skip
def test_an_unknown_file_and_what_every_step_uses_select_every_step(repository, name):
    assert steps_for(repository, name) == set(STEPS)


def test_files_that_no_step_reads_select_nothing(repository):
    write(repository, "LICENSE", ".github/workflows/ci.yml")
    done = changed(repository)
    assert done.returncode == 0
    assert re.fullmatch(r"2 files changed since \w+\. The steps that they can affect, and why:\n  none\n", done.stdout)


def test_only_the_tests_of_what_changed_are_run_on_the_host(repository):
    write(repository, "docs/can-objects.md", "tests/ros2/test_bus_file.py")
    assert chosen(changed(repository).stdout)["host"] == "docs/can-objects.md and 1 more (only these tests: node ros2_bus test_docs)"
    write(repository, "sim_host/simulator/run/run.cpp")
    assert chosen(changed(repository).stdout)["host"] == "docs/can-objects.md and 2 more"


def test_each_test_that_the_list_names_exists():
    named = set(re.findall(r"\bhost:(\w+)", text_of("tools/lib/changed.sh"))) - {"TEST"}
    lists = "".join(path.read_text(encoding="utf-8") for path in (ROOT / "tests").glob("**/CMakeLists.txt"))
    known = set(re.findall(r"add_test\(\s*NAME (\w+)", lists)) | {path.stem for path in (ROOT / "tests").glob("**/test_*.cpp")}
    assert named and named <= known


def test_each_step_can_be_selected_by_a_file_that_does_not_select_all():
    names = [*SELECTED, "tools/report/page.py", "tools/fuzz", "tools/registers/values.toml", "tools/source_checks/words.py", "README.md"]
    script = 'source tools/lib/common.sh; source tools/lib/changed.sh; for n in "$@"; do steps_of_kind "$n"; steps_of_place "$n"; done'
    command = ["bash", "-euc", script, "bash", *names]
    words = set(subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=True).stdout.split())
    assert "all" not in words
    assert set(STEPS) <= words


def test_every_file_of_this_repository_has_a_place_that_is_known_or_is_used_by_all():
    """Files for which every step runs are few: who adds a folder adds it to the list."""
    script = """source tools/lib/common.sh; source tools/lib/checks.sh; source tools/lib/changed.sh
      git ls-files | while read -r file; do [[ "$(steps_of_place "$file")" != *all* ]] || echo "$file"; done"""
    found = subprocess.run(["bash", "-euc", script], cwd=ROOT, capture_output=True, text=True, check=True).stdout.split()
    unknown = [name for name in found if not re.search(r"CMake|\.cmake$|^cmake/|^tools/(lib/|setup$|test$|requirements)", name)]
    assert unknown == []


def test_committed_uncommitted_new_deleted_and_renamed_files_count(repository):
    write(repository, "tools/report/old.py", "tests/ros2/gone.py", "tools/misra/edited")
    git(repository, "add", ".")
    git(repository, "commit", "--quiet", "--message=on main")
    git(repository, "switch", "--quiet", "--create", "work")
    write(repository, "tests/conformance/committed.py")
    git(repository, "add", ".")
    git(repository, "commit", "--quiet", "--message=work")
    (repository / "tests/command_line").mkdir()
    git(repository, "mv", "tools/report/old.py", "tests/command_line/renamed.py")
    (repository / "tests/ros2/gone.py").unlink()
    write(repository, "tools/misra/edited", "tests/canopen/new.py")
    reasons = chosen(changed(repository).stdout)
    assert reasons["host"].endswith("(only these tests: canopen_client command_line conformance ros2_bus test_docs)")
    assert reasons["python"] == "tools/report/old.py" and reasons["cppcheck"] == "tools/misra/edited"
    assert chosen(changed(repository, "HEAD").stdout)["host"].endswith("(only these tests: canopen_client command_line ros2_bus test_docs)")


def test_what_main_has_got_since_does_not_count(repository):
    git(repository, "switch", "--quiet", "--create", "work")
    git(repository, "switch", "--quiet", "main")
    write(repository, "CMakeLists.txt")
    git(repository, "add", ".")
    git(repository, "commit", "--quiet", "--message=main goes on")
    git(repository, "switch", "--quiet", "work")
    write(repository, "LICENSE")
    assert "  none\n" in changed(repository).stdout
    assert "  none\n" in changed(repository, "main").stdout


@pytest.mark.parametrize(("arguments", "reported"), [
    (["nowhere"], "test: 'nowhere' is no commit with a common history: name one, for example --changed HEAD~3.\n"),
    (["HEAD", "host"], "test: --changed takes one commit and no steps.\n"),
])  # fmt: skip
def test_a_wrong_base_is_one_error(repository, arguments, reported):
    failed = changed(repository, *arguments)
    assert failed.returncode == 1 and failed.stderr == reported and failed.stdout == ""
