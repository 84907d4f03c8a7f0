# SPDX-License-Identifier: Apache-2.0
"""Executes a test plan on the live axis: from place to place, the experiments of 0x2100, each tick recorded.

It decides nothing: `identify plan` has planned every experiment and its place. On any error the experiment is aborted
and the axis ends at rest (live.py); the objects of the set-up, mode, limits and PDO mappings are restored.
"""

from __future__ import annotations

import contextlib
import math
import struct
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from types import TracebackType

from ..drive import power
from ..drive.drive import POLL_S, Drive
from ..errors import MotionError, Refused
from ..link.device import DEVICE_STATE, Device
from ..motion.live import LiveAxis
from ..objects.parameter import AXES, AXIS_SHIFT
from ..units import POSITION_COUNTS_PER_RAD, RATE_COUNTS_PER_RAD_S, degrees
from .recorder import BREAK_AWAY, Recording, TickRecorder
from .test_plan import FIELDS, LIMIT_FIELDS, Envelope, Experiment, Place, TestPlan

OBJECT = 0x2100
COMMAND, STATE, PROGRESS, KIND, COUNT, BREAK_AWAYS = 1, 2, 3, 4, 5, 19
START, ABORT = 1, 2
RUNS, DONE = 1, 2
ENDS = {
    0: "it did not start", 3: "it was aborted", 4: "the axis exceeded the travel limit of the experiment (2100:14)",
    5: "the axis exceeded the speed limit of the experiment (2100:15)", 6: "it exceeded its time limit (2100:17)",
    7: "the drive stopped the axis, for example at a position limit (607D)",
}  # fmt: skip
"""2100:2 other than runs and done."""
SWEPT_AWAY = (4, 5)
"""Left the travel, too fast."""
STOPPED_BY_DRIVE = 7
RAMP_S = 1.0
"""An axis that another client disables is enabled until it stands."""
RAMPS = ((0x6084, 0), (0x60A4, 1))
"""Deceleration and jerk of the drive, in 1e-6 rad/s^2 and 1e-6 rad/s^3."""
JERK_TIME_S = 0.02
"""Maximum time until the drive brakes fully."""
START_TIMEOUT_S = 5.0
SETTLE_S = 0.3
NEAR_RAD = 1e-3
"""A place this near needs no move."""
STRAY_SHARE = 0.05
"""Share of an experiment's travel limit: the experiment may begin this far from its place. A sweep does not end at its
start angle."""
MAX_MISSING = 1e-3
"""Share of a run's ticks; a larger loss is reported."""

Report = Callable[[str, float], None]
"""Called with the current action and the elapsed part of the test plan, s."""


@dataclass(frozen=True)
class BreakAway:
    """The device's statistics of break-away runs of one direction: number, mean and standard deviation, N m."""

    angle_rad: float
    direction: str
    count: int
    mean_nm: float
    deviation_nm: float


@dataclass(frozen=True)
class Outcome:
    """The whole recording, and the lost ticks."""

    recording: Recording
    break_aways: list[BreakAway]
    other_held: bool

    def incomplete_runs(self) -> list[tuple[int, float]]:
        """(run, missing share) of those that miss more than a permille."""
        shares = [(run, self.recording.missing_share(run)) for run in range(1, int(self.recording.run[-1]) + 1)]
        return [(run, share) for run, share in shares if share > MAX_MISSING]


def check_place(drive: Drive, envelope: Envelope) -> None:
    """Raises MotionError when the axis is outside its allowed travel."""
    here, low, high = drive.position(), envelope.lowest_rad, envelope.highest_rad
    if low <= here <= high:
        return
    middle = degrees((low + high) / 2)
    distance = math.ceil(abs(middle - degrees(here)) + 1)
    raise MotionError(
        f"{drive.name} is at {degrees(here):.1f}°, outside {degrees(low):.5g}° to {degrees(high):.5g}°. Move it"
        f" inside first, e.g. 'servoctl move {drive.name} --to {middle:.0f} --max-travel {distance}'."
    )


