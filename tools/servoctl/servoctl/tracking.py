"""Tracking in mode -1 as a client sees it: the camera's PDO, its counters, and the states (docs/can.md)."""

from __future__ import annotations

from dataclasses import dataclass

from .device import Device
from .drive import Drive
from .errors import InputError, MotionError
from .parameter import AXIS_SHIFT
from .pdo_loan import PdoLoan

SUPPORTED_BIT = 16
"""Of 6502: mode -1."""

NOT_TRACKING, SEARCHING, ACQUIRING, ON_TARGET, COASTING, LOST = range(6)
STATES = ("not tracking", "searching", "acquiring", "tracking", "coasting", "lost")
"""By the value of 3072:5 and :6."""

DROPS = {
    1: "they are not newer than the one before: does a second camera send, too?",
    2: "they are older than 127 ms when they arrive",
    3: "they were exposed later than now: does 3071:5 fit the sender's time?",
    4: "their quality is above 100 %",
}
"""Why a frame does not count, by 3072:4."""

RPDO = 3
FRAME = [0x3070 << 16 | sub << 8 | bits for sub, bits in enumerate((16, 16, 16, 8, 8), start=1)]
"""Objects of a camera frame, as they are mapped."""


def check_supported(device: Device, axis: int) -> None:
    """Raises MotionError for a node without mode -1."""
    data = device.try_upload(0x6502 + AXIS_SHIFT * axis)
    if data is None or not int.from_bytes(data, "little") >> SUPPORTED_BIT & 1:
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


@dataclass(frozen=True)
class FrameCounts:
    """Frames that counted, that were missed, and that were dropped, with the reason of the last one; their age."""

    taken: int
    missed: int
    dropped: int
    last_drop: int
    age_ms: int


def frame_counts(device: Device) -> FrameCounts:
    """3072:1 to :4 and :7."""
    taken, missed, dropped, last_drop, age_ms = (device.read_int(0x3072, sub) for sub in (1, 2, 3, 4, 7))
    return FrameCounts(taken, missed, dropped, last_drop, age_ms)


def state_of(drive: Drive) -> int:
    """3072:5 or :6."""
    return drive.device.read_int(0x3072, 5 + drive.axis)


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
        found = int(text.lower().removeprefix("0x").removesuffix("h"), 16)
    except ValueError:
        found = 0
    if not 0x181 <= found <= 0x57F and not 0x680 <= found <= 0x6DF:
        raise InputError(f"'{text}' is not an identifier of a camera; expected 181 to 57F or 680 to 6DF (hexadecimal).")
    return found
