"""follow: a trajectory of both joints over time, from a CSV file or the pass of a satellite."""

from __future__ import annotations

import contextlib
import math
import time
from collections.abc import Sequence
from dataclasses import dataclass
from datetime import datetime, timedelta, timezone
from pathlib import Path
from typing import Any

import click
import numpy as np
from numpy.typing import NDArray

from .. import power
from ..cable_wrap import TURNS, longest_within, with_turns
from ..device import Device
from ..drive import Drive
from ..errors import InputError, MotionError
from ..live import LiveAxis
from ..node_limits import read_limits
from ..pair_stream import PositionStream
from ..parameter import AXES
from ..session import Session, common
from ..trajectory import AxisLimits, Trajectory, read_trajectory
from ..units import TICK_S, degrees
from .following import check_plot, following_options, save_errors
from .motion import check_pace, check_slew, confirm, slew
from .quantity import ANGLE, DURATION, Quantity

Real = NDArray[np.float64]

PERIOD_TICKS = 10
"""60C2: time between set-points."""
LEAD_TICKS = 1
"""From the tick whose frame makes us send a set-point to the one in which the node takes it."""
REST_S = 0.3
"""At rest at the first angle, before the start."""
ACCELERATION_SHARE = 0.5
"""Of 6083 and 6084, for the start from rest and the stop after the end."""
SWITCH_S = 1.0
"""Time for the change to mode csp before a start at a fixed time."""
_FOREVER = 1 << 62
READY_S = 10.0
"""From the time at which the axes could have slewed to the first angle to the start: they are enabled, one after the
other, and stand there for some seconds."""
LATE_S = 0.05
"""A start later than this would be a jump."""
OLD_DAYS = 14.0
_METRES = Quantity("m", low=-500.0, high=9000.0)
_LOWEST_DEG, _HIGHEST_DEG = -5.0, 89.0


@dataclass(frozen=True)
class SkyOptions:
    """Options that only two-line elements need."""

    site: tuple[float, float, float] | None
    heading_rad: float
    after: str | None
    lowest_rad: float
    rehearse: bool


@click.command(short_help="Follow a trajectory from a file, or a satellite.")
@click.argument("file", type=click.Path(path_type=Path, dir_okay=False))
@click.option(
    "--site", type=(ANGLE, ANGLE, _METRES), metavar="LAT LON HEIGHT", default=None,
    help="Two-line elements: latitude and longitude (°, north and east positive) and height (m, WGS 84) of the tracker.",
)
@click.option(
    "--heading", type=ANGLE, default="0", show_default=True,
    help="Two-line elements: direction of joint azimuth 0, clockwise from north (°).",
)
@click.option(
    "--after", metavar="TIME",
    help="Two-line elements: follow the first pass that begins after this time, e.g. 2026-11-23T05:00:00Z (default: now).",
)
@click.option(
    "--min-elevation", "lowest", type=ANGLE, default="10", show_default=True,
    help="Two-line elements: elevation at which a pass begins and ends (°).",
)
@click.option("--rehearse", is_flag=True, help="Two-line elements: do not wait for the pass, begin at once.")
@click.option("--seconds", type=DURATION, help="Follow only the first rows, up to this time after the first one.")
@following_options("first angle")
@common
def follow(
    session: Session, file: Path, site: tuple[float, float, float] | None, heading: float, after: str | None, lowest: float,
    rehearse: bool, seconds: float | None, slew_rate: float, interval: float, plot: Path | None, overwrite: bool,
    dry_run: bool, yes: bool,
) -> None:  # fmt: skip
    """Follow a trajectory of the joints over time in mode csp: FILE is a CSV file, or has the two-line elements of a
    satellite.

    A CSV file has the columns time_s, azimuth_deg or pitch_deg or both, and if known azimuth_rate_deg_s and
    pitch_rate_deg_s. Other units are ms, rad, mrad and urad. Angles are those of the joints. Lines that begin with # are
    comments.

    The whole trajectory is checked against the node's limits of travel, rate (607F) and acceleration (6083, 6084) before
    anything moves. The axes slew to the first angle, start from rest, follow in time, and stop after the last row.
    """
    check_plot(session, plot, overwrite, file)
    sky = SkyOptions(site, heading, after, lowest, rehearse)
    source = _satellite(file, sky) if _is_elements(file) else _from_csv(file, sky)
    with session.connect() as device:
        limits = {axis: _limits(Drive(device, axis)) for axis in source.candidates[0].angle_rad}
        candidates = [whole.shortened(seconds) if seconds else whole for whole in source.candidates]
        chosen = longest_within(candidates, limits)
        trajectory = candidates[chosen]
        gentle = ACCELERATION_SHARE * min(min(limit.acceleration_rad_s2, limit.deceleration_rad_s2) for limit in limits.values())
        whole = trajectory.extended(gentle, REST_S)
        whole.check(limits)
        for axis, angle in whole.angle_rad.items():
            check_slew(Drive(device, axis), float(angle[0]), slew_rate)
        plan = _announce(session, source.text, whole)
        if chosen and not source.begin:
            session.out.say(
                f"  the azimuth is {360 * TURNS[chosen]:+d}° from the file's angles, which leave its travel."
            )
        if source.note:
            session.out.note(source.note)
        if not confirm(session, plan, dry_run, yes):
            return
        check_pace(device)
        if source.begin is not None and not rehearse:
            early_s = _slew_s(device, whole, slew_rate) - float(whole.time_s[0]) + READY_S
            _wait(session, source.begin, early_s)
        record = _run(session, device, trajectory, whole, source.begin if not rehearse else None, slew_rate, interval)
    _show(session, trajectory, record, plot, overwrite)


