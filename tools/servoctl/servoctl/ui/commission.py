# SPDX-License-Identifier: Apache-2.0
"""The guided commissioning of the page: first look, identify, design, tune. Each step uses the library as the commands
`identify` and `tune` do, and writes the same files to a folder; what is in the folder says which step comes next."""

from __future__ import annotations

import re
import time
from collections.abc import Callable
from dataclasses import asdict
from functools import lru_cache, partial
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Any

import numpy as np

from ..drive import power
from ..drive.drive import Drive
from ..errors import InputError, MotionError
from ..gains import tune_run
from ..gains.frequency_response import branch
from ..gains.loop_model import Complex
from ..gains.loop_test import LINES, LOWEST_HZ, LoopStimulus, loop_stimulus, measure_loop
from ..identify.commissioning import Commissioning, check_place
from ..identify.identification import (
    FIRST_LOOK,
    FIRST_LOOK_RESULT,
    MAIN,
    PROGRESS,
    REPORT,
    RESULT,
    STRUCTURE,
    Identification,
    envelope_text,
    make_folder,
    read_envelope,
    read_progress,
)
from ..identify.identified import Identified, read_identified
from ..identify.identify_program import IdentifyProgram, find_identify, read_json
from ..identify.recorded_signals import RecordedSignals
from ..identify.test_plan import COLUMNS, Envelope, as_json, rows_of, summary_of
from ..link.device import Device
from ..motion.moves import plan_data
from ..objects.access_lock import need_unlock
from ..objects.journal import state_folder
from ..objects.parameter import AXES
from ..show.friction_curves import DIRECTIONS, Legs, friction_points, legs, steady_friction_nm
from ..show.number_table import read_columns
from ..units import degrees, number, radians

if TYPE_CHECKING:
    from .jobs import Jobs

_NAME = re.compile(r"identify-(azimuth|pitch)-[0-9]{8}T[0-9]{6}Z")
_FILE = re.compile(r"[A-Za-z0-9_-]+\.(html|json|csv|toml)")
LABELS = {
    "speed_loop_bandwidth_hz": "bandwidth of the speed loop", "speed_loop_damping": "damping of the speed loop",
    "setpoint_weight": "set-point weight", "setpoint_model_hz": "frequency of the set-point model",
    "observer_bandwidth_hz": "bandwidth of the observer",
    "disturbance_rms_nm": "slow torque from outside, rms", "disturbance_corner_hz": "its corner frequency",
    "least_gain_margin_db": "smallest gain margin", "least_phase_margin_deg": "smallest phase margin",
    "most_torque_noise_nm": "largest torque noise", "tracking_bandwidth_hz": "bandwidth of the tracking loop",
    "position_bandwidth_hz": "bandwidth of the position loop",
}  # fmt: skip
"""Of the requirements, as on the page."""
CURVE_POINTS = 60


# --- what is in the folders; needs no bus -----------------------------------------------------------------------------


def root() -> Path:
    """Where the page keeps identifications."""
    return state_folder() / "commissioning"


def find(name: str) -> Path:
    """The folder of an identification; raises InputError."""
    path = root() / name
    if not _NAME.fullmatch(name) or not path.is_dir():
        raise InputError(f"there is no identification '{name}'.")
    return path


def find_file(name: str, file: str) -> Path:
    """One of its files; raises InputError."""
    path = find(name) / file
    if not _FILE.fullmatch(file) or not path.is_file():
        raise InputError(f"there is no file '{file}' in {name}.")
    return path


def overview() -> list[dict[str, Any]]:
    """All identifications, newest first, and how far each has come."""
    names = sorted((path.name for path in root().glob("identify-*") if _NAME.fullmatch(path.name)), key=lambda n: n[-16:], reverse=True)
    return [{"name": name, "axis": name.split("-")[1], "done": _done(root() / name)} for name in names]


def _done(folder: Path) -> list[str]:
    """Finished steps and parts of steps."""
    try:
        parts = list(read_progress(folder).done) if (folder / PROGRESS).exists() else []
    except InputError:  # one folder hides no other; whoever opens it reads what is wrong
        parts = []
    found = [part for part in parts if part != FIRST_LOOK or (folder / FIRST_LOOK_RESULT).exists()]
    files = {"identify": (RESULT, REPORT), "design": ("design.json",), "tune": (tune_run.PAGE,)}  # the last one is written last
    return found + [step for step, names in files.items() if all((folder / name).exists() for name in names)]