class Commissioning:
    """One axis, enabled, monitored and recorded within a `with` block, for a sequence of test plans.

    Between two plans it is held, so that wind does not turn it while the first one is fitted.
    """

    def __init__(self, device: Device, axis: int, envelope: Envelope) -> None:
        self._device = device
        self._axis = axis
        self._envelope = envelope
        self._recorder = TickRecorder(device, axis)
        self._live = LiveAxis(device, axis, power.NO_MODE)
        self._both = contextlib.ExitStack()
        self._other_held = False
        self._written: dict[int, bytes] = {}

    def __enter__(self) -> Commissioning:
        check_place(self._live.drive, self._envelope)
        with contextlib.ExitStack() as both:
            both.enter_context(self._recorder)
            both.enter_context(self._live)
            self._live.when_broken_off.append(self._abort)
            self._borrow()
            self._other_held = self._live.hold(1 - self._axis)
            self._both = both.pop_all()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._both.__exit__(kind, error, trace)

    @property
    def recorder(self) -> TickRecorder:
        """Of the ticks, for those who show them as they come."""
        return self._recorder

    def run(self, test_plan: TestPlan, report: Report) -> Outcome:
        """Moves the axis; raises MotionError when the test plan could not be completed."""
        self._brake_as(test_plan)
        self._recorder.start()
        began_rad = self._live.drive.position()
        break_aways: list[BreakAway] = []
        done_s = 0.0
        for place in test_plan.places:
            report(f"to {degrees(place.angle_rad):.1f}°", done_s)
            done_s += self._go_to(place.angle_rad, test_plan.moving_rad_s)
            for experiment in place.experiments:
                step = f"{experiment.name} at {degrees(place.angle_rad):.1f}°"
                if abs(self._live.drive.position() - place.angle_rad) > STRAY_SHARE * test_plan.limits["travel_rad"]:
                    self._go_to(place.angle_rad, test_plan.moving_rad_s)
                self._set_up(experiment, test_plan)
                self._start(step)
                for share in self._until_done(step, experiment.kind):
                    report(step, done_s + share * experiment.duration_s)
                done_s += experiment.duration_s
                if experiment.kind == BREAK_AWAY:
                    break_aways += self._reported_break_aways(place)
        return Outcome(self._recorder.recording(began_rad), break_aways, self._other_held)

    # --- objects ----------------------------------------------------------------------------------------------------

    def _borrow(self) -> None:
        """The objects of the experiments' set-up are restored at the end, and the travel is monitored meanwhile
        (607D)."""
        live = self._live
        live.keep(OBJECT, 1, KIND)
        for sub in (*FIELDS.values(), *LIMIT_FIELDS.values()):
            live.keep(OBJECT, 4, sub)
        for sub, value in ((1, self._envelope.lowest_rad), (2, self._envelope.highest_rad)):
            live.keep(0x607D, 4, sub)
            self._device.axis_write(self._axis, 0x607D, round(value * POSITION_COUNTS_PER_RAD), 4, sub)
        for index, sub in RAMPS:
            live.keep(index, 4, sub)

    def _brake_as(self, test_plan: TestPlan) -> None:
        """The drive stops at least as fast as experiments reverse: otherwise 607D would stop them where they have room
        to reverse."""
        fastest = max(experiment.fields.get("acceleration_rad_s2", 0.0) for _, experiment in test_plan)
        for (index, sub), least in zip(RAMPS, (fastest, fastest / JERK_TIME_S), strict=True):
            if self._device.axis_int(self._axis, index, sub) < least * RATE_COUNTS_PER_RAD_S:
                self._device.axis_write(self._axis, index, round(least * RATE_COUNTS_PER_RAD_S), 4, sub)

    def _write(self, sub: int, data: bytes) -> None:
        """Only values that differ from those we wrote last."""
        if self._written.get(sub) != data:
            self._device.download(OBJECT + AXIS_SHIFT * self._axis, sub, data)
            self._written[sub] = data

    def _int(self, sub: int) -> int:
        return self._device.axis_int(self._axis, OBJECT, sub)

    def _abort(self) -> None:
        if self._int(STATE) == RUNS:
            self._device.axis_write(self._axis, OBJECT, ABORT, 1, sub=COMMAND)

    def _reported_break_aways(self, place: Place) -> list[BreakAway]:
        found = []
        for first, direction in ((BREAK_AWAYS, "positive"), (BREAK_AWAYS + 3, "negative")):
            mean, deviation = (self._device.axis_real(self._axis, OBJECT, first + i) for i in (1, 2))
            found.append(BreakAway(place.angle_rad, direction, self._int(first), mean, deviation))
        return found

    # --- motion -----------------------------------------------------------------------------------------------------

    def _monitor(self) -> int:
        """The statusword, while there is no error."""
        self._recorder.check_alive()
        return self._live.check_enabled()

    def _go_to(self, angle_rad: float, rate_rad_s: float) -> float:
        """Returns the approximate duration, s."""
        drive = self._live.drive
        distance = abs(angle_rad - drive.position())
        if distance < NEAR_RAD:
            return 0.0
        expected_s = distance / rate_rad_s + 1.0
        self._monitor()
        drive.set_mode(power.PROFILE_POSITION)
        drive.start_to(angle_rad, rate_rad_s)
        clock = self._device.clock
        deadline = clock.now() + 2.0 * expected_s + 5.0
        while not self._monitor() & power.TARGET_REACHED:
            if clock.now() > deadline:
                raise MotionError(f"{drive.name} did not reach {degrees(angle_rad):.2f}° in time.")
            time.sleep(4 * POLL_S)
        drive.set_mode(power.NO_MODE)
        clock.sleep(SETTLE_S)
        return expected_s

    def _set_up(self, experiment: Experiment, test_plan: TestPlan) -> None:
        self._write(KIND, bytes([experiment.kind]))
        for name, value in experiment.fields.items():
            sub = FIELDS[name]
            self._write(sub, struct.pack("<I", round(value)) if sub == COUNT else struct.pack("<f", value))
        for name, sub in LIMIT_FIELDS.items():
            self._write(sub, struct.pack("<f", test_plan.limits[name]))

    def _start(self, step: str) -> None:
        """The device refuses while its ramp has not ended."""
        deadline = self._device.clock.now() + START_TIMEOUT_S
        while True:
            self._monitor()
            try:
                self._device.axis_write(self._axis, OBJECT, START, 1, sub=COMMAND)
                return
            except Refused as error:
                if error.abort != DEVICE_STATE:
                    raise MotionError(
                        f"{step} was refused because its set-up does not fit its limits: {error}"
                    ) from error
                if self._device.clock.now() > deadline:
                    raise MotionError(
                        f"{step} was refused for {START_TIMEOUT_S:g} s: {AXES[self._axis]} does not come to rest,"
                        " or is at a position limit (607D)."
                    ) from error
            time.sleep(POLL_S)

    def _until_done(self, step: str, kind: int) -> Iterator[float]:
        """The elapsed share, repeatedly, until the experiment ends; raises MotionError when it is aborted.

        A break-away that wind takes beyond its limits ends there, at rest; this does no harm.
        """
        while (state := self._int(STATE)) == RUNS:
            self._monitor()
            yield 0.01 * self._int(PROGRESS)
            time.sleep(4 * POLL_S)
        if state != DONE and not (kind == BREAK_AWAY and state in SWEPT_AWAY):
            self._monitor()  # an emergency or a fault has more information
            if state == STOPPED_BY_DRIVE:
                for _ in self._device.clock.every(POLL_S, RAMP_S):
                    self._monitor()
            raise MotionError(f"{step} ended early: {ENDS.get(state, f'state {state}')}.")
