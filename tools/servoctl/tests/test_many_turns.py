# SPDX-License-Identifier: Apache-2.0
"""Positions of an axis without end stops are counted on where the node's wrap. No device is needed."""

from __future__ import annotations

import struct

import pytest

from servoctl.drive.drive import Drive
from servoctl.link.pair_stream import WrapCounter
from servoctl.units import POSITION_COUNTS_PER_RAD, POSITION_RANGE_RAD, radians

RANGE_END = 2_010_619_298


class FakeNode:
    """Answers 607B and 6064, and keeps 607A."""

    def __init__(self, wraps: bool | None) -> None:
        self.wraps, self.counts, self.target = wraps, 0, 0

    def axis_int(self, axis: int, index: int, sub: int = 0, signed: bool = False) -> int:
        assert (index, signed) == (0x6064, True)
        return self.counts

    def axis_write(self, axis: int, index: int, value: int, size: int, sub: int = 0) -> None:
        assert (index, size) == (0x607A, 4)
        self.target = value

    def try_upload(self, index: int, sub: int = 0) -> bytes | None:
        assert (index, sub) == (0x607B, 2)
        return None if self.wraps is None else struct.pack("<i", RANGE_END if self.wraps else 0)


def drive_of(node: FakeNode) -> Drive:
    return Drive(node, 0)  # type: ignore[arg-type]


@pytest.mark.parametrize("direction", [1, -1])
def test_a_position_goes_on_over_the_ends_of_the_range(direction: int) -> None:
    node = FakeNode(wraps=True)
    drive = drive_of(node)
    for turn in range(1000):
        true_rad = direction * 0.9 * turn * radians(360.0)
        node.counts = round((true_rad - POSITION_RANGE_RAD * round(true_rad / POSITION_RANGE_RAD)) * POSITION_COUNTS_PER_RAD)
        assert drive.position() == pytest.approx(true_rad, abs=1e-7)


@pytest.mark.parametrize("wraps, target_rad, counts", [
    (True, 201.0, 2_010_000_000), (True, 202.0, -2_001_238_597), (True, -202.0, 2_001_238_597), (True, 6283.0, -1_509_817_546),
    (False, 210.0, 2_100_000_000), (None, 210.0, 2_100_000_000),
])  # fmt: skip
def test_a_target_is_within_the_range_if_there_is_one(wraps: bool | None, target_rad: float, counts: int) -> None:
    node = FakeNode(wraps)
    drive_of(node).set_target_position(target_rad)
    assert node.target == counts


def test_a_stream_counts_the_ranges_of_each_axis() -> None:
    counter = WrapCounter()
    for pair in ((RANGE_END, 0), (-RANGE_END, 5), (-RANGE_END + 9, -RANGE_END + 1000), (RANGE_END, RANGE_END), (-RANGE_END, RANGE_END)):
        counter.take(struct.pack("<ii", *pair))
    assert counter.ranges == [(0, 0), (1, 0), (1, 0), (0, -1), (1, -1)]
