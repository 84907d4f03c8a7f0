# SPDX-License-Identifier: Apache-2.0
"""What makes the gate fail, and what lets it pass."""

from __future__ import annotations

import os
import re
from datetime import date
from pathlib import Path

import pytest
from conftest import BIN, PROJECT, Gate

TRACKER = PROJECT / "sim_host/plants/tracker.toml"
LIMITS = PROJECT / "sim_host/limits/tracker.toml"
SHIPPED_RAD_S = 219.91148  # bandwidth of the observer, both axes


def gains_with_observer(folder: Path, factor: float, axes: tuple[str, ...] = ("azimuth", "pitch")) -> Path:
    file = folder / "gains.toml"
    lines = (f"[{axis}.disturbance_observer]\nbandwidth = {factor * SHIPPED_RAD_S}\n" for axis in axes)
    file.write_text("\n".join(lines))
    return file


def plant_with_friction(folder: Path, factor: float) -> Path:
    file = folder / "plant.toml"
    key = re.compile(r"^((?:coulomb_nm|breakaway_nm|viscous_nm_s_rad) = )([0-9.]+)$", re.MULTILINE)
    text, found = key.subn(lambda m: f"{m[1]}{factor * float(m[2])}", TRACKER.read_text())
    assert found == 12, "three numbers, two directions, two axes"
    file.write_text(text)
    return file


def test_unchanged_firmware_with_other_seeds_stays_green(gate: Gate) -> None:
    """Twenty seeds of today's date; GATE_FIRST_SEED tries others."""
    first_seed = int(os.environ.get("GATE_FIRST_SEED", date.today().strftime("%y%m%d00")))
    print(f"GATE_FIRST_SEED={first_seed}")
    verdict = gate.check("--seeds", *(str(first_seed + i) for i in range(20)))
    assert verdict.code == 0, verdict.failures
    assert verdict.failures == []
    assert verdict.results["kept"] is True
    assert "Passed" in (verdict.folder / "report.html").read_text()


@pytest.mark.parametrize(
    ("axis", "other", "factor", "figures"),
    [
        ("azimuth", "pitch", 1.3, ["gain_margin_db", "crossover_hz"]),
        ("pitch", "azimuth", 0.7, ["crossover_hz", "rms_error_deg_s"]),
    ],
)
def test_an_observer_gain_off_by_30_percent_is_red_and_named(
    gate: Gate, tmp_path: Path, axis: str, other: str, factor: float, figures: list[str]
) -> None:
    steady = PROJECT / "sim_host/scenarios/steady_speed.toml"
    verdict = gate.check("--gains", gains_with_observer(tmp_path, factor, (axis,)), "--limits", LIMITS, "--scenario", steady)
    assert verdict.code == 1
    for figure in figures:
        assert any(figure in failure and axis in failure for failure in verdict.failures), verdict.failures
    assert not any(f", {other}: " in failure for failure in verdict.failures), verdict.failures


def test_a_plant_with_twice_the_friction_is_red_and_named(gate: Gate, tmp_path: Path) -> None:
    verdict = gate.check("--plant", plant_with_friction(tmp_path, 2.0), "--limits", LIMITS)
    assert verdict.code == 1
    for axis in ("azimuth", "pitch"):
        named = [failure for failure in verdict.failures if failure.startswith(f"low_speed_start, 1 deg/s, {axis}: ")]
        assert named, verdict.failures


def test_a_firmware_whose_observer_has_the_wrong_sign_is_red_and_named(gate: Gate) -> None:
    verdict = gate.check(program=BIN / "check_wrong_observer")
    assert verdict.code == 1
    for axis in ("azimuth", "pitch"):
        assert any(f"{axis}: rms_error_deg_s" in failure for failure in verdict.failures), verdict.failures


def test_the_copy_with_the_mistake_differs_in_one_line_only() -> None:
    right = (PROJECT / "firmware/control/disturbance_observer.c").read_text().splitlines()
    wrong = (PROJECT / "build/host/tests/gate/wrong_observer.c").read_text().splitlines()
    assert len(right) == len(wrong)
    assert sum(a != b for a, b in zip(right, wrong, strict=True)) == 1
