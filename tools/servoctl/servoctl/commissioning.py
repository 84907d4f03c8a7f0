"""Carries a programme out on the live axis: goes from place to place, runs the experiments of 0x2100, records each tick.

It decides nothing: what is done where was planned by `identify plan`. Whatever goes wrong, the experiment is aborted
and the axis ends at rest (live.py); the objects of the set-up, mode, limits and PDO mappings are as before.
"""

from __future__ import annotations

import struct
import time
from collections.abc import Callable
from dataclasses import dataclass

from . import power
from .device import DEVICE_STATE, Device
from .drive import POLL_S, Drive
from .errors import MotionError, Refused
from .live import LiveAxis
from .parameter import AXES, AXIS_SHIFT
from .programme import FIELDS, LIMIT_FIELDS, Envelope, Experiment, Place, Programme
from .recorder import BREAK_AWAY, Recording, TickRecorder
from .units import POSITION_COUNTS_PER_RAD, degrees

OBJECT = 0x2100
COMMAND, STATE, PROGRESS, KIND, COUNT, BREAK_AWAYS = 1, 2, 3, 4, 5, 19
START, ABORT = 1, 2
RUNS, DONE = 1, 2
ENDS = {
    0: "it did not start", 3: "it was aborted", 4: "the axis left the travel limit of the experiment (2100:14)",
    5: "the axis was faster than the limit of the experiment (2100:15)", 6: "it took longer than its limit (2100:17)",
    7: "the drive stopped the axis",
}  # fmt: skip
"""2100:2 other than runs and done."""
START_TIMEOUT_S = 5.0
SETTLE_S = 0.3
NEAR_RAD = 1e-3
"""A place that is so near needs no move."""
MOST_MISSING = 1e-3
"""Share of a run's ticks; more is told."""

Report = Callable[[str, float], None]
"""Called with what is being done, and how much of the programme's time is over, s."""


@dataclass(frozen=True)
class BreakAway:
    """What the device told after break-away runs of one direction: their number, mean and standard deviation, N m."""

    angle_rad: float
    direction: str
    count: int
    mean_nm: float
    deviation_nm: float


@dataclass(frozen=True)
class Outcome:
    """All that was recorded, and what was lost."""

    recording: Recording
    break_aways: list[BreakAway]
    other_held: bool

    def incomplete_runs(self) -> list[tuple[int, float]]:
        """(run, share missing) of those that miss more than a permille."""
        shares = [(run, self.recording.missing_share(run)) for run in range(1, int(self.recording.run[-1]) + 1)]
        return [(run, share) for run, share in shares if share > MOST_MISSING]


