# SPDX-License-Identifier: Apache-2.0
"""The program `identify` (sim_host/commands/identify.cpp): finds it, runs it, and passes its files."""

from __future__ import annotations

import contextlib
import os
import shutil
import subprocess
from collections.abc import Callable, Iterator
from importlib import import_module
from pathlib import Path
from typing import Any

from ..errors import InputError
from ..objects.schema import named_file_of, starts
from ..show.text_file import json_of, read_text
from .test_plan import Envelope, TestPlan, read_test_plan

ENVIRONMENT = "TRACKSERVO_IDENTIFY"
PACKAGE = "trackservo_identify"
BUILD = "cmake --preset host && cmake --build --preset host --target identify"
LOOK_S = 0.1
FITTED, REFUSED_SOME, REFUSED_SOME_BEFORE = 0, 1, 2
"""Exit codes; programs before 2026-12 ended with 2 where they end with 1 now, both without a sentence."""


def find_identify(explicit: Path | None) -> Path:
    """By option, environment, the build of the surrounding checkout, the package trackservo-identify, PATH; raises
    InputError that says how to get it."""
    named = named_file_of(explicit, ENVIRONMENT)
    if named is not None:
        if not (named.is_file() and os.access(named, os.X_OK)):
            raise InputError(f"{named}: not a program; give the built 'identify'.")
        return named.resolve()
    for start in starts():
        for folder in (start, *start.parents):
            for path in sorted(folder.glob("build/host/bin/identify")):
                return path
    packed = _packed()
    if packed is not None:
        return packed
    found = shutil.which("identify")
    # ImageMagick has a program of this name too.
    if found and "paper-damping" not in (_help(found) or ""):
        found = None
    if found is None:
        raise InputError(
            f"the program 'identify' was not found: on Linux install 'servoctl[identify]', in the source tree build it with"
            f" '{BUILD}', or give its path with --identify-program or {ENVIRONMENT}."
        )
    return Path(found)


def _packed() -> Path | None:
    """That of the package trackservo-identify, if it is installed (tools/identify)."""
    try:
        program = Path(import_module(PACKAGE).PROGRAM)
    except ImportError:
        return None
    return program if os.access(program, os.X_OK) else None


def _help(program: str) -> str | None:
    try:
        return subprocess.run([program, "--help"], capture_output=True, text=True, timeout=5).stdout
    except (OSError, subprocess.TimeoutExpired):
        return None


class IdentifyProgram:
    """`identify plan`, `identify fit` and `identify design`."""

    def __init__(self, path: Path, meanwhile: Callable[[], object] = lambda: None) -> None:
        """`meanwhile` is called ten times a second while the program computes; what it raises ends the program."""
        self.path = path
        self._meanwhile = meanwhile

    def plan(
        self, envelope: Envelope, start_rad: float, plan: Path, identified: Path | None = None, structure: bool = False
    ) -> TestPlan:
        """First look, or with its result the test plan, or the chirps for the structure; written and checked."""
        words = [
            "plan", "--lowest-rad", f"{envelope.lowest_rad!r}", "--highest-rad", f"{envelope.highest_rad!r}",
            "--torque-nm", f"{envelope.torque_nm!r}", "--fastest-rad-s", f"{envelope.fastest_rad_s!r}",
            "--start-rad", f"{start_rad!r}",
        ]  # fmt: skip
        if identified is not None:
            words += ["--identified", str(identified), *(["--structure"] if structure else [])]
        with _kept_whole(plan) as (new,):
            self._run([*words, *_written("--json", new)])
        test_plan = read_test_plan(plan)
        test_plan.check(envelope, str(plan))
        return test_plan

    def fit(
        self, recording: Path, result: Path, residuals: Path | None = None, structure: Path | None = None
    ) -> bool:
        """Whether every parameter was found; `result` is written in both cases."""
        with _kept_whole(*([residuals] if residuals else []), result) as (*left, new):
            words = ["fit", str(recording), *_written("--json", new)]
            words += ["--residuals", str(left[0])] if left else []
            words += ["--structure", str(structure)] if structure else []
            return self._run(words, (REFUSED_SOME, REFUSED_SOME_BEFORE)) == FITTED

    def design(self, identified: Path, requirements: Path, parameters: Path, design: Path) -> Any:
        """The gains for given requirements, in the form of design.json."""
        words = ["design", "--identified", str(identified), "--wishes", str(requirements)]
        words += ["--parameters", str(parameters)]
        with _kept_whole(design) as (new,):
            self._run([*words, *_written("--json", new)])
        return read_json(design, "trackservo-design")

    def _run(self, words: list[str], good_in_silence: tuple[int, ...] = ()) -> int:
        try:
            program = subprocess.Popen([str(self.path), *words], stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
        except OSError as error:
            raise InputError(f"{self.path}: cannot be run: {error.strerror}.") from error
        with program:
            reported = [line for line in self._errors(program).splitlines() if line.strip()]
        code = int(program.returncode)
        if code != FITTED and (reported or code not in good_in_silence):
            reason = " ".join(line.strip() for line in reported).removeprefix("identify: ")
            raise InputError(
                f"'identify {words[0]}' failed:"
                f" {reason or f'{self.path} ended with {code} without a message'}"
            )
        return code

    def _errors(self, program: subprocess.Popen[str]) -> str:
        """What it has written to its error stream, when it has ended."""
        try:
            while True:
                try:
                    return program.communicate(timeout=LOOK_S)[1]
                except subprocess.TimeoutExpired:
                    self._meanwhile()
        except BaseException:
            program.kill()
            raise


@contextlib.contextmanager
def _kept_whole(*files: Path) -> Iterator[list[Path]]:
    """Names beside theirs for the results of a run. They take their places when it has succeeded, the last one last: what a
    run leaves that is ended, or whose disk is full, are the files before it."""
    new = [new_name(file) for file in files]
    try:
        yield new
        for written, file in zip(new, files, strict=True):
            written.replace(file)
    except OSError as error:
        raise InputError(f"{error.filename}: cannot be written: {error.strerror}.") from error
    finally:
        for written in new:
            written.unlink(missing_ok=True)


def new_name(file: Path) -> Path:
    """Beside it, for what takes its place when it is whole."""
    return file.with_name(f"{file.stem}.new{file.suffix}")


def _written(option: str, file: Path) -> tuple[str, str, str]:
    """The options for a result: servoctl has asked whether the user's files may be replaced."""
    return option, str(file), "--overwrite"


def read_json(path: Path, kind: str) -> Any:
    """A file of `identify` of this format, version 1; raises InputError."""
    data = json_of(read_text(path))
    if not isinstance(data, dict) or (data.get("format"), data.get("version")) != (kind, 1):
        raise InputError(f"{path}: not a file of format {kind}, version 1.")
    return data
