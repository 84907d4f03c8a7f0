"""What the commands that move an axis share: limits, saying what will move, and running rates on the live axis."""

from __future__ import annotations

import sys
from collections.abc import Callable
from datetime import datetime
from pathlib import Path
from typing import Any, TypeVar

import click
import numpy as np
from numpy.typing import NDArray

from .. import power
from ..device import Device
from ..drive import Drive
from ..errors import InputError, MotionError
from ..limits import Guard, Limits, Plan
from ..live import LiveAxis, pace
from ..parameter import AXES
from ..session import Session
from ..stream import TICK_S, RateStream
from ..units import degrees
from .quantity import DURATION, FASTEST_RATE, LONGEST_WAY

F = TypeVar("F", bound=Callable[..., Any])
Real = NDArray[np.float64]

FASTEST_PACE = 1.5
"""Of the device's time beside ours, that set-points sent from here can follow."""

MANY_LOST = 50
"""Lost samples, of 1 ms each, beyond which a time that was measured is doubtful."""


def motion_options(max_rate: str, max_travel: str, max_duration: str) -> Callable[[F], F]:
    """Axis, limits, --dry-run and --yes."""

    def add(command: F) -> F:
        for option in (
            click.option("--yes", "-y", is_flag=True, help="Move without asking; needed when no terminal can answer."),
            click.option("--dry-run", is_flag=True, help="Say what would move, and move nothing."),
            click.option(
                "--max-duration", type=DURATION, default=max_duration, show_default=True, help="Longest motion (s)."
            ),
            click.option("--max-travel", type=LONGEST_WAY, default=max_travel, show_default=True, help="Farthest way (°)."),
            click.option("--max-rate", type=FASTEST_RATE, default=max_rate, show_default=True, help="Fastest rate (°/s)."),
            click.argument("axis", type=click.Choice(AXES)),
        ):
            command = option(command)
        return command

    return add


def announce(session: Session, plan: Plan, limits: Limits, device: Device | None, dry_run: bool, yes: bool) -> bool:
    """Says what will move, checks it, asks; False when nothing shall move."""
    plan.check(limits, Drive(device, AXES.index(plan.axis)) if device else None)
    session.out.say(f"{plan.axis} will move: {plan.text}")
    session.out.say(
        f"  at most {degrees(plan.rate_rad_s):.3g} °/s, {degrees(plan.forward_rad):.3g}° forward and"
        f" {degrees(plan.backward_rad):.3g}° back, {plan.duration_s:.3g} s"
    )
    if dry_run:
        session.out.json({"dry_run": True, "plan": plan_data(plan)})
        session.out.say("dry run: nothing has moved.")
        return False
    if not yes:
        if session.out.as_json or not sys.stdin.isatty():
            raise InputError("nobody can be asked whether this may move: add --yes.")
        click.confirm("Is the way clear?", abort=True)
    return True


def plan_data(plan: Plan) -> dict[str, Any]:
    """The plan for --json, in ° and s."""
    return {
        "axis": plan.axis, "text": plan.text, "rate_deg_s": degrees(plan.rate_rad_s), "forward_deg": degrees(plan.forward_rad),
        "backward_deg": degrees(plan.backward_rad), "duration_s": plan.duration_s,
    }  # fmt: skip


def new_path(folder: Path, what: str, axis: str) -> Path:
    """Name without ending for the files of a measurement."""
    return folder / f"{what}-{axis}-{datetime.now().strftime('%Y%m%d-%H%M%S')}"


def run_rates(
    session: Session, device: Device, axis: str, rates: Real, interpolation_ms: int,
    period_s: float, limits: Limits, what: str, hold_other: bool = False,
) -> tuple[Real, Real, int]:  # fmt: skip
    """Sends rates (rad/s, one per tick) in csv and returns demand, answer (rad/s at 1 kHz) and lost frames."""
    number = AXES.index(axis)
    duration = len(rates) * TICK_S
    if device.pace() > FASTEST_PACE:
        raise MotionError("the simulator's time is faster than real time: set-points cannot keep up. Serve it with --speed realtime.")
    with RateStream(device, number) as stream, LiveAxis(device, number, power.CYCLIC_VELOCITY) as live:
        if hold_other:
            live.hold(1 - number)
        live.set_interpolation(interpolation_ms)
        stream.start()
        guard = Guard(stream, limits)
        with session.out.progress() as bar:
            task = bar.add_task(what, total=duration)
            for count, now in enumerate(pace(period_s, duration)):
                stream.send(float(rates[min(int(now / TICK_S), len(rates) - 1)]))
                guard.look()
                if count % 50 == 0:
                    bar.update(task, completed=now)
        stream.send(0.0)
        live.check_enabled()
        demand, answer = stream.samples()
        lost = stream.lost()
    if len(demand) < 0.9 * duration / TICK_S:
        raise MotionError(
            f"only {len(demand)} of {duration / TICK_S:.0f} samples came: the bus is too slow or too busy."
        )
    return demand, answer, lost


def show_files(session: Session, files: list[str], lost: int) -> None:
    if lost:
        worse = (
            "; times are too short by as many ms: run it again on a quieter bus or computer" if lost > MANY_LOST else ""
        )
        session.out.note(f"{lost} samples were lost on the way{worse}.")
    session.out.say("saved: " + ", ".join(files))
