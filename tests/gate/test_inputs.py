# SPDX-License-Identifier: Apache-2.0
"""Limits, gains and baselines: learned, read, refused."""

from __future__ import annotations

import os
import subprocess
from pathlib import Path
from typing import Any

import pytest
from conftest import PROJECT, Gate

TRACKER = PROJECT / "sim_host/plants/tracker.toml"
START = PROJECT / "sim_host/scenarios/low_speed_start.toml"
LIMITS = PROJECT / "sim_host/limits/tracker.toml"
DESCRIPTIONS = Path(os.environ.get("NODE_DESCRIPTIONS", PROJECT / "build/host/share/trackservo"))
FEW = ("--scenario", START, "--seeds", "1", "2", "3", "4")
# A change of four times the scatter is certain with eight seeds; with four it is not.
ENOUGH = ("--scenario", START, "--seeds", *"12345678")


def test_limits_are_learned_from_a_plant_of_ones_own_and_kept_by_the_next_run(gate: Gate, sim_host: Path, tmp_path: Path) -> None:
    gains = tmp_path / "gains.toml"
    subprocess.run([sim_host, "gains", "--plant", TRACKER, "--out", gains], check=True, capture_output=True)
    own = ("--plant", TRACKER, "--gains", gains)
    limits = tmp_path / "limits.toml"
    learned = gate.check(*own, *FEW, "--learn", limits)
    assert learned.code == 0, learned.err
    again = gate.check(*own, "--scenario", START, "--seeds", "11", "12", "13", "14", "--limits", limits)
    assert again.code == 0, again.failures
    assert len(again.results["figures"]) == len(learned.results["figures"])
    for row in again.results["figures"]:
        assert row["min"] is not None or row["max"] is not None, row


def test_worse_than_the_baseline_is_red_unless_it_only_reports(gate: Gate, tmp_path: Path) -> None:
    loose = tmp_path / "loose.toml"
    loose.write_text('[loop."computed, sliding".azimuth]\ngain_margin_db = { min = 1.0 }\n'
                     '[low_speed_start."1 deg/s".azimuth]\novershoot_percent = { max = 100.0 }\n')
    before = gate.check(*ENOUGH, "--limits", loose)
    assert before.code == 0
    baseline = before.folder / "results.json"
    slow = tmp_path / "gains.toml"
    slow.write_text("[azimuth.speed_loop]\nproportional_gain = 550.0\n[azimuth.disturbance_observer]\nbandwidth = 120.0\n")
    same = gate.check(*ENOUGH, "--limits", loose, "--baseline", baseline)
    assert same.code == 0
    assert same.results["baseline"]["changes"] == []
    assert same.results["baseline"]["paired"] is True
    worse = gate.check(*ENOUGH, "--limits", loose, "--gains", slow, "--baseline", baseline)
    assert worse.code == 1
    assert "worse: low_speed_start, 1 deg/s, azimuth: " in worse.out
    assert "better: loop, computed, sliding, azimuth: gain_margin_db" in worse.out
    assert any("worse: low_speed_start" in failure for failure in worse.failures)
    changes: list[dict[str, Any]] = worse.results["baseline"]["changes"]
    assert {change["axis"] for change in changes} == {"azimuth"}, "pitch has its old gains"
    reported = gate.check(*ENOUGH, "--limits", loose, "--gains", slow, "--baseline", baseline, "--baseline-only-reports")
    assert reported.code == 0
    assert reported.results["baseline"]["changes"] == changes


def test_a_run_that_ends_in_a_fault_is_red_and_says_which_fault(gate: Gate, tmp_path: Path) -> None:
    weak = tmp_path / "gains.toml"
    weak.write_text("[pitch.protection]\nover_speed_limit = 0.001\n")
    verdict = gate.check(*FEW, "--limits", LIMITS, "--gains", weak)
    assert verdict.code == 1
    assert any("has no value in 4 of 4 seeds: the axes are not enabled: pitch: fault 8481h" in failure for failure in verdict.failures)