def details(name: str) -> dict[str, Any]:
    """Everything that is known, for the steps of the page."""
    folder = find(name)
    progress = read_progress(folder)
    envelope = progress.envelope
    result, rough = folder / RESULT, folder / FIRST_LOOK_RESULT
    identified = read_identified(result if result.exists() else rough) if result.exists() or rough.exists() else None
    runs = folder / ("runs.csv" if result.exists() else "first_look.csv")
    return {
        "name": name, "axis": progress.axis, "folder": str(folder), "done": _done(folder),
        "envelope": envelope_text(progress.axis, envelope),
        "limits": {"low_deg": degrees(envelope.lowest_rad), "high_deg": degrees(envelope.highest_rad), "rate_deg_s": degrees(envelope.fastest_rad_s)},
        "files": sorted(path.name for path in folder.iterdir() if _FILE.fullmatch(path.name)),
        "identified": _identified(identified) if identified else None,
        "friction": _friction(identified, _legs(runs, runs.stat().st_mtime)) if identified and runs.exists() else None,
        "design": _designed(folder), "report": REPORT if (folder / REPORT).exists() else None,
        "tuned": tune_run.PAGE if (folder / tune_run.PAGE).exists() else None,
    }  # fmt: skip


def _identified(found: Identified) -> dict[str, Any]:
    return {
        "rows": [estimate.row() for estimate in found.estimates.values()], "warnings": found.warnings,
        "refused": [message for _, message in found.refused], "complete": not found.refused,
    }  # fmt: skip


@lru_cache(maxsize=4)
def _legs(path: Path, _changed: float) -> Legs:
    return legs(read_columns(path))


def _friction(found: Identified, points: Legs) -> dict[str, Any]:
    """Torque over joint speed, °/s: mean of each leg at a constant speed without the constant load, and the model."""
    curves = []
    for direction in DIRECTIONS:
        speed, friction = friction_points(found, points, direction)
        grid = np.geomspace(speed.min() / 2, speed.max(), CURVE_POINTS) if len(speed) else np.geomspace(1e-4, 0.3, CURVE_POINTS)
        model = steady_friction_nm(found, direction, grid)
        curves.append({
            "direction": direction, "speed_deg_s": degrees(1.0) * speed, "torque_nm": friction,
            "model_speed_deg_s": degrees(1.0) * grid, "model_nm": model,
        })  # fmt: skip
    return {"curves": [{key: _list(value) for key, value in curve.items()} for curve in curves]}


def _list(value: Any) -> Any:
    return value.round(6).tolist() if isinstance(value, np.ndarray) else value


def _designed(folder: Path) -> dict[str, Any] | None:
    path = folder / "design.json"
    if not path.exists():
        return None
    loop = read_json(path, "trackservo-design")["loop_gain"]
    return {"loop": _bode(np.asarray(loop["frequency_hz"]), np.asarray(loop["real"]) + 1j * np.asarray(loop["imag"]))}


def _bode(frequency_hz: Any, loop: Complex) -> dict[str, Any]:
    gain_db = 20 * np.log10(np.abs(loop))
    phase_deg = branch(np.degrees(np.unwrap(np.angle(loop))), gain_db)
    return {"frequency_hz": _list(np.asarray(frequency_hz)), "db": _list(gain_db), "deg": _list(phase_deg)}


# --- the steps, run by the thread of the bus --------------------------------------------------------------------------


