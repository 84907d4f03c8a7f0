"""A motion on the live axis that cannot be left running: whatever happens, the axis ends at rest.

While it lasts the device watches a heartbeat of ours (1016): should this program or its computer die, the device
brakes by itself. Done: the axis stands, and is enabled or not as before. Broken off (error, Ctrl-C, SIGTERM): quick
stop, then disabled. Mode, targets, interpolation period, heartbeat watch and NMT state are as before in both cases.
"""

from __future__ import annotations

import contextlib
import gc
import signal
import threading
import time
from collections.abc import Callable, Iterator
from types import TracebackType
from typing import Any

import can

from . import power
from .device import Device
from .drive import STANDSTILL_RAD_S, Drive
from .errors import MotionError, ServoctlError
from .units import degrees

WATCH_MS = 1000
"""The device brakes when our heartbeat stays away for so long."""
BEAT_S = 0.1
_CONSUMERS = (4, 3, 2, 1)
_OPERATIONAL = 5


class LiveAxis:
    """One axis, enabled and watched within a `with` block."""

    def __init__(self, device: Device, axis: int, mode: int) -> None:
        """`mode` is that of CiA 402 (power.CYCLIC_VELOCITY ...)."""
        self.device = device
        self.drive = Drive(device, axis)
        self.mode = mode
        self._turn = contextlib.ExitStack()
        self._undo: list[Callable[[], None]] = []
        self._beat: _Heartbeat | None = None
        self._was_enabled = False

    def __enter__(self) -> LiveAxis:
        drive = self.drive
        state = drive.state()
        if state in (power.FAULT, "fault reaction active"):
            raise MotionError(
                f"{drive.name} has a fault (603F = {drive.error_code():04X}): 'servoctl state {drive.name} reset' resets it."
            )
        self._was_enabled = state == power.ENABLED
        if self._was_enabled and abs(drive.rate()) > 10 * STANDSTILL_RAD_S:
            raise MotionError(
                f"{drive.name} moves at {degrees(drive.rate()):.3f} °/s: stop it first ('servoctl state {drive.name} disable')."
            )
        self._turn.enter_context(self.device.turns.motion())
        try:
            self._prepare()
        except BaseException:
            self._leave(broken_off=True)
            raise
        gc.disable()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        gc.enable()
        self._leave(broken_off=kind is not None)

    def _prepare(self) -> None:
        device, drive = self.device, self.drive
        nmt = device.nmt_state()
        if nmt != "operational":
            device.set_nmt("operational")
            if nmt in ("pre-operational", "stopped"):
                self._undo.append(lambda: device.set_nmt(nmt))
        self._watch()
        for index, size, sub in ((0x6060, 1, 0), (0x60C2, 1, 1), (0x60C2, 1, 2), (0x6081, 4, 0)):
            self._keep(index, size, sub)
        drive.set_target_rate(0.0)
        drive.set_target_position(drive.position())
        if self._was_enabled and drive.mode_number() != self.mode:
            drive.set_mode(self.mode)
        elif not self._was_enabled:
            device.axis_write(drive.axis, 0x6060, self.mode, 1)
        drive.enable()

    def _keep(self, index: int, size: int, sub: int) -> None:
        """Puts the object back to what it is now when the motion is over."""
        before = self.device.axis_int(self.drive.axis, index, sub)
        self._undo.append(lambda: self.device.axis_write(self.drive.axis, index, before, size, sub))

    def _watch(self) -> None:
        """Lets the device watch our heartbeat, in an entry of 1016 that nobody uses."""
        device = self.device
        master = 127 if device.node_id != 127 else 126
        entries = {
            sub: device.read_int(0x1016, sub) for sub in _CONSUMERS if device.try_upload(0x1016, sub) is not None
        }
        ours = [sub for sub, entry in entries.items() if entry >> 16 & 0x7F == master]  # a killed program's
        free = [sub for sub, entry in entries.items() if entry & 0xFFFF == 0]
        if not ours and not free:
            return
        sub = (ours or free)[0]
        self._beat = _Heartbeat(device, master)
        self._beat.start()
        device.write_int(0x1016, sub, master << 16 | WATCH_MS, 4)
        self._undo.append(lambda: device.write_int(0x1016, sub, 0, 4))

    def set_interpolation(self, period_ms: int) -> None:
        """60C2: time between set-points, ms."""
        self.device.axis_write(self.drive.axis, 0x60C2, period_ms, 1, sub=1)
        self.device.axis_write(self.drive.axis, 0x60C2, -3, 1, sub=2)

    def _leave(self, broken_off: bool) -> None:
        """To rest, and all as before; Ctrl-C is deaf meanwhile, an error is told after all has been tried."""
        with _deaf():
            failed: list[Exception] = []
            steps = [self._stop_hard if broken_off else self._stop_gently, *reversed(self._undo)]
            for step in steps:
                try:
                    step()
                except (ServoctlError, can.CanError, OSError) as error:
                    failed.append(error)
            self._undo.clear()
            if self._beat is not None:
                self._beat.stop()
            self._turn.close()
        if failed and not broken_off:
            raise failed[0]

    def _stop_gently(self) -> None:
        drive = self.drive
        if drive.state() != power.ENABLED:
            raise MotionError(f"{drive.name} left 'operation enabled' during the motion; it is in '{drive.state()}'.")
        if self.mode != power.PROFILE_POSITION:
            drive.set_target_rate(0.0)
        drive.wait_for_standstill()
        if not self._was_enabled:
            drive.disable()

    def _stop_hard(self) -> None:
        drive = self.drive
        drive.set_target_rate(0.0)
        try:
            drive.quick_stop()
        finally:
            if drive.state() not in (power.FAULT, "fault reaction active"):
                drive.disable()


class _Heartbeat(threading.Thread):
    """Our own heartbeat, from a thread of its own."""

    def __init__(self, device: Device, node_id: int) -> None:
        super().__init__(daemon=True, name="heartbeat")
        self._device = device
        self._cob_id = 0x700 + node_id
        self._end = threading.Event()

    def run(self) -> None:
        while not self._end.is_set():
            with contextlib.suppress(can.CanError, OSError, RuntimeError):
                self._device.network.send_message(self._cob_id, bytes([_OPERATIONAL]))
            self._end.wait(BEAT_S)

    def stop(self) -> None:
        """Ends it."""
        self._end.set()
        self.join(timeout=1.0)


@contextlib.contextmanager
def _deaf() -> Iterator[None]:
    """Ctrl-C and SIGTERM wait until the axis is at rest."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    before: dict[signal.Signals, Any] = {s: signal.signal(s, signal.SIG_IGN) for s in (signal.SIGINT, signal.SIGTERM)}
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


def pace(period_s: float, duration_s: float) -> Iterator[float]:
    """Gives the time since the start, s, every `period_s` until `duration_s`; late ones are left out, not caught up."""
    start = time.perf_counter()
    next_s = 0.0
    while True:
        now = time.perf_counter() - start
        if now < next_s:
            time.sleep(next_s - now)
            now = time.perf_counter() - start
        if now >= duration_s:
            return
        yield now
        next_s = (int(now / period_s) + 1) * period_s
