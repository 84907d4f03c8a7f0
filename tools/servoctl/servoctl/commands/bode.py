"""bode: the speed loop of the live axis in the frequency domain."""

from __future__ import annotations

import math
from dataclasses import asdict
from pathlib import Path
from typing import Any

import click
import numpy as np

from ..errors import InputError, MotionError
from ..frequency_response import (
    GOOD_COHERENCE,
    Multisine,
    bandwidth_hz,
    design_multisine,
    estimate,
    margins,
    open_loop_is_sharp,
    peak_db,
)
from ..limits import Limits, Plan, span
from ..loop_model import open_loop, read_gains
from ..parameter import AXES
from ..session import Session, common
from ..stream import TICK_S
from ..units import degrees
from .motion import announce, motion_options, new_path, run_rates, show_files
from .quantity import FREQUENCY, RATE

SETPOINT_PERIOD_S = 0.002
WARM_UP_S = 1.0


@click.command()
@motion_options("5", "45", "180")
@click.option("--low", type=FREQUENCY, default="1", show_default=True, help="Lowest frequency (Hz).")
@click.option("--high", type=FREQUENCY, default="200", show_default=True, help="Highest frequency (Hz).")
@click.option("--bias", type=RATE, default="1", show_default=True, help="Mean rate (°/s): the axis slides throughout.")
@click.option(
    "--amplitude", type=RATE, default="0.6", show_default=True, help="Peak of the multisine (°/s), below the bias."
)
@click.option("--lines", type=click.IntRange(5, 200), default=50, show_default=True, help="Number of sines.")
@click.option(
    "--periods", type=click.IntRange(2, 100), default=5, show_default=True, help="Periods measured; more average more."
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

    A multisine around a mean rate is the set-point (60FF, mode csv, every 2 ms); demand (606B) and answer (606C) come
    back at 1 kHz. The closed loop is their quotient; the open loop at the motor's torque is computed from it with the
    gains that the device has. The way of set-points limits the method to 200 Hz. Friction makes the loop non-linear:
    the result is that of the axis sliding at the mean rate.
    """
    if not 0.05 <= low < high or high > 0.4 / SETPOINT_PERIOD_S:
        raise InputError(
            f"the frequencies {low:g} to {high:g} Hz are not possible: --low is 0.05 Hz or more, --high at most"
            f" {0.4 / SETPOINT_PERIOD_S:.0f} Hz, as set-points go out every {1e3 * SETPOINT_PERIOD_S:g} ms."
        )
    if amplitude <= 0 or (bias != 0 and amplitude >= abs(bias)):
        raise InputError("--amplitude must be above 0 and below --bias, or the axis would turn round and stick.")
    sine = design_multisine(low, high, lines)
    duration = WARM_UP_S + periods * sine.period_s + 0.1
    time_s = np.arange(0.0, duration, TICK_S)
    ramp = np.minimum(1.0, time_s / WARM_UP_S)
    rates = ramp * (bias + amplitude * sine.at(time_s))
    forward, backward = span(rates, TICK_S)
    text = (
        f"{degrees(bias):.3g} °/s with {len(sine.frequency_hz)} sines of {low:g} to {high:g} Hz, peak {degrees(amplitude):.3g} °/s,"
        f" {periods} × {sine.period_s:g} s"
    )
    plan = Plan(axis, text, float(np.max(np.abs(rates))), forward, backward, duration)
    limits = Limits(max_rate, max_travel, max_duration)
    with session.connect() as device:
        if not announce(session, plan, limits, device, dry_run, yes):
            return
        gains = read_gains(device, AXES.index(axis))
        interpolation_ms = round(SETPOINT_PERIOD_S / TICK_S)
        demand, answer, lost = run_rates(
            session, device, axis, rates, interpolation_ms, SETPOINT_PERIOD_S, limits, "bode"
        )
    _report_bode(session, axis, sine, demand, answer, lost, gains, new_path(folder, "bode", axis))


def _report_bode(
    session: Session, axis: str, sine: Multisine, demand: Any, answer: Any, lost: int, gains: Any, path: Path
) -> None:
    skip = int((WARM_UP_S + 0.05) / TICK_S)
    closed = estimate(demand[skip:], answer[skip:], TICK_S, sine)
    loop = open_loop(gains, closed.frequency_hz, closed.value)
    good = closed.coherence >= GOOD_COHERENCE
    if np.count_nonzero(good) < 3:
        raise MotionError(
            f"the coherence is below {GOOD_COHERENCE} nearly everywhere: the answer is noise. More --amplitude or --periods help."
        )
    sharp = open_loop_is_sharp(closed, loop)
    if np.count_nonzero(sharp) < 3:
        raise MotionError("the open loop cannot be told from the noise: more --amplitude or --periods help.")
    found = margins(closed.frequency_hz[sharp], loop[sharp])
    width = bandwidth_hz(closed.frequency_hz[good], closed.value[good])
    from ..plots import plot_bode, write_csv

    write_csv(
        path.with_suffix(".csv"),
        {
            "frequency_hz": closed.frequency_hz,
            "closed_db": 20 * np.log10(np.abs(closed.value)),
            "closed_deg": np.degrees(np.unwrap(np.angle(closed.value))),
            "open_db": 20 * np.log10(np.abs(loop)),
            "open_deg": np.degrees(np.unwrap(np.angle(loop))),
            "coherence": closed.coherence,
            "open_loop_trusted": sharp.astype(float),
        },
    )
    plot_bode(
        path.with_suffix(".png"),
        f"{axis}: speed loop, measured",
        closed.frequency_hz,
        closed.value,
        loop,
        closed.coherence,
        sharp,
        found,
        width,
    )
    files = [str(path.with_suffix(".png")), str(path.with_suffix(".csv"))]
    result = asdict(found) | {
        "bandwidth_hz": width,
        "closed_peak_db": peak_db(closed.value[good]),
        "trusted": int(np.count_nonzero(good)),
        "lines": len(good),
    }
    session.out.json({"axis": axis, **result, "lost": lost, "files": files})

    def shown(value: float | None, unit: str, where: float | None = None) -> str:
        if value is None or not math.isfinite(value):
            return "not within the measured frequencies"
        return f"{value:.1f} {unit}" + (f" at {where:.1f} Hz" if where is not None else "")

    out = session.out
    out.say(f"closed loop   bandwidth {shown(width, 'Hz')} (−3 dB), peak {result['closed_peak_db']:+.1f} dB")
    out.say(f"open loop     phase margin {shown(found.phase_margin_deg, '°', found.crossover_hz)}")
    out.say(f"              gain margin  {shown(found.gain_margin_db, 'dB', found.phase_crossover_hz)}")
    out.say(f"              sensitivity peak {shown(found.sensitivity, '')}".rstrip())
    out.say(
        f"coherence     {result['trusted']} of {result['lines']} lines above {GOOD_COHERENCE}; the others are not used"
    )
    show_files(session, files, lost)
