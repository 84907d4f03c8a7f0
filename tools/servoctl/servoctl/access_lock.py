"""The lock of guarded parameters: motor and protection limits can be written only while it is open.

Object 0x3040: 1 takes the word "open", which opens it for 60 s; any other value locks it.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager

from .device import Device
from .errors import InputError, ServoctlError
from .parameter import Parameter, Value

LOCK_OBJECT, ACCESS_WORD = 0x3040, 1
OPEN, LOCKED = b"open", bytes(4)


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


@contextmanager
def unlocked(device: Device, wanted: bool) -> Iterator[None]:
    """Open within the `with` block, if required; locked again after it."""
    if not wanted:
        yield
        return
    device.download(LOCK_OBJECT, ACCESS_WORD, OPEN, "access lock")
    try:
        yield
    finally:
        try:
            device.download(LOCK_OBJECT, ACCESS_WORD, LOCKED, "access lock")
        except ServoctlError:
            pass  # the device locks it by itself after a minute
