# SPDX-License-Identifier: Apache-2.0
"""follow: a trajectory of both joints over time, from a CSV file or the pass of a satellite."""

from __future__ import annotations

import contextlib
import math
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from datetime import datetime, timedelta, timezone
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click
import numpy as np
from numpy.typing import NDArray

from ..drive import power
from ..drive.drive import Drive
from ..drive.node_limits import read_limits
from ..errors import InputError, MotionError
from ..link.device import Device
from ..link.pair_stream import PositionStream
from ..motion.cable_wrap import TURNS, longest_within, with_turns
from ..motion.live import LiveAxis
from ..motion.moves import check_slew, slew
from ..motion.trajectory import AxisLimits, Trajectory, read_trajectory
from ..objects.parameter import AXES
from ..session import Session, common
from ..show.text_file import TextFile, read_text
from ..units import TICK_S, degrees
from .following import check_plot, following_options, save_errors
from .motion import check_pace, confirm
from .quantity import ANGLE, DURATION, Quantity

if TYPE_CHECKING:
    from ..motion.satellite import Pass, Site
    from ..motion.two_lines import TwoLines

Real = NDArray[np.float64]
Limits = dict[int, AxisLimits]

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
SPARE_S = 1.0
"""For what lies between this computation and the motion."""
CONFIRM_S = 10.0
"""For a person to confirm."""
JOIN_S = 600.0
"""So much later than now a satellite that does not set may be joined."""
JOIN_STEPS = 6
"""Of the search for where the axes meet the satellite."""
LEAST_S = 5.0
"""Of a pass that is under way; what is shorter is left to the next one."""
LONGEST_S = 24 * 3600.0
"""Of a satellite that does not set."""
OLD_DAYS = 14.0
_METRES = Quantity("m", low=-500.0, high=9000.0)
_LOWEST_DEG, _HIGHEST_DEG = -5.0, 89.0


@dataclass(frozen=True)
class SkyOptions:
    """Options that only two-line elements need."""

    site: tuple[float, float, float] | None
    heading_rad: float
    tilt_rad: tuple[float, float]
    after: str | None
    lowest_rad: float
    rehearse: bool
    satellite: str
    seconds: float | None


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
    "--tilt", type=(ANGLE, ANGLE), metavar="ROLL PITCH", default=("0", "0"),
    help="Two-line elements: how far the tracker stands off level (°): ROLL raises its left side, PITCH its front, seen from joint"
    " azimuth 0.  [default: 0 0]",
)
@click.option(
    "--after", metavar="TIME",
    help="Two-line elements: follow the pass that is under way at this time, or else the next one, e.g. 2026-11-23T05:00:00Z"
    " (default: now).",
)
@click.option(
    "--min-elevation", "lowest", type=ANGLE, default="10", show_default=True,
    help="Two-line elements: elevation at which a pass begins and ends (°).",
)
@click.option(
    "--satellite", metavar="NAME", default="",
    help="Two-line elements: name, part of it, or number of the satellite, if the file has several (default: the first one).",
)
@click.option("--rehearse", is_flag=True, help="Two-line elements: do not wait for the pass, begin at once.")
@click.option("--seconds", type=DURATION, help="Follow only the first rows, up to this time after the first one. A satellite that never sets: default 1 h.")
@following_options("first angle")
@common
def follow(
    session: Session, file: Path, site: tuple[float, float, float] | None, heading: float, tilt: tuple[float, float], after: str | None,
    lowest: float, satellite: str, rehearse: bool, seconds: float | None, slew_rate: float, interval: float, plot: Path | None, overwrite: bool,
    dry_run: bool, yes: bool,
) -> None:  # fmt: skip
    """Follow a trajectory of the joints over time in mode csp: FILE is a CSV file, or has the two-line elements of a
    satellite.

    A CSV file has the columns time_s, azimuth_deg or pitch_deg or both, and if known azimuth_rate_deg_s and
    pitch_rate_deg_s. Other units are ms, rad, mrad and urad. Angles are those of the joints. Lines that begin with # are
    comments. With semicolons or tabs between the columns, decimal commas are understood.

    The whole trajectory is checked against the node's limits of travel, rate (607F) and acceleration (6083, 6084) before
    anything moves. The axes slew to the first angle, start from rest, follow in time, and stop after the last row.

    A satellite is followed during its next pass. A pass that is under way is joined as soon as the axes can be there. One that
    does not set is followed for --seconds.
    """
    check_plot(session, plot, overwrite, file)
    sky = SkyOptions(site, heading, tilt, after, lowest, rehearse, satellite, seconds)
    source = _source(read_text(file), sky)
    with session.connect() as device:
        limits = {axis: _limits(Drive(device, axis)) for axis in source.candidates[0].angle_rad}
        motion = Motion(slew_rate, 0.0 if yes else CONFIRM_S, seconds, timed=not rehearse)
        source, chosen, trajectory = _choose(device, source, limits, motion)
        whole = _extended(device, trajectory, limits, slew_rate)
        plan = _announce(session, source, trajectory, whole)
        if chosen and not source.begin:
            session.out.say(
                f"  the azimuth is {360 * TURNS[chosen]:+d}° from the file's angles, which leave its travel."
            )
        if source.note:
            session.out.note(source.note)
        if not confirm(session, plan, dry_run, yes):
            return
        check_pace(device)
        if source.begin is not None and motion.timed:
            later = _joined(device, source.candidates[chosen], source, limits, replace(motion, confirm_s=0.0))
            if later is None:
                raise InputError("too little is left of the pass: confirm sooner, or give a later --after.")
            if later.time_s[0] > trajectory.time_s[0]:  # the confirmation took long
                trajectory, whole = later, _extended(device, later, limits, slew_rate)
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
    longest_s: float | None = None
    """How long it is followed at most, counted from where it is joined."""
    next: Callable[[], Source] | None = None
    """What follows when too little of it is left."""


