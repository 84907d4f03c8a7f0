"""identify: friction and inertia of the live axis, from experiments on it."""

from __future__ import annotations

import json
import math
import sys
import tempfile
from contextlib import ExitStack
from dataclasses import asdict
from pathlib import Path
from typing import Any

import click

from ..commissioning import Commissioning, Outcome, check_place
from ..device import Device
from ..drive import Drive
from ..errors import ExitCode, InputError
from ..gains_file import write_gains
from ..identified import Identified, add_machine, read_identified
from ..identify_program import ENVIRONMENT, IdentifyProgram, find_identify
from ..limits import allowed_travel
from ..node_limits import read_limits
from ..parameter import AXES, Parameter, Value
from ..test_plan import Envelope, Experiment, Place, TestPlan
from ..session import Session, common
from ..units import degrees, radians
from .gains import about
from .motion import new_path

FASTEST_OF_EXPERIMENTS_RAD_S = 100.0
"""2100:15 accepts no more: a 607F above means that it was never set."""

PROGRAM = click.option(
    "--identify-program", "program", type=click.Path(path_type=Path, dir_okay=False), metavar="FILE",
    help=(
        f"Path of the program 'identify' (environment: {ENVIRONMENT}; default: the one in the build folder, or in"
        " PATH)."
    ),
)  # fmt: skip


@click.command(short_help="Measure friction and inertia of an axis.")
@click.option("--axis", type=click.Choice(AXES), required=True, help="The axis to identify.")
@click.option("--out", "folder", type=click.Path(path_type=Path, file_okay=False), help="Folder for the results.")
@click.option(
    "--travel-deg", type=float, nargs=2, metavar="LOW HIGH",
    help="Joint angles between which the axis may move (default: the node's limits, 607D, 2060:9 and 2060:10)."
)
@click.option("--speed-deg-s", type=float, help="Fastest joint rate (default: the node's limits, 607F and 2060).")
@PROGRAM
@click.option(
    "--quick", is_flag=True, help="Run only the rough first look: about a minute, accurate to a factor of two."
)
@click.option("--dry-run", is_flag=True, help="Show what would move, how far, how fast and how long, without moving.")
@click.option("--yes", "-y", is_flag=True, help="Move without asking; required when standard input is not a terminal.")
@common
def identify(
    session: Session, axis: str, folder: Path | None, travel_deg: tuple[float, float] | None, speed_deg_s: float | None,
    program: Path | None, quick: bool, dry_run: bool, yes: bool,
) -> int:  # fmt: skip
    """Measure friction and inertia of an axis by experiments, and write the results and a report.

    A rough first look assumes only the travel, the torque limit, and that the present gains keep the axis stable. Its
    results size the main test plan. The other axis is held in place. No gain is changed. Exit code 1 means that a
    parameter could not be determined; the report names the missing run.
    """
    identifier = IdentifyProgram(find_identify(program))
    out = folder or new_path(Path(), "identify", axis)
    with session.connect() as device, ExitStack() as stack:
        drive = Drive(device, AXES.index(axis))
        envelope = read_envelope(device, AXES.index(axis), travel_deg, speed_deg_s)
        check_place(drive, envelope)
        work = Path(stack.enter_context(tempfile.TemporaryDirectory())) if dry_run else make_folder(out)
        first = identifier.plan(envelope, drive.position(), work / "first_look_plan.json")
        show_envelope(session, axis, envelope)
        show_test_plan(session, first, "first look")
        if not quick:
            session.out.say(
                "The main test plan, sized by these results, and chirps for structural resonances follow. Their"
                " tables are shown before the axis moves."
            )
        if dry_run:
            session.out.json({"dry_run": True, "axis": axis, "envelope": asdict(envelope), "plan": as_json(first)})
            session.out.say("dry run: nothing was moved.")
            return int(ExitCode.OK)
        ask(session, yes)
        recording, structure = out / ("first_look.csv" if quick else "runs.csv"), out / "structure.csv"
        with Commissioning(device, AXES.index(axis), envelope) as machine:
            outcome = carry_out(session, machine, first, out / "first_look.csv")
            if not quick:
                fit(session, identifier, out / "first_look.csv", out / "first_look.json")
                test_plan = identifier.plan(envelope, drive.position(), out / "plan.json", out / "first_look.json")
                show_test_plan(session, test_plan, "main test plan")
                outcome = carry_out(session, machine, test_plan, recording)
                chirps = identifier.plan(
                    envelope, drive.position(), out / "structure_plan.json", out / "first_look.json", structure=True
                )
                show_test_plan(session, chirps, "structural resonances")
                carry_out(session, machine, chirps, structure)
        if not outcome.other_held:
            session.out.note(f"{AXES[1 - AXES.index(axis)]} was not held; its motion may affect the result.")
        fit(
            session, identifier, recording, out / "result.json", out / "residuals.csv", None if quick else structure
        )
        add_machine(out / "result.json", device, AXES.index(axis), envelope)
        identified = read_identified(out / "result.json")
        gains = identified.gains(device.schema, AXES.index(axis))
        plant = identified.plant(device.schema, AXES.index(axis))
        if gains:
            write_gains(out / f"{axis}-identified.toml", gains, about(device))
    page = write_report(out, axis, identified, plant, recording, outcome)
    return show_result(session, axis, out, identified, list(plant), outcome, page)


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


