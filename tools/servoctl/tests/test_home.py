# SPDX-License-Identifier: Apache-2.0
"""servoctl home, on an azimuth whose travel leaves two turns possible."""

from __future__ import annotations

import math
from collections.abc import Iterator
from pathlib import Path

import pytest

from .conftest import FAST, Bench, Eventually, Serving

MAXIMUM = "azimuth.protection.hard_maximum_position"
RESTRICTIONS = "azimuth.envelope.restrictions"


@pytest.fixture
def lost(serving: Serving, tmp_path: Path, eventually: Eventually) -> Iterator[Bench]:
    """Just started at 0, or at 360: that is within the margin of this travel until the axis has moved up by 6.8
    degrees."""
    with serving(FAST) as served:
        bench = Bench(served.address, tmp_path)
        bench.json("set", f"{MAXIMUM}={math.radians(361.0)}", "--unlock")
        eventually(lambda: bench.value(RESTRICTIONS) == 2, 5)
        yield bench


@pytest.mark.image
def test_motion_finds_the_turn(lost: Bench) -> None:
    plan = lost.json("home", "azimuth", "--up", "--dry-run")["plan"]
    assert plan["possible_deg"] == pytest.approx([0.0, 360.0], abs=2.0)
    assert lost.value(RESTRICTIONS) == 2
    found = lost.json("home", "azimuth", "--up", "--yes")
    assert found["start_turn"] == 0 and 5.0 < found["position_deg"] < 9.0
    assert lost.value(RESTRICTIONS) == 0
    again = lost("home", "azimuth", "--up", "--yes")
    assert again.code == 0 and "known already" in again.out


def test_what_was_seen_is_confirmed_or_refused(lost: Bench) -> None:
    text = " ".join(lost("home", "azimuth", "--seen", "180", "--unlock", "--yes").err.split())
    assert "cannot be near 180.0°" in text, text
    assert lost.value(RESTRICTIONS) == 2
    found = lost.json("home", "azimuth", "--seen", "350", "--unlock", "--yes")
    assert found["start_turn"] == 1 and found["position_deg"] == pytest.approx(360.0, abs=2.0)


def test_it_says_what_is_missing(servo: Bench) -> None:
    assert "one of --down, --up, or --seen" in servo("home", "azimuth").err
    assert "needs --unlock" in " ".join(servo("home", "azimuth", "--seen", "3").err.split())
