# SPDX-License-Identifier: Apache-2.0
"""Tracking in mode -1 as a client sees it: the camera's PDO, its counters, and the states (docs/can.md)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from ..drive import power
from ..drive.drive import Drive
from ..errors import InputError, MotionError
from ..link.device import Device
from ..link.pdo_loan import PdoLoan
from ..objects.parameter import AXIS_SHIFT
from ..units import degrees, is_plain
from .live import LiveAxis

SUPPORTED_BIT = 16
"""Of 6502: mode -1."""

NOT_TRACKING, SEARCHING, ACQUIRING, ON_TARGET, COASTING, LOST, PICTURE_WRONG = range(7)
STATES = ("not tracking", "searching", "acquiring", "tracking", "coasting", "lost", "wrong picture")
"""By the value of 3072:5 and :6."""

DROPS = {
    1: "they are not newer than the one before: does a second camera send, too?",
    2: "they are older than 127 ms when they arrive",
    3: "they were exposed later than now: does 3071:5 fit the sender's time?",
    4: "their quality is above 100 %",
    5: "the node's clock (1013) was set while they were under way, so that their time can be meant in two ways",
    6: "its picture is frozen: the target's place in it does not change while the axes move; restart the image processor",
    7: "its picture is turned or mirrored, or does not answer (3072:9); 'servoctl camera calibrate' measures and corrects it",
    8: "their errors are at the end of 16 bits, or above 3.14, a target 72° off: does 3071:1 fit the unit of 3070:1 and 3070:2?",
    9: "their errors jump to and fro from frame to frame: has the image processor lost its target, or does it take turns"
    " between two?",
    10: "they are far from those around them, one at a time: does the image processor take something else for its target?",
}
"""Why a frame does not count, by 3072:4."""
UNKNOWN_INTERVAL = 65535
FIRST_FRAME_S = 1.0
"""Frames come at 10 Hz at least."""

RPDO = 3
FRAME = [0x3070 << 16 | sub << 8 | bits for sub, bits in enumerate((16, 16, 16, 8, 8), start=1)]
"""Objects of a camera frame, as they are mapped."""


def is_supported(device: Device, axis: int) -> bool:
    """The node has mode -1."""
    data = device.try_upload(0x6502 + AXIS_SHIFT * axis)
    return data is not None and bool(int.from_bytes(data, "little") >> SUPPORTED_BIT & 1)


def check_supported(device: Device, axis: int) -> None:
    """Raises MotionError for a node without mode -1."""
    if not is_supported(device, axis):
        raise MotionError(
            f"node {device.node_id} has no mode of operation for tracking (bit {SUPPORTED_BIT} of 6502 is not set):"
            " update its firmware."
        )


class CameraMapping:
    """RPDO4 takes the frames of the camera within a `with` block; nothing changes without an identifier."""

    def __init__(self, device: Device, identifier: int | None) -> None:
        self._loan = PdoLoan(device, 0x1400 + RPDO, 0x1600 + RPDO)
        self._identifier = identifier

    def __enter__(self) -> None:
        if self._identifier is not None:
            try:
                self._loan.take(self._identifier, FRAME, event_ms=0)
            except BaseException:
                self._loan.give_back()
                raise

    def __exit__(self, *_: object) -> None:
        self._loan.give_back()

    def move_to(self, device: Device) -> None:
        """The same node, connected anew."""
        self._loan.move_to(device)


@dataclass(frozen=True)
class FrameCounts:
    """Frames that counted, that were missed, and that were dropped, with the reason of the last one; their age."""

    taken: int
    missed: int
    dropped: int
    last_drop: int
    age_ms: int

    def since(self, before: FrameCounts) -> FrameCounts:
        """What has come after `before`."""
        return FrameCounts(
            self.taken - before.taken, self.missed - before.missed, self.dropped - before.dropped, self.last_drop, self.age_ms
        )


def frame_counts(device: Device) -> FrameCounts:
    """3072:1 to :4 and :7."""
    taken, missed, dropped, last_drop, age_ms = (device.read_int(0x3072, sub) for sub in (1, 2, 3, 4, 7))
    return FrameCounts(taken, missed, dropped, last_drop, age_ms)


def state_of(drive: Drive) -> int:
    """3072:5 or :6."""
    return drive.device.read_int(0x3072, 5 + drive.axis)


UNKNOWN_RETURN_MS = 0xFFFF
_REASONS = ("too fast", "beyond the azimuth's travel", "azimuth turns back")
"""Why the axes are not on the target, by 3075:3."""


def return_text(device: Device) -> tuple[float | None, str]:
    """When the line of sight will be back on a target that is too fast for the axes or beyond their travel (3075:1), in s
    and for a line; None and "" while they follow it, and with firmware that does not predict it."""
    data = device.try_upload(0x3075, 1)
    left_ms = 0 if data is None else int.from_bytes(data, "little")
    if left_ms == 0:
        return None, ""
    state = device.try_upload(0x3075, 3)
    reason = _REASONS[0 if state is None else min(state[0], 2)]
    if left_ms == UNKNOWN_RETURN_MS:
        return None, reason
    return left_ms / 1000, f"{reason}, back in {1e-3 * left_ms:.1f} s"


PICTURE_TURNED = 2
_PICTURES = {
    PICTURE_TURNED: "the camera's picture is turned by {:.0f}° against the axes",
    3: "the axes have stopped: the camera's picture is turned by {:.0f}° against their motion, and would drive them away from the target",
    4: "the axes have stopped: the camera's picture is mirrored, and would drive them away from the target",
    5: "the axes have stopped: the target came no nearer while they moved, and the camera's picture does not answer their motion",
}
"""By 3072:9."""


def picture_text(device: Device) -> str:
    """What is wrong with the picture, by the motion of the axes (3072:9, :10), and the remedy; "" when nothing is known, and
    with firmware that does not judge it."""
    verdict, roll = (device.try_upload(0x3072, sub) for sub in (9, 10))
    if verdict is None or roll is None or verdict[0] not in _PICTURES:
        return ""
    degrees_off = abs(degrees(1e-4 * int.from_bytes(roll, "little", signed=True)))
    return _PICTURES[verdict[0]].format(degrees_off) + ". 'servoctl camera calibrate' measures and corrects it."


@dataclass(frozen=True)
class DelayEstimate:
    """True age of a frame minus its stated age, half of its 95 % interval, and what the node adds, ms; `known` is False while
    the node has no estimate."""

    delay_ms: float
    half_interval_ms: float
    added_ms: int
    known: bool


def delay_estimate(device: Device) -> DelayEstimate | None:
    """3073:5 to :7; None for firmware without it."""
    delay, half, added = (device.try_upload(0x3073, sub) for sub in (5, 6, 7))
    if delay is None or half is None or added is None:
        return None
    interval = int.from_bytes(half, "little")
    return DelayEstimate(
        int.from_bytes(delay, "little", signed=True) / 100, interval / 100, int.from_bytes(added, "little", signed=True),
        interval != UNKNOWN_INTERVAL,
    )  # fmt: skip


def begin_following(lives: Sequence[LiveAxis]) -> None:
    """All axes at once, so that the line of sight is estimated as one from the start. They are enabled, and at rest."""
    for live in lives:
        live.device.axis_write(live.drive.axis, 0x6060, power.TRACKING, 1)
        live.mode = power.TRACKING


def end_following(lives: Sequence[LiveAxis]) -> None:
    """The axes stop on their ramps (6084), and stay enabled."""
    for live in lives:
        live.drive.set_target_rate(0.0)
        live.drive.set_mode(power.PROFILE_VELOCITY)
        live.mode = power.PROFILE_VELOCITY


def check_frames(device: Device, identifier: int | None, wait_s: float) -> None:
    """Waits for frames that count; raises MotionError with the reason when none come. The node is operational."""
    before = frame_counts(device)
    end = device.clock.now() + wait_s
    while device.clock.now() < end:
        if frame_counts(device).taken != before.taken:
            return
    after = frame_counts(device)
    if after.dropped != before.dropped:
        raise MotionError(
            f"the node drops every frame of the camera (3072:3): {DROPS.get(after.last_drop, 'the reason is unknown')}."
        )
    if identifier is not None:
        raise MotionError(
            f"no frame of the camera arrives at the node (3072:1): does the camera send with the identifier"
            f" {identifier:03X}?"
        )
    raise MotionError(
        "no frame of the camera arrives at the node (3072:1): no RPDO takes 3070, or the camera does not send; map it"
        " with --camera-id, e.g. --camera-id 541 for the simulator."
    )


def parse_identifier(text: str) -> int:
    """Hexadecimal, as the documents write identifiers; raises InputError."""
    try:
        found = int(text.lower().removeprefix("0x").removesuffix("h") if is_plain(text) else "", 16)
    except ValueError:
        found = 0
    if not 0x181 <= found <= 0x57F and not 0x680 <= found <= 0x6DF:
        raise InputError(f"'{text}' is not an identifier of a camera; expected 181 to 57F or 680 to 6DF (hexadecimal).")
    return found