def make_folder(folder: Path) -> Path:
    """The folder, created if necessary; raises InputError, also when it holds another identification."""
    if (folder / "result.json").exists():
        raise InputError(
            f"{folder}: already contains an identification (result.json): give another folder with --out."
        )
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(f"{folder}: cannot be created: {error.strerror}.") from error
    return folder


def show_envelope(session: Session, axis: str, envelope: Envelope) -> None:
    """The bounds of everything that follows."""
    session.out.say(
        f"{axis} will move between {degrees(envelope.lowest_rad):.4g}° and {degrees(envelope.highest_rad):.4g}°, at up"
        f" to {degrees(envelope.fastest_rad_s):.4g} °/s, with up to {envelope.torque_nm:.4g} N m; the other axis is"
        " held."
    )


def show_test_plan(session: Session, test_plan: TestPlan, title: str) -> None:
    """Motion of each kind of experiment: axis, distance, speed, torque, duration; one row per kind."""
    alike: dict[str, list[tuple[Place, Experiment]]] = {}
    for place, experiment in test_plan:
        alike.setdefault(json.dumps([experiment.kind, experiment.fields], sort_keys=True), []).append(
            (place, experiment)
        )
    rows = []
    for group in alike.values():
        experiment, duration_s = group[0][1], sum(each.duration_s for _, each in group)
        rows.append(
            (
                experiment.name,
                str(len(group)),
                _where(group, test_plan),
                *_extent(experiment, test_plan),
                f"{duration_s:.0f}",
            )
        )
    columns = ["experiment", ("times", "right"), ("at °", "right"), ("travel ± °", "right"), ("max °/s", "right"),
               ("max N m", "right"), ("s", "right")]  # fmt: skip
    session.out.table(columns, rows, title)
    places = ", ".join(_angle(place.angle_rad) for place in test_plan.places)
    session.out.say(
        f"{title}: {test_plan.experiments} experiments at {places}°, {test_plan.duration_s:.0f} s; moves between"
        f" these angles at {degrees(test_plan.moving_rad_s):.3g} °/s."
    )


def _where(group: list[tuple[Place, Experiment]], test_plan: TestPlan) -> str:
    """The angles, or that it runs at all places."""
    angles = {place.angle_rad: None for place, _ in group}
    return "all" if len(angles) == len(test_plan.places) else ", ".join(_angle(angle) for angle in angles)


def _angle(angle_rad: float) -> str:
    """In °, without a minus before 0."""
    return f"{round(degrees(angle_rad), 1) + 0.0:.1f}"


def _extent(experiment: Experiment, test_plan: TestPlan) -> tuple[str, str, str]:
    """Path, rate and torque; the limit of the experiment where the set-up has no value."""
    rate, torque = experiment.fastest_rad_s, experiment.torque_nm
    return (
        f"{degrees(experiment.reach_rad(test_plan.limits['travel_rad'])):.3g}",
        f"{degrees(rate if rate is not None else test_plan.limits['rate_rad_s']):.3g}",
        f"{torque if torque is not None else test_plan.limits['torque_nm']:.3g}",
    )


