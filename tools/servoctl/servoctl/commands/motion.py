"""move, step and bode: the commands that move an axis. Each says what will move before it moves."""

from __future__ import annotations

import math
import sys
import time
from collections.abc import Callable
from dataclasses import asdict
from datetime import datetime
from pathlib import Path
from typing import Any, TypeVar

import click
import numpy as np

from .. import power
from ..device import Device
from ..drive import Drive
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
from ..limits import Guard, Limits, Plan, span
from ..live import LiveAxis, pace
from ..loop_model import open_loop, read_gains
from ..parameter import AXES
from ..session import Session, common
from ..step_response import StepNumbers, analyse_step
from ..stream import TICK_S, RateStream
from ..units import degrees, parse_quantity, radians

F = TypeVar("F", bound=Callable[..., Any])

SETPOINT_PERIOD_S = 0.002
STEP_SETPOINT_PERIOD_S = 0.004
BEFORE_STEP_S = 0.15
WARM_UP_S = 1.0
MANY_LOST = 50


class Quantity(click.ParamType):  # type: ignore[type-arg] # not generic in click 8.1
    """A number with a unit, e.g. "5deg" or "0.1 rad/s"; bare numbers are degrees or seconds."""

    name = "value"

    def __init__(self, unit: str, bare: str) -> None:
        self.unit = unit
        self.bare = bare

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> float:
        """To the SI unit."""
        if isinstance(value, float):
            return value
        try:
            return parse_quantity(str(value), self.unit, self.bare)
        except InputError as error:
            self.fail(str(error), param, ctx)

    def get_metavar(self, param: click.Parameter, ctx: click.Context) -> str:
        """The unit of bare numbers."""
        return self.bare.upper().replace("DEG", "°")


ANGLE, RATE, TIME, FREQUENCY = (
    Quantity("rad", "deg"),
    Quantity("rad/s", "deg/s"),
    Quantity("s", "s"),
    Quantity("Hz", "Hz"),
)


