# SPDX-License-Identifier: Apache-2.0
"""The lock of guarded parameters: motor, protection limits and board scales can be written only while it is open.

Object 0x3040 belongs to the SDO channel of the request. The owner may set a word (:4); a SipHash of it is all that the
device keeps. Without one the word is "open" (:1). The lock closes by itself after 60 s.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass

import click

from ..drive.drive import Drive
from ..errors import InputError, Refused, ServoctlError
from ..link.device import DEVICE_STATE, STORE_TIMEOUT_S, Device
from .parameter import AXES, Parameter, Value

LOCK_OBJECT, ACCESS_WORD, SECONDS_LEFT, OWNERS_WORD, NEW_WORD, HAS_WORD, DELAY_LEFT = 0x3040, 1, 2, 3, 4, 5, 6
OPEN, LOCKED = b"open", bytes(4)
WORD_BYTES = 8
WRONG_WORD = 0x06090030
ENVIRONMENT = "SERVOCTL_WORD"
NO_TORQUE = ("switch on disabled", "ready to switch on", "switched on", "fault", "not ready to switch on")


@dataclass(frozen=True)
class LockState:
    """Object 0x3040, as the channel of this program sees it."""

    open_s: int
    has_word: bool
    delay_s: int


def without_equal_guarded(
    values: Mapping[Parameter, Value], present: Mapping[Parameter, Value | None]
) -> dict[Parameter, Value]:
    """Values that have to be written; guarded values that the device already has are left out."""
    return {p: value for p, value in values.items() if not p.guarded or present[p] != value}


def need_unlock(guarded: list[Parameter]) -> None:
    """Raises InputError, one sentence that names the parameters, if there are any."""
    if guarded:
        others = f" and {len(guarded) - 1} more" if len(guarded) > 1 else ""
        raise InputError(
            f"{guarded[0].name} ({guarded[0].where}){others} is locked because a wrong value can cause damage."
            " Nothing was written; add --unlock to write it."
        )


def bytes_of(word: str) -> bytes:
    """As the device compares it; raises InputError."""
    data = word.encode("ascii", errors="replace")
    if not 1 <= len(data) <= WORD_BYTES or not word.isascii() or not word.isprintable():
        raise InputError(f"an access word has 1 to {WORD_BYTES} printable ASCII characters.")
    return data.ljust(WORD_BYTES, b"\0")


def lock_state(device: Device) -> LockState:
    """Raises Refused for a device without a lock."""
    left, word, delay = (
        device.try_upload(LOCK_OBJECT, sub) for sub in (SECONDS_LEFT, HAS_WORD, DELAY_LEFT)
    )
    if left is None:
        raise Refused(f"node {device.node_id} has no access lock (3040).")
    return LockState(
        int.from_bytes(left, "little"), bool(word and word[0]), int.from_bytes(delay or b"", "little")
    )


def open_lock(device: Device) -> None:
    """With the owner's word if one is set; raises InputError or Refused, and the lock stays closed."""
    state = lock_state(device)
    if state.delay_s:
        raise Refused(
            f"the access lock of node {device.node_id} accepts no word for another {state.delay_s} s, because the last"
            " one was wrong."
        )
    try:
        if state.has_word:
            device.download(LOCK_OBJECT, OWNERS_WORD, bytes_of(_owners_word(device)), "access lock")
        else:
            device.download(LOCK_OBJECT, ACCESS_WORD, OPEN, "access lock")
    except Refused as error:
        if error.abort != WRONG_WORD:
            raise
        delay_s = lock_state(device).delay_s
        raise Refused(
            f"wrong access word for node {device.node_id}: the lock stays closed and accepts the next word in"
            f" {delay_s} s. A lost word is recovered at the device (docs/can.md).",
            error.abort,
        ) from error


def _owners_word(device: Device) -> str:
    if device.access_word:
        return device.access_word
    if sys.stdin is not None and sys.stdin.isatty():
        return str(click.prompt("Access word", hide_input=True, err=True))
    raise InputError(
        f"the owner of node {device.node_id} has set an access word: give it with --word or in {ENVIRONMENT}."
    )


def close_lock(device: Device) -> None:
    """For the channel of this program."""
    device.download(LOCK_OBJECT, ACCESS_WORD, LOCKED, "access lock")


def set_word(device: Device, word: str | None) -> None:
    """Replaces the owner's word, None removes it; the device stores it at once. Raises InputError or Refused."""
    data = bytes_of(word) if word is not None else bytes(WORD_BYTES)
    with unlocked(device, True):
        device.download(LOCK_OBJECT, NEW_WORD, data, "new access word", STORE_TIMEOUT_S)


def refuse_torque(device: Device) -> None:
    """Raises Refused while an axis has torque: the device then refuses guarded values."""
    for axis, name in enumerate(AXES):
        state = Drive(device, axis).state()
        if state not in NO_TORQUE:
            raise Refused(
                f"{name} has torque (state '{state}'). Guarded parameters and the access word change only while both axes are off:"
                f" 'servoctl state {name} disable'. Nothing was written.",
                DEVICE_STATE,
            )


@contextmanager
def unlocked(device: Device, wanted: bool, with_torque: bool = False) -> Iterator[None]:
    """Open within the `with` block, if required; locked again after it. `with_torque`: for a command that needs the
    lock, but changes no guarded value."""
    if not wanted:
        yield
        return
    if not with_torque:
        refuse_torque(device)
    open_lock(device)
    try:
        yield
    finally:
        try:
            close_lock(device)
        except ServoctlError:
            pass  # the device locks it by itself after a minute
