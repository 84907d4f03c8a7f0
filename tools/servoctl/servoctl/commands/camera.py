# SPDX-License-Identifier: Apache-2.0
"""camera: how the camera sits on the line of sight, and how old its frames are."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, NamedTuple

import click
import numpy as np

from ..drive import power
from ..drive.drive import Drive
from ..errors import InputError, MotionError, Refused
from ..gains.tuning import Change, Tuning
from ..link.device import Device
from ..motion import tracking
from ..motion.camera_fit import CameraFit, Pose, fit_camera
from ..motion.live import LiveAxis
from ..motion.moves import check_slew, slew
from ..motion.tracking import CameraMapping
from ..objects.parameter import AXES, Parameter, Value
from ..session import Session, common
from ..units import degrees
from .motion import confirm, yes_options
from .quantity import LONGEST_TRAVEL, Quantity

FRAME, CAMERA, DELAY = 0x3070, 0x3071, 0x3073
SCALE, ROLL, BORESIGHT_X, BORESIGHT_Y, TIME, MIRRORED, STATED_DELAY = 1, 2, 3, 4, 5, 7, 8
STROBE_FIRST = 2
CLIPPED = 32767

STEPS = (0, 0), (1, 0), (-1, 0), (0, 1), (0, -1), (0, 0)
"""In steps along azimuth and pitch, run through ROUNDS times; the first and last one show whether the target stands."""
ROUNDS = 2
RATE_DEG_S = 1.0
SETTLE_S = 0.4
FRAMES = 10
"""For the mean at each place."""
FRAMES_S = 3.0
STANDS = 0.05
"""A target that moves by more than this share of a step does not stand."""
SQUARE = 0.03
"""Rows and columns may differ by this share; more is told."""
LOWEST_COSINE = 0.2
DITHER_RAD = 1e-4
TRACKED_S = 1.0
GOOD_S = 1e-3
"""Half the interval of the delay that is good enough to end."""


class Seen(NamedTuple):
    """Counts of a frame, and its counter."""

    x: int
    y: int
    counter: int


@click.group(short_help="How the camera sits on the axes.")
def camera() -> None:
    """How the camera sits on the line of sight, and how old its frames are."""


@camera.command(short_help="Measure scale, roll, mirror and delay on a still target.")
@click.option(
    "--camera-id", metavar="ID",
    help="Identifier of the camera's frames (hexadecimal): RPDO4 takes them for the time of the command. Default: the"
    " node's own mapping.",
)
@click.option(
    "--step", type=LONGEST_TRAVEL, default="0.2", show_default=True,
    help="How far the axes move from here in each direction (°); the target must stay in the picture.",
)
@click.option(
    "--boresight", is_flag=True,
    help="Also hold targets from now on where this one is in the picture (3071:3, :4): the laser has been pointed at it.",
)
@click.option(
    "--delay", "delay_s", type=Quantity("s", low=0.0, high=60.0), default="20", show_default=True,
    help="Then track the target for at most so long, with a dither of 0.1 mrad, to measure how old the frames are; 0: not.",
)
@click.option("--no-write", is_flag=True, help="Show what is found; write nothing, and do not track.")
@yes_options
@common
def calibrate(
    session: Session, camera_id: str | None, step: float, boresight: bool, delay_s: float, no_write: bool, dry_run: bool,
    yes: bool,
) -> None:  # fmt: skip
    """Measure the camera's image scale, roll and mirror, and the delay of its frames, on a target that stands still.

    Point the axes at a target that stands, so that the camera sees it. Both axes move by small slow steps about where
    they are; what the target then does in the picture tells scale (3071:1), roll (3071:2) and whether the picture is
    mirrored (3071:7). These are written. Then both axes track the target, and the delay found is added to what the frames
    state (3071:8). 'servoctl undo' restores what was before; 'servoctl store' keeps it.
    """
    identifier = tracking.parse_identifier(camera_id) if camera_id else None
    with session.connect() as device:
        for axis in range(len(AXES)):
            tracking.check_supported(device, axis)
        start, steps = _places(device, step)
        delay_s = 0.0 if no_write else _delay_time(session, device, delay_s)
        if not confirm(session, _announce(session, step, delay_s), dry_run, yes):
            return
        tuning = Tuning(device, "camera calibrate")
        with CameraMapping(device, identifier):
            fit = _measure(session, device, identifier, start, steps, step)
            values = _mounting(device, fit, boresight)
            before = {parameter: device.read(parameter) for parameter in values}
            changes = [] if no_write else tuning.write(values)
            delay = _find_delay(session, device, delay_s) if delay_s > 0.0 else None
            if delay is not None and delay.known:
                changes += tuning.write(_stated(device, delay.delay_ms))
    _show(session, fit, before, changes, delay, no_write)


def _object(device: Device, sub: int) -> Parameter:
    found = device.schema.by_index(CAMERA, sub)
    if found is None:
        raise InputError(f"node {device.node_id} has no 3071:{sub}: update its firmware.")
    return found


def _places(device: Device, step: float) -> tuple[list[float], list[list[float]]]:
    """Joint angles now and of all steps; raises InputError when one is beyond a limit."""
    drives = [Drive(device, axis) for axis in range(len(AXES))]
    start = [drive.position() for drive in drives]
    cosine = abs(math.cos(start[1]))
    if cosine < LOWEST_COSINE:
        raise InputError(
            f"the pitch is at {degrees(start[1]):.1f}°: so near to the zenith the azimuth hardly moves the picture. Choose a"
            f" target below {degrees(math.acos(LOWEST_COSINE)):.0f}°."
        )
    moves = [(step / cosine, step)[axis] for axis in range(len(AXES))]
    for drive, here, move in zip(drives, start, moves, strict=True):
        check_slew(drive, here + move, math.radians(RATE_DEG_S))
        check_slew(drive, here - move, math.radians(RATE_DEG_S))
    return start, [[here + move * by for here, move, by in zip(start, moves, place, strict=True)] for place in STEPS]


def _delay_time(session: Session, device: Device, delay_s: float) -> float:
    if delay_s > 0.0 and device.read_int(CAMERA, TIME) >= STROBE_FIRST:
        session.out.note("the delay is not measured: the strobe gives the age of the frames (3071:5).")
        return 0.0
    if delay_s > 0.0 and device.read_int(DELAY, 1) == 0:
        session.out.note("the delay is not measured: 3073:1 is 0.")
        return 0.0
    return delay_s


def _announce(session: Session, step: float, delay_s: float) -> dict[str, Any]:
    tracked = f", then they track the target for at most {delay_s:g} s" if delay_s > 0.0 else ""
    session.out.say(
        f"azimuth and pitch will move by {degrees(step):.3g}° in each direction from here, in the picture, at"
        f" {RATE_DEG_S:g} °/s, {ROUNDS} times{tracked}"
    )
    return {"step_deg": degrees(step), "rate_deg_s": RATE_DEG_S, "rounds": ROUNDS, "delay_s": delay_s}


def _frame(device: Device) -> Seen | None:
    """The newest frame; None when the target is not in it, or when another frame has come meanwhile."""
    before = device.read_int(FRAME, 5)
    x, y = (device.read_int(FRAME, sub, signed=True) for sub in (1, 2))
    quality = device.read_int(FRAME, 4)
    good = device.read_int(FRAME, 5) == before and max(1, device.read_int(CAMERA, 6)) <= quality <= 100
    return Seen(x, y, before) if good and max(abs(x), abs(y)) < CLIPPED else None


def _look(device: Device, angles: Callable[[], list[float]]) -> Pose:
    """Mean of FRAMES frames and of the joint angles meanwhile."""
    seen: dict[int, Seen] = {}
    joints: list[list[float]] = []
    end = device.clock.now() + FRAMES_S
    while len(seen) < FRAMES:
        if device.clock.now() > end:
            raise MotionError(
                "the camera does not see the target, or its frames do not come at 10 Hz at least: the target must stay in the"
                " picture during the steps; try a smaller --step."
            )
        frame = _frame(device)
        joints.append(angles())
        if frame is not None:
            seen[frame.counter] = frame
    azimuth, pitch = np.mean(joints, axis=0)
    x, y = np.mean([(f.x, f.y) for f in seen.values()], axis=0)
    return Pose(float(azimuth), float(pitch), float(x), float(y))


def _measure(
    session: Session, device: Device, identifier: int | None, start: list[float], steps: list[list[float]], step: float
) -> CameraFit:
    poses: list[Pose] = []
    with LiveAxis(device, 0, power.PROFILE_POSITION) as azimuth, LiveAxis(device, 1, power.PROFILE_POSITION) as pitch:
        lives = [azimuth, pitch]
        tracking.check_frames(device, identifier, tracking.FIRST_FRAME_S)
        with session.out.progress() as bar:
            task = bar.add_task("places", total=ROUNDS * len(steps))
            for place in steps * ROUNDS:
                slew(lives, place, math.radians(RATE_DEG_S))
                device.clock.sleep(SETTLE_S)
                poses.append(_look(device, lambda: [live.drive.position() for live in lives]))
                bar.advance(task)
        slew(lives, start, math.radians(RATE_DEG_S))
    fit = fit_camera(poses)
    moved = fit.scale_rad * max(math.hypot(p.x - poses[0].x, p.y - poses[0].y) for p, at in zip(poses, STEPS * ROUNDS, strict=True) if at == (0, 0))
    if moved > STANDS * step:
        raise MotionError(
            f"the target moved by {1e3 * moved:.2f} mrad during the steps: calibrate on a target that stands still. Nothing"
            " was written."
        )
    return fit


def _mounting(device: Device, fit: CameraFit, boresight: bool) -> dict[Parameter, Value]:
    values: dict[Parameter, Value] = {
        _object(device, SCALE): float(np.float32(fit.scale_rad)),
        _object(device, ROLL): float(np.float32(fit.roll_rad)),
        _object(device, MIRRORED): int(fit.mirrored),
    }
    if boresight:
        for sub, place in zip((BORESIGHT_X, BORESIGHT_Y), fit.at_first, strict=True):
            values[_object(device, sub)] = float(np.float32(place))
    return {parameter: parameter.check(value) for parameter, value in values.items()}


def _stated(device: Device, delay_ms: float) -> dict[Parameter, Value]:
    stated = _object(device, STATED_DELAY)
    counts = round(100.0 * delay_ms) + int(device.read(stated))
    if counts < 0:
        raise Refused(
            f"the frames are {-delay_ms:.1f} ms younger than they state, which 3071:8 cannot hold: correct the time that the"
            " image processor states. Scale, roll and mirror are written."
        )
    return {stated: stated.check(counts)}


def _find_delay(session: Session, device: Device, longest_s: float) -> tracking.DelayEstimate | None:
    """Both axes track with a dither; returns the estimate, with an interval that is good enough if there is time."""
    estimate = None
    with LiveAxis(device, 0, power.PROFILE_POSITION) as azimuth, LiveAxis(device, 1, power.PROFILE_POSITION) as pitch:
        lives = [azimuth, pitch]
        before = device.upload(DELAY, 2)
        device.download(DELAY, 2, np.float32(DITHER_RAD).tobytes())
        try:
            tracking.begin_following(lives)
            device.clock.sleep(TRACKED_S)
            device.write_int(DELAY, 4, min(60, math.ceil(longest_s)), 1)
            with session.out.progress() as bar:
                task = bar.add_task("delay", total=longest_s)
                for passed in device.clock.every(0.5, longest_s):
                    for live in lives:
                        live.check_enabled()
                    _check_followed(lives)
                    estimate = tracking.delay_estimate(device)
                    bar.update(task, completed=passed)
                    if estimate is not None and estimate.known and estimate.half_interval_ms <= 1e3 * GOOD_S:
                        break
            device.write_int(DELAY, 4, 0, 1)
            tracking.end_following(lives)
        finally:
            device.download(DELAY, 2, before)
    return estimate


def _check_followed(lives: list[LiveAxis]) -> None:
    for live in lives:
        state = tracking.state_of(live.drive)
        if state >= tracking.LOST:
            raise MotionError(
                f"{live.drive.name} does not follow the target ({tracking.STATES[state]}): the delay is not known. Scale, roll"
                " and mirror are written; 'servoctl undo' restores what was before."
            )


def _show(
    session: Session, fit: CameraFit, before: dict[Parameter, Value], changes: list[Change],
    delay: tracking.DelayEstimate | None, no_write: bool,
) -> None:  # fmt: skip
    session.out.json({
        "scale_rad": fit.scale_rad, "scale_half_interval_rad": fit.scale_half, "roll_deg": degrees(fit.roll_rad),
        "roll_half_interval_deg": degrees(fit.roll_half), "mirrored": fit.mirrored, "anisotropy": fit.anisotropy,
        "rms_urad": 1e6 * fit.rms_rad, "target_urad": [1e6 * at for at in fit.at_first],
        "target_half_interval_urad": [1e6 * half for half in fit.at_first_half],
        "delay_ms": delay.delay_ms if delay is not None and delay.known else None,
        "delay_half_interval_ms": delay.half_interval_ms if delay is not None and delay.known else None,
        "written": not no_write,
        "changes": [{"name": c.parameter.name, "index": c.parameter.where, "old": c.old, "new": c.new} for c in changes],
    })  # fmt: skip
    scale, roll, mirrored, *boresight = (float(value) for value in before.values())
    rows = [
        ("image scale (3071:1)", f"{1e6 * fit.scale_rad:.4f} ± {1e6 * fit.scale_half:.4f} µrad", f"{1e6 * scale:.4f} µrad"),
        ("roll (3071:2)", f"{degrees(fit.roll_rad):.2f} ± {degrees(fit.roll_half):.2f}°", f"{degrees(roll):.2f}°"),
        ("mirrored (3071:7)", "yes" if fit.mirrored else "no", "yes" if mirrored else "no"),
    ]
    places = zip(("x (3071:3)", "y (3071:4)"), fit.at_first, fit.at_first_half, boresight, strict=False)  # none without --boresight
    rows += [(f"boresight {name}", f"{1e6 * at:.1f} ± {1e6 * half:.1f} µrad", f"{1e6 * old:.1f} µrad") for name, at, half, old in places]
    session.out.table(["", ("found (95 %)", "right"), ("before", "right")], rows)
    if delay is not None:
        _show_delay(session, delay, changes)
    if fit.anisotropy > SQUARE:
        session.out.note(
            f"rows and columns differ in scale by {100 * fit.anisotropy:.0f} %, and the node has one scale for both: make the"
            " image processor send angles, or square pixels."
        )
    session.out.say("nothing was written." if no_write else "written; 'servoctl undo' restores what was before, 'servoctl store' keeps it.")


def _show_delay(session: Session, delay: tracking.DelayEstimate, changes: list[Change]) -> None:
    if not delay.known:
        session.out.note("the delay was not found in this time: track for longer (--delay), or see 3073:5 and :6 later.")
        return
    stated = changes[-1]
    session.out.say(
        f"frames are {delay.delay_ms:.2f} ± {delay.half_interval_ms:.2f} ms older than they state: stated delay (3071:8)"
        f" {0.01 * int(stated.new):.2f} ms, before {0.01 * int(stated.old or 0):.2f} ms."
    )
