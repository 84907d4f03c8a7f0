# SPDX-License-Identifier: Apache-2.0
"""bode: the speed loop of the live axis in the frequency domain."""

from __future__ import annotations

import math
from dataclasses import asdict
from pathlib import Path

import click
import numpy as np

from ..gains.frequency_response import GOOD_COHERENCE, peak_db
from ..gains.loop_test import (
    AMPLITUDE_DEG_S,
    BIAS_DEG_S,
    HIGHEST_HZ,
    LINES,
    LOWEST_HZ,
    MOST,
    PERIODS,
    MeasuredLoop,
    loop_stimulus,
)
from ..motion.limits import Limits
from ..session import Session, common
from .loop import measure_loop, save_loop
from .motion import announce, motion_options, new_path, show_files
from .quantity import FREQUENCY, RATE, Whole


@click.command(short_help="Measure the speed loop: Bode plot, margins.")
@motion_options(MOST)
@click.option("--low", type=FREQUENCY, default=f"{LOWEST_HZ:g}", show_default=True, help="Lowest frequency (Hz).")
@click.option("--high", type=FREQUENCY, default=f"{HIGHEST_HZ:g}", show_default=True, help="Highest frequency (Hz).")
@click.option("--bias", type=RATE, default=f"{BIAS_DEG_S:g}", show_default=True, help="Mean rate (°/s); keeps the axis sliding.")
@click.option(
    "--amplitude",
    type=RATE,
    default=f"{AMPLITUDE_DEG_S:g}",
    show_default=True,
    help=("Peak of the multisine (°/s); must be below the bias."),
)
@click.option("--lines", type=Whole(5, 200), default=LINES, show_default=True, help="Number of sines.")
@click.option(
    "--periods",
    type=Whole(2, 100),
    default=PERIODS,
    show_default=True,
    help=("Number of periods measured; more periods reduce noise."),
)
@click.option(
    "--out", "folder", type=click.Path(path_type=Path, file_okay=False), default=".", help="Folder for PNG and CSV."
)
@common
def bode(
    session: Session, axis: str, low: float, high: float, bias: float, amplitude: float, lines: int, periods: int, folder: Path,
    max_rate: float, max_travel: float, max_duration: float, dry_run: bool, yes: bool,
) -> None:  # fmt: skip
    """Measure the speed loop of the live axis: closed and open loop, margins, bandwidth, coherence.

    The set-point (60FF, mode csv, every 2 ms) is a multisine around a mean rate. Demand (606B) and response (606C) are
    recorded at 1 kHz. The closed loop is the ratio of response to demand. The open loop at the motor torque is computed
    from it with the gains of the device. The method works up to 200 Hz because of the set-point period. Friction makes
    the loop non-linear: the result is valid for an axis that slides at the mean rate.
    """
    stimulus = loop_stimulus(low, high, bias, amplitude, lines, periods)
    limits = Limits(max_rate, max_travel, max_duration)
    with session.connect() as device:
        if not announce(session, stimulus.plan(axis), limits, device, dry_run, yes):
            return
        measured = measure_loop(session, device, axis, stimulus, limits, "bode")
    files = save_loop(measured, f"{axis}: speed loop, measured", new_path(folder, "bode", axis))
    _report_bode(session, axis, measured, files)


def _report_bode(session: Session, axis: str, measured: MeasuredLoop, files: list[str]) -> None:
    found, width = measured.margins, measured.bandwidth_hz
    result = asdict(found) | {
        "bandwidth_hz": width,
        "closed_peak_db": peak_db(measured.closed.value[measured.good]),
        "trusted": int(np.count_nonzero(measured.good)),
        "lines": len(measured.good),
    }
    session.out.json({"axis": axis, **result, "lost": measured.lost, "files": files})

    def shown(value: float | None, unit: str, where: float | None = None) -> str:
        if value is None or not math.isfinite(value):
            return "outside the measured frequencies"
        return f"{value:.1f} {unit}" + (f" at {where:.1f} Hz" if where is not None else "")

    out = session.out
    out.say(f"closed loop   bandwidth {shown(width, 'Hz')} (−3 dB), peak {result['closed_peak_db']:+.1f} dB")
    out.say(f"open loop     phase margin {shown(found.phase_margin_deg, '°', found.crossover_hz)}")
    out.say(f"              gain margin  {shown(found.gain_margin_db, 'dB', found.phase_crossover_hz)}")
    out.say(f"              sensitivity peak {shown(found.sensitivity, '')}".rstrip())
    out.say(
        f"coherence     {result['trusted']} of {result['lines']} lines above {GOOD_COHERENCE}; the others were not used"
    )
    show_files(session, files, measured.lost)