def _source(file: TextFile, sky: SkyOptions) -> Source:
    from ..motion.two_lines import is_elements

    return _satellite(file, sky) if is_elements(file) else _from_csv(file, sky)


def _from_csv(file: TextFile, sky: SkyOptions) -> Source:
    given = sky.site is not None or sky.after is not None or sky.rehearse or sky.satellite
    if given:
        raise InputError(f"--site, --after, --satellite and --rehearse are for two-line elements, but {file.path} has none.")
    trajectory = read_trajectory(file)
    return Source(f"{file.path}, {len(trajectory.time_s)} rows, {trajectory.duration_s:.4g} s", with_turns(trajectory))


def _satellite(file: TextFile, sky: SkyOptions) -> Source:
    from ..motion.satellite import Site, parse_time
    from ..motion.two_lines import choose, read_entries

    if sky.site is None:
        raise InputError(f"{file.path} has two-line elements: give the place of the tracker, e.g. --site 52.2 21.0 100.")
    latitude, longitude, height = sky.site
    if abs(latitude) > math.pi / 2:
        raise InputError(f"--site: the latitude {degrees(latitude):g}° is beyond ±90°.")
    if not _LOWEST_DEG <= degrees(sky.lowest_rad) <= _HIGHEST_DEG:
        raise InputError(f"--min-elevation: {degrees(sky.lowest_rad):g}° is not from {_LOWEST_DEG:g}° to {_HIGHEST_DEG:g}°.")
    after = parse_time(sky.after) if sky.after else datetime.now(timezone.utc)
    entries = read_entries(file)
    chosen = choose(entries, sky.satellite, after)
    others = len({entry.number for entry in entries}) - 1
    note = f"{file.path} has {others + 1} satellites; this is the first one. --satellite NAME chooses another." if others and not sky.satellite else ""
    return _pass(chosen, Site(latitude, longitude, height), sky, after, note)


def _pass(chosen: TwoLines, site: Site, sky: SkyOptions, after: datetime, note: str) -> Source:
    from ..motion.satellite import ENDLESS_S, Base, next_pass, pass_trajectory
    from ..motion.two_lines import age_days

    elements = chosen.satrec()
    longest_s = sky.seconds or ENDLESS_S
    found = next_pass(elements, site, after, sky.lowest_rad, longest_s)
    now = datetime.now(timezone.utc)
    if not found.sets and not sky.rehearse and found.begin < now:
        found = next_pass(elements, site, now, sky.lowest_rad, longest_s)
    if not sky.rehearse and found.end < now:
        raise InputError(
            f"the pass began at {found.begin:%Y-%m-%d %H:%M:%S} UTC, which is past: give a later --after, or --rehearse."
        )
    if not found.sets and longest_s > LONGEST_S:
        raise InputError(f"{chosen.name} does not set: give --seconds up to {LONGEST_S:g}, not {longest_s:g}.")
    days = age_days(elements, found.begin)
    if abs(days) > OLD_DAYS:
        note += f"{' ' if note else ''}the elements are {days:.0f} days from the pass: after {OLD_DAYS:g} days a low satellite may be off by degrees."
    base = Base(sky.heading_rad, *sky.tilt_rad)
    covered = found if found.sets else replace(found, duration_s=longest_s + JOIN_S)
    turns = [pass_trajectory(chosen.name, elements, site, covered, base, turn) for turn in (0, 1, -1)]
    return Source(
        _pass_text(chosen.name, found, sky), turns, found.begin, note, None if found.sets else longest_s,
        lambda: _pass(chosen, site, sky, found.end + timedelta(seconds=1.0), note),
    )  # fmt: skip


