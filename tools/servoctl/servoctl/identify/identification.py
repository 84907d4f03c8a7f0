# SPDX-License-Identifier: Apache-2.0
"""The steps of an identification in a folder of results: for `identify` and the page. Each part is recorded to files of its
own, so that an identification can be left after any part and taken up later, by another program too.

    first look   first_look_plan.json, first_look.csv, then first_look.json by the fit
    test plan    plan.json, runs.csv
    structure    structure_plan.json, structure.csv
    result       result.json, residuals.csv, AXIS-identified.toml, report.html

progress.json names the axis, the limits and the finished parts.
"""

from __future__ import annotations

import json
import math
from collections.abc import Callable
from contextlib import AbstractContextManager, nullcontext
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from ..drive.drive import Drive
from ..drive.node_limits import read_limits
from ..errors import InputError
from ..gains.gain_set import about
from ..gains.gains_file import write_gains
from ..link.device import Device
from ..motion.limits import allowed_travel
from ..objects.parameter import AXES, Parameter, Value
from ..units import degrees, radians
from .commissioning import BreakAway, Commissioning, Outcome, Report
from .identified import Identified, add_machine, read_identified
from .identify_program import IdentifyProgram, new_name, read_json
from .recorder import read_recording
from .test_plan import Envelope, TestPlan

FASTEST_OF_EXPERIMENTS_RAD_S = 100.0
"""2100:15 accepts no more: a 607F above means that it was never set."""
FIRST_LOOK, MAIN, STRUCTURE = "first look", "main test plan", "structural resonances"
PARTS = (FIRST_LOOK, MAIN, STRUCTURE)
RESULT, RESIDUALS, REPORT, PROGRESS = "result.json", "residuals.csv", "report.html", "progress.json"
_FORMAT = "trackservo-identification-progress"
_FILES = {
    FIRST_LOOK: ("first_look_plan.json", "first_look.csv"), MAIN: ("plan.json", "runs.csv"),
    STRUCTURE: ("structure_plan.json", "structure.csv"),
}  # fmt: skip
FIRST_LOOK_RESULT = "first_look.json"


def read_envelope(
    device: Device, axis: int, travel_deg: tuple[float, float] | None, speed_deg_s: float | None
) -> Envelope:
    """Limits of the device and the user; raises InputError for a limit that neither gives."""
    drive = Drive(device, axis)
    travel = allowed_travel(drive, travel_deg)
    low, high = travel.lowest.value, travel.highest.value
    if speed_deg_s is not None and not 0.0 < speed_deg_s < math.inf:
        raise InputError("--speed-deg-s must be greater than 0.")
    node = read_limits(drive)
    if speed_deg_s is not None:
        node.check_rate(radians(speed_deg_s))
    fastest = node.fastest.value if speed_deg_s is None else radians(speed_deg_s)
    if fastest > FASTEST_OF_EXPERIMENTS_RAD_S:
        raise InputError(
            f"{drive.name} has no rate limit (607F, 2060:1). Give its fastest rate, e.g. --speed-deg-s 20."
        )
    return Envelope(low, high, drive.torque_limit(), fastest)


def envelope_text(axis: str, envelope: Envelope) -> str:
    """The bounds of everything that follows."""
    return (
        f"{axis} will move between {degrees(envelope.lowest_rad):.4g}° and {degrees(envelope.highest_rad):.4g}°, at up"
        f" to {degrees(envelope.fastest_rad_s):.4g} °/s, with up to {envelope.torque_nm:.4g} N m; the other axis is"
        " held."
    )


def result_files(folder: Path, axis: int) -> list[Path]:
    """All that an identification may write into its folder."""
    names = [*(name for part in _FILES.values() for name in part), FIRST_LOOK_RESULT, RESULT, RESIDUALS, gains_name(axis), REPORT, PROGRESS]
    return [folder / name for name in names]


def gains_name(axis: int) -> str:
    """Of the gains file with the result."""
    return f"{AXES[axis]}-identified.toml"


