# SPDX-License-Identifier: Apache-2.0
"""The device of these tests is the one that was requested."""

from __future__ import annotations

import pytest

from .conftest import DEVICE, Bench


@pytest.mark.image
def test_the_image_is_the_one_that_was_requested(servo: Bench) -> None:
    """1018:4 is the CRC-32 of the chip's unique identifier, which a simulator does not have."""
    assert (servo.json("info")["serial"] > 0xFFFF) == (DEVICE == "image")
