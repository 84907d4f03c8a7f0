# SPDX-License-Identifier: Apache-2.0
"""step: a step of the rate on the live axis, in numbers and as a picture."""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path

import click
import numpy as np

from ..motion.limits import Limits
from ..motion.step_test import MOST, SETPOINT_TICKS, StepRecord, cut_steps, disturbed_text, plan_step
from ..session import Session, common
from ..units import TICK_S, degrees
from .motion import announce, motion_options, new_path, run_rates, show_files
from .quantity import DURATION, RATE


@click.command(short_help="Apply a rate step: rise, overshoot, settling.")
@motion_options(MOST)
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
    planned = plan_step(axis, amplitude, base, hold, one_way)
    limits = Limits(max_rate, max_travel, max_duration)
    with session.connect() as device:
        if not announce(session, planned.plan, limits, device, dry_run, yes):
            return
        run = run_rates(session, device, axis, planned.rates, SETPOINT_TICKS, limits, "step", interpolation=1)
    demand, answer, lost = run.demand, run.answer, run.lost
    records = cut_steps(run, hold)
    if disturbed := disturbed_text(records, planned, run):
        session.out.note(disturbed)
    path = new_path(folder, "step", axis)
    from ..plots import save, steps_figure, write_csv

    write_csv(
        path.with_suffix(".csv"),
        {"time_s": (np.arange(len(demand)) * TICK_S).tolist(), "demand_rad_s": demand, "rate_rad_s": answer},
    )
    save(steps_figure(f"{axis}: rate step of {degrees(amplitude):.3g} °/s", records), path.with_suffix(".png"))
    _show_steps(session, axis, records, path, lost)


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
