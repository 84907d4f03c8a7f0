# SPDX-License-Identifier: Apache-2.0
"""One servo as an object for scripts and notebooks: `connect` opens it, its axes read, set, move, measure and tune.

    with connect("slcan-tcp:127.0.0.1:29536") as servo:
        servo.azimuth.move(by_rad=0.1)
        frame = servo.record(seconds=2.0)

Each method calls what the command of its name calls, with the same checks against the limits of the node, the same monitoring
and the same journal. None asks for a confirmation: whoever calls one that moves has made sure that the travel is clear. What
cannot be done is a ServoctlError of one sentence, and nothing of it is in force. Angles are in rad, rates in rad/s, times in s of
the node.

A `Servo` is the node, its `Axis` what turns. `Drive`, which an axis has, are the objects of CiA 402 alone: it checks nothing.
"""

from __future__ import annotations

import os
import tempfile
import warnings
from collections.abc import Sequence
from pathlib import Path
from types import TracebackType
from typing import TYPE_CHECKING

from .axis import Axis, File
from .errors import InputError
from .gains import gain_set
from .gains.gain_check import check_gains
from .gains.gains_file import read_gains, write_gains
from .gains.tuning import Change, Tuning, undo_last
from .link.bus import ENVIRONMENT, FORMS, parse_bus
from .link.device import Device
from .motion import moves, track_run, tracking
from .motion.live_recording import LiveRecording
from .objects.access_lock import bytes_of
from .objects.named_parameters import NamedParameters
from .objects.parameter import AXES
from .show.frames import check_frame, need_pandas, tracking_frame
from .show.output_files import check_new
from .units import radians
from .wording import in_python

if TYPE_CHECKING:
    from pandas import DataFrame

MOST_RECORDED_S = 3600.0
"""In memory; `Recorder` writes longer ones to files."""


def _path(file: File | None) -> Path | None:
    return None if file is None else Path(file)


def _number(axis: str) -> int:
    if axis not in AXES:
        raise InputError(f"there is no axis '{axis}': expected {' or '.join(AXES)}.")
    return AXES.index(axis)


@in_python
def connect(
    bus: str | None = None, node_id: int = 1, *, bit_rate: int = 1_000_000, parameters: File | None = None, word: str | None = None
) -> Servo:
    """Opens the servo with this node id (1 to 127). `bus`: slcan-tcp:HOST:PORT, slcan:/dev/ttyACM0 or socketcan:can0; without it
    the environment names it (SERVOCTL_BUS).

    `bit_rate` in bit/s, for SLCAN adapters; `parameters`: the parameters.json of firmware that servoctl does not know; `word`:
    that of the access lock, if the owner has set one. Close the servo, or use it in a `with` block. Raises InputError, or
    ConnectionFailed when the node does not answer.
    """
    place = bus or os.environ.get(ENVIRONMENT)
    if not place:
        raise InputError(f"no bus given: name it in connect or in {ENVIRONMENT}; expected {FORMS}.")
    if not 1 <= node_id <= 127:
        raise InputError(f"there is no node id {node_id}: expected 1 to 127.")
    if word is not None:
        bytes_of(word)
    device = Device(parse_bus(place), node_id, Path(parameters) if parameters else None, bit_rate)
    try:
        device.access_word = word
        device.read_int(0x1000)
    except BaseException:
        device.close()
        raise
    return Servo(device)