class Commissioning:
    """One programme on one axis."""

    def __init__(self, device: Device, axis: int, programme: Programme, envelope: Envelope) -> None:
        self._device = device
        self._axis = axis
        self._programme = programme
        self._envelope = envelope
        self._written: dict[int, bytes] = {}
        self._break_aways: list[BreakAway] = []
        self._done_s = 0.0
        self._step = ""

    def run(self, report: Report) -> Outcome:
        """Moves the axis; raises MotionError when the programme could not be carried out to its end."""
        drive = Drive(self._device, self._axis)
        with TickRecorder(self._device, self._axis) as recorder, LiveAxis(self._device, self._axis, power.NO_MODE) as live:
            self._borrow(live)
            held = live.hold(1 - self._axis)
            live.when_broken_off.append(self._abort)
            recorder.start()
            began_rad = drive.position()
            for number, place in enumerate(self._programme.places, 1):
                self._go_to(live, recorder, place, report)
                for experiment in place.experiments:
                    self._step = f"{experiment.name} at {degrees(place.angle_rad):.1f}° (place {number})"
                    self._perform(live, recorder, place, experiment, report)
            return Outcome(recorder.recording(began_rad), self._break_aways, held)

    # --- objects ----------------------------------------------------------------------------------------------------

    def _borrow(self, live: LiveAxis) -> None:
        """What the experiments are set up by is put back at the end, and the travel is watched meanwhile (607D)."""
        live.keep(OBJECT, 1, KIND)
        for sub in (*FIELDS.values(), *LIMIT_FIELDS.values()):
            live.keep(OBJECT, 4, sub)
        limits = live.drive.position_limits() or (-float("inf"), float("inf"))
        for sub, value in ((1, max(limits[0], self._envelope.lowest_rad)), (2, min(limits[1], self._envelope.highest_rad))):
            live.keep(0x607D, 4, sub)
            self._device.axis_write(self._axis, 0x607D, round(value * POSITION_COUNTS_PER_RAD), 4, sub)

    def _write(self, sub: int, data: bytes) -> None:
        """Only what differs from what we wrote last."""
        if self._written.get(sub) != data:
            self._device.download(OBJECT + AXIS_SHIFT * self._axis, sub, data)
            self._written[sub] = data

    def _int(self, sub: int) -> int:
        return self._device.axis_int(self._axis, OBJECT, sub)

    def _abort(self) -> None:
        if self._int(STATE) == RUNS:
            self._device.axis_write(self._axis, OBJECT, ABORT, 1, sub=COMMAND)

    # --- motion -----------------------------------------------------------------------------------------------------

    def _watch(self, live: LiveAxis, recorder: TickRecorder) -> int:
        """The statusword, while all is well."""
        recorder.check_alive()
        return live.check_enabled()

    def _go_to(self, live: LiveAxis, recorder: TickRecorder, place: Place, report: Report) -> None:
        drive = live.drive
        way = abs(place.angle_rad - drive.position())
        if way < NEAR_RAD:
            return
        expected_s = way / self._programme.moving_rad_s + 1.0
        report(f"to {degrees(place.angle_rad):.1f}°", self._done_s)
        drive.set_mode(power.PROFILE_POSITION)
        drive.start_to(place.angle_rad, self._programme.moving_rad_s)
        deadline = time.monotonic() + 2.0 * expected_s + 5.0
        while not self._watch(live, recorder) & power.TARGET_REACHED:
            if time.monotonic() > deadline:
                raise MotionError(f"{drive.name} has not reached {degrees(place.angle_rad):.2f}° in time.")
            time.sleep(4 * POLL_S)
        drive.set_mode(power.NO_MODE)
        time.sleep(SETTLE_S)
        self._done_s += expected_s

    def _perform(
        self, live: LiveAxis, recorder: TickRecorder, place: Place, experiment: Experiment, report: Report
    ) -> None:
        self._set_up(experiment)
        self._start(live, recorder)
        while (state := self._int(STATE)) == RUNS:
            self._watch(live, recorder)
            report(self._step, self._done_s + 0.01 * self._int(PROGRESS) * experiment.duration_s)
            time.sleep(4 * POLL_S)
        if state != DONE:
            self._watch(live, recorder)  # an emergency or a fault says more
            raise MotionError(f"{self._step} did not come to its end: {ENDS.get(state, f'state {state}')}.")
        self._done_s += experiment.duration_s
        if experiment.kind == BREAK_AWAY:
            self._tell_break_aways(place)

    def _set_up(self, experiment: Experiment) -> None:
        self._write(KIND, bytes([experiment.kind]))
        for name, value in experiment.fields.items():
            sub = FIELDS[name]
            self._write(sub, struct.pack("<I", round(value)) if sub == COUNT else struct.pack("<f", value))
        for name, sub in LIMIT_FIELDS.items():
            self._write(sub, struct.pack("<f", self._programme.limits[name]))

    def _start(self, live: LiveAxis, recorder: TickRecorder) -> None:
        """The device refuses while its ramp has not ended."""
        deadline = time.monotonic() + START_TIMEOUT_S
        while True:
            self._watch(live, recorder)
            try:
                self._device.axis_write(self._axis, OBJECT, START, 1, sub=COMMAND)
                return
            except Refused as error:
                if error.abort != DEVICE_STATE:
                    raise MotionError(f"{self._step} was refused: its set-up does not fit its limits ({error})") from error
                if time.monotonic() > deadline:
                    raise MotionError(
                        f"{self._step} was refused for {START_TIMEOUT_S:g} s: {AXES[self._axis]} does not come to rest, or"
                        " stands at a position limit (607D)."
                    ) from error
            time.sleep(POLL_S)

    def _tell_break_aways(self, place: Place) -> None:
        for first, direction in ((BREAK_AWAYS, "positive"), (BREAK_AWAYS + 3, "negative")):
            mean, deviation = (self._device.axis_real(self._axis, OBJECT, first + 1 + i) for i in range(2))
            self._break_aways.append(BreakAway(place.angle_rad, direction, self._int(first), mean, deviation))