# --- sources ----------------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Source:
    """What to follow: trajectories that show the same (other whole turns), best first; when it begins, if that is fixed."""

    text: str
    candidates: Sequence[Trajectory]
    begin: datetime | None = None
    note: str = ""


def _is_elements(file: Path) -> bool:
    from ..satellite import is_elements

    return is_elements(file)


def _from_csv(file: Path, sky: SkyOptions) -> Source:
    if sky.site is not None or sky.after is not None or sky.rehearse:
        raise InputError(f"--site, --after and --rehearse are for two-line elements, but {file} has none.")
    trajectory = read_trajectory(file)
    return Source(f"{file}, {len(trajectory.time_s)} rows, {trajectory.duration_s:.4g} s", with_turns(trajectory))


def _satellite(file: Path, sky: SkyOptions) -> Source:
    from ..satellite import Site, age_days, next_pass, parse_time, pass_trajectory, read_elements

    if sky.site is None:
        raise InputError(f"{file} has two-line elements: give the place of the tracker, e.g. --site 52.2 21.0 100.")
    latitude, longitude, height = sky.site
    if abs(latitude) > math.pi / 2:
        raise InputError(f"--site: the latitude {degrees(latitude):g}° is beyond ±90°.")
    if not _LOWEST_DEG <= degrees(sky.lowest_rad) <= _HIGHEST_DEG:
        raise InputError(f"--min-elevation: {degrees(sky.lowest_rad):g}° is not from {_LOWEST_DEG:g}° to {_HIGHEST_DEG:g}°.")
    name, elements = read_elements(file)
    after = parse_time(sky.after) if sky.after else datetime.now(timezone.utc)
    site = Site(latitude, longitude, height)
    found = next_pass(elements, site, after, sky.lowest_rad)
    if not sky.rehearse and found.begin < datetime.now(timezone.utc):
        raise InputError(
            f"the pass began at {found.begin:%Y-%m-%d %H:%M:%S} UTC, which is past: give a later --after, or --rehearse."
        )
    text = (
        f"{name}, pass of {found.begin:%Y-%m-%d %H:%M:%S} UTC, {found.duration_s:.0f} s, up to"
        f" {degrees(found.highest_rad):.1f}°"
    )
    turns = [pass_trajectory(name, elements, site, found, sky.heading_rad, turn) for turn in (0, 1, -1)]
    days = age_days(elements, found.begin)
    old = f"the elements are {days:.0f} days from the pass: after {OLD_DAYS:g} days a low satellite may be off by degrees."
    return Source(text, turns, found.begin, old if abs(days) > OLD_DAYS else "")