def make_folder(folder: Path) -> Path:
    """The folder, created if necessary; raises InputError."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(f"{folder}: cannot be created: {error.strerror}.") from error
    return folder


@dataclass
class Progress:
    """How far an identification has come: progress.json."""

    axis: str
    serial: int
    envelope: Envelope
    done: list[str]
    break_aways: list[BreakAway]
    other_held: bool = True

    def check_machine(self, device: Device, folder: Path) -> None:
        """Raises InputError when it was begun on another device."""
        serial = device.serial_number()
        if self.serial and self.serial != serial:
            raise InputError(
                f"{folder}: was begun on the device with serial number {self.serial}, but this device has {serial}:"
                " begin a new identification."
            )


def read_progress(folder: Path) -> Progress:
    """Raises InputError when the folder has none."""
    path = folder / PROGRESS
    data = read_json(path, _FORMAT)
    try:
        return Progress(
            str(data["axis"]), int(data["serial"]), Envelope(**data["envelope"]), [str(part) for part in data["done"]],
            [BreakAway(**row) for row in data["break_aways"]], bool(data["other_held"]),
        )  # fmt: skip
    except (KeyError, TypeError, ValueError) as error:
        raise InputError(f"{path}: not written by servoctl: {error!r}.") from error


RunPart = Callable[[str, Commissioning, TestPlan], object]
"""Runs a part, as `Identification.run` does, and shows it to people."""


def silent(_what: str, _done_s: float) -> None:
    """A report that nobody reads."""


@dataclass(frozen=True)
class Finished:
    """What an identification has found, and its files."""

    identified: Identified
    plant: dict[Parameter, Value]
    outcome: Outcome
    files: list[Path]


class Identification:
    """One identification. The parts move the axis within a Commissioning; planning and fitting do not."""

    def __init__(
        self, program: IdentifyProgram, device: Device, axis: int, envelope: Envelope, folder: Path,
        fitting: Callable[[str], AbstractContextManager[Any]] = lambda _what: nullcontext(),
    ) -> None:  # fmt: skip
        """`fitting` is entered while the program computes, which may take a quarter of a minute."""
        self.folder = folder
        self.axis = axis
        self.envelope = envelope
        self._program = program
        self._device = device
        self._fitting = fitting
        self._progress = Progress(AXES[axis], device.serial_number(), envelope, [], [])
        self._outcomes: dict[str, Outcome] = {}

    @classmethod
    def take_up(cls, program: IdentifyProgram, device: Device, folder: Path, *more: Any) -> Identification:
        """One that was left; raises InputError when it is of another device."""
        progress = read_progress(folder)
        progress.check_machine(device, folder)
        found = cls(program, device, AXES.index(progress.axis), progress.envelope, folder, *more)
        found._progress = progress
        return found

    def note(self) -> None:
        """Writes progress.json, so that it can be taken up."""
        self._write_progress()

    def is_done(self, part: str) -> bool:
        """Its recording is complete."""
        return part in self._progress.done

    # --- what moves -------------------------------------------------------------------------------------------------

    def plan(self, part: str, folder: Path | None = None) -> TestPlan:
        """Sized by the results of the first look; raises InputError. Written to `folder`, otherwise to the one of the
        results."""
        here = Drive(self._device, self.axis).position()
        path = (folder or self.folder) / _FILES[part][0]
        if part == FIRST_LOOK:
            return self._program.plan(self.envelope, here, path)
        return self._program.plan(self.envelope, here, path, self.folder / FIRST_LOOK_RESULT, structure=part == STRUCTURE)

    def run(self, part: str, machine: Commissioning, test_plan: TestPlan, report: Report) -> Outcome:
        """Moves the axis, and writes the recording."""
        outcome = machine.run(test_plan, report)
        self._outcomes[part] = outcome
        outcome.recording.write(self.recording(part))
        if part != STRUCTURE:
            self._progress.break_aways, self._progress.other_held = outcome.break_aways, outcome.other_held
        self._progress.done = [name for name in PARTS if name == part or name in self._progress.done]
        self._write_progress()
        return outcome

    def carry_out(self, first: TestPlan, quick: bool = False, run: RunPart | None = None) -> Finished:
        """All parts, one after the other, from this plan of the first look on; then the fit. `quick`: the first look alone."""
        run = run or (lambda part, machine, test_plan: self.run(part, machine, test_plan, silent))
        with Commissioning(self._device, self.axis, self.envelope) as machine:
            run(FIRST_LOOK, machine, first)
            if not quick:
                self.fit_first_look()
                for part in (MAIN, STRUCTURE):
                    run(part, machine, self.plan(part))
        return self.finish(quick)

    def recording(self, part: str) -> Path:
        """Its file."""
        return self.folder / _FILES[part][1]

    def _write_progress(self) -> None:
        path = self.folder / PROGRESS
        new = new_name(path)  # a full disk leaves the old one
        try:
            new.write_text(json.dumps({"format": _FORMAT, "version": 1, **asdict(self._progress)}, indent=2) + "\n", encoding="utf-8")
            new.replace(path)
        except OSError as error:
            raise InputError(f"{path}: cannot be written: {error.strerror}.") from error

    # --- what is computed -------------------------------------------------------------------------------------------

    def fit_first_look(self) -> Identified:
        """Rough values, which size the test plan."""
        path = self.folder / FIRST_LOOK_RESULT
        self._fit(self.recording(FIRST_LOOK), path)
        return read_identified(path)

    def finish(self, quick: bool = False) -> Finished:
        """Fits, and writes result, gains file and report; `quick`: from the first look alone."""
        part = FIRST_LOOK if quick else MAIN
        recording, result = self.recording(part), self.folder / RESULT
        residuals = self.folder / RESIDUALS
        self._fit(recording, result, residuals, None if quick else self.recording(STRUCTURE))
        add_machine(result, self._device, self.axis, self.envelope)
        identified = read_identified(result)
        gains = identified.gains(self._device.schema, self.axis)
        plant = identified.plant(self._device.schema, self.axis)
        file = self.folder / gains_name(self.axis)
        if gains:
            write_gains(file, gains, about(self._device))
        outcome = self._outcomes.get(part) or Outcome(
            read_recording(recording), self._progress.break_aways, self._progress.other_held
        )
        page = self._write_report(identified, plant, recording, residuals, outcome)
        return Finished(identified, plant, outcome, [page, result, file])

    def _fit(self, recording: Path, result: Path, residuals: Path | None = None, structure: Path | None = None) -> None:
        with self._fitting(f"fitting {recording.name}"):
            self._program.fit(recording, result, residuals, structure)

    def _write_report(
        self, identified: Identified, plant: dict[Parameter, Value], recording: Path, residuals: Path, outcome: Outcome
    ) -> Path:
        """The pictures take a second to import."""
        from ..show.identification_report import write_identification_report

        path = self.folder / REPORT
        new = new_name(path)
        write_identification_report(new, AXES[self.axis], identified, plant, recording, residuals, outcome)
        new.replace(path)
        return path