def as_json(test_plan: TestPlan) -> dict[str, Any]:
    """For --json, in ° and s."""
    return {
        "stage": test_plan.stage, "duration_s": test_plan.duration_s, "experiments": test_plan.experiments,
        "places_deg": [degrees(place.angle_rad) for place in test_plan.places],
        "moving_deg_s": degrees(test_plan.moving_rad_s), "limits": test_plan.limits,
    }  # fmt: skip


def ask(session: Session, yes: bool, question: str = "Is the travel range clear?") -> None:
    """Raises click.Abort or InputError unless it may continue."""
    if yes:
        return
    if session.out.as_json or not sys.stdin.isatty():
        raise InputError("cannot ask for confirmation because standard input is not a terminal: add --yes.")
    click.confirm(question, abort=True)


def carry_out(session: Session, machine: Commissioning, test_plan: TestPlan, path: Path) -> Outcome:
    """Runs the test plan and writes the recording."""
    with session.out.progress(time_left=True) as bar:
        task = bar.add_task(test_plan.stage, total=test_plan.duration_s)

        def report(what: str, done_s: float) -> None:
            bar.update(task, description=what, completed=min(done_s, test_plan.duration_s))

        outcome = machine.run(test_plan, report)
    outcome.recording.write(path)
    for run, share in outcome.incomplete_runs():
        session.out.note(
            f"run {run} in {path} lost {100 * share:.2g} % of its ticks: the bus or this computer is too busy."
        )
    return outcome


def fit(
    session: Session, program: IdentifyProgram, recording: Path, result: Path, residuals: Path | None = None,
    structure: Path | None = None,
) -> None:  # fmt: skip
    """`identify fit`, which may take a quarter of a minute."""
    with session.out.errors.status(f"fitting {recording.name}"):
        program.fit(recording, result, residuals, structure)


def write_report(
    folder: Path, axis: str, identified: Identified, plant: dict[Parameter, Value], recording: Path, outcome: Outcome
) -> Path:
    """report.html; the pictures take a second to import."""
    from ..identification_report import write_identification_report

    path = folder / "report.html"
    write_identification_report(path, axis, identified, plant, recording, folder / "residuals.csv", outcome)
    return path


def show_result(
    session: Session, axis: str, folder: Path, identified: Identified, plant: list[Parameter], outcome: Outcome, page: Path
) -> int:
    """The result as a table, refused parameters, written files; the exit code."""
    files = [str(page), str(folder / "result.json"), str(folder / f"{axis}-identified.toml")]
    session.out.json(
        {
            "axis": axis, "complete": not identified.refused, "parameters": identified.data["parameters"],
            "refused": identified.data["refused"], "missing_ticks": outcome.recording.missing, "folder": str(folder),
            "files": files,
        }
    )  # fmt: skip
    rows = []
    for estimate in identified.estimates.values():
        value = f"{estimate.value:.5g}" if estimate.value is not None else "not determined"
        percent = f"±{estimate.percent:.1f}" if estimate.percent is not None else "–"
        paper = f"{estimate.paper:.5g}" if estimate.paper is not None else "–"
        rows.append((estimate.title, value, percent, paper, estimate.unit))
    session.out.table(
        ["parameter", ("value", "right"), ("95 % interval, %", "right"), ("paper's method", "right"), "unit"], rows
    )
    for _, message in identified.refused:
        session.out.note(f"not determined: {message}")
    for warning in identified.warnings:
        session.out.note(warning)
    session.out.say("saved: " + ", ".join(files))
    if plant:
        session.out.say(
            f"{axis}-identified.toml and 'servoctl tune' also set the plant against which the device checks gains"
            f" ({plant[0].index:04X}); both write it with --unlock only."
        )
    session.out.say(f"To design gains from this: 'servoctl tune --axis {axis} --from {folder}'.")
    return int(ExitCode.DIFFERENT if identified.refused else ExitCode.OK)
