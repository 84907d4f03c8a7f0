# SPDX-License-Identifier: Apache-2.0
"""track: follow the target that a camera on the bus sees, with the error live."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import groupby
from pathlib import Path
from typing import Any

import click
import numpy as np
from numpy.typing import NDArray

from ..errors import InputError
from ..link.device import Device
from ..link.pair_stream import ErrorStream
from ..motion import tracking
from ..motion.cable_wrap import AZIMUTH
from ..motion.live import LiveAxis
from ..motion.track_run import Record, check_cue, follow_target
from ..motion.tracking import NOT_TRACKING, ON_TARGET, PICTURE_WRONG, SEARCHING, STATES
from ..objects.parameter import AXES
from ..session import Session, common
from ..units import degrees
from .following import check_plot, following_options, save_errors
from .motion import confirm
from .quantity import ANGLE, DURATION

Real = NDArray[np.float64]

SEARCHED_S = 3.0
"""Searching for so long after the start, the axes look where the target is not."""


@click.command(short_help="Follow the target of a camera.")
@click.option(
    "--axis", "which", type=click.Choice([*AXES, "both"]), default="both", show_default=True, help="Axes that follow."
)
@click.option(
    "--camera-id", metavar="ID",
    help="Identifier of the camera's frames (hexadecimal): RPDO4 takes them for the time of the command. Default: the"
    " node's own mapping.",
)
@click.option(
    "--cue", type=(ANGLE, ANGLE), metavar="AZIMUTH PITCH", default=None,
    help="First slew to these joint angles (°), then hand over to the camera. Of azimuths a revolution apart within the"
    " travel, the one that lasts longest is taken.",
)
@click.option(
    "--cue-rate", type=ANGLE, default=None, metavar="RATE",
    help="Rate of the target's azimuth (°/s), for that choice; default: unknown.",
)
@click.option("--seconds", type=DURATION, help="Stop after this time; default: until Ctrl-C.")
@following_options("cue")
@common
def track(
    session: Session, which: str, camera_id: str | None, cue: tuple[float, float] | None, cue_rate: float | None,
    slew_rate: float, seconds: float | None, interval: float, plot: Path | None, overwrite: bool, dry_run: bool, yes: bool,
) -> None:  # fmt: skip
    """Follow the target that a camera on the bus sees (mode -1), and show the error live.

    Prints the state (searching, acquiring, tracking, coasting, lost) and the error of each axis in µrad, and when the
    axes will be back on a target that is too fast for them. Ctrl-C or the end of --seconds stops the axes on their
    ramps. The node's limits hold as in every mode.
    """
    check_plot(session, plot, overwrite)
    identifier = tracking.parse_identifier(camera_id) if camera_id else None
    if cue is None and cue_rate is not None:
        raise InputError("--cue-rate chooses the azimuth of a cue: give --cue, too.")
    axes = list(range(len(AXES))) if which == "both" else [AXES.index(which)]
    with session.connect() as device:
        for axis in axes:
            tracking.check_supported(device, axis)
        angles, why = check_cue(device, axes, cue, cue_rate, slew_rate) if cue is not None else (None, "")
        if not confirm(session, _announce(session, axes, angles, why, seconds), dry_run, yes):
            return
        record = follow_target(device, axes, identifier, angles, slew_rate, seconds, _Watch(session, interval).look)
    _show(session, record, plot, overwrite)


def _announce(
    session: Session, axes: list[int], cue: Sequence[float] | None, why: str, seconds: float | None
) -> dict[str, Any]:
    names = " and ".join(AXES[axis] for axis in axes)
    session.out.say(
        f"{names} will follow the target within the limits of the node, {f'for {seconds:g} s' if seconds else 'until Ctrl-C'}"
    )
    if cue is not None:
        session.out.say(
            "  first to "
            + ", ".join(f"{AXES[axis]} {degrees(cue[axis]):.3f}°{why if axis == AZIMUTH else ''}" for axis in axes)
        )
    return {
        "axes": [AXES[axis] for axis in axes], "seconds": seconds,
        "cue_deg": None if cue is None else {AXES[axis]: degrees(cue[axis]) for axis in axes},
    }  # fmt: skip


class _Watch:
    """What a person sees of the motion: a line at each interval, and remarks."""

    def __init__(self, session: Session, interval: float) -> None:
        self._session = session
        self._interval = interval
        self._shown_s, self._shown, self._searched, self._told = 0.0, 0, False, ""

    def look(self, record: Record, stream: ErrorStream, lives: Sequence[LiveAxis]) -> None:
        """Prints what is new."""
        now_s, states = record.states[-1]
        device = lives[0].drive.device
        if not self._searched and now_s >= SEARCHED_S:
            self._searched = True
            _note_search(self._session, record)
        due = now_s >= self._shown_s + self._interval
        if due or PICTURE_WRONG in states:
            self._told = _note_picture(self._session, device, self._told)
        if due:
            _show_line(self._session, now_s, record.axes, states, stream.errors(self._shown), tracking.return_text(device))
            self._shown_s, self._shown = self._shown_s + self._interval, stream.count()


def _note_search(session: Session, record: Record) -> None:
    searching = all(state == SEARCHING for state in record.states[-1][1])
    if searching and all(state <= SEARCHING for _, states in record.states for state in states):
        session.out.note(
            f"the camera has not seen the target for {SEARCHED_S:g} s: it is outside the picture, or does not stand out in"
            " it. Stop, and give a --cue that is nearer to the target than half the picture."
        )


def _note_picture(session: Session, device: Device, told: str) -> str:
    text = tracking.picture_text(device)
    if text and text != told:
        session.out.note(text)
    return text


def _show_line(
    session: Session, now_s: float, axes: list[int], states: list[int], errors: Real, back: tuple[float | None, str]
) -> None:
    values, texts = [], []
    for axis, state in zip(axes, states, strict=True):
        known = state > NOT_TRACKING and len(errors) > 0
        now, rms = (1e6 * errors[-1, axis], 1e6 * np.sqrt(np.mean(errors[:, axis] ** 2))) if known else (0.0, 0.0)
        values.append({"axis": AXES[axis], "state": STATES[state], "error_urad": round(float(now), 2), "rms_urad": round(float(rms), 2)})
        texts.append(f"{AXES[axis]} {STATES[state]:<12} {now:+8.1f} µrad (rms {rms:.1f})")
    session.out.json({"time_s": round(now_s, 3), "axes": values, "back_in_s": back[0]})
    session.out.say(f"{now_s:8.1f} s  " + "  ".join([*texts, back[1]]).rstrip())


def _spans(record: Record) -> dict[str, list[tuple[float, float]]]:
    """Times in each state but tracking, of the axis that is furthest from it."""
    found: dict[str, list[tuple[float, float]]] = {}
    worst = [(at, max(states, key=lambda s: (s != ON_TARGET, s))) for at, states in record.states]
    ends = [at for at, _ in worst[1:]] + [worst[-1][0]] if worst else []
    for state, run in groupby(zip(worst, ends, strict=True), key=lambda item: item[0][1]):
        items = list(run)
        if state != ON_TARGET:
            found.setdefault(STATES[state], []).append((items[0][0][0], items[-1][1]))
    return found


def _show(session: Session, record: Record, plot: Path | None, overwrite: bool) -> None:
    results, rows = [], []
    for place, axis in enumerate(record.axes):
        errors = 1e6 * record.errors[record.followed(axis), axis]
        share = np.mean([states[place] == ON_TARGET for _, states in record.states]) if record.states else 0.0
        rms = float(np.sqrt(np.mean(errors**2))) if len(errors) else None
        largest = float(np.max(np.abs(errors))) if len(errors) else None
        final = STATES[record.states[-1][1][place]] if record.states else STATES[0]
        results.append({
            "axis": AXES[axis], "tracking_share": float(share), "rms_urad": rms, "max_urad": largest, "last_state": final
        })  # fmt: skip
        rows.append((
            AXES[axis], f"{100 * share:.1f}", "–" if rms is None else f"{rms:.1f}", "–" if largest is None else f"{largest:.1f}", final
        ))  # fmt: skip
    files = _save(record, plot, overwrite) if plot else []
    frames = record.frames
    counts = {} if frames is None else {"taken": frames.taken, "missed": frames.missed, "dropped": frames.dropped}
    session.out.json({"axes": results, "frames": counts, "files": files})
    session.out.table(
        ["axis", ("tracking %", "right"), ("error rms µrad", "right"), ("largest µrad", "right"), "last state"], rows
    )
    session.out.say("error: as measured by the camera (60F4), while the axis was tracking or coasting.")
    if frames is not None:
        session.out.say(f"frames: {frames.taken} counted, {frames.missed} missed, {frames.dropped} dropped.")
    if files:
        session.out.say("saved: " + ", ".join(files))


def _save(record: Record, plot: Path, overwrite: bool) -> list[str]:
    time_s = record.time_s()
    if not len(time_s):
        raise InputError("there is nothing to plot: the axes followed for less than 10 ms.")
    errors = {AXES[axis]: 1e6 * record.errors[:, axis] for axis in record.axes}
    return save_errors(plot, overwrite, "Target minus line of sight", time_s, errors, _spans(record))
