# SPDX-License-Identifier: Apache-2.0
"""The one thread that works on the bus. Others give it jobs, take samples, and stop the axes without waiting for it.

    stop            from any thread: both controlwords at once as PDOs, then the thread of the bus brings the axes to rest
    submit          a job for the thread of the bus; its future has the result, or the error as one sentence
    state, samples  what the page shows
"""

from __future__ import annotations

import contextlib
import errno
import itertools
import queue
import threading
import time
from collections import deque
from collections.abc import Callable, Iterator
from concurrent.futures import Future
from dataclasses import asdict, dataclass
from functools import partial
from typing import Any

import can

from ..drive import power
from ..drive.axis_state import read_axis
from ..drive.drive import QUICK_STOP_ACTIVE, Drive
from ..drive.node_limits import limits_data, read_limits
from ..errors import ConnectionFailed, InputError, MotionError, Refused, ServoctlError
from ..gains.loop_test import MeasuredLoop
from ..gains.tuning import set_state
from ..identify.recorded_signals import RecordedSignals
from ..link.can_bits import frame_bits
from ..link.device import Device
from ..link.interrupts import deaf
from ..link.signal_stream import SETS, Samples, Signal, SignalStream
from ..link.stop_frames import StopFrames
from ..motion import tracking
from ..objects import restrictions
from ..objects.fault_table import FaultTable, find_faults
from ..objects.parameter import AXES
from ..show import capture, recording
from ..show.recording import Recorder
from ..units import degrees
from .held_axis import HeldAxis
from .jobs import Jobs
from .page_words import of_page

STEP_S = 0.02
POLL_S = 0.1
CAMERA_POLL_S = 1.0
"""While no axis follows."""
SETTINGS_POLL_S = 1.0
RETRY_S = 0.25
STREAM_SILENT_S = 2.0
JOG_SILENT_S = 0.3
"""Without a word from the page for this long, a jog ends on its ramp; for twice as long, with a quick stop."""
COMMANDER_SILENT_S = 1.0
REJOIN_S = 5.0
"""After a lost link: the node misses our heartbeat within a second, by its own clock."""

UNREAD = {
    "state": "unknown", "mode": "", "position_deg": None, "rate_deg_s": None, "torque_percent": None, "doing": "is not read meanwhile",
}  # fmt: skip
"""Of an axis, while a job measures."""

Job = Callable[[Jobs], Any]


class NodeStopped(ConnectionFailed):
    """By NMT: it takes no SDO."""


@dataclass(frozen=True)
class Order:
    """When a job was ordered, and who may still want it: `stops` are those before it."""

    stops: int
    stands: Callable[[], bool] = lambda: True


@dataclass(frozen=True)
class _Entry:
    """A job that waits for its turn: orders come before readings, which change nothing."""

    order: Order | None
    number: int
    job: Job | None
    """None wakes the thread of the bus."""
    future: Future[Any]

    def __lt__(self, other: _Entry) -> bool:
        return self._turn < other._turn

    @property
    def _turn(self) -> tuple[bool, int]:
        return self.job is not None and self.order is None, self.number


class BusLoad(can.Listener):
    """Counts bits of all frames that are received; those of this program are not."""

    def __init__(self, bit_rate: int | None) -> None:
        """`bit_rate` in bit/s, None if it is unknown: then the share is, too."""
        self.bits = 0
        self._bit_rate = bit_rate
        self._since = (time.monotonic(), 0)
        self.share: float | None = 0.0 if bit_rate else None

    def on_message_received(self, msg: can.Message) -> None:
        """Called by the thread that receives."""
        if not msg.is_error_frame:
            self.bits += frame_bits(msg)

    def on_error(self, exc: Exception) -> None:
        """The thread of the bus reports it."""

    def update(self) -> None:
        """Call every second or so."""
        now, bits = time.monotonic(), self.bits
        passed = now - self._since[0]
        if passed >= 0.5:
            self.share = (bits - self._since[1]) / passed / self._bit_rate if self._bit_rate else None
            self._since = (now, bits)