# --- before the motion ------------------------------------------------------------------------------------------------


def _limits(drive: Drive) -> AxisLimits:
    def counts(index: int) -> float:
        return drive.device.axis_int(drive.axis, index) * 1e-6

    return AxisLimits(read_limits(drive), counts(0x6083), counts(0x6084))


def _announce(session: Session, text: str, whole: Trajectory) -> dict[str, Any]:
    session.out.say(f"{' and '.join(AXES[axis] for axis in whole.angle_rad)} will follow {text}")
    plan: dict[str, Any] = {"text": text, "axes": []}
    for axis, angle in whole.angle_rad.items():
        values = {
            "axis": AXES[axis], "first_deg": degrees(float(angle[0])), "lowest_deg": degrees(float(angle.min())),
            "highest_deg": degrees(float(angle.max())), "rate_deg_s": degrees(whole.fastest(axis)),
        }  # fmt: skip
        plan["axes"].append(values)
        session.out.say(
            f"  {AXES[axis]} from {values['first_deg']:.3f}°, between {values['lowest_deg']:.3f}° and"
            f" {values['highest_deg']:.3f}°, at most {values['rate_deg_s']:.3g} °/s"
        )
    return plan


def _slew_s(device: Device, whole: Trajectory, rate_rad_s: float) -> float:
    return max(abs(float(angle[0]) - Drive(device, axis).position()) for axis, angle in whole.angle_rad.items()) / rate_rad_s


def _wait(session: Session, begin: datetime, early_s: float) -> None:
    until = begin - timedelta(seconds=early_s)
    left_s = (until - datetime.now(timezone.utc)).total_seconds()
    if left_s < 0.0:
        raise InputError(
            f"the pass begins in {left_s + early_s:.0f} s, but the axes need {early_s:.0f} s to be ready: give a later"
            " --after, a faster --slew-rate, or --rehearse."
        )
    session.out.say(f"waits {left_s:.0f} s; the axes begin to move at {until:%H:%M:%S} UTC.")
    while (left_s := (until - datetime.now(timezone.utc)).total_seconds()) > 0.0:
        time.sleep(min(left_s, 1.0))


# --- the motion -------------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Record:
    """Times of the trajectory (s) and, by axis, what the node measured minus what the file says (rad)."""

    time_s: Real
    error_rad: dict[int, Real]
    lost: int
    late: int


