# SPDX-License-Identifier: Apache-2.0
"""servoctl uses the node's time: a node that is slower or faster than real time gives the same result.

Set-points that do not arrive are reported as not received by the node.
"""

from __future__ import annotations

import struct
from collections.abc import Iterator
from pathlib import Path
from typing import Any, cast

import pytest

from servoctl.errors import MotionError
from servoctl.link.device import Device
from servoctl.link.node_clock import NodeClock
from servoctl.link.stream import RateStream, SampleGatherer
from servoctl.motion.rate_run import FASTEST_PACE, check_pace

from .conftest import Bench, Serving

SLOW = "0.5"


class FakeNode:
    """Ticks that advance by `step` with each reading."""

    def __init__(self, first: int, step: int) -> None:
        self.ticks, self.step = first, step

    def read(self) -> int:
        self.ticks = (self.ticks + self.step) % (1 << 32)
        return self.ticks


def test_the_clock_goes_on_over_the_wrap_of_the_counter_and_over_a_reset() -> None:
    node = FakeNode((1 << 32) - 1500, 1000)
    clock = NodeClock(node.read)
    begun = clock.now()
    assert [clock.now() - begun for _ in range(3)] == pytest.approx([1.0, 2.0, 3.0])
    node.ticks = -980  # it restarted 20 ms ago
    assert clock.now() - begun == pytest.approx(3.02)


def test_a_sleep_and_a_pace_last_by_the_nodes_clock() -> None:
    slow = NodeClock(FakeNode(0, 1).read)
    begun = slow.now()
    slow.sleep(0.01)
    assert 0.01 <= slow.now() - begun < 0.013
    fast = NodeClock(FakeNode(0, 300).read)
    times = list(fast.every(0.5, 3.0))
    assert times[-1] < 3.0 and all(later - earlier >= 0.3 for earlier, later in zip(times, times[1:], strict=False))


def test_a_node_without_a_tick_counter_keeps_the_computers_time() -> None:
    clock = NodeClock(lambda: None)
    begun = clock.now()
    clock.sleep(0.02)
    assert 0.02 <= clock.now() - begun < 2.0


def sample(number: int) -> bytes:
    return struct.pack("<ii", number, number)


def gathered(lost: set[int], lost_clocks: set[int], first: int = 0) -> SampleGatherer:
    """Of 100 ticks, of which each tenth carries its number."""
    found = SampleGatherer()
    for tick in range(100):
        if tick not in lost:
            found.take_sample(sample(tick))
        if tick % 10 == 9 and tick not in lost_clocks:
            found.take_clock((first + tick) % (1 << 32))
    return found


@pytest.mark.parametrize("first", [0, (1 << 32) - 50])
def test_samples_that_are_lost_are_counted_by_the_nodes_ticks(first: int) -> None:
    whole = gathered(set(), set(), first)
    assert (len(whole.frames), whole.lost, whole.ticks) == (90, 0, 90)  # from the first tick that was reported
    some = gathered({12, 13, 14, 55}, {59, 69}, first)
    assert (len(some.frames), some.lost, some.ticks) == (86, 4, 90)
    assert SampleGatherer().ticks == -1


class FakeDevice:
    def __init__(self, paces: list[float]) -> None:
        self.paces = paces

    def pace(self, _seconds: float) -> float:
        return self.paces.pop(0)


def test_set_points_are_refused_to_a_node_that_stays_faster_than_real_time() -> None:
    check_pace(cast(Device, FakeDevice([1.0])))
    check_pace(cast(Device, FakeDevice([2 * FASTEST_PACE, 1.0])))  # it caught up after a stall
    with pytest.raises(MotionError, match="8.0 times as fast.*--speed 1"):
        check_pace(cast(Device, FakeDevice([7.0, 8.0])))


@pytest.fixture(scope="module")
def slow(serving: Serving) -> Iterator[str]:
    """The address of a slow servo."""
    with serving(SLOW) as served:
        yield served.address


@pytest.mark.parametrize("pace", ["slow", pytest.param("served", marks=pytest.mark.image)])
def test_a_motion_lasts_as_long_as_commanded_by_the_nodes_clock(
    request: pytest.FixtureRequest, serving: Serving, tmp_path: Path, pace: str
) -> None:
    """Half as fast as real time, and FAST."""
    servo = Bench(request.getfixturevalue(pace), tmp_path)
    moved = servo.json("move", "azimuth", "--rate", "2", "--for", "2", "--yes")
    assert moved["to_deg"] - moved["from_deg"] == pytest.approx(4.0, abs=1.5)


def test_a_step_on_a_node_slower_than_the_computer_is_the_same(slow: str, tmp_path: Path) -> None:
    found = Bench(slow, tmp_path).json("step", "azimuth", "--hold", "0.4", "--yes")
    assert [s["direction"] for s in found["steps"]] == ["forward", "backward"]
    for step in found["steps"]:
        assert 0.001 < step["rise_s"] < 0.1 and step["settling_s"] < 0.2


@pytest.mark.real_time
@pytest.mark.parametrize("words", [("step", "--hold", "0.3"), ("bode", "--periods", "2")])
def test_set_points_that_are_not_heard_are_reported_with_their_identifier(
    servo: Bench, monkeypatch: pytest.MonkeyPatch, words: tuple[Any, ...]
) -> None:
    before = servo.json("state", "azimuth")["axes"][0]["position_deg"]
    with monkeypatch.context() as patch:
        patch.setattr(RateStream, "_send", lambda _stream, _counts: None)
        refused = servo(words[0], "azimuth", *words[1:], "--yes")
    assert refused.code == 6 and refused.err.count("\n") == 1, refused
    assert "node 1 does not receive identifier 6BC" in refused.err and "late" not in refused.err
    state = servo.json("state", "azimuth")["axes"][0]
    assert state["state"] == "switch on disabled" and abs(state["position_deg"] - before) < 1.0
