# SPDX-License-Identifier: Apache-2.0
"""Following the target of a camera with the live axes (mode -1): for `track` and scripts. States and errors are recorded."""

from __future__ import annotations

import contextlib
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from ..drive import power
from ..drive.drive import Drive
from ..link.device import Device
from ..link.pair_stream import ERROR_TICKS, ErrorStream
from ..objects.parameter import AXES
from ..units import TICK_S
from . import tracking
from .cable_wrap import AZIMUTH, lasting_cue
from .live import LiveAxis
from .moves import check_slew, slew
from .tracking import COASTING, ON_TARGET, CameraMapping, FrameCounts

Real = NDArray[np.float64]

_POLL_S = 0.05
_ERROR_S = ERROR_TICKS * TICK_S


@dataclass
class Record:
    """States by time (s, one for each axis), and errors in rad at 100 Hz, a column for each axis of the node."""

    axes: list[int]
    states: list[tuple[float, list[int]]] = field(default_factory=list)
    errors: Real = field(default_factory=lambda: np.zeros((0, len(AXES))))
    frames: FrameCounts | None = None

    def time_s(self) -> Real:
        """Of the errors."""
        return _ERROR_S * np.arange(len(self.errors), dtype=np.float64)

    def states_of(self, axis: int) -> NDArray[np.int64]:
        """The state of an axis at the time of each error."""
        if not self.states:
            return np.full(len(self.errors), tracking.NOT_TRACKING)
        place = self.axes.index(axis)
        times = np.array([at for at, _ in self.states])
        row = np.searchsorted(times, self.time_s(), side="right") - 1
        return np.where(row < 0, tracking.NOT_TRACKING, np.array([states[place] for _, states in self.states])[np.maximum(row, 0)])

    def followed(self, axis: int) -> NDArray[np.bool_]:
        """The errors of an axis that count: while it was on target or coasting."""
        return np.isin(self.states_of(axis), (ON_TARGET, COASTING))


Look = Callable[[Record, ErrorStream, Sequence[LiveAxis]], object]
"""Called at each look at the axes, when their states are in the record; what it raises ends the motion."""


def unseen(_record: Record, _stream: ErrorStream, _lives: Sequence[LiveAxis]) -> None:
    """Nobody looks."""


def check_cue(device: Device, axes: Sequence[int], cue_rad: Sequence[float], rate_rad_s: float | None, slew_rate_rad_s: float) -> tuple[list[float], str]:
    """The first angles of all axes of the node: of azimuths a revolution apart the one that lasts longest at this rate of the
    target (None: unknown), and how it came about ("": as given). Raises InputError when an axis may not slew there."""
    angles, why = list(cue_rad), ""
    if AZIMUTH in axes:
        angles[AZIMUTH], why = lasting_cue(Drive(device, AZIMUTH), angles[AZIMUTH], rate_rad_s)
    for axis in axes:
        check_slew(Drive(device, axis), angles[axis], slew_rate_rad_s)
    return angles, why


def follow_target(
    device: Device, axes: Sequence[int], identifier: int | None, cue_rad: Sequence[float] | None, slew_rate_rad_s: float,
    seconds: float | None, look: Look = unseen,
) -> Record:  # fmt: skip
    """Slews to the cue, if there is one (an angle for each axis of the node), and follows until `seconds` have passed by the
    node's clock or Ctrl-C. RPDO4 takes the camera's frames with this identifier meanwhile; None: as it is mapped.

    Raises MotionError, and the axes are at rest.
    """
    record = Record(list(axes))
    with CameraMapping(device, identifier), ErrorStream(device) as stream, contextlib.ExitStack() as motion:
        lives = [motion.enter_context(LiveAxis(device, axis, power.PROFILE_POSITION)) for axis in axes]
        tracking.check_frames(device, identifier, tracking.FIRST_FRAME_S)
        if cue_rad is not None:
            slew(lives, [cue_rad[axis] for axis in axes], slew_rate_rad_s)
        before = tracking.frame_counts(device)
        tracking.begin_following(lives)
        stream.start()
        with contextlib.suppress(KeyboardInterrupt):  # the usual end
            _record(record, stream, lives, seconds, look)
        record.errors = stream.errors()
        record.frames = tracking.frame_counts(device).since(before)
        tracking.end_following(lives)
    return record


def _record(record: Record, stream: ErrorStream, lives: Sequence[LiveAxis], seconds: float | None, look: Look) -> None:
    while True:
        for live in lives:
            live.check_enabled()
        stream.check_alive()
        now_s = stream.count() * _ERROR_S
        record.states.append((now_s, [tracking.state_of(live.drive) for live in lives]))
        look(record, stream, lives)
        if seconds is not None and now_s >= seconds:
            return
        time.sleep(_POLL_S)