class Servo(NamedParameters):
    """A node with its two axes. `device` is for the functions below this object."""

    def __init__(self, device: Device) -> None:
        super().__init__(device, None)
        self.azimuth = Axis(device, 0)
        self.pitch = Axis(device, 1)

    def __enter__(self) -> Servo:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def close(self) -> None:
        """Leaves the bus."""
        self.device.close()

    # --- parameters -------------------------------------------------------------------------------------------------

    @in_python
    def undo(self, *, unlock: bool = False) -> list[Change]:
        """Takes back the last change in the journal, as `servoctl undo`; raises Refused when another client has changed a value
        since."""
        return undo_last(Tuning(self.device, "undo"), unlock)

    @in_python
    def save(self, file: File, *, overwrite: bool = False) -> int:
        """Writes a gains file, for `restore`, `servoctl diff` and `sim_host check`; the number of gains."""
        path = Path(file)
        check_new([path], overwrite, "save")
        values = gain_set.read_to_save(self.device)
        write_gains(path, values, gain_set.about(self.device))
        return len(values)

    @in_python
    def restore(self, file: File, *, unlock: bool = False, override: bool = False) -> list[Change]:
        """Writes a gains file to the device, all or none, and reads it back; `unlock` and `override` as for `set`."""
        compared = gain_set.compare(self.device, read_gains(Path(file), self.device.schema).values)
        return gain_set.restore(self.device, compared, unlock=unlock, override=override)

    @in_python
    def store(self) -> Path:
        """Stores the active values in the flash, after a backup file, whose path it returns. Both axes must be off."""
        return gain_set.store_with_backup(self.device)

    # --- signals ----------------------------------------------------------------------------------------------------

    @in_python
    def recording(self, signals: str = "both") -> LiveRecording:
        """Records signals in every tick (1 kHz on a bus of 1 Mbit/s) in a `with` block, also while an axis moves by `move` or
        `run`. Afterwards `recording.frame()` is its frame. `signals`: both, azimuth, pitch or tracking."""
        return LiveRecording(self.device, signals)

    @in_python
    def record(self, seconds: float, signals: str = "both") -> DataFrame:
        """Records for a time of the node; indexed by time in s, with columns such as azimuth_rate_deg_s. Nothing moves."""
        need_pandas()
        if not 0.0 < seconds <= MOST_RECORDED_S:
            raise InputError(f"cannot record for {seconds:g} s: expected more than 0 and at most {MOST_RECORDED_S:g} s.")
        with self.recording(signals) as live:
            self.device.clock.sleep(seconds)
        return live.recording.frame()

    @in_python
    def track(
        self, seconds: float, *, camera_id: int | None = None, cue_rad: tuple[float, float] | None = None,
        slew_rate_rad_s: float = radians(moves.SLEW_RATE_DEG_S), axes: Sequence[str] = AXES,
    ) -> DataFrame:  # fmt: skip
        """Follows the target of a camera for a time of the node, or until Ctrl-C, as `servoctl track`; then the axes stop on their
        ramps and are disabled, if they were before.

        `camera_id`: identifier of the camera's frames, 0x181 to 0x57F; None: as the node has mapped them. `cue_rad`: azimuth and
        pitch to which the axes slew first, at `slew_rate_rad_s`. A row per 10 ms: the error of each axis in rad (target minus
        line of sight), NaN while it did not follow, and its state. Raises InputError or MotionError.
        """
        need_pandas()
        if not seconds > 0.0:
            raise InputError(f"cannot track for {seconds:g} s: expected more than 0.")
        if not slew_rate_rad_s > 0.0:
            raise InputError(f"slew_rate_rad_s is {slew_rate_rad_s:g}: a slew needs a rate above 0.")
        if cue_rad is not None and len(cue_rad) != len(AXES):
            raise InputError(f"cue_rad has {len(cue_rad)} angles: expected those of azimuth and pitch.")
        chosen = [_number(name) for name in axes]
        if not chosen or len(set(chosen)) < len(chosen):
            raise InputError("axes must name one axis or two different ones.")
        identifier = None if camera_id is None else tracking.parse_identifier(f"{camera_id:x}")
        for axis in chosen:
            tracking.check_supported(self.device, axis)
        cue = track_run.check_cue(self.device, chosen, cue_rad, None, slew_rate_rad_s)[0] if cue_rad is not None else None
        return tracking_frame(track_run.follow_target(self.device, chosen, identifier, cue, slew_rate_rad_s, seconds))

    # --- judgement --------------------------------------------------------------------------------------------------

    @in_python
    def check(
        self, limits: File | None = None, *, plant: File | None = None, scenarios: Sequence[File] = (), seeds: Sequence[int] = (),
        out: File | None = None,
    ) -> DataFrame:  # fmt: skip
        """Judges the gains of this device with `sim_host check` (docs/ci.md): the firmware of the simulator's build with these
        gains on a simulated machine, the figures against the limits of a file. Nothing moves here.

        Without files: the shipped tracker, its limits and scenarios; without `seeds`: 1 to 20, which take some 15 s of processor
        time. A row per figure, with its value, limits, and whether they are `kept`. `out`: a new folder for results.json and
        report.html. What the program warns of is a Python warning. Raises InputError.
        """
        need_pandas()
        with tempfile.TemporaryDirectory() as folder:
            gains = Path(folder) / "gains.toml"
            self.save(gains)
            found = check_gains(gains, _path(limits), _path(plant), [Path(each) for each in scenarios], seeds, _path(out))
        for warning in found.warnings:
            warnings.warn(warning, stacklevel=3)
        return check_frame(found.figures)