def _pass_text(name: str, found: Pass, sky: SkyOptions) -> str:
    begin, highest = f"{found.begin:%Y-%m-%d %H:%M:%S} UTC", f"up to {degrees(found.highest_rad):.1f}°"
    if not found.sets:
        default = "" if sky.seconds else "; --seconds changes that"
        return f"{name}, which does not set within 48 h, from {begin} for {found.duration_s:g} s{default}, {highest}"
    if found.under_way:
        return f"{name}, pass under way at {begin}, which sets at {found.end:%H:%M:%S} UTC, {found.duration_s:.0f} s later, {highest} until then"
    return f"{name}, pass of {begin}, {found.duration_s:.0f} s, {highest}"


# --- before the motion ------------------------------------------------------------------------------------------------


def _limits(drive: Drive) -> AxisLimits:
    def counts(index: int) -> float:
        return drive.device.axis_int(drive.axis, index) * 1e-6

    return AxisLimits(read_limits(drive), counts(0x6083), counts(0x6084))


@dataclass(frozen=True)
class Motion:
    """How the axes get to a trajectory: the rate of the slew (rad/s), time for a confirmation (s), how much is followed (s), and
    whether it happens at a fixed time."""

    slew_rad_s: float
    confirm_s: float
    seconds: float | None
    timed: bool


def _choose(device: Device, source: Source, limits: Limits, motion: Motion) -> tuple[Source, int, Trajectory]:
    """The source, or a later pass if too little of it is left; the whole turns of the azimuth, by their number in the candidates;
    and what is followed."""
    while True:
        found = {
            number: joined for number, candidate in enumerate(source.candidates)
            if (joined := _joined(device, candidate, source, limits, motion)) is not None
        }  # fmt: skip
        if found:
            chosen = list(found)[longest_within(list(found.values()), limits)]
            return source, chosen, found[chosen]
        if source.next is None:
            raise InputError("there is nothing left to follow.")
        source = source.next()


def _joined(device: Device, trajectory: Trajectory, source: Source, limits: Limits, motion: Motion) -> Trajectory | None:
    """From where the axes can be on it, as long as is wanted; None when too little is left."""
    found: Trajectory | None = trajectory
    if source.begin is not None and motion.timed:
        at_s = _meeting_s(device, trajectory, source.begin, limits, motion)
        if at_s > trajectory.time_s[0]:
            found = trajectory.later(at_s) if at_s <= trajectory.time_s[-1] - LEAST_S else None
    return found and found.shortened(min(motion.seconds or math.inf, source.longest_s or math.inf))


def _meeting_s(device: Device, trajectory: Trajectory, begin: datetime, limits: Limits, motion: Motion) -> float:
    """Time of the trajectory at which the axes can be on it. The later it is, the further they may have to slew."""
    here = {axis: Drive(device, axis).position() for axis in trajectory.angle_rad}
    at_s = float(trajectory.time_s[0])
    for _ in range(JOIN_STEPS):
        at = np.array([at_s])
        slew_s = max(abs(float(trajectory.angles(axis, at)[0]) - here[axis]) for axis in here) / motion.slew_rad_s
        ramp_s = max(abs(float(trajectory.rates(axis, at)[0])) for axis in here) / _gentle(limits) + REST_S
        past_s = (datetime.now(timezone.utc) - begin).total_seconds()
        at_s = max(at_s, past_s + slew_s + ramp_s + READY_S + motion.confirm_s + SPARE_S)
    return at_s


def _gentle(limits: Limits) -> float:
    """Acceleration of the start and the stop, rad/s²."""
    return ACCELERATION_SHARE * min(min(limit.acceleration_rad_s2, limit.deceleration_rad_s2) for limit in limits.values())


def _extended(device: Device, trajectory: Trajectory, limits: Limits, slew_rate: float) -> Trajectory:
    """With start and stop; raises InputError when that, or the slew to it, is not allowed."""
    whole = trajectory.extended(_gentle(limits), REST_S)
    whole.check(limits)
    for axis, angle in whole.angle_rad.items():
        check_slew(Drive(device, axis), float(angle[0]), slew_rate)
    return whole


def _announce(session: Session, source: Source, trajectory: Trajectory, whole: Trajectory) -> dict[str, Any]:
    session.out.say(f"{' and '.join(AXES[axis] for axis in whole.angle_rad)} will follow {source.text}")
    plan: dict[str, Any] = {"text": source.text, "seconds": trajectory.duration_s, "axes": []}
    if source.begin is not None:
        first = source.begin + timedelta(seconds=float(trajectory.time_s[0]))
        plan["begin"] = first.isoformat(timespec="milliseconds")
        if first - source.begin > timedelta(seconds=1.0):
            session.out.say(f"  joins it at {first:%H:%M:%S} UTC, for {trajectory.duration_s:.0f} s: the axes are ready then")
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
