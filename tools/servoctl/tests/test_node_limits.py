# SPDX-License-Identifier: Apache-2.0
"""Every motion is checked against every limit of the node, before anything moves."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator
from contextlib import contextmanager

import pytest

from servoctl.drive.node_limits import Bound, NodeLimits
from servoctl.errors import InputError

from .conftest import Bench

SOFTWARE, HARD, RATE = "azimuth.software_position_limit", "azimuth.protection.hard", "azimuth.max_profile_velocity"
OVER_SPEED, GYRO = "azimuth.protection.over_speed_limit", "azimuth.protection.gyro_range"
FREE = ("--max-travel", "1e4", "--max-duration", "1e4", "--max-rate", "1e4")


def here(servo: Bench) -> float:
    return float(servo.json("state", "azimuth")["axes"][0]["position_deg"])


@pytest.fixture
def still(servo: Bench) -> Iterator[float]:
    """The angle (°) of the axis, off: limits change only without torque, and its brake holds it."""
    yield here(servo)


@contextmanager
def limited(servo: Bench, *assignments: str) -> Iterator[None]:
    servo.json("set", *assignments, "--unlock")
    try:
        yield
    finally:
        servo.json("undo", "--unlock")


def hard(low_deg: float, high_deg: float) -> tuple[str, str]:
    return f"{HARD}_minimum_position={math.radians(low_deg):.6f}", f"{HARD}_maximum_position={math.radians(high_deg):.6f}"


def software(low_deg: float, high_deg: float) -> tuple[str, str]:
    low, high = (round(math.radians(angle) * 1e7) for angle in (low_deg, high_deg))
    return f"{SOFTWARE}.min_position_limit={low}", f"{SOFTWARE}.max_position_limit={high}"


def test_a_move_beyond_the_travel_names_the_limit_its_value_and_what_is_within(servo: Bench, still: float) -> None:
    for assignments, named, margin in (
        (software(still - 3, still + 4), ("607D:2", "607D:1"), 0.0),
        (hard(still - 3, still + 4), ("2060:10", "2060:9"), 0.286),
    ):
        with limited(servo, *assignments):
            for travel, name, end in ((500.0, named[0], still + 4), (-300.0, named[1], still - 3)):
                refused = servo("move", "azimuth", "--by", str(travel), *FREE, "--yes")
                assert refused.code == 2 and f"{name} ({end:.2f}°" in refused.err, refused
                forward, back = re.findall(r"most ([\d.]+)° forward and ([\d.]+)° back", refused.err)[0]
                assert (float(forward), float(back)) == pytest.approx((4 - margin, 3 - margin), abs=0.05)
                within = str(float(forward) - 0.03) if travel > 0 else f"-{float(back) - 0.03}"
                assert servo("move", "azimuth", "--by", within, "--dry-run").code == 0
    assert here(servo) == pytest.approx(still, abs=0.05)


def test_a_rate_beyond_607F_over_speed_or_the_gyro_is_refused_with_what_is_within(servo: Bench, still: float) -> None:
    for assignment, name, within_deg_s in (
        (f"{RATE}={round(math.radians(8) * 1e6)}", "607F (8 °/s)", 8.0),
        (f"{OVER_SPEED}={math.radians(6)}", "over-speed limit 2060:1 (80 % of 6 °/s)", 4.8),
        (f"{GYRO}={math.radians(5)}", "gyro's range 2060:3 (90 % of 5 °/s)", 4.5),
    ):
        with limited(servo, assignment):
            for words in (
                ("move", "azimuth", "--by", "1", "--rate", "9"),
                ("move", "azimuth", "--rate", "-9", "--for", "0.2"),
                ("step", "azimuth", "--amplitude", "9"),
                ("bode", "azimuth", "--bias", "8", "--amplitude", "1"),
            ):
                refused = servo(*words, *FREE, "--yes")
                assert refused.code == 2 and name in refused.err, (words, refused)
                assert float(re.findall(r"at most ([\d.]+) °/s is allowed", refused.err)[0]) == pytest.approx(
                    within_deg_s, abs=0.011
                )
            within = ("move", "azimuth", "--by", "1", "--rate", str(within_deg_s - 0.02), "--dry-run")
            assert servo(*within).code == 0
    assert here(servo) == pytest.approx(still, abs=0.05)


def test_step_bode_and_runs_at_a_rate_are_checked_against_the_travel(servo: Bench, still: float) -> None:
    with limited(servo, *hard(still - 0.6, still + 0.6)):
        for words in (
            ("step", "azimuth"), ("step", "azimuth", "--amplitude", "-1"), ("bode", "azimuth"), ("move", "azimuth", "--rate", "2", "--for", "1"),
        ):  # fmt: skip
            refused = servo(*words, "--yes")
            assert refused.code == 2 and "2060:" in refused.err, (words, refused)
    assert here(servo) == pytest.approx(still, abs=0.05)


def test_identify_and_tune_stay_within_the_hard_limits(servo: Bench, still: float) -> None:
    with limited(servo, *hard(still - 20, still + 20)):
        wide = ("--travel-deg", str(still - 19), str(still + 19.9))
        refused = servo("identify", "--axis", "azimuth", *wide, "--dry-run")
        assert refused.code == 2 and "2060:10" in refused.err, refused
        inside = servo.json("identify", "--axis", "azimuth", "--dry-run")["envelope"]  # from the node
        assert math.degrees(inside["lowest_rad"]) == pytest.approx(still - 19.714, abs=0.02)
        assert math.degrees(inside["highest_rad"]) == pytest.approx(still + 19.714, abs=0.02)


def test_without_any_limit_of_the_travel_identify_asks_for_one(servo: Bench, still: float) -> None:
    with limited(servo, *hard(0, 0), *software(0, 0)):
        refused = servo("identify", "--axis", "azimuth", "--dry-run")
        assert refused.code == 2 and "2060:10" in refused.err and "--travel-deg -150 150" in refused.err, refused
        assert servo("identify", "--axis", "azimuth", "--travel-deg", str(still - 20), str(still + 20), "--dry-run").code == 0


@pytest.mark.image
def test_an_axis_beyond_a_limit_may_come_back(servo: Bench, still: float) -> None:
    with limited(servo, *hard(still - 30, still - 1)):
        assert servo("move", "azimuth", "--by", "0.5", "--yes").code == 2
        back = servo.json("move", "azimuth", "--by", "-2", "--yes")
    assert back["to_deg"] == pytest.approx(still - 2, abs=0.05)


def test_what_is_no_number_is_within_no_limit() -> None:
    limits = NodeLimits(Bound(-1.0, "low"), Bound(1.0, "high"), Bound(1.0, "fast"))
    limits.check_rate(1.0)
    limits.check_travel("azimuth", 0.5, 1.5, 0.5)
    limits.check_travel("azimuth", 3.0, 1.0, 0.0)  # back from beyond
    for rate in (math.nan, 1.01):
        with pytest.raises(InputError, match="above fast"):
            limits.check_rate(rate)
    for back, forward, name in ((0.0, math.nan, "high"), (math.nan, 0.0, "low"), (1.51, 0.0, "low"), (0.0, 0.51, "high")):
        with pytest.raises(InputError, match=f"beyond {name}"):
            limits.check_travel("azimuth", 0.5, back, forward)