def _run(
    session: Session, device: Device, trajectory: Trajectory, whole: Trajectory, begin: datetime | None, slew_rate: float,
    interval: float,
) -> Record:  # fmt: skip
    axes = sorted(whole.angle_rad)
    first_s = float(whole.time_s[0])
    with PositionStream(device) as stream, contextlib.ExitStack() as motion:
        lives = [motion.enter_context(LiveAxis(device, axis, power.PROFILE_POSITION)) for axis in axes]
        slew(lives, [float(whole.angle_rad[axis][0]) for axis in axes], slew_rate)
        if begin is not None:
            _sleep_until(begin + timedelta(seconds=first_s - SWITCH_S))
        for live in lives:
            live.set_interpolation(PERIOD_TICKS)
            live.drive.set_mode(power.CYCLIC_POSITION)
            live.mode = power.CYCLIC_POSITION
        still = [Drive(device, axis).position() for axis in range(len(AXES))]
        stream.start()
        zero_s, shown_s = first_s, 0.0
        for count, tick in enumerate(stream.pace(PERIOD_TICKS, _FOREVER)):
            if count == 0:
                zero_s = first_s if begin is None else (datetime.now(timezone.utc) - begin).total_seconds() - tick * TICK_S
                shown_s = zero_s
                if zero_s > first_s + LATE_S:
                    raise MotionError(f"the axes were ready {zero_s - first_s:.1f} s too late for the pass.")
            now_s = zero_s + tick * TICK_S
            if now_s >= whole.time_s[-1]:
                break
            at = np.array([now_s + (PERIOD_TICKS + LEAD_TICKS) * TICK_S])
            targets = [float(whole.angles(axis, at)[0]) if axis in axes else still[axis] for axis in range(len(AXES))]
            stream.send(*targets)
            if count % 10 == 9:
                lives[count // 10 % len(lives)].check_enabled()
            if now_s >= shown_s + interval:
                shown_s += interval
                _show_line(session, _record(stream, trajectory, zero_s, round(interval / TICK_S)), now_s)
        for live in lives:
            live.check_enabled()
        return _record(stream, trajectory, zero_s)


def _sleep_until(when: datetime) -> None:
    time.sleep(max(0.0, (when - datetime.now(timezone.utc)).total_seconds()))


def _record(stream: PositionStream, trajectory: Trajectory, zero_s: float, last: int = 0) -> Record:
    """Of the file's times; only the last samples if `last` is given."""
    time_s, angle = stream.positions(-last if last else 0)
    time_s = time_s + zero_s
    inside = (time_s >= trajectory.time_s[0]) & (time_s <= trajectory.time_s[-1])
    errors = {axis: angle[inside, axis] - trajectory.angles(axis, time_s[inside]) for axis in trajectory.angle_rad}
    return Record(time_s[inside], errors, stream.lost(), stream.late)


# --- results ----------------------------------------------------------------------------------------------------------


def _show_line(session: Session, part: Record, now_s: float) -> None:
    if not len(part.time_s):
        return
    errors = {AXES[axis]: 1e6 * float(np.sqrt(np.mean(error**2))) for axis, error in part.error_rad.items()}
    session.out.json({"time_s": round(now_s, 3)} | {f"{name}_rms_urad": error for name, error in errors.items()})
    session.out.say(f"{now_s:8.1f} s  error (rms) " + "  ".join(f"{name} {error:.1f} µrad" for name, error in errors.items()))


def delay_s(error_rad: Real, rate_rad_s: Real) -> float:
    """How late the axis is, by the part of the error that is proportional to the rate; 0 for an axis that stands."""
    square = float(np.sum(rate_rad_s**2))
    return -float(np.sum(error_rad * rate_rad_s)) / square if square > 0.0 else 0.0


def _show(session: Session, trajectory: Trajectory, record: Record, plot: Path | None, overwrite: bool) -> None:
    results, rows = [], []
    for axis, error in record.error_rad.items():
        rate = np.gradient(trajectory.angles(axis, record.time_s), record.time_s) if len(error) > 2 else np.zeros(len(error))
        found = {
            "axis": AXES[axis], "rms_urad": 1e6 * float(np.sqrt(np.mean(error**2))),
            "max_urad": 1e6 * float(np.max(np.abs(error))), "delay_ms": 1e3 * delay_s(error, rate),
        }  # fmt: skip
        results.append(found)
        rows.append((AXES[axis], f"{found['rms_urad']:.1f}", f"{found['max_urad']:.1f}", f"{found['delay_ms']:+.2f}"))
    files = _save(record, plot, overwrite) if plot else []
    session.out.json({"axes": results, "samples": len(record.time_s), "lost": record.lost, "late_ms": record.late, "files": files})
    session.out.table(["axis", ("error rms µrad", "right"), ("largest µrad", "right"), ("behind time ms", "right")], rows)
    if record.lost:
        session.out.note(f"{record.lost} samples were lost in transmission.")
    if files:
        session.out.say("saved: " + ", ".join(files))


def _save(record: Record, plot: Path, overwrite: bool) -> list[str]:
    errors = {AXES[axis]: 1e6 * error for axis, error in record.error_rad.items()}
    return save_errors(plot, overwrite, "Measured angle minus trajectory", record.time_s, errors)
