# SPDX-License-Identifier: Apache-2.0
"""Lets the device brake by itself: it monitors a heartbeat of each motion, in an entry of 1016 of its own.

Several motions may run at one node, in separate processes. Each has a unique master id, so that no other heartbeat can
replace one that has stopped. The first of them makes the node operational, the last one restores its NMT state.
"""

from __future__ import annotations

import contextlib
import threading
import time

import can

from ..errors import MotionError
from .device import Device
from .file_lock import FileLock

MONITOR_MS = 1009
"""The device brakes when our heartbeat is missing for this long; an odd number, which identifies our entries."""
STRICT_MONITOR_MS = 907
"""The same for a program that moves an axis as a person holds a button: together with BEAT_S it is within a second."""
MAX_TIMES_REAL_TIME = 64
"""1016 has room for this many times WATCH_MS."""
BEAT_S = 0.1
LISTEN_S = 0.3
"""Time without a heartbeat after which an id counts as free: three beats."""
MASTERS = range(127, 111, -1)
"""Node ids that motions choose, best first."""
_CONSUMERS = (4, 3, 2, 1)
_OPERATIONAL = 5


class Supervision:
    """Of one motion, from `begin` to `end`."""

    def __init__(self, device: Device, monitor_ms: int = MONITOR_MS) -> None:
        """`monitor_ms`: MONITOR_MS or STRICT_MONITOR_MS."""
        self._device = device
        self._monitor_ms = monitor_ms
        self._gate = device.turns.lock("gate")  # only one begins or ends at a time
        self._members = device.turns.lock("members")  # shared by all motions; its text: the NMT state before the first
        self._master: FileLock | None = None
        self._entry: tuple[int, int] | None = None
        self._beat: _Heartbeat | None = None
        self._joined = False

    def begin(self) -> None:
        """The node is operational and monitors us; raises MotionError, and nothing is changed, when it cannot."""
        try:
            with self._gate.held():
                self._join()
                self._monitor()
        except BaseException:
            self.end()
            raise

    def abandon(self) -> None:
        """The node still monitors us but no longer receives our heartbeat: `end` then leaves its entry, and the device
        brakes."""
        self._entry = None

    def end(self) -> None:
        """The node no longer monitors us; its NMT state is restored when we are the last motion."""
        try:
            with self._gate.held():
                try:
                    self._unwatch()
                finally:
                    self._part()
        finally:
            if self._beat is not None:
                self._beat.stop()
            for lock in (self._master, self._members, self._gate):
                if lock is not None:
                    lock.close()

    # --- NMT state ------------------------------------------------------------------------------------------------

    def _join(self) -> None:
        nmt = self._device.nmt_state()
        if self._members.try_alone():
            self._members.text = nmt
        self._members.wait(shared=True)
        self._joined = True
        if nmt != "operational":
            self._device.set_nmt("operational")

    def _part(self) -> None:
        if not self._joined:
            return
        before = self._members.text
        if not self._members.try_alone():
            return
        if before in ("pre-operational", "stopped") or (before == "operational" and self._has_missed_us()):
            self._device.set_nmt(before)

    def _has_missed_us(self) -> bool:
        """The node is pre-operational because our heartbeat came too late, as far as it monitors nobody else. Its axes are off,
        or in the fault."""
        device = self._device
        if str(device.node.nmt.state).lower() != "pre-operational":
            return False
        return not any(device.read_int(0x1016, sub) for sub in _CONSUMERS if device.try_upload(0x1016, sub) is not None)

    # --- heartbeat ------------------------------------------------------------------------------------------------

    def _monitor(self) -> None:
        device = self._device
        entries = {
            sub: device.read_int(0x1016, sub) for sub in _CONSUMERS if device.try_upload(0x1016, sub) is not None
        }
        master, sub = self._choose(entries)
        self._beat = _Heartbeat(device, master)
        entry = master << 16 | self._monitor_ms * self._pace()
        device.write_int(0x1016, sub, entry, 4)
        self._entry = (sub, entry)
        self._beat.send()  # the device monitors from the first one on
        self._beat.start()

    def _pace(self) -> int:
        """How many times faster than ours the device's clock runs: that of a simulator may."""
        return max(1, min(MAX_TIMES_REAL_TIME, round(self._device.pace())))

    def _choose(self, entries: dict[int, int]) -> tuple[int, int]:
        """A free id, locked for us, and the entry for it: one left by a killed motion, or a free one."""
        used = {entry >> 16 & 0x7F: sub for sub, entry in entries.items() if entry >> 16 and entry & 0xFFFF}
        left = {
            node: sub for node, sub in used.items() if node in MASTERS and _is_ours(entries[sub] & 0xFFFF)
        }  # or of one that works: then its lock or its heartbeat shows it
        free = [sub for sub in entries if sub not in used.values()]
        heard = self._heard(MONITOR_MS / 1000 + BEAT_S if left else LISTEN_S)
        for master in sorted(MASTERS, key=lambda node: node not in left):
            sub = left.get(master) or (free[0] if free and master not in used else None)
            if sub is None or master in heard:
                continue
            lock = FileLock(f"master-{master}")
            if lock.try_alone():
                self._master = lock
                return master, sub
            lock.close()
        raise MotionError(self._refusal(used, bool(entries), bool(free)))

    def _heard(self, seconds: float) -> set[int]:
        """Nodes on the bus, ours included, after at least this long."""
        device = self._device
        time.sleep(max(0.0, device.opened_s + seconds - time.monotonic()))
        return {device.node_id, *device.network.scanner.nodes}

    def _refusal(self, used: dict[int, int], any_entry: bool, any_free: bool) -> str:
        node = self._device.node_id
        if not any_entry:
            return (
                f"node {node} cannot monitor a heartbeat (it has no object 1016), so nothing would stop it if this"
                " computer failed."
            )
        if any_free:
            return (
                f"all node ids from {MASTERS[-1]} to {MASTERS[0]} are in use; a motion needs one of them for its"
                " heartbeat."
            )
        monitored = ", ".join(str(master) for master in used)
        return (
            f"node {node} already monitors {len(used)} heartbeats (1016: nodes {monitored}) and has no entry for"
            " another. Wait until another motion has finished, or clear an unused entry, e.g. 'set 0x1016:1 0'."
        )

    def _unwatch(self) -> None:
        """Clears our entry, if it is still ours."""
        if self._entry is None:
            return
        sub, entry = self._entry
        self._entry = None
        if self._device.read_int(0x1016, sub) == entry:
            self._device.write_int(0x1016, sub, 0, 4)


def _is_ours(time_ms: int) -> bool:
    """The time in an entry is one that servoctl writes."""
    return any(time_ms % monitor_ms == 0 for monitor_ms in (MONITOR_MS, STRICT_MONITOR_MS))


class _Heartbeat(threading.Thread):
    """Our own heartbeat, from a thread of its own."""

    def __init__(self, device: Device, node_id: int) -> None:
        super().__init__(daemon=True, name="heartbeat")
        self._device = device
        self._cob_id = 0x700 + node_id
        self._end = threading.Event()

    def send(self) -> None:
        """One."""
        self._device.network.send_message(self._cob_id, bytes([_OPERATIONAL]))

    def run(self) -> None:
        while not self._end.wait(BEAT_S):
            with contextlib.suppress(can.CanError, OSError, RuntimeError):
                self.send()

    def stop(self) -> None:
        """Ends it, also one that never began."""
        self._end.set()
        if self.is_alive():
            self.join(timeout=1.0)