REFUSED_LIMITS = [
    ('[sine."1 deg/s, 0.1 Hz".azimuth]\nrms_eror_deg_s = { max = 1.0 }', ":2: ", "rms_error_deg_s"),
    ('[sine."1 deg/s, 0.1 Hz".azimut]\nrms_error_deg_s = { max = 1.0 }', ":1: ", "azimuth"),
    ('[sine."2 deg/s".azimuth]\nrms_error_deg_s = { max = 1.0 }', ":1: ", "1 deg/s, 0.1 Hz"),
    ('[cosine."1 deg/s".azimuth]\nrms_error_deg_s = { max = 1.0 }', ":1: ", "sine"),
    ('[sine."1 deg/s, 0.1 Hz".azimuth]\nrms_error_deg_s = { most = 1.0 }', ":2: ", "max"),
    ('[sine."1 deg/s, 0.1 Hz".azimuth]\nrms_error_deg_s = { max = "1" }', ":2: ", "finite number"),
    ('[sine."1 deg/s, 0.1 Hz".azimuth]\nrms_error_deg_s = { min = 2.0, max = 1.0 }', ":2: ", "above max"),
    ('[sine."1 deg/s, 0.1 Hz".azimuth]\nrms_error_deg_s = { }', ":2: ", "max = "),
    ('[sine."1 deg/s, 0.1 Hz".azimuth]\nrms_error_deg_s = { max = 1.0 }', "", "has no limits"),
    ("[sine\n", ":1: ", "syntax"),
]


@pytest.mark.parametrize(("text", "line", "remedy"), REFUSED_LIMITS)
def test_limits_that_make_no_sense_are_refused_with_their_line(gate: Gate, tmp_path: Path, text: str, line: str, remedy: str) -> None:
    limits = tmp_path / "limits.toml"
    limits.write_text(text + "\n")
    verdict = gate.check("--limits", limits)
    assert verdict.code == 2
    assert f"{limits}{line}" in verdict.err
    assert remedy in verdict.err
    assert len(verdict.err.strip().splitlines()) == 1


REFUSED_GAINS = [
    ("[azimuth.disturbance_observer]\nbandwith = 100.0", ":2: "),
    ("[azimuth.disturbance_observer]\nbandwidth = -1.0", ":2: "),
    ('[azimuth.disturbance_observer]\nbandwidth = "fast"', ":2: "),
    ("[azimuth.disturbance_observer]\non = 0.5", ":2: "),
    ("[device]\nnode = 1", ":1: "),
]


@pytest.mark.parametrize(("text", "line"), REFUSED_GAINS)
def test_gains_that_the_firmware_has_not_are_refused_with_their_line(gate: Gate, tmp_path: Path, text: str, line: str) -> None:
    gains = tmp_path / "gains.toml"
    gains.write_text(text + "\n")
    verdict = gate.check("--gains", gains)
    assert verdict.code == 2
    assert f"{gains}{line}" in verdict.err
    assert len(verdict.err.strip().splitlines()) == 1


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("--plant", TRACKER), "--learn"),
        (("--baseline", TRACKER), "results.json"),
        (("--limits", "no-such-file.toml"), "no-such-file.toml"),
        (("--seeds", "1", "1"), "twice"),
        (("--no-such-option",), "--no-such-option"),
        (("--scenario", START, "--scenario", START), "already used"),
        (("--baseline-only-reports",), "--baseline"),
    ],
)
def test_wrong_input_ends_with_2_before_anything_runs(gate: Gate, arguments: tuple[str | Path, ...], message: str) -> None:
    verdict = gate.check(*arguments)
    assert verdict.code == 2
    assert message in verdict.out + verdict.err


def tunable_names() -> list[str]:
    from servoctl.objects.schema import load_schema

    return [parameter.name for parameter in load_schema(DESCRIPTIONS / "parameters.json").tunable]


def test_a_gains_file_has_the_same_names_for_servoctl_and_for_the_gate(gate: Gate, sim_host: Path, tmp_path: Path) -> None:
    from servoctl.gains.gains_file import read_gains, write_gains
    from servoctl.objects.schema import load_schema

    schema = load_schema(DESCRIPTIONS / "parameters.json")
    written = tmp_path / "gains.toml"
    subprocess.run([sim_host, "gains", "--plant", TRACKER, "--out", written], check=True, capture_output=True)
    values = read_gains(written, schema).values
    assert {parameter.name for parameter in values} == set(tunable_names())
    saved = tmp_path / "saved.toml"
    write_gains(saved, values, {"node": 1})
    verdict = gate.check(*ENOUGH, "--limits", LIMITS, "--gains", saved)
    assert verdict.code == 0, verdict.err + str(verdict.failures)


def test_a_whole_number_may_be_written_with_a_point_as_for_servoctl(gate: Gate, tmp_path: Path) -> None:
    """The rate estimator's window is 2 to 16 angles: 2.0 gets as far as the wrong limits."""
    gains = tmp_path / "gains.toml"
    wrong = tmp_path / "wrong.toml"
    wrong.write_text("nonsense = 1\n")
    for written, says in (("2.0", "nonsense"), ("2.5", "is not a whole number"), ("17.0", "17 is out of range"), ("true", "is not a whole number")):
        gains.write_text(f"[azimuth.rate_sensors]\nestimator_window = {written}\n")
        done = gate.check("--gains", gains, "--limits", wrong)
        assert done.code == 2 and says in done.err, (written, done.err)
