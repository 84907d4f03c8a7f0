# SPDX-License-Identifier: Apache-2.0
"""A motion on the live axis that must not be left running: whatever happens, the axis ends at rest.

Meanwhile the device monitors our heartbeat (supervision.py): if this program or its computer stops, the device brakes
by itself. Completed: the axis is at rest, and enabled or not as before. Aborted (error, Ctrl-C, SIGTERM): quick stop,
then disabled. Mode, targets, interpolation period and heartbeat monitoring are restored in both cases, the NMT state
when no other motion is left at the node.
"""

from __future__ import annotations

import contextlib
import gc
from collections.abc import Callable, Iterable
from types import TracebackType

import can

from ..drive import power
from ..drive.drive import POSITIONING_OPTION, SHORTER_WAY, STANDSTILL_RAD_S, Drive
from ..errors import ConnectionFailed, MotionError, ServoctlError
from ..link.device import Device
from ..link.interrupts import deaf
from ..link.supervision import MONITOR_MS, Supervision
from ..units import degrees


class LiveAxis:
    """One axis, enabled and monitored within a `with` block."""

    def __init__(
        self, device: Device, axis: int, mode: int, monitor_ms: int = MONITOR_MS, collects_garbage: bool = False
    ) -> None:
        """`mode` is that of CiA 402 (power.CYCLIC_VELOCITY ...), `monitor_ms` as in Supervision. A motion may take hours
        when `collects_garbage`; without it no set-point waits for the collector."""
        self.device = device
        self.drive = Drive(device, axis)
        self.mode = mode
        self.when_broken_off: list[Callable[[], None]] = []
        """Runs before the quick stop; set by code that has started something on the axis."""
        self._turn = contextlib.ExitStack()
        self._undo: list[Callable[[], None]] = []
        self._supervision = Supervision(device, monitor_ms)
        self._collects_garbage = collects_garbage
        self._was_enabled = False

    def __enter__(self) -> LiveAxis:
        drive, turns = self.drive, self.device.turns
        with contextlib.ExitStack() as turn:
            refusal = f"another servoctl is moving {drive.name}: wait until it has finished."
            turn.enter_context(turns.alone(drive.name, refusal))
            self._check_at_rest()
            turn.enter_context(turns.motion())
            self._supervision.begin()
            self._undo.append(self._supervision.end)
            self._turn = turn.pop_all()
        try:
            self._prepare()
        except BaseException:
            self._leave(broken_off=True)
            raise
        if not self._collects_garbage:
            gc.disable()
        return self

    def _check_at_rest(self) -> None:
        drive = self.drive
        state = drive.state()
        if state in (power.FAULT, "fault reaction active"):
            raise MotionError(
                f"{drive.name} has a fault (603F = {drive.error_code():04X}): reset it with 'servoctl state"
                f" {drive.name} reset'."
            )
        self._was_enabled = state == power.ENABLED
        if self._was_enabled and abs(drive.rate()) > 10 * STANDSTILL_RAD_S:
            raise MotionError(
                f"{drive.name} moves at {degrees(drive.rate()):.3f} °/s: stop it first ('servoctl state"
                f" {drive.name} disable')."
            )

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if not self._collects_garbage:
            gc.enable()
        self._leave(broken_off=kind is not None)

    def _prepare(self) -> None:
        device, drive = self.device, self.drive
        for index, size, sub in ((0x6060, 1, 0), (0x60C2, 1, 1), (0x60C2, 1, 2), (0x6081, 4, 0)):
            self.keep(index, size, sub)
        if drive.wraps():
            self.keep(POSITIONING_OPTION, 2)
            device.axis_write(drive.axis, POSITIONING_OPTION, SHORTER_WAY, 2)
        drive.set_target_rate(0.0)
        drive.set_target_position(drive.position())
        if self._was_enabled and drive.mode_number() != self.mode:
            drive.set_mode(self.mode)
        elif not self._was_enabled:
            device.axis_write(drive.axis, 0x6060, self.mode, 1)
        drive.enable()

    def keep(self, index: int, size: int, sub: int = 0) -> None:
        """Restores an object of the axis to its present value when the motion has ended."""
        before = self.device.axis_int(self.drive.axis, index, sub)
        self._undo.append(lambda: self.device.axis_write(self.drive.axis, index, before, size, sub))

    def change_mode(self, mode: int) -> None:
        """Of the axis, which is at rest."""
        if mode != self.mode:
            self.drive.set_target_rate(0.0)
            self.drive.set_mode(mode)
            self.mode = mode

    def check_enabled(self) -> int:
        """The statusword; raises MotionError when the axis is no longer enabled."""
        drive = self.drive
        status = drive.statusword()
        if drive.state(status) != power.ENABLED:
            raise MotionError(
                f"{drive.name} is in '{drive.state(status)}' (603F = {drive.error_code():04X}); 'servoctl faults'"
                " shows details."
            )
        return status

    def hold(self, axis: int) -> bool:
        """Enables another axis where it is, until the motion has ended; False when another process moves it or it has a
        fault.

        One that is enabled already stays enabled.
        """
        other = Drive(self.device, axis)
        state = other.state()
        if state == power.ENABLED:
            return True
        try:
            self._turn.enter_context(self.device.turns.alone(other.name, f"another servoctl is moving {other.name}."))
        except MotionError:
            return False
        if state in (power.FAULT, "fault reaction active"):
            return False
        mode = other.mode_number()
        self._undo.append(lambda: self.device.axis_write(axis, 0x6060, mode, 1))
        self._undo.append(other.disable)
        self.device.axis_write(axis, 0x6060, power.NO_MODE, 1)
        other.enable()
        return True

    def set_interpolation(self, period_ms: int) -> None:
        """60C2: time between set-points, ms."""
        self.device.axis_write(self.drive.axis, 0x60C2, period_ms, 1, sub=1)
        self.device.axis_write(self.drive.axis, 0x60C2, -3, 1, sub=2)

    def _leave(self, broken_off: bool) -> None:
        """Stop the axis and restore its settings. Ctrl-C is ignored meanwhile; errors are raised after all steps were
        attempted."""
        with deaf():
            failed: list[Exception] = []
            stops = [*self.when_broken_off, self._stop_hard] if broken_off else [self._stop_gently_or_hard]
            self._try(stops, failed)
            self._try(reversed(self._undo), failed)
            self._undo.clear()
            self._turn.close()
        if failed and not broken_off:
            raise failed[0]

    @staticmethod
    def _try(steps: Iterable[Callable[[], None]], failed: list[Exception]) -> None:
        """All of them; adds their errors."""
        for step in steps:
            try:
                step()
            except (ServoctlError, can.CanError, OSError) as error:
                failed.append(error)

    def _stop_gently_or_hard(self) -> None:
        """What does not come to rest is switched off as long as the device still monitors us."""
        try:
            self._stop_gently()
        except (ServoctlError, can.CanError, OSError):
            self._stop_hard()
            raise

    def _stop_gently(self) -> None:
        drive = self.drive
        if drive.state() != power.ENABLED:
            raise MotionError(
                f"{drive.name} left 'operation enabled' during the motion; its state is '{drive.state()}'."
            )
        if self.mode != power.PROFILE_POSITION:
            drive.set_target_rate(0.0)
        drive.wait_for_standstill()
        if not self._was_enabled:
            drive.disable()

    def _stop_hard(self) -> None:
        """Repeated once when the bus fails; when it fails again, the device has to brake because our heartbeat is
        missing, and what we have borrowed stays as it is."""
        with contextlib.suppress(ServoctlError, can.CanError, OSError):
            return self._stop_quickly()
        try:
            self._stop_quickly()
        except (ServoctlError, can.CanError, OSError) as error:
            self._supervision.abandon()
            if isinstance(error, ConnectionFailed) and not self.device.given_up:
                self._undo.insert(0, lambda: self.device.give_up(""))  # runs last
                self.device.give_up(str(error))
            raise

    def _stop_quickly(self) -> None:
        drive = self.drive
        drive.set_target_rate(0.0)
        try:
            drive.quick_stop()
        finally:
            if drive.state() not in (power.FAULT, "fault reaction active"):
                drive.disable()
