# SPDX-License-Identifier: Apache-2.0
"""Which of two joint angles lasts longest, for a cue and for a trajectory. No device is needed."""

from __future__ import annotations

import math

import numpy as np
import pytest

from servoctl.drive.node_limits import REACH_RAD, Bound, NodeLimits
from servoctl.errors import InputError
from servoctl.motion.cable_wrap import lasts_s, longest_lasting, longest_within, turned_text, with_turns
from servoctl.motion.trajectory import AxisLimits, Real, Trajectory
from servoctl.units import degrees, radians

TRAVEL = NodeLimits(Bound(radians(-280.0), "607D:1"), Bound(radians(280.0), "607D:2"), Bound(1.0, "607F"))
ENDLESS = NodeLimits(Bound(-REACH_RAD, "6064"), Bound(REACH_RAD, "6064"), Bound(1.0, "607F"), has_travel=False)
LIMITS = {0: AxisLimits(TRAVEL, 1.0, 1.0)}


def course(first_deg: float, rate_deg_s: float, duration_s: float = 30.0) -> Trajectory:
    """At a constant rate, a row each second."""
    time_s: Real = np.arange(0.0, duration_s + 0.5, 1.0, dtype=np.float64)
    angle = radians(first_deg) + radians(rate_deg_s) * time_s
    rate = np.full(len(time_s), radians(rate_deg_s))
    return Trajectory(time_s, {0: angle}, {0: rate}, [f"path.csv:{i + 2}" for i in range(len(time_s))])


@pytest.mark.parametrize("angle, rate, turns", [
    (0.0, None, 0), (79.0, None, 0), (100.0, None, 0), (179.0, None, 0), (181.0, None, -1), (-270.0, None, 1),
    (100.0, 10.0, -1), (100.0, -10.0, 0), (-100.0, -10.0, 1), (-100.0, 10.0, 0), (300.0, None, -1), (300.0, 5.0, -1),
    (700.0, None, 0),
])  # fmt: skip
def test_a_cue_takes_the_angle_that_lasts_longest(angle: float, rate: float | None, turns: int) -> None:
    """At an unknown rate: that which is further from both limits."""
    known = None if rate is None else radians(rate)
    assert longest_lasting(TRAVEL, radians(angle), known) == turns
    assert longest_lasting(ENDLESS, radians(angle), known) == 0


def test_the_time_that_an_angle_lasts() -> None:
    assert lasts_s(TRAVEL, radians(100.0), radians(10.0)) == pytest.approx(18.0)
    assert lasts_s(TRAVEL, radians(100.0), radians(-10.0)) == pytest.approx(38.0)
    assert lasts_s(TRAVEL, radians(281.0), radians(-10.0)) < 0.0
    assert lasts_s(TRAVEL, radians(100.0), 0.0) == math.inf


def test_a_choice_is_printed() -> None:
    assert turned_text(radians(270.0), 0) == ""
    assert turned_text(radians(270.0), -1) == " (270.000° − 360°, which lasts longer)"


@pytest.mark.parametrize("first, rate, last", [(0.0, 9.0, 270.0), (100.0, 9.0, 10.0), (-100.0, -9.0, -10.0)])
def test_a_trajectory_takes_the_turn_that_fits_as_a_whole(first: float, rate: float, last: float) -> None:
    candidates = with_turns(course(first, rate))
    chosen = candidates[longest_within(candidates, LIMITS)]
    assert degrees(float(chosen.angle_rad[0][-1])) == pytest.approx(last)


def test_one_that_fits_with_no_turn_is_refused_where_it_leaves_the_travel_last() -> None:
    """From 0 at 20 °/s: 280° after 14 s; begun a turn before, at -360°, it is outside at once."""
    with pytest.raises(InputError) as refused:
        longest_within(with_turns(course(0.0, 20.0)), LIMITS)
    text = str(refused.value)
    assert text.startswith("path.csv:16: at 14 s azimuth would move to 300.000°, beyond 607D:2"), text
    assert "+0° lasts longest" in text
    with pytest.raises(InputError) as refused:
        longest_within(with_turns(course(200.0, 20.0)), LIMITS)
    assert str(refused.value).startswith("path.csv:24: at 22 s"), refused.value
    assert "-360° lasts longest" in str(refused.value)


def test_a_limit_of_the_rate_is_said_without_a_turn() -> None:
    with pytest.raises(InputError) as refused:
        longest_within(with_turns(course(0.0, 60.0, 3.0)), LIMITS)
    assert "60 °/s, above 607F" in str(refused.value) and "lasts longest" not in str(refused.value)


def test_a_pitch_alone_has_no_turns() -> None:
    whole = course(0.0, 1.0)
    assert len(with_turns(Trajectory(whole.time_s, {1: whole.angle_rad[0]}, {1: whole.rate_rad_s[0]}, whole.places))) == 1
