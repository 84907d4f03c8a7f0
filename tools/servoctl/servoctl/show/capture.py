# SPDX-License-Identifier: Apache-2.0
"""The device's scope: its set-up, and the decoding of a capture.

Objects 0x3000 (set-up), 0x3001 (capture), 0x3002 (names of the signals); layout of a capture as in
firmware/commissioning/scope.h: header, then frames of 32-bit words, little endian.
"""

from __future__ import annotations

import difflib
import math
import struct
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..errors import InputError, Refused
from ..link.device import Device
from ..units import TICK_S

SET_UP, DATA, NAMES = 0x3000, 0x3001, 0x3002
COMMAND, STATE, DIVIDER, PRETRIGGER, TRIGGER, TRIGGER_CHANNEL, LEVEL, FRAMES, CHANNELS, FIRST_SIGNAL = range(1, 11)
ARM, STOP, FORCE = 1, 2, 3
MAX_CHANNELS = 8
WORDS = 8192
PHASES = ("idle", "filling", "waiting for the trigger", "triggered", "done")
TRIGGERED, DONE = 3, 4
TRIGGERS = ("now", "above", "below", "rising", "falling", "state", "fault")
LEVEL_TRIGGERS = ("above", "below", "rising", "falling")

_HEADER = struct.Struct("<4s7I")
_KINDS = ("<f4", "<i4", "<u4")


@dataclass(frozen=True)
class Capture:
    """Signals by name over `time_s`, which is 0 at the trigger (at the start when none came)."""

    time_s: NDArray[np.float64]
    traces: dict[str, NDArray[np.float64]]
    triggered: bool


def signal_names(device: Device) -> dict[int, str]:
    """Names of the signals by number, as reported by the device; raises Refused when it has no scope."""
    try:
        count = device.upload(NAMES, 0)[0]
    except Refused as error:
        raise Refused("this device has no scope (objects 0x3000 to 0x3002).", error.abort) from error
    return {n: device.upload(NAMES, n).rstrip(b"\0").decode("ascii", errors="replace") for n in range(1, count + 1)}


UNITS = {"rad_s": "rad/s", "nm": "N m", "a": "A", "rad": "rad", "v": "V"}
"""Of the endings of the signals' names."""


def unit_of(name: str) -> str:
    """The unit at the end of a signal's name, as in azimuth.torque_nm."""
    return next((unit for ending, unit in UNITS.items() if name.endswith("_" + ending)), "")


def without_unit(name: str) -> str:
    """azimuth.torque of azimuth.torque_nm."""
    return next((name.removesuffix("_" + ending) for ending in UNITS if name.endswith("_" + ending)), name)


def find_signal(names: dict[int, str], text: str) -> int:
    """The number of a name, with or without its unit, of a unique part of it, or of a number; raises InputError with
    suggestions."""
    if text.isascii() and text.isdigit() and int(text) in names:
        return int(text)
    exact = [n for n, name in names.items() if text in (name, without_unit(name))]
    part = [n for n, name in names.items() if text in name]
    if len(exact or part) == 1:
        return (exact or part)[0]
    close = [without_unit(names[n]) for n in part] or difflib.get_close_matches(
        text, [without_unit(name) for name in names.values()], n=3, cutoff=0.5
    )
    hint = f"; did you mean {' or '.join(close[:4])}?" if close else "; 'servoctl scope --list' lists the signals."
    raise InputError(f"no unique signal '{text}'{hint}")


def set_up(
    device: Device, signals: list[int], divider: int, pretrigger: int, trigger: str, channel: int, level: float
) -> None:
    """Writes the set-up and arms; `divider` in ticks of 1 ms, `pretrigger` in frames, `level` in the signal's unit."""
    device.write_int(SET_UP, COMMAND, STOP, 1)
    device.write_int(SET_UP, CHANNELS, len(signals), 1)
    for position, signal in enumerate(signals):
        device.write_int(SET_UP, FIRST_SIGNAL + position, signal, 1)
    device.write_int(SET_UP, DIVIDER, divider, 2)
    device.write_int(SET_UP, PRETRIGGER, pretrigger, 2)
    device.write_int(SET_UP, TRIGGER, TRIGGERS.index(trigger), 1)
    device.write_int(SET_UP, TRIGGER_CHANNEL, channel, 1)
    device.download(SET_UP, LEVEL, struct.pack("<f", level), "scope trigger level")
    device.write_int(SET_UP, COMMAND, ARM, 1)


def capacity(channels: int) -> int:
    """Frames that fit for this number of channels."""
    return WORDS // channels


