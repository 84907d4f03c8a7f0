# SPDX-License-Identifier: Apache-2.0
"""move: to an angle, by an angle, or at a rate for a time."""

from __future__ import annotations

import time

import click

from .. import power
from ..device import Device
from ..drive import Drive
from ..errors import InputError, MotionError
from ..limits import Limits
from ..live import LiveAxis
from ..moves import DEFAULT_RATE_DEG_S, longest_s, plan_run, plan_to
from ..parameter import AXES
from ..session import Session, common
from ..units import degrees, radians
from .motion import announce, motion_options
from .quantity import ANGLE, DURATION, RATE


@click.command(short_help="Move to or by an angle, or at a rate for a time.")
@motion_options("20", "90", "120")
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
            _run_at_rate(session, device, axis, rate, plan.duration_s)
            end = drive.position()
        else:
            end = _go_to(session, device, axis, start + travel, rate, plan.duration_s)
        error = end - (start + travel)
    session.out.json({"axis": axis, "from_deg": degrees(start), "to_deg": degrees(end), "state": "standing"})
    arrived = "" if runs else f", {1e6 * error:+.0f} µrad from the target"
    session.out.say(f"{axis} stands at {degrees(end):.4f}° (from {degrees(start):.4f}°){arrived}.")


def _run_at_rate(session: Session, device: Device, axis: str, rate: float, duration: float) -> None:
    with LiveAxis(device, AXES.index(axis), power.PROFILE_VELOCITY) as live, session.out.progress() as bar:
        task = bar.add_task(f"{axis} runs", total=duration)
        live.drive.set_target_rate(rate)
        for now in device.clock.every(0.05, duration):
            live.check_enabled()
            bar.update(task, completed=now)


def _go_to(session: Session, device: Device, axis: str, target: float, rate: float, expected_s: float) -> float:
    """Position of the axis on arrival; after it is disabled, wind may turn it."""
    with LiveAxis(device, AXES.index(axis), power.PROFILE_POSITION) as live, session.out.progress() as bar:
        drive = live.drive
        task = bar.add_task(f"{axis} moves", total=1.0)
        start = drive.position()
        drive.start_to(target, rate)
        deadline = device.clock.now() + longest_s(expected_s)
        while not live.check_enabled() & power.TARGET_REACHED:
            done = abs(drive.position() - start) / max(abs(target - start), 1e-9)
            bar.update(task, completed=min(done, 1.0))
            if device.clock.now() > deadline:
                raise MotionError(f"{axis} has not reached its target after {longest_s(expected_s):.0f} s.")
            time.sleep(0.02)
        return drive.position()