def motion_options(max_rate: str, max_travel: str, max_duration: str) -> Callable[[F], F]:
    """Axis, limits, --dry-run and --yes."""

    def add(command: F) -> F:
        for option in (
            click.option("--yes", "-y", is_flag=True, help="Move without asking; needed when no terminal can answer."),
            click.option("--dry-run", is_flag=True, help="Say what would move, and move nothing."),
            click.option(
                "--max-duration", type=TIME, default=max_duration, show_default=True, help="Longest motion (s)."
            ),
            click.option("--max-travel", type=ANGLE, default=max_travel, show_default=True, help="Farthest way (°)."),
            click.option("--max-rate", type=RATE, default=max_rate, show_default=True, help="Fastest rate (°/s)."),
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


# --- move -------------------------------------------------------------------------------------------------------------


@click.command(context_settings={"ignore_unknown_options": False})
@motion_options("20", "90", "120")
@click.option("--to", "target", type=ANGLE, help="Absolute joint angle (°).")
@click.option("--by", type=ANGLE, help="Relative way (°).")
@click.option(
    "--rate", type=RATE, help="Without --to or --by: run at this rate (°/s); else the profile rate (default 2)."
)
@click.option("--for", "duration", type=TIME, help="How long to run at the rate (s).")
@common
def move(
    session: Session, axis: str, target: float | None, by: float | None, rate: float | None, duration: float | None,
    max_rate: float, max_travel: float, max_duration: float, dry_run: bool, yes: bool,
) -> None:  # fmt: skip
    """Move an axis: --to or --by an angle (mode pp), or --rate --for a time (mode pv).

    Angles and rates are in degrees unless a unit follows, as in --by "10 mrad". The axis is enabled for it, and
    disabled again when it was before.
    """
    runs = target is None and by is None
    if runs and (rate is None or duration is None):
        raise InputError("say --to or --by an angle, or --rate and --for.")
    if target is not None and by is not None or (not runs and duration is not None):
        raise InputError("--to, --by and --rate with --for exclude each other.")
    limits = Limits(max_rate, max_travel, max_duration)
    with session.connect() as device:
        drive = Drive(device, AXES.index(axis))
        start = drive.position()
        if runs:
            assert rate is not None and duration is not None
            way = rate * duration
            plan = Plan(
                axis,
                f"runs at {degrees(rate):.4g} °/s for {duration:.4g} s",
                abs(rate),
                max(way, 0.0),
                max(-way, 0.0),
                duration,
            )
        else:
            rate = abs(rate) if rate else radians(2.0)
            way = by if by is not None else (target or 0.0) - start
            plan = Plan(
                axis, f"from {degrees(start):.4f}° to {degrees(start + way):.4f}° at up to {degrees(rate):.4g} °/s",
                rate, max(way, 0.0), max(-way, 0.0), abs(way) / rate + 1.0,
            )  # fmt: skip
        if not announce(session, plan, limits, device, dry_run, yes):
            return
        if runs:
            _run_at_rate(session, device, axis, rate, plan.duration_s)
        else:
            _go_to(session, device, axis, start + way, rate, plan.duration_s)
        end = drive.position()
        error = end - (start + way)
    session.out.json({"axis": axis, "from_deg": degrees(start), "to_deg": degrees(end), "state": "standing"})
    arrived = "" if runs else f", {1e6 * error:+.0f} µrad from the target"
    session.out.say(f"{axis} stands at {degrees(end):.4f}° (from {degrees(start):.4f}°){arrived}.")


def _run_at_rate(session: Session, device: Device, axis: str, rate: float, duration: float) -> None:
    with LiveAxis(device, AXES.index(axis), power.PROFILE_VELOCITY) as live, session.out.progress() as bar:
        task = bar.add_task(f"{axis} runs", total=duration)
        live.drive.set_target_rate(rate)
        for now in pace(0.05, duration):
            _still_enabled(live)
            bar.update(task, completed=now)


def _go_to(session: Session, device: Device, axis: str, target: float, rate: float, expected_s: float) -> None:
    with LiveAxis(device, AXES.index(axis), power.PROFILE_POSITION) as live, session.out.progress() as bar:
        drive = live.drive
        task = bar.add_task(f"{axis} moves", total=1.0)
        drive.set_profile_rate(rate)
        drive.set_target_position(target)
        start = drive.position()
        drive.control(power.ENABLE_OPERATION)
        drive.control(power.ENABLE_OPERATION | power.NEW_SETPOINT | power.CHANGE_IMMEDIATELY)
        drive.wait(lambda: bool(drive.statusword() & power.SETPOINT_ACKNOWLEDGED), 1.0, "take the target")
        drive.control(power.ENABLE_OPERATION)
        deadline = time.monotonic() + 2.0 * expected_s + 5.0
        while not _still_enabled(live) & power.TARGET_REACHED:
            done = abs(drive.position() - start) / max(abs(target - start), 1e-9)
            bar.update(task, completed=min(done, 1.0))
            if time.monotonic() > deadline:
                raise MotionError(f"{axis} has not reached its target after {2.0 * expected_s + 5.0:.0f} s.")
            time.sleep(0.02)


def _still_enabled(live: LiveAxis) -> int:
    """The statusword; raises MotionError when the axis is no longer enabled."""
    status = live.drive.statusword()
    if live.drive.state(status) != power.ENABLED:
        raise MotionError(
            f"{live.drive.name} is in '{live.drive.state(status)}' (603F = {live.drive.error_code():04X}); 'servoctl faults' tells more."
        )
    return status


# --- step -------------------------------------------------------------------------------------------------------------


@click.command()
@motion_options("5", "30", "60")
@click.option("--amplitude", type=RATE, default="1", show_default=True, help="Height of the step (°/s).")
@click.option("--from", "base", type=RATE, default="0", show_default=True, help="Rate before the step (°/s).")
@click.option("--hold", type=TIME, default="1", show_default=True, help="Time at each rate (s).")
@click.option(
    "--one-way", is_flag=True, help="Only forward; else the same backward, so that the axis ends where it began."
)
@click.option(
    "--out", "folder", type=click.Path(path_type=Path, file_okay=False), default=".", help="Folder for PNG and CSV."
)
@common
def step(
    session: Session, axis: str, amplitude: float, base: float, hold: float, one_way: bool, folder: Path,
    max_rate: float, max_travel: float, max_duration: float, dry_run: bool, yes: bool,
) -> None:  # fmt: skip
    """Step the rate of the live axis (mode csv): rise, overshoot, settling, with plot and CSV.

    Demand (606B) and answer (606C) are recorded at 1 kHz, of the same tick. Limits are --max-rate, --max-travel and
    --max-duration.
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
        demand, answer, lost = _run_rates(session, device, axis, rates, 1, STEP_SETPOINT_PERIOD_S, limits, "step")
    records = _cut_steps(demand, answer, hold)
    if not records:
        raise MotionError(
            "the axis' demand did not step as told: this computer was late by more than 20 ms; run it again."
        )
    if len(records) < len(signs):
        session.out.note(f"only {len(records)} of {len(signs)} steps came through undisturbed; run it again.")
    path = new_path(folder, "step", axis)
    from ..plots import plot_steps, write_csv

    write_csv(
        path.with_suffix(".csv"),
        {"time_s": (np.arange(len(demand)) * TICK_S).tolist(), "demand_rad_s": demand, "rate_rad_s": answer},
    )
    plot_steps(path.with_suffix(".png"), f"{axis}: step of the rate by {degrees(amplitude):.3g} °/s", records)
    _show_steps(session, axis, records, path, lost)


def _run_rates(
    session: Session, device: Device, axis: str, rates: np.ndarray[Any, np.dtype[np.float64]], interpolation_ms: int,
    period_s: float, limits: Limits, what: str,
) -> tuple[np.ndarray[Any, np.dtype[np.float64]], np.ndarray[Any, np.dtype[np.float64]], int]:  # fmt: skip
    """Sends rates (rad/s, one per tick) in csv and returns demand, answer (rad/s at 1 kHz) and lost frames."""
    number = AXES.index(axis)
    duration = len(rates) * TICK_S
    with RateStream(device, number) as stream, LiveAxis(device, number, power.CYCLIC_VELOCITY) as live:
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
        _still_enabled(live)
        demand, answer = stream.samples()
        lost = stream.lost()
    if len(demand) < 0.9 * duration / TICK_S:
        raise MotionError(
            f"only {len(demand)} of {duration / TICK_S:.0f} samples came: the bus is too slow or too busy."
        )
    return demand, answer, lost


StepRecord = tuple[
    str,
    "np.ndarray[Any, np.dtype[np.float64]]",
    "np.ndarray[Any, np.dtype[np.float64]]",
    "np.ndarray[Any, np.dtype[np.float64]]",
    StepNumbers,
]


def _cut_steps(
    demand: np.ndarray[Any, np.dtype[np.float64]], answer: np.ndarray[Any, np.dtype[np.float64]], hold: float
) -> list[StepRecord]:
    """The parts of the record around each step away from zero that was held as long as told."""
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
    columns = ["step", ("to 50 % ms", "right"), ("rise ms", "right"), ("to 90 % ms", "right"), ("overshoot %", "right"),
               ("settling ms", "right"), ("error °/s", "right"), ("noise °/s", "right")]  # fmt: skip
    session.out.table(columns, rows)
    session.out.say("rise: 10 to 90 %; settling: to within 5 %; error and noise: of the last 30 %.")
    _show_files(session, files, lost)


def _show_files(session: Session, files: list[str], lost: int) -> None:
    if lost:
        worse = (
            "; times are too short by as many ms: run it again on a quieter bus or computer" if lost > MANY_LOST else ""
        )
        session.out.note(f"{lost} samples were lost on the way{worse}.")
    session.out.say("saved: " + ", ".join(files))


# --- bode -------------------------------------------------------------------------------------------------------------


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
        demand, answer, lost = _run_rates(
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
    _show_files(session, files, lost)
