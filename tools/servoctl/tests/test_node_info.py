# SPDX-License-Identifier: Apache-2.0
"""What servoctl says of the option bytes of the board's chip (3061:1)."""

from __future__ import annotations

from typing import cast

import pytest

from servoctl.commands.node import _option_bytes
from servoctl.link.device import Device
from servoctl.objects.restrictions import reason

BANKS = "DBANK or BFB2: the flash has other banks than the image needs; no torque, and nothing is stored"
PARITY, PROTECTION = "SRAM_PE: no parity of the RAM", "WRP1A: the image is not write-protected"


class Board:
    """A device whose 3061:1 has this value; none: it has no such object."""

    def __init__(self, status: int | None) -> None:
        self._status = status

    def try_upload(self, index: int, sub: int) -> bytes | None:
        assert (index, sub) == (0x3061, 1)
        return None if self._status is None else self._status.to_bytes(4, "little")


@pytest.mark.parametrize("status, said", [
    (0xFF, "as needed"),
    (0xB0, "as needed"),
    (0x7F, BANKS),
    (0xEF, PARITY),
    (0xDF, PROTECTION),
    (0x4F, f"{BANKS}; {PARITY}; {PROTECTION}"),
    (None, None),
])  # fmt: skip
def test_info_names_each_option_byte_that_is_not_as_the_image_needs_it(status: int | None, said: str | None) -> None:
    assert _option_bytes(cast(Device, Board(status))) == said


def test_what_keeps_an_axis_off_names_the_banks() -> None:
    assert "DBANK and BFB2" in (reason(cast(Device, Board(0x30)), 0) or "")