class Commission:
    """Angles in °, rates in °/s, as people read them. Words are those of the page."""

    def __init__(self, jobs: Jobs, device: Device) -> None:
        self._jobs = jobs
        self._engine = jobs.engine
        self._device = device

    def _program(self) -> IdentifyProgram:
        """A stop ends it, and so does an order while it only shows what would be."""
        return IdentifyProgram(find_identify(None), lambda: self._engine.look_after(self._device))

    def dry_run(self, axis: int, name: str, step: str, travel_deg: tuple[float, float] | None, speed_deg_s: float | None) -> dict[str, Any]:
        """What a step would move, as `identify --dry-run`: nothing moves, and no file stays."""
        self._need_rest()
        with TemporaryDirectory() as work:
            if name:
                run = Identification.take_up(self._program(), self._device, find(name))
            else:
                envelope = self._envelope(axis, travel_deg, speed_deg_s)
                run = Identification(self._program(), self._device, axis, envelope, Path(work))
            check_place(Drive(self._device, run.axis), run.envelope)
            plans = [(part, run.plan(part, Path(work))) for part in self._parts(run, step)]
        return {
            "axis": AXES[run.axis], "envelope": envelope_text(AXES[run.axis], run.envelope), "columns": COLUMNS,
            "plans": [{"title": part, "rows": rows_of(plan), "summary": summary_of(plan), **as_json(plan)} for part, plan in plans],
        }  # fmt: skip

    def _envelope(self, axis: int, travel_deg: tuple[float, float] | None, speed_deg_s: float | None) -> Envelope:
        try:
            return read_envelope(self._device, axis, travel_deg, speed_deg_s)
        except InputError as error:
            text = str(error).replace("--travel-deg", "the travel").replace("--speed-deg-s", "the rate")
            raise InputError(text) from error

    @staticmethod
    def _parts(run: Identification, step: str) -> list[str]:
        """Those of a step that are not done."""
        wanted = (FIRST_LOOK,) if step == "look" else (MAIN, STRUCTURE)
        if step != "look" and not run.is_done(FIRST_LOOK):
            raise InputError("the first look comes first: it sizes the test plan.")
        return [part for part in wanted if not run.is_done(part)]

    def begin(self, axis: int, travel_deg: tuple[float, float] | None, speed_deg_s: float | None) -> str:
        """A new folder; its name. Nothing moves."""
        envelope = self._envelope(axis, travel_deg, speed_deg_s)
        name = time.strftime(f"identify-{AXES[axis]}-%Y%m%dT%H%M%SZ", time.gmtime())
        run = Identification(self._program(), self._device, axis, envelope, make_folder(root() / name))
        run.note()
        return name

    def look(self, name: str) -> dict[str, Any]:
        """The first look: recorded unless it is there, and fitted."""
        run = self._take_up(name)
        self._record(run, "look")
        self._compute("fits the first look", run.fit_first_look)
        self._engine.say(f"{AXES[run.axis]}: first look done", "good")
        return details(name)

    def identify(self, name: str) -> dict[str, Any]:
        """The parts of the test plan that are not recorded yet, then the fit and its files."""
        run = self._take_up(name)
        self._record(run, "identify")
        found = self._compute("fits the test plan", run.finish)
        self._engine.say(f"{AXES[run.axis]}: identified; {found.files[0]}", "good")
        return details(name)

    def _need_rest(self) -> None:
        """The program computes in the thread of the bus, which has to serve enabled axes."""
        if self._jobs.held:
            raise MotionError("it needs both axes at rest: disable the axes first.")

    def _take_up(self, name: str) -> Identification:
        self._need_rest()
        return Identification.take_up(self._program(), self._device, find(name))

    def _record(self, run: Identification, step: str) -> None:
        """On any error or stop the axis ends at rest; finished parts stay."""
        parts = self._parts(run, step)
        if not parts:
            return
        name, other = AXES[run.axis], 1 - run.axis
        drive = Drive(self._device, run.axis)
        try:
            with self._engine.without_stream(self._device, {run.axis: power.NO_MODE, other: power.NO_MODE}):
                with Commissioning(self._device, run.axis, run.envelope) as machine:
                    self._engine.show(RecordedSignals(machine.recorder, run.axis, drive.position()))
                    for part in parts:
                        self._engine.commissioning = {"axis": name, "part": part, "what": "is planned", "done_s": 0.0, "duration_s": 1.0}
                        plan = run.plan(part)
                        outcome = run.run(part, machine, plan, self._reporter(name, part, plan.duration_s))
                        self._engine.say(f"{name}: {part} recorded to {run.recording(part)}")
                        for run_number, share in outcome.incomplete_runs():
                            self._engine.say(f"run {run_number} lost {100 * share:.2g} % of its ticks: the bus or this computer is too busy.", "bad")
        finally:
            self._engine.commissioning = None

    def _reporter(self, axis: str, part: str, duration_s: float) -> Callable[[str, float], None]:
        def report(what: str, done_s: float) -> None:
            self._engine.commissioning = {"axis": axis, "part": part, "what": what, "done_s": min(done_s, duration_s), "duration_s": duration_s}
            self._engine.busy(f"{part}: {100 * min(done_s / duration_s, 1.0):.0f} %")
            self._engine.refresh(self._device)

        return report

    def _compute(self, what: str, work: Callable[[], Any]) -> Any:
        self._engine.busy(f"{what} …")
        try:
            return work()
        finally:
            self._engine.busy("")

    # --- gains --------------------------------------------------------------------------------------------------------

    def _propose(self, name: str, requirements: dict[str, float], unlock: bool) -> tune_run.Proposal:
        folder = find(name)
        if not (folder / RESULT).exists():
            raise InputError("identify the axis first: a design needs its result.")
        axis = AXES.index(name.split("-")[1])
        identified = read_identified(folder / RESULT)
        identified.check_machine(self._device, axis)
        unknown = requirements.keys() - LABELS.keys()
        if unknown:
            raise InputError(f"there is no requirement '{sorted(unknown)[0]}'.")
        return tune_run.propose(
            self._program(), self._device, identified, axis, folder, requirements, unlock, lambda key: f"'{LABELS[key]}'"
        )

    def design(self, name: str, requirements: dict[str, float], unlock: bool) -> dict[str, Any]:
        """Gains for these requirements, beside the present ones. No gain changes."""
        self._need_rest()
        proposal: tune_run.Proposal = self._compute("designs", lambda: self._propose(name, requirements, unlock))
        return self._described(proposal) | {"details": details(name)}

    @staticmethod
    def _described(proposal: tune_run.Proposal) -> dict[str, Any]:
        return {
            "rows": [
                {"name": p.name, "where": p.where, "before": number(proposal.present[p]), "after": number(value), "unit": p.unit, "guarded": p.guarded}
                for p, value in proposal.changed.items()
            ],
            "predicted": tune_run.predicted_text(proposal.design), "notes": proposal.design.notes,
            "left_out": [p.name for p in proposal.plant], "loop": _bode(proposal.design.frequency_hz, proposal.design.loop),
        }  # fmt: skip

    @staticmethod
    def _stimulus(bias_deg_s: float, amplitude_deg_s: float, high_hz: float, periods: int) -> LoopStimulus:
        if not 2 <= periods <= 100:
            raise InputError("expected 2 to 100 periods.")
        stimulus = loop_stimulus(LOWEST_HZ, high_hz, radians(bias_deg_s), radians(amplitude_deg_s), LINES, periods)
        tune_run.check_slides(stimulus)
        return stimulus

    def plan_tune(self, name: str, *stimulus: Any) -> dict[str, Any]:
        """What the measurement would move; raises InputError when it is not allowed."""
        folder = find(name)
        plan = self._stimulus(*stimulus).plan(name.split("-")[1])
        drive = Drive(self._device, AXES.index(plan.axis))
        tune_run.check_reach(drive, plan, read_identified(folder / RESULT), None)
        plan.check(tune_run.LIMITS, drive)
        return plan_data(plan)

    def tune(self, name: str, requirements: dict[str, float], unlock: bool, word: str, *stimulus: Any) -> dict[str, Any]:
        """Designs again for the present gains, tries the new ones on the axis, and keeps them if the margins are met."""
        self._need_rest()
        self.plan_tune(name, *stimulus)
        wanted = self._stimulus(*stimulus)
        with self._jobs.word(unlock, word):
            proposal: tune_run.Proposal = self._compute("designs", lambda: self._propose(name, requirements, unlock))
            if not proposal.changed:
                raise InputError("the device already has these gains; there is nothing to try.")
            if not unlock:
                need_unlock(proposal.locked)
            axis, total = proposal.axis, wanted.plan(AXES[proposal.axis]).duration_s
            modes = {axis: power.CYCLIC_VELOCITY, 1 - axis: power.NO_MODE}
            with self._engine.without_stream(self._device, modes):
                tried = tune_run.try_out(self._device, proposal, wanted, unlock, partial(measure_loop, progress=self._jobs.progress(axis, "tune", total)))
            files = tune_run.write_files(find(name), self._device, proposal, tried)
        name_of_axis = AXES[axis]
        text = f"{name_of_axis} has the new gains" if tried.kept else f"{name_of_axis} has its old gains again: {tried.reasons}"
        self._engine.say(f"{text}; {files[0]}", "good" if tried.kept else "bad")
        measured = tried.measured
        sharp = measured.sharp
        before = measured.loop_with(tune_run.loop_gains(proposal.present, measured.gains))
        return self._described(proposal) | {
            "kept": tried.kept, "text": text,
            "verdicts": [asdict(verdict) | {"text": verdict.text} for verdict in tried.verdicts],
            "measured": _bode(measured.closed.frequency_hz[sharp], measured.loop[sharp]),
            "before": _bode(measured.closed.frequency_hz[sharp], before[sharp]), "details": details(name),
        }  # fmt: skip
