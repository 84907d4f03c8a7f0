# SPDX-License-Identifier: Apache-2.0
"""identify: friction and inertia of the live axis, from experiments on it."""

from __future__ import annotations

import sys
import tempfile
from contextlib import ExitStack
from dataclasses import asdict
from functools import partial
from pathlib import Path

import click

from ..drive.drive import Drive
from ..errors import ExitCode, InputError
from ..identify.commissioning import Commissioning, check_place
from ..identify.identification import (
    FIRST_LOOK,
    Finished,
    Identification,
    envelope_text,
    make_folder,
    read_envelope,
    result_files,
)
from ..identify.identify_program import ENVIRONMENT, IdentifyProgram, find_identify
from ..identify.test_plan import COLUMNS, TestPlan, as_json, rows_of, summary_of
from ..objects.parameter import AXES
from ..session import Session, common
from ..show.output_files import overwrite_option
from .motion import new_path
from .quantity import DEGREES, Quantity

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
    "--travel-deg", type=(DEGREES, DEGREES), metavar="LOW HIGH",
    help="Joint angles between which the axis may move (default: the node's limits, 607D, 2060:9 and 2060:10)."
)
@click.option("--speed-deg-s", type=Quantity("deg/s"), help="Fastest joint rate (default: the node's limits, 607F and 2060).")
@PROGRAM
@click.option(
    "--quick", is_flag=True, help="Run only the rough first look: about a minute, accurate to a factor of two."
)
@click.option("--dry-run", is_flag=True, help="Show what would move, how far, how fast and how long, without moving.")
@click.option("--yes", "-y", is_flag=True, help="Move without asking; required when standard input is not a terminal.")
@overwrite_option
@common
def identify(
    session: Session, axis: str, folder: Path | None, travel_deg: tuple[float, float] | None, speed_deg_s: float | None,
    program: Path | None, quick: bool, overwrite: bool, dry_run: bool, yes: bool,
) -> int:  # fmt: skip
    """Measure friction and inertia of an axis by experiments, and write the results and a report.

    A rough first look assumes only the travel, the torque limit, and that the present gains keep the axis stable. Its
    results size the main test plan. The other axis is held in place. No gain is changed. Exit code 1 means that a
    parameter could not be determined; the report names the missing run.
    """
    out = folder or new_path(Path(), "identify", axis)
    if not dry_run:
        session.check_new(result_files(out, AXES.index(axis)), overwrite, "--out")
    identifier = IdentifyProgram(find_identify(program))
    with session.connect() as device, ExitStack() as stack:
        envelope = read_envelope(device, AXES.index(axis), travel_deg, speed_deg_s)
        check_place(Drive(device, AXES.index(axis)), envelope)
        work = Path(stack.enter_context(tempfile.TemporaryDirectory())) if dry_run else make_folder(out)
        run = Identification(identifier, device, AXES.index(axis), envelope, work, session.out.errors.status)
        first = run.plan(FIRST_LOOK)
        session.out.say(envelope_text(axis, envelope))
        show_test_plan(session, first, FIRST_LOOK)
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
        found = run.carry_out(first, quick, partial(run_part, session, run))
    if not found.outcome.other_held:
        session.out.note(f"{AXES[1 - AXES.index(axis)]} was not held; its motion may affect the result.")
    return show_result(session, axis, out, found)


def show_test_plan(session: Session, test_plan: TestPlan, title: str) -> None:
    """Motion of each kind of experiment: axis, distance, speed, torque, duration; one row per kind."""
    columns = [COLUMNS[0], *((name, "right") for name in COLUMNS[1:])]
    session.out.table(columns, rows_of(test_plan), title)
    session.out.say(f"{title}: {summary_of(test_plan)}")


def ask(session: Session, yes: bool, question: str = "Is the travel range clear?") -> None:
    """Raises click.Abort or InputError unless it may continue."""
    if yes:
        return
    if session.out.as_json or not sys.stdin.isatty():
        raise InputError("cannot ask for confirmation because standard input is not a terminal: add --yes.")
    click.confirm(question, abort=True)


def run_part(session: Session, run: Identification, part: str, machine: Commissioning, test_plan: TestPlan) -> None:
    """With a progress bar; the table of the first look was shown before the question."""
    if part != FIRST_LOOK:
        show_test_plan(session, test_plan, part)
    with session.out.progress(time_left=True) as bar:
        task = bar.add_task(test_plan.stage, total=test_plan.duration_s)

        def report(what: str, done_s: float) -> None:
            bar.update(task, description=what, completed=min(done_s, test_plan.duration_s))

        outcome = run.run(part, machine, test_plan, report)
    for number, share in outcome.incomplete_runs():
        session.out.note(
            f"run {number} in {run.recording(part)} lost {100 * share:.2g} % of its ticks: the bus or this computer is too busy."
        )


def show_result(session: Session, axis: str, folder: Path, found: Finished) -> int:
    """The result as a table, refused parameters, written files; the exit code."""
    identified, plant, outcome = found.identified, list(found.plant), found.outcome
    files = [str(path) for path in found.files]
    session.out.json(
        {
            "axis": axis, "complete": not identified.refused, "parameters": identified.data["parameters"],
            "refused": identified.data["refused"], "missing_ticks": outcome.recording.missing, "folder": str(folder),
            "files": files,
        }
    )  # fmt: skip
    rows = [estimate.row() for estimate in identified.estimates.values()]
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