def parse_capture(data: bytes, names: dict[int, str]) -> Capture:
    """Raises InputError when the bytes are no capture."""
    if len(data) < _HEADER.size:
        raise InputError(f"invalid capture: {len(data)} bytes, but its header alone has {_HEADER.size}.")
    magic, version, header, channels, frames, trigger, divider, tick_ns = _HEADER.unpack_from(data)
    if magic != b"TSSC" or version != 1:
        raise InputError(f"invalid capture: unknown format ({magic!r}, version {version}).")
    expected = header + 4 * channels * frames
    if not 1 <= channels <= MAX_CHANNELS or len(data) != expected:
        raise InputError(f"invalid capture: {len(data)} bytes instead of {expected}.")
    described = [struct.unpack_from("<II", data, _HEADER.size + 8 * i) for i in range(channels)]
    words = np.frombuffer(data, dtype="<u4", offset=header).reshape(frames, channels)
    traces = {
        names.get(number, f"signal {number}"): np.ascontiguousarray(words[:, i]).view(_KINDS[kind]).astype(np.float64)
        for i, (number, kind) in enumerate(described)
    }
    triggered = trigger < frames
    time_s = (np.arange(frames) - (trigger if triggered else 0)) * divider * tick_ns * 1e-9
    return Capture(time_s, traces, triggered)


@dataclass(frozen=True)
class Request:
    """A capture as a person asks for it: signals by number, `divider` in ticks, numbers of frames."""

    signals: list[int]
    divider: int
    wanted: int
    before: int
    all: int
    cut: bool
    trigger: str
    on: int
    level: float

    @property
    def period_s(self) -> float:
        """From frame to frame."""
        return self.divider * TICK_S

    @property
    def seconds_after(self) -> float:
        """From the trigger to the end of what is wanted."""
        return (self.wanted - self.before) * self.period_s


def request(
    names: dict[int, str], signals: list[int], rate_hz: float, duration_s: float | None, pre_s: float, trigger: str,
    on: int | None, level: float,
) -> Request:  # fmt: skip
    """`on` is the signal that triggers, the first one by default, `level` in its SI unit; raises InputError."""
    if not 1 <= len(signals) <= MAX_CHANNELS:
        raise InputError(f"expected 1 to {MAX_CHANNELS} signals; 'servoctl scope --list' lists them.")
    on = signals[0] if on is None else on
    if on not in signals:
        raise InputError(f"the trigger signal {names[on]} must be one of the captured signals.")
    if trigger not in TRIGGERS:
        raise InputError(f"unknown trigger '{trigger}': expected one of {', '.join(TRIGGERS)}.")
    if not 0.0 < rate_hz <= 1000.0 or not math.isfinite(level) or pre_s < 0.0 or (duration_s is not None and duration_s <= 0.0):
        raise InputError("expected a rate up to 1000 Hz, a length above 0, a time before the trigger, and a finite level.")
    divider = max(1, round(1000.0 / rate_hz))
    frames = capacity(len(signals))
    before = round(pre_s * 1000.0 / divider)
    wanted = min(frames, round(duration_s * 1000.0 / divider)) if duration_s else frames
    if before >= wanted:
        raise InputError(f"the time before the trigger, {pre_s:g} s, must be shorter than the capture of {wanted * divider / 1000:g} s.")
    return Request(signals, divider, wanted, before, frames, duration_s is not None, trigger, signals.index(on), level)


class Run:
    """A capture in the device, from arming to reading; times by the node's clock. It needs no attention in between."""

    def __init__(self, device: Device, wanted: Request) -> None:
        self.wanted = wanted
        self._device = device
        self._triggered_s: float | None = None
        set_up(device, wanted.signals, wanted.divider, wanted.before, wanted.trigger, wanted.on, wanted.level)
        self._begun_s = device.clock.now()
        self.captured_s = 0.0
        """Since the trigger."""
        self.waited_s = 0.0
        """Since it was armed."""

    def poll(self) -> str:
        """The phase, one of PHASES; ends the capture when what is wanted is there."""
        phase = self._device.read_int(SET_UP, STATE)
        now = self._device.clock.now()
        self.waited_s = now - self._begun_s
        if phase == TRIGGERED:
            self._triggered_s = self._triggered_s or now
            self.captured_s = now - self._triggered_s
            wanted = self.wanted
            if wanted.wanted < wanted.all and self.captured_s > wanted.seconds_after + 0.05:
                self.stop()
        return PHASES[min(phase, DONE)]

    def force(self) -> None:
        """The trigger, now."""
        self._device.write_int(SET_UP, COMMAND, FORCE, 1)

    def stop(self) -> None:
        """Ends it with what has been captured."""
        self._device.write_int(SET_UP, COMMAND, STOP, 1)

    def read(self, names: dict[int, str]) -> Capture:
        """What was wanted of it; takes a second, and waits while an axis moves."""
        whole = parse_capture(self._device.upload_block(DATA, 0, "scope data"), names)
        if not self.wanted.cut:
            return whole
        start = max(0, int(np.searchsorted(whole.time_s, -1e-9)) - self.wanted.before) if whole.triggered else 0
        keep = slice(start, start + self.wanted.wanted)
        return Capture(whole.time_s[keep], {name: trace[keep] for name, trace in whole.traces.items()}, whole.triggered)