def _bit_rate(device: Device) -> int | None:
    """That of the node (3050:2), otherwise that of the connection, in bit/s."""
    return 1000 * int.from_bytes(device.try_upload(0x3050, 2) or b"", "little") or device.bit_rate


class Engine:
    """Opens the node, opens it again when it was lost, and never moves anything by itself."""

    def __init__(self, connect: Callable[[], Device], place: str) -> None:
        """`place` is the bus and the node, for messages."""
        self._connect = connect
        self._place = place
        self._jobs: queue.PriorityQueue[_Entry] = queue.PriorityQueue()
        self._numbers = itertools.count()
        self._ordered: set[Future[Any]] = set()
        self._order: Order | None = None
        """Of the job that runs; None for one that changes nothing."""
        self._stops = 0
        self._withdrawn = ""
        self._end = threading.Event()
        self._measured: set[int] = set()
        """Axes that a job moves."""
        self._stopped: set[int] = set()
        """Of these, the ones that a stop has ended."""
        self._why: str | None = None
        self._unfinished = False
        """The link was lost while an axis was enabled here, or while a job moved one."""
        self._rejoin_until_s = 0.0
        self._lock = threading.Lock()
        self._stop_frames: StopFrames | None = None
        self._device: Device | None = None
        self._stream: SignalStream | RecordedSignals | None = None
        self._missing_before = 0
        """Samples that earlier streams have missed."""
        self._held: dict[int, HeldAxis] = {}
        self._choice = "both"
        self._was_operational = False
        self._busy = ""
        self._faults: FaultTable = find_faults([])
        self._emergencies: deque[tuple[int, int]] = deque(maxlen=32)
        self._commander_seen_s: float | None = None
        self._axes: list[dict[str, Any]] = []
        self._axes_s = 0.0
        """When they were read."""
        self._start_asked = False
        self._run_id = time.time_ns()
        """Of this server, which counts its events."""
        self._events: deque[dict[str, Any]] = deque(maxlen=100)
        self._event_count = 0
        self._link = {"up": False, "text": f"connecting to {place} …"}
        self._node: dict[str, Any] = {}
        self._limits: list[dict[str, Any]] = []
        self._load: BusLoad | None = None
        self.recorder: Recorder | None = None
        """Takes all samples; used by the jobs."""
        self.loops: dict[int, MeasuredLoop] = {}
        """Measured last, by axis; used by the jobs."""
        self.scope: capture.Run | None = None
        """Armed or done, and not yet read; used by the jobs."""
        self.commissioning: dict[str, Any] | None = None
        """The step that runs: for the page; set by the jobs."""
        self._scope_phase = ""
        self._camera: tracking.CameraMapping | None = None
        self._polled_s = 0.0
        self._opened_s = self._operational_s = 0.0
        self._no_stream = ""
        self._camera_polled_s = 0.0
        self._settings_polled_s = 0.0
        self._settings_turn = 0
        self._sets: list[list[int] | None] = [None] * len(AXES)
        """CRCs of the active and the stored set of each axis, and whether values are staged."""
        self._tracking: dict[str, Any] | None = None
        self._threads = [
            threading.Thread(target=target, name=name, daemon=True)
            for target, name in ((self._run, "bus"), (self._supervise, "supervision"))
        ]

    # --- from any thread ------------------------------------------------------------------------------------------

    def start(self) -> None:
        """Begins to work on the bus."""
        for thread in self._threads:
            thread.start()

    def close(self) -> None:
        """Stops what was enabled or ordered here, restores what was borrowed, and ends."""
        if self.anything_held:
            self.stop("the server ends")
        self._end.set()
        self._put(None)
        for thread in self._threads:
            thread.join(timeout=15.0)
        self.end_recording()

    def stop(self, why: str) -> None:
        """Quick stop of both axes, at once; what was ordered before it and waits is refused. Without a connection to the node
        it is kept until there is one."""
        self._withdraw(f"the axes were stopped before its turn came ({why})")
        device, frames = self._device, self._stop_frames
        if device is not None:
            device.stopped.set()
        if frames is not None:
            frames.send()
        with self._lock:
            self._why = why
            self._stopped |= self._measured
        self._put(None)
        if device is None:
            self.say(f"{why}: there is no connection to the node; the axes are stopped as soon as there is one", "bad")

    def _withdraw(self, why: str) -> None:
        """No order from before now is carried out."""
        with self._lock:
            self._stops += 1
            self._withdrawn = why

    def order(self, stands: Callable[[], bool] = lambda: True) -> Order:
        """For a job that is ordered now; take it before anything else can stop the axes."""
        return Order(self._stops, stands)

    def submit(self, job: Job, order: Order | None = None) -> Future[Any]:
        """Runs in the thread of the bus. With an order it is refused when its turn comes after a later stop, or when the
        order does not stand any more; without one it must change nothing, and waits for all orders."""
        return self._put(job, order)

    def _put(self, job: Job | None, order: Order | None = None) -> Future[Any]:
        future: Future[Any] = Future()
        if order is not None:
            self._ordered.add(future)
            future.add_done_callback(self._ordered.discard)
        self._jobs.put(_Entry(order, next(self._numbers), job, future))
        return future

    def jog_held(self, axis: int) -> None:
        """The page says that the button is still held."""
        held = self._held.get(axis)
        if held is not None and held.jog_seen_s is not None:
            held.jog_seen_s = time.monotonic()

    def commander_seen(self, present: bool = True) -> None:
        """The page that commands is there, or nobody commands any more."""
        self._commander_seen_s = time.monotonic() if present else None

    @property
    def commander_is_silent(self) -> bool:
        """The page that commands has said nothing for so long that what it held was stopped."""
        seen = self._commander_seen_s
        return seen is None or time.monotonic() - seen > COMMANDER_SILENT_S

    @property
    def anything_held(self) -> bool:
        """The page has enabled an axis, measures on one, or has ordered something that is not done yet."""
        return bool(self._held or self._busy or self._ordered)

    def say(self, text: str, kind: str = "note") -> None:
        """An event for all viewers; `kind` is note, good or bad."""
        text = of_page(text)
        with self._lock:
            self._event_count += 1
            self._events.append(
                {"run": self._run_id, "number": self._event_count, "time": time.time(), "text": text, "kind": kind}
            )

    def busy(self, text: str) -> None:
        """What the thread of the bus does for a longer time."""
        self._busy = text

    def measured(self, axis: int, rate_rad_s: float | None, text: str) -> None:
        """Of a job that measures: it has the rate of its axis, which is enabled, and nothing else is read meanwhile."""
        self.busy(text)
        rate_deg_s = None if rate_rad_s is None else degrees(rate_rad_s)
        moving = {"state": power.ENABLED, "rate_deg_s": rate_deg_s, "doing": f"is measured: {text}"}
        self._axes_s = time.monotonic()
        self._axes = [found | UNREAD | (moving if found["axis"] == AXES[axis] else {}) for found in self._axes]
        if self._load is not None:
            self._load.update()

    def look_after(self, device: Device) -> None:
        """Of a job that computes, ten times a second: the states stay fresh. Raises MotionError after a stop, and in a job that
        changes nothing when an order waits for it."""
        self.refresh(device)
        if device.stopped.is_set():
            raise MotionError("left, because the axes were stopped.")
        if self._order is None and self._ordered:
            raise MotionError("left, because the page that commands has given an order: ask again.")

    def events(self, after: int) -> list[dict[str, Any]]:
        """Those with a number above `after`."""
        with self._lock:
            return [event for event in self._events if event["number"] > after]

    def state(self) -> dict[str, Any]:
        """Everything that is known now."""
        load, scope, recorder = self._load, self.scope, self.recorder
        with self._lock:
            stream, missing = self._stream, self._missing_before
        signals = stream.signals if stream else ()
        return {
            "link": self._link,
            "node": self._node,
            "axes": self._axes,
            "axes_age_s": time.monotonic() - self._axes_s,
            "sets": self._sets,
            "tracking": self._tracking,
            "recording": {"name": recorder.path.name, "samples": recorder.samples, "error": recorder.error} if recorder else None,
            "scope": {"phase": self._scope_phase, "waited_s": scope.waited_s, "captured_s": scope.captured_s} if scope else None,
            "stream": {
                "choice": self._choice, "choices": list(SETS), "period_ms": stream.period_ms if stream else 0,
                "missing": missing + (stream.missing if stream else 0), "signals": [_signal(signal) for signal in signals],
                "note": stream.note if stream else "",
            },
            "commissioning": self.commissioning, "busy": self._busy, "load": load.share if load else 0.0,
        }  # fmt: skip

    @property
    def connected(self) -> bool:
        """The node answers."""
        return bool(self._link["up"])

    def start_when_found(self) -> None:
        """NMT start at the next attempt to connect: a node that is stopped answers nothing else."""
        self._start_asked = True

    def samples(self) -> Samples | None:
        """What has come since the last call."""
        stream, recorder = self._stream, self.recorder
        samples = stream.take() if stream is not None else None
        if recorder is not None and samples is not None and len(samples.ticks):
            recorder.add(samples)
        return samples

    # --- supervision ------------------------------------------------------------------------------------------------

    def _supervise(self) -> None:
        """Ends motions whose page is silent, whatever the thread of the bus waits for."""
        while not self._end.wait(STEP_S):
            try:
                self._end_silent_motions()
            except Exception as error:  # noqa: BLE001 - the page shows it, and the thread goes on
                self.stop(internal(error))
                self._end.wait(COMMANDER_SILENT_S)

    def _end_silent_motions(self) -> None:
        now = time.monotonic()
        for axis, held in list(self._held.items()):
            seen = held.jog_seen_s
            if seen is None:
                continue
            if now - seen > 2 * JOG_SILENT_S:
                self.stop(f"{AXES[axis]} jogged, and the page is silent")
                held.jog_seen_s = None
            elif now - seen > JOG_SILENT_S:
                self.submit(partial(Jobs.release, axis=axis), self.order())
        seen = self._commander_seen_s
        if seen is not None and self.anything_held and now - seen > COMMANDER_SILENT_S:
            self._commander_seen_s = None
            self.stop("the page that commands is silent")

    # --- the thread of the bus ------------------------------------------------------------------------------------

    def _run(self) -> None:
        while not self._end.is_set():
            try:
                with self._connect() as device:
                    if self._start_asked:
                        self._start_asked = False
                        device.set_nmt("operational")
                    self._serve(device)
            except Exception as error:  # noqa: BLE001 - the page shows it, and the thread goes on
                self._lost(error)
            self._pause(RETRY_S)

    def _lost(self, error: BaseException) -> None:
        text = str(error) if isinstance(error, ServoctlError | can.CanError | OSError | RuntimeError) else internal(error)
        if self._link["up"]:
            self.say(f"connection lost: {text}", "bad")
        self._link = {"up": False, "text": text, "stopped": isinstance(error, NodeStopped)}
        self._axes = []

    def _pause(self, seconds: float) -> None:
        """Until the next attempt; jobs are refused meanwhile."""
        end = time.monotonic() + seconds
        while not self._end.is_set() and (left := end - time.monotonic()) > 0:
            with contextlib.suppress(queue.Empty):
                entry = self._jobs.get(timeout=left)
                if entry.job is not None and entry.future.set_running_or_notify_cancel():
                    entry.future.set_exception(ConnectionFailed(f"no connection: {self._link['text']}"))

    def _serve(self, device: Device) -> None:
        try:
            identity = device.identity()
        except ConnectionFailed as error:
            if str(device.node.nmt.state).lower() == "stopped":
                raise NodeStopped(f"node {device.node_id} is stopped by NMT: it answers nothing until it is started.") from error
            raise
        frames = StopFrames(device)
        load = BusLoad(_bit_rate(device))
        if device.network.notifier is not None:
            device.network.notifier.add_listener(load)
        device.network.subscribe(0x80 + device.node_id, self._take_emergency)
        self._faults = find_faults([device.any_schema.source])
        self._held = {}
        self.scope = None
        self._camera_polled_s = 0.0
        self._tracks = all(tracking.is_supported(device, axis) for axis in range(len(AXES)))
        self._withdraw("the node was connected only after it was ordered")
        with self._lock:
            self._why = "the link was lost" if self._unfinished else self._why
        if self._why is not None:
            self._stop_at_once(device, frames)
        jobs = Jobs(self, device, self._held)
        self._read_node(device, identity)
        self._device, self._stop_frames, self._load = device, frames, load
        self._link = {"up": True, "text": f"{self._place}"}
        self.say(f"connected to {self._place}", "good")
        if not frames.complete:
            self.say("a master has mapped RPDO1 or RPDO2: a stop goes by SDO, one axis after the other", "bad")
        try:
            self._start_again(device)
            if self._camera is not None:  # the link was lost while an axis followed
                self._camera.move_to(device)
                self._unmap_camera()
            self._open_stream(device)
            self._loop(device, jobs)
        except BaseException as error:
            self._lost(error)
            if self._held:
                frames.send()
            if isinstance(error, ConnectionFailed | can.CanError | OSError):
                device.give_up(str(self._link["text"]))
            self._device = None
            self._unfinished = self._unfinished or bool(self._held)
            with self._lock:
                self._stopped |= self._held.keys()
            self._leave_all(error)
            raise
        else:
            self._leave_all(MotionError("the server ends"))
            self._unmap_camera()
        finally:
            self._device = self._stop_frames = None
            self._close_stream()

    def _stop_at_once(self, device: Device, frames: StopFrames) -> None:
        """What has moved since the link was lost, or was to be stopped while there was none; the SDOs follow. The node misses our
        heartbeat nevertheless, and is then pre-operational."""
        for axis in range(len(AXES)):
            frames.note_mode(axis, Drive(device, axis).mode_number())
        frames.send()
        if self._unfinished:
            self._unfinished = False
            self._rejoin_until_s = time.monotonic() + REJOIN_S

    def _start_again(self, device: Device) -> None:
        """A node that we have seen operational sends samples again; after a lost heartbeat it is pre-operational. Its axes
        are off, or in a fault that has to be reset."""
        state = device.nmt_state()
        if state == "pre-operational" and self._was_operational:
            device.set_nmt("operational")
            self.say("the node is operational again: it sends samples; nothing moves")

    def _loop(self, device: Device, jobs: Jobs) -> None:
        stepped = 0.0
        while not self._end.is_set() or self._why:
            if self._why:
                self._stop_now(device)
            now = time.monotonic()
            self.refresh(device)
            if self._held and now - stepped >= STEP_S:
                self._step_all()
                stepped = now
            if self._camera is not None and not self._follows():
                self._unmap_camera()
            self._work(jobs, STEP_S if self._held else POLL_S)
            for axis, held in self._held.items():
                if self._stop_frames is not None:
                    self._stop_frames.note_mode(axis, held.live.mode)

    def _work(self, jobs: Jobs, wait_s: float) -> None:
        try:
            entry = self._jobs.get(timeout=wait_s)
        except queue.Empty:
            return
        job, order, future = entry.job, entry.order, entry.future
        if job is None or not future.set_running_or_notify_cancel():
            return
        self._order = order
        try:
            self._check(order)
            future.set_result(job(jobs))
        except (ConnectionFailed, can.CanError, OSError) as error:
            if isinstance(error, OSError) and is_of_a_file(error):
                future.set_exception(error)
                return
            self._unfinished = self._unfinished or order is not None
            future.set_exception(error)
            raise
        except Exception as error:  # noqa: BLE001 - the page shows it
            future.set_exception(error)

    def _check(self, order: Order | None) -> None:
        """Its turn has come; raises MotionError when nobody wants it any more."""
        with self._lock:
            stops, why = self._stops, self._withdrawn
        if order is not None and order.stops != stops:
            raise MotionError(f"not done: {why}.")
        if order is not None and not order.stands():
            raise MotionError("not done: the page that ordered it no longer commands.")

    def _stop_now(self, device: Device) -> None:
        """The axes to rest, after the frames of `stop`; then enabling is allowed again."""
        with self._lock:
            why, self._why = self._why, None
            stopped, self._stopped = self._stopped, set()
        moving = self._moving(device, stopped)
        self._leave_all(MotionError(f"stopped: {why}"))
        for axis in range(len(AXES)):
            try:
                Drive(device, axis).quick_stop()
            except MotionError as error:  # the other axis is stopped, too
                self.say(str(error), "bad")
            except BaseException:  # the link is lost: the stop waits for it
                with self._lock:
                    self._why = self._why or why
                    self._stopped |= stopped
                raise
        device.stopped.clear()
        what = f"{' and '.join(moving)} stopped and off" if moving else "nothing was enabled"
        self.say(f"stop: {why}; {what}", "bad" if moving else "note")

    def _moving(self, device: Device, stopped: set[int]) -> list[str]:
        """Names of the axes that a stop finds enabled, for people."""
        found = []
        for axis, name in enumerate(AXES):
            with contextlib.suppress(ServoctlError, can.CanError, OSError):  # the stop itself comes next
                if axis in self._held or axis in stopped or Drive(device, axis).state() in (power.ENABLED, QUICK_STOP_ACTIVE):
                    found.append(name)
        return found

    def _leave_all(self, error: BaseException | None) -> None:
        for axis in list(self._held):
            self.leave(axis, error)

    def leave(self, axis: int, error: BaseException | None = None) -> Exception | None:
        """An axis is no longer held, whatever happens; an error is an event, and the result."""
        held = self._held.pop(axis)
        try:
            with deaf():
                held.leave(error)
        except (ServoctlError, can.CanError, OSError) as failed:
            self.say(str(failed), "bad")
            return failed
        except Exception as failed:  # noqa: BLE001 - the other axis is left too
            self.say(internal(failed), "bad")
            return failed
        return None

    def _step_all(self) -> None:
        for axis, held in list(self._held.items()):
            if self._why is not None:
                return  # the stop comes next, and leaves them
            try:
                held.step()
            except MotionError as error:
                if self._why is not None:
                    return
                self.say(str(error), "bad")
                self.leave(axis, error)

    # --- what is read regularly -----------------------------------------------------------------------------------

    def _take_emergency(self, _identifier: int, data: bytearray, _time: float) -> None:
        if len(data) >= 5:
            self._emergencies.append((int.from_bytes(data[:2], "little"), data[4] << 8 | data[3]))

    def _read_node(self, device: Device, identity: dict[str, Any]) -> None:
        self._limits = [limits_data(read_limits(Drive(device, axis))) for axis in range(len(AXES))]
        self._node = {
            **{key: identity[key] for key in ("node", "name", "firmware", "software", "serial")},
            "schema_fits": device.schema_fits, "mismatch": "" if device.schema_fits else device.mismatch,
        }  # fmt: skip

    def refresh(self, device: Device) -> None:
        """States of the axes, if they are old; raises ConnectionFailed when the node is silent."""
        now = time.monotonic()
        if now - self._polled_s >= POLL_S:
            self._poll(device)
            self._polled_s = now

    def _poll_settings(self, device: Device) -> None:
        """Limits and parameter set of one axis, the axes in turn: another tool may change them. Not while an axis is held, which
        every transfer keeps waiting."""
        now = time.monotonic()
        if self._held or now - self._settings_polled_s < SETTINGS_POLL_S:
            return
        self._settings_polled_s = now
        axis = self._settings_turn = (self._settings_turn + 1) % len(AXES)
        self._limits[axis] = limits_data(read_limits(Drive(device, axis)))
        found = set_state(device, axis)
        self._sets[axis] = [found.active_crc, found.stored_crc, found.staged_differs] if found else None

    def _poll(self, device: Device) -> None:
        """States of the axes by SDO; raises ConnectionFailed when the node is silent."""
        nmt = str(device.node.nmt.state).lower()
        self._poll_settings(device)
        axes = []
        for axis in range(len(AXES)):
            found = read_axis(device, axis)
            held = self._held.get(axis)
            words = self._faults.words(found["error"]) if found["error"] else []
            axes.append(found | {
                "held": held is not None, "doing": held.doing if held else self._doing(axis, found["state"]), "limits": self._limits[axis],
                "fault": self._faults.meaning(found["error"]) if found["error"] else "",
                "cause": words[0].cause if words else "", "cure": words[0].cure if words else "",
                "restriction": self._restriction(device, axis),
            })  # fmt: skip
            if self._stop_frames is not None:
                self._stop_frames.note_mode(axis, Drive(device, axis).mode_number())
        self._axes, self._axes_s = axes, time.monotonic()
        if nmt == "pre-operational" and self._held and self._why is None:
            self.stop("the node left 'operational', where an axis can be stopped at once")
        self._poll_camera(device)
        self._scope_phase = self.scope.poll() if self.scope is not None else ""
        self._node = self._node | {"nmt": nmt}
        self._watch_stream(device, nmt)
        self._was_operational = self._was_operational or nmt == "operational"
        if nmt == "pre-operational" and time.monotonic() < self._rejoin_until_s:
            self._start_again(device)
        if self._load is not None:
            self._load.update()
        while self._emergencies:
            code, info = self._emergencies.popleft()
            if code:
                words = self._faults.reported(code, info)
                self.say(f"emergency {code:04X}: {' or '.join(w.name for w in words) or self._faults.meaning(code)}", "bad")

    def _doing(self, axis: int, state: str) -> str:
        """Of an axis that a job moves or holds, for people."""
        step = self.commissioning
        if step is None or state != power.ENABLED:
            return ""
        return str(step["what"]) if step["axis"] == AXES[axis] else "is held meanwhile"

    @staticmethod
    def _restriction(device: Device, axis: int) -> str:
        return (restrictions.reason(device, axis) or "") if device.schema_fits else ""

    # --- the camera -----------------------------------------------------------------------------------------------

    def _follows(self) -> bool:
        return any(held.follows for held in self._held.values())

    def map_camera(self, device: Device, identifier: int | None) -> None:
        """RPDO4 takes the frames until no axis follows any more; nothing changes without an identifier."""
        self._unmap_camera()
        camera = tracking.CameraMapping(device, identifier)
        camera.__enter__()
        self._camera = camera

    def _unmap_camera(self) -> None:
        if self._camera is not None:
            self._camera.__exit__(None, None, None)
            self._camera = None

    def _poll_camera(self, device: Device) -> None:
        now = time.monotonic()
        if not self._tracks:
            self._tracking = None
        elif self._follows() or now - self._camera_polled_s >= CAMERA_POLL_S:
            self._camera_polled_s = now
            delay = tracking.delay_estimate(device)
            self._tracking = {
                "states": [tracking.STATES[tracking.state_of(Drive(device, axis))] for axis in range(len(AXES))],
                "frames": asdict(tracking.frame_counts(device)), "delay": asdict(delay) if delay else None,
                "note": tracking.picture_text(device) or tracking.return_text(device)[1], "follows": self._follows(),
            }  # fmt: skip

    # --- the stream -----------------------------------------------------------------------------------------------

    def record(self, device: Device) -> str:
        """All samples from now on go to a file of the folder of recordings; its name. A lost link is a gap in it."""
        if self.recorder is not None:
            raise MotionError(f"{self.recorder.path.name} is being recorded: end it first.")
        if self._stream is None:
            raise MotionError("there are no samples to record: the live view is off.")
        path = recording.folder() / time.strftime("recording-%Y%m%dT%H%M%SZ.mcap", time.gmtime())
        about = {key: self._node[key] for key in ("name", "node", "serial", "firmware")}
        self.recorder = Recorder(path, self._stream.signals, self._stream.period_ms, about)
        self.say(f"recording to {path}", "good")
        return path.name

    def end_recording(self) -> str:
        """Ends the file; its name."""
        recorder, self.recorder = self.recorder, None
        if recorder is None:
            return ""
        recorder.close()
        self.say(recorder.error or f"{recorder.samples} samples recorded to {recorder.path}", "bad" if recorder.error else "good")
        return recorder.path.name

    def choose(self, device: Device, choice: str) -> None:
        """Other signals."""
        if choice not in SETS:
            raise InputError(f"there is no choice of signals '{choice}'.")
        if self.recorder is not None and choice != self._choice:
            raise MotionError("these signals are being recorded: end the recording before you choose others.")
        if choice == self._choice and self._stream is not None:
            return
        self._close_stream()
        self._choice = choice
        self._open_stream(device)

    @contextlib.contextmanager
    def without_stream(self, device: Device, modes: dict[int, int]) -> Iterator[None]:
        """For a job that borrows the same PDOs, and moves axes in these modes (6060). Raises MotionError during a recording,
        which would have a hole."""
        if self.recorder is not None:
            raise MotionError("the live view is being recorded, and this would leave a hole in it: end the recording first.")
        self._close_stream()
        if str(device.node.nmt.state).lower() != "operational":
            device.set_nmt("operational")  # stays so, as when an axis is enabled: the samples go on after the job
        if self._stop_frames is not None:
            for axis, mode in modes.items():
                self._stop_frames.note_mode(axis, mode)
        self.busy("measures")
        self._axes = [found | UNREAD for found in self._axes]
        self._measured = set(modes)
        try:
            yield
        except BaseException:
            try:
                self._measured_all(device)
            except (ConnectionFailed, can.CanError, OSError):  # shows by itself, and hides no error of the job
                self._unfinished = True
            except ServoctlError:
                pass
            raise
        else:
            self._measured_all(device)

    def _measured_all(self, device: Device) -> None:
        self._measured = set()
        self.busy("")
        self._close_stream()
        self._open_stream(device)

    def show(self, signals: RecordedSignals) -> None:
        """Within `without_stream`: what the job records, in place of the stream."""
        self._stream = signals

    def _open_stream(self, device: Device) -> None:
        try:
            stream = SignalStream(device, self._choice)
            stream.__enter__()
        except (MotionError, InputError, Refused) as error:
            if str(error) != self._no_stream:
                self.say(f"no plot: {error}", "bad")
            self._no_stream = str(error)
            return
        finally:
            self._opened_s = time.monotonic()
        self._no_stream = ""
        stream.start()
        self._stream = stream

    def _watch_stream(self, device: Device, nmt: str) -> None:
        """A node that was reset has its own TPDOs again; the stream that another program had may be free."""
        now = time.monotonic()
        stream = self._stream
        if nmt != "operational":
            self._operational_s = now
        elif stream is None and now - self._opened_s > STREAM_SILENT_S:
            self._open_stream(device)
        elif isinstance(stream, SignalStream) and min(stream.silent_s, now - self._operational_s) > STREAM_SILENT_S:
            self.say("no samples come, although the node is operational: it was reset, or its TPDOs were changed; they are mapped again", "bad")
            self._close_stream()
            self._open_stream(device)

    def _close_stream(self) -> None:
        with self._lock:
            stream, self._stream = self._stream, None
            self._missing_before += stream.missing if stream else 0
        if isinstance(stream, SignalStream):
            with contextlib.suppress(ServoctlError, can.CanError, OSError, RuntimeError):
                stream.__exit__(None, None, None)


def is_of_a_file(error: OSError) -> bool:
    """Not of the bus: a file that cannot be written, or a full disk."""
    return error.filename is not None or error.errno in (errno.ENOSPC, errno.EDQUOT, errno.EROFS, errno.EFBIG)


def file_error(error: OSError) -> str:
    """A sentence on it."""
    return f"{error.filename or 'a file'}: cannot be written or read: {error.strerror}."


def internal(error: BaseException) -> str:
    """A sentence on an error of servoctl itself."""
    return f"internal error of servoctl: {error!r}."


def _signal(signal: Signal) -> dict[str, Any]:
    return {"name": signal.name, "unit": signal.unit, "plot": signal.plot, "axis": signal.axis}
