# SPDX-License-Identifier: Apache-2.0
"""move: to an angle, by an angle, or at a rate for a time."""

from __future__ import annotations

import contextlib
from collections.abc import Iterator

import click

from ..drive.drive import Drive
from ..errors import InputError
from ..motion.limits import Limits
from ..motion.moves import DEFAULT_RATE_DEG_S, MOST, Report, go_to, plan_run, plan_to, run_at_rate
from ..objects.parameter import AXES
from ..session import Session, common
from ..units import degrees, radians
from .motion import announce, motion_options
from .quantity import ANGLE, DURATION, RATE


@click.command(short_help="Move to or by an angle, or at a rate for a time.")
@motion_options(MOST)
@click.option("--to", "target", type=ANGLE, help="Absolute joint angle (°).")
@click.option("--by", type=ANGLE, help="Relative angle (°).")
@click.option(
    "--rate", type=RATE, help="Rate (°/s). With --to or --by the profile rate (default 2), else the rate to run at."
)
@click.option("--for", "duration", type=DURATION, help="Duration of the run at --rate (s).")
@common
def move(
    session: Session, axis: str, target: float | None, by: float | None, rate: float | None, duration: float | None,
    max_rate: float, max_travel: float, max_duration: float, dry_run: bool, yes: bool,
) -> None:  # fmt: skip
    """Move an axis: to an angle with --to, by an angle with --by (mode pp), or at a rate for a time with --rate and
    --for (mode pv).

    Angles and rates are in degrees unless a unit follows, e.g. --by "10 mrad". The axis is enabled for the motion. If
    it was disabled before, it is disabled again.
    """
    runs = target is None and by is None
    if runs and (rate is None or duration is None):
        raise InputError("give --to or --by with an angle, or --rate and --for.")
    if target is not None and by is not None or (not runs and duration is not None):
        raise InputError("--to, --by, and --rate with --for exclude each other.")
    if not runs and rate == 0.0:
        raise InputError("--rate must not be 0 with --to or --by.")
    limits = Limits(max_rate, max_travel, max_duration)
    with session.connect() as device:
        drive = Drive(device, AXES.index(axis))
        start = drive.position()
        if runs:
            assert rate is not None and duration is not None
            travel = rate * duration
            plan = plan_run(axis, rate, duration)
        else:
            rate = abs(rate) if rate else radians(DEFAULT_RATE_DEG_S)
            travel = by if by is not None else (target or 0.0) - start
            plan = plan_to(axis, start, start + travel, rate)
        if not announce(session, plan, limits, device, dry_run, yes):
            return
        if runs:
            with _bar(session, f"{axis} runs") as report:
                run_at_rate(device, drive.axis, rate, plan.duration_s, report)
            end = drive.position()
        else:
            with _bar(session, f"{axis} moves") as report:
                end = go_to(device, drive.axis, start + travel, plan, report)
        error = end - (start + travel)
    session.out.json({"axis": axis, "from_deg": degrees(start), "to_deg": degrees(end), "state": "standing"})
    arrived = "" if runs else f", {1e6 * error:+.0f} µrad from the target"
    session.out.say(f"{axis} stands at {degrees(end):.4f}° (from {degrees(start):.4f}°){arrived}.")


@contextlib.contextmanager
def _bar(session: Session, what: str) -> Iterator[Report]:
    with session.out.progress() as bar:
        task = bar.add_task(what, total=1.0)
        yield lambda share: bar.update(task, completed=share)
