"""step: a step of the rate on the live axis, in numbers and as a picture."""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path

import click
import numpy as np
from numpy.typing import NDArray

from ..errors import InputError, MotionError
from ..limits import Limits, Plan, span
from ..session import Session, common
from ..step_response import StepNumbers, analyse_step
from ..units import TICK_S, degrees
from .motion import announce, motion_options, new_path, run_rates, show_files
from .quantity import DURATION, RATE

Real = NDArray[np.float64]

SETPOINT_TICKS = 4
BEFORE_STEP_S = 0.15


@click.command(short_help="Apply a rate step: rise, overshoot, settling.")
@motion_options("5", "30", "60")
@click.option("--amplitude", type=RATE, default="1", show_default=True, help="Height of the step (°/s).")
@click.option("--from", "base", type=RATE, default="0", show_default=True, help="Rate before the step (°/s).")
@click.option("--hold", type=DURATION, default="1", show_default=True, help="Time at each rate (s).")
@click.option(
    "--one-way",
    is_flag=True,
    help=("Step forward only. Default: repeat the step backward, so that the axis ends where it began."),
)
@click.option(
    "--out", "folder", type=click.Path(path_type=Path, file_okay=False), default=".", help="Folder for PNG and CSV."
)
@common
def step(
    session: Session, axis: str, amplitude: float, base: float, hold: float, one_way: bool, folder: Path,
    max_rate: float, max_travel: float, max_duration: float, dry_run: bool, yes: bool,
) -> None:  # fmt: skip
    """Apply a step to the rate of the live axis (mode csv) and measure rise, overshoot and settling. Saves a plot and
    a CSV file.

    Demand (606B) and response (606C) are recorded at 1 kHz in the same tick. The motion is limited by --max-rate,
    --max-travel and --max-duration.
    """
    if amplitude == 0.0 or hold < 0.1 or hold > 30.0:
        raise InputError("--amplitude must not be 0, and --hold must be 0.1 to 30 s.")
    signs = [1.0] if one_way else [1.0, -1.0]
    levels = [level + 0.0 for sign in signs for level in (sign * base, sign * (base + amplitude))] + [0.0]
    times = [hold if base else BEFORE_STEP_S + 0.1, hold] * len(signs) + [0.3]
    rates = np.concatenate([np.full(int(t / TICK_S), level) for level, t in zip(levels, times, strict=True)])
    forward, backward = span(rates, TICK_S)
    text = " → ".join(f"{degrees(level) + 0.0:.3g}" for level in levels) + f" °/s, {hold:g} s each"
    plan = Plan(axis, text, float(np.max(np.abs(rates))), forward, backward, float(sum(times)))
    limits = Limits(max_rate, max_travel, max_duration)
    with session.connect() as device:
        if not announce(session, plan, limits, device, dry_run, yes):
            return
        run = run_rates(session, device, axis, rates, SETPOINT_TICKS, limits, "step", interpolation=1)
    demand, answer, lost = run.demand, run.answer, run.lost
    records = _cut_steps(demand, answer, hold)
    reported = f"the latest set-point was {run.late} ms late by the node's clock, {lost} samples were lost"
    if not records:
        raise MotionError(
            f"the axis' demand (606B) did not follow the commanded steps: {reported}. Repeat with less load on the bus"
            " and on this computer."
        )
    if len(records) < len(signs):
        session.out.note(
            f"only {len(records)} of {len(signs)} steps were recorded undisturbed ({reported}); repeat the measurement."
        )
    path = new_path(folder, "step", axis)
    from ..plots import plot_steps, write_csv

    write_csv(
        path.with_suffix(".csv"),
        {"time_s": (np.arange(len(demand)) * TICK_S).tolist(), "demand_rad_s": demand, "rate_rad_s": answer},
    )
    plot_steps(path.with_suffix(".png"), f"{axis}: rate step of {degrees(amplitude):.3g} °/s", records)
    _show_steps(session, axis, records, path, lost)


StepRecord = tuple[
    str,
    Real,
    Real,
    Real,
    StepNumbers,
]


def _cut_steps(demand: Real, answer: Real, hold: float) -> list[StepRecord]:
    """The parts of the record around each step away from zero that was held for the required time."""
    change = np.abs(np.diff(demand))
    edges = [0, *(np.flatnonzero(change > 1e-5) + 1), len(demand)]
    plateaus = [(a, b) for a, b in zip(edges[:-1], edges[1:], strict=True) if b - a > 20]
    records: list[StepRecord] = []
    for (a, b), (c, d) in zip(plateaus[:-1], plateaus[1:], strict=True):
        if abs(demand[c]) <= abs(demand[a]) or d - c < 0.8 * hold / TICK_S or c - b > 4:
            continue
        start = max(a, c - int(BEFORE_STEP_S / TICK_S / 2))
        part = slice(start, d)
        numbers = analyse_step(demand[part], answer[part], TICK_S)
        time_s = (np.arange(start, d) - c) * TICK_S
        name = "forward" if demand[c] > demand[a] else "backward"
        records.append((name, time_s, demand[part], answer[part], numbers))
    return records


def _show_steps(session: Session, axis: str, records: list[StepRecord], path: Path, lost: int) -> None:
    files = [str(path.with_suffix(".png")), str(path.with_suffix(".csv"))]
    session.out.json(
        {"axis": axis, "steps": [{"direction": r[0], **asdict(r[4])} for r in records], "lost": lost, "files": files}
    )

    def ms(value: float | None) -> str:
        return "–" if value is None else f"{1e3 * value:.1f}"

    rows = [
        (r[0], ms(r[4].time_to_half_s), ms(r[4].rise_s), ms(r[4].time_to_90_s), f"{r[4].overshoot_percent:.1f}", ms(r[4].settling_s),
         f"{degrees(r[4].final_error_rad_s):+.5f}", f"{degrees(r[4].noise_rad_s):.5f}")
        for r in records
    ]  # fmt: skip
    columns = ["step", ("to\N{NO-BREAK SPACE}50\N{NO-BREAK SPACE}% ms", "right"), ("rise ms", "right"), ("to\N{NO-BREAK SPACE}90\N{NO-BREAK SPACE}% ms", "right"), ("overshoot %", "right"),
               ("settling ms", "right"), ("error °/s", "right"), ("noise °/s", "right")]  # fmt: skip
    session.out.table(columns, rows)
    session.out.say("rise: 10 to 90 %; settling: to within 5 %; error and noise: over the last 30 %.")
    show_files(session, files, lost)
