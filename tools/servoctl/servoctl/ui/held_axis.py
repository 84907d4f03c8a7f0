# SPDX-License-Identifier: Apache-2.0
"""An axis that the page has enabled: it jogs, moves, or moves back and forth, one short step at a time."""

from __future__ import annotations

import time

from ..drive import power
from ..drive.drive import STANDSTILL_RAD_S
from ..drive.node_limits import read_limits
from ..errors import MotionError
from ..link.device import Device
from ..link.supervision import STRICT_MONITOR_MS
from ..motion.limits import Limits, Plan
from ..motion.live import LiveAxis
from ..motion.moves import longest_s, plan_to
from ..motion.tracking import begin_following, end_following
from ..units import degrees

ANY = Limits(float("inf"), float("inf"), float("inf"), by_options=False)
"""The page shows what will move; the limits are those of the node."""
RESTS_RAD_S = 20 * STANDSTILL_RAD_S
"""Slow enough for the next motion."""
SETTLE_S = 0.1
"""After a new set-point, before "target reached" counts."""


class HeldAxis:
    """One axis between `enter` and `leave`; rates in rad/s, angles in rad. Used by the thread of the bus only."""

    def __init__(self, device: Device, axis: int) -> None:
        self.live = LiveAxis(device, axis, power.PROFILE_VELOCITY, STRICT_MONITOR_MS, collects_garbage=True)
        self.drive = self.live.drive
        self.doing = ""
        """For people; empty at rest."""
        self.jog_seen_s: float | None = None
        """When the page last said that the button is held; None while it is not."""
        self._targets: list[float] = []
        self._rate = 0.0
        self._deadline_s = 0.0
        self._begun_s = 0.0

    def enter(self) -> None:
        """Enables; raises MotionError."""
        if self.drive.state() == power.ENABLED:
            raise MotionError(
                f"{self.drive.name} is enabled already, by another master or command: stop it before you enable it here."
            )
        self.live.__enter__()

    def leave(self, error: BaseException | None = None) -> None:
        """Stops on the ramp and disables; after an error with a quick stop."""
        first: BaseException | None = error
        if first is None:
            try:
                self.rest()
            except BaseException as failed:
                first = failed
        self.live.__exit__(type(first) if first else None, first, None)
        if first is not error:
            assert first is not None
            raise first

    # --- motions --------------------------------------------------------------------------------------------------

    def need_rest(self) -> None:
        """Raises MotionError while it moves, unless it jogs."""
        if self.doing and self.jog_seen_s is None:
            raise MotionError(f"{self.drive.name} {self.doing}: wait until it has ended, or stop it.")

    def jog(self, rate_rad_s: float) -> None:
        """Runs until `release`; raises InputError beyond the node's limit."""
        self.need_rest()
        read_limits(self.drive).check_rate(abs(rate_rad_s))
        if self.jog_seen_s is None:
            self.live.change_mode(power.PROFILE_VELOCITY)
        self.jog_seen_s = time.monotonic()
        self.drive.set_target_rate(rate_rad_s)
        self.doing = f"jogs at {degrees(rate_rad_s):.4g} °/s"

    def release(self) -> None:
        """Ends a jog on the ramp."""
        if self.jog_seen_s is not None:
            self.rest()

    def rest(self) -> None:
        """Ends any motion on its ramp; the axis stays enabled."""
        self.jog_seen_s = None
        self._targets = []
        if self.live.mode == power.PROFILE_VELOCITY:
            self.drive.set_target_rate(0.0)
        elif self.follows:
            end_following([self.live])
        elif self.doing:
            self._halt()
        self.doing = ""

    @property
    def follows(self) -> bool:
        """Follows what a camera sees."""
        return self.live.mode == power.TRACKING

    def _halt(self) -> None:
        """A motion in mode pp ends on the ramp, halt (605D). Without the change of mode it would go on after the halt."""
        self.drive.control(power.ENABLE_OPERATION | power.HALT)
        self.drive.wait_for_standstill()
        self.live.change_mode(power.PROFILE_VELOCITY)
        self.drive.control(power.ENABLE_OPERATION)

    def plan(self, target_rad: float, rate_rad_s: float) -> Plan:
        """To an angle from here; raises InputError when it is beyond a limit of the node."""
        found = plan_to(self.drive.name, self.drive.position(), target_rad, rate_rad_s)
        found.check(ANY, self.drive)
        return found

    def move(self, targets_rad: list[float], rate_rad_s: float, forever: bool = False) -> None:
        """To one angle after the other; `forever`: from the last one to the first one again."""
        self.need_rest()
        for target in targets_rad:
            self.plan(target, rate_rad_s)
        self.live.change_mode(power.PROFILE_POSITION)
        self._rate = rate_rad_s
        self._targets = list(targets_rad)
        self._forever = forever
        self._next()

    def _next(self) -> None:
        target = self._targets.pop(0)
        if self._forever:
            self._targets.append(target)
        plan = plan_to(self.drive.name, self.drive.position(), target, self._rate)
        self.drive.start_to(target, self._rate)
        clock = self.drive.device.clock.now()
        self._begun_s, self._deadline_s = clock, clock + longest_s(plan.duration_s)
        again = ", back and forth" if self._forever else ""
        self.doing = f"moves to {degrees(target):.3f}° at up to {degrees(self._rate):.4g} °/s{again}"

    def step(self) -> None:
        """Call every few ten ms; raises MotionError when the axis is no longer enabled, or does not arrive."""
        status = self.live.check_enabled()
        if self.live.mode != power.PROFILE_POSITION or not self.doing:
            return
        now = self.drive.device.clock.now()
        if status & power.TARGET_REACHED and now - self._begun_s > SETTLE_S:
            if self._targets:
                self._next()
            else:
                self.doing = ""
        elif now > self._deadline_s:
            raise MotionError(f"{self.drive.name} has not reached its target in time.")


def follow(axes: list[HeldAxis]) -> None:
    """All at once; they follow what the camera sees until `rest`."""
    begin_following([held.live for held in axes])
    for held in axes:
        held.doing = "follows the target of the camera"
