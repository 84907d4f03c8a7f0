# SPDX-License-Identifier: Apache-2.0
"""Common parts of the commands that move an axis: limits, the announcement of the motion, and rates on the live
axis."""

from __future__ import annotations

import sys
from collections.abc import Callable
from datetime import datetime
from pathlib import Path
from typing import Any, TypeVar

import click
import numpy as np
from numpy.typing import NDArray

from ..drive.drive import Drive
from ..errors import InputError
from ..link.device import Device
from ..motion.limits import Limits, Plan
from ..motion.moves import plan_data
from ..motion.rate_run import RatesRun, send_rates
from ..motion.rate_run import check_pace as check_pace
from ..objects.parameter import AXES
from ..session import Session
from ..show.output_files import unused
from ..units import TICK_S, degrees
from .quantity import DURATION, FASTEST_RATE, LONGEST_TRAVEL

F = TypeVar("F", bound=Callable[..., Any])
Real = NDArray[np.float64]

MANY_LOST = 50
"""Lost samples, of 1 ms each, above which a measured time is doubtful."""


def motion_options(most: Limits) -> Callable[[F], F]:
    """Axis, limits with these defaults, --dry-run and --yes."""

    def add(command: F) -> F:
        command = yes_options(command)
        for option in (
            click.option(
                "--max-duration", type=DURATION, default=f"{most.duration_s:g}", show_default=True,
                help="Limit of the duration (s)."
            ),
            click.option(
                "--max-travel", type=LONGEST_TRAVEL, default=f"{degrees(most.travel_rad):g}", show_default=True,
                help="Limit of the travel (°).",
            ),
            click.option(
                "--max-rate", type=FASTEST_RATE, default=f"{degrees(most.rate_rad_s):g}", show_default=True,
                help="Limit of the rate (°/s).",
            ),
            click.argument("axis", type=click.Choice(AXES)),
        ):
            command = option(command)
        return command

    return add


def announce(session: Session, plan: Plan, limits: Limits, device: Device | None, dry_run: bool, yes: bool) -> bool:
    """Announces the motion, checks it, asks for confirmation; False when nothing must move."""
    plan.check(limits, Drive(device, AXES.index(plan.axis)) if device else None)
    session.out.say(f"{plan.axis} will move: {plan.text}")
    session.out.say(
        f"  at most {degrees(plan.rate_rad_s):.3g} °/s, {degrees(plan.forward_rad):.3g}° forward and"
        f" {degrees(plan.backward_rad):.3g}° back, {plan.duration_s:.3g} s"
    )
    return confirm(session, plan_data(plan), dry_run, yes)


def confirm(session: Session, plan: Any, dry_run: bool, yes: bool) -> bool:
    """Asks for confirmation of an announced motion; False when nothing must move. `plan` is for --json."""
    if dry_run:
        session.out.json({"dry_run": True, "plan": plan})
        session.out.say("dry run: nothing was moved.")
        return False
    if not yes:
        if session.out.as_json or not sys.stdin.isatty():
            raise InputError("cannot ask for confirmation because standard input is not a terminal: add --yes.")
        click.confirm("Is the travel range clear?", abort=True)
    return True


def yes_options(command: F) -> F:
    """--dry-run and --yes."""
    for option in (
        click.option(
            "--yes", "-y", is_flag=True, help="Move without asking; required when standard input is not a terminal."
        ),
        click.option("--dry-run", is_flag=True, help="Show what would move, without moving."),
    ):
        command = option(command)
    return command


def new_path(folder: Path, what: str, axis: str) -> Path:
    """Base name of the PNG and CSV file of a measurement, or name of a folder; nothing with it exists."""
    return timed_path(folder, f"{what}-{axis}")


def timed_path(folder: Path, what: str) -> Path:
    """The same of something that has no axis."""
    return unused(folder / f"{what}-{datetime.now().strftime('%Y%m%d-%H%M%S')}", ".png", ".csv")


def run_rates(
    session: Session, device: Device, axis: str, rates: Real, period: int, limits: Limits, what: str,
    hold_other: bool = False, interpolation: int | None = None,
) -> RatesRun:  # fmt: skip
    """As in the library, with a progress bar."""
    with session.out.progress() as bar:
        task = bar.add_task(what, total=len(rates) * TICK_S)
        return send_rates(
            device, AXES.index(axis), rates, period, limits, hold_other, interpolation,
            lambda passed_s, _rate_rad_s: bar.update(task, completed=passed_s),
        )  # fmt: skip


def show_files(session: Session, files: list[str], lost: int) -> None:
    if lost:
        worse = (
            "; measured times are too short by as many ms: repeat on a less busy bus or computer" if lost > MANY_LOST else ""
        )
        session.out.note(f"{lost} samples were lost in transmission{worse}.")
    session.out.say("saved: " + ", ".join(files))
