# SPDX-License-Identifier: Apache-2.0
"""What a run of `identify` leaves behind: a program that writes its result and then ends well, badly, or not at all."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

from servoctl.errors import InputError, MotionError
from servoctl.identify.identify_program import ENVIRONMENT, PACKAGE, IdentifyProgram, find_identify

OLD, NEW = "the result before", "new"


def identify(folder: Path, ending: str) -> IdentifyProgram:
    """Writes each of its results, and then does `ending`."""
    program = folder / "identify"
    program.write_text(
        "#!/bin/sh\n"
        'while [ $# -gt 0 ]; do case $1 in --json | --residuals) echo new >"$2" ;; esac; shift; done\n'
        f"{ending}\n"
    )
    program.chmod(0o755)

    def stop() -> None:
        raise MotionError("left.")

    return IdentifyProgram(program, stop)


def files(folder: Path) -> dict[str, str]:
    return {path.name: path.read_text().strip() for path in folder.iterdir() if path.name != "identify"}


@pytest.mark.parametrize(
    ("ending", "error"), [("exec sleep 600", MotionError), ("echo the disk is full >&2; exit 2", InputError), ("exit 0", None)]
)
def test_files_take_the_place_of_those_before_when_a_run_has_succeeded(
    tmp_path: Path, ending: str, error: type[Exception] | None
) -> None:
    result, residuals = tmp_path / "result.json", tmp_path / "residuals.csv"
    for path in (result, residuals):
        path.write_text(OLD)
    program = identify(tmp_path, ending)
    if error is None:
        program.fit(tmp_path / "runs.csv", result, residuals)
    else:
        with pytest.raises(error):
            program.fit(tmp_path / "runs.csv", result, residuals)
    wanted = NEW if error is None else OLD
    assert files(tmp_path) == {"result.json": wanted, "residuals.csv": wanted}


@pytest.fixture
def outside(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """An empty folder that is no checkout's, without any identify."""
    monkeypatch.setattr("servoctl.identify.identify_program.starts", lambda: (tmp_path,))
    monkeypatch.setenv("PATH", str(tmp_path))
    monkeypatch.delenv(ENVIRONMENT, raising=False)
    monkeypatch.delitem(sys.modules, PACKAGE, raising=False)
    monkeypatch.syspath_prepend(str(tmp_path))
    return tmp_path


def test_outside_a_checkout_the_package_has_the_program(outside: Path) -> None:
    package = outside / PACKAGE
    package.mkdir()
    (package / "__init__.py").write_text("from pathlib import Path\nPROGRAM = Path(__file__).parent / 'identify'\n")
    program = identify(package, "").path
    assert find_identify(None) == program
    program.chmod(0o644)
    with pytest.raises(InputError):
        find_identify(None)


def test_without_any_the_sentence_names_what_to_install(outside: Path) -> None:
    with pytest.raises(InputError, match=r"not found: on Linux install 'servoctl\[identify\]'"):
        find_identify(None)
