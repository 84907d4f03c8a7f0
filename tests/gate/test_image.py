# SPDX-License-Identifier: Apache-2.0
"""The gate with the board's image on the emulated board: what makes it fail. test_steps has what lets it pass."""

from __future__ import annotations

import subprocess
from pathlib import Path

from conftest import BIN, PROJECT, Gate

IMAGE = PROJECT / "build/stm32g474/bin/trackservo.bin"
START = PROJECT / "sim_host/scenarios/board/low_speed_start.toml"
FLASH_BASE = 0x08000000
LIMITS = PROJECT / "sim_host/limits/tracker_board.toml"


def test_an_image_with_an_observer_gain_off_by_30_percent_is_red(gate: Gate, tmp_path: Path) -> None:
    gains = tmp_path / "gains.toml"
    gains.write_text("[azimuth.disturbance_observer]\nbandwidth = 153.9\n[pitch.disturbance_observer]\nbandwidth = 153.9\n")
    steady = PROJECT / "sim_host/scenarios/board/steady_speed.toml"
    verdict = gate.check("--image", IMAGE, "--gains", gains, "--scenario", steady, "--limits", LIMITS)
    assert verdict.code == 1, verdict.out
    assert any("rms_error_deg_s" in failure for failure in verdict.failures), verdict.failures


def test_a_damaged_image_is_red_and_says_so(gate: Gate, tmp_path: Path) -> None:
    damaged = bytearray(IMAGE.read_bytes())
    damaged[len(damaged) // 2] ^= 0xFF
    image = tmp_path / "damaged.bin"
    image.write_bytes(damaged)
    verdict = gate.check("--image", image, "--scenario", START, "--limits", LIMITS, "--seeds", "1")
    assert verdict.code == 1, verdict.out + verdict.err
    assert any("has no value in 1 of 1 seeds" in failure for failure in verdict.failures), verdict.failures


def test_an_image_that_never_runs_its_control_task_is_red_and_says_so(gate: Gate, tmp_path: Path) -> None:
    endless_loop = b"\xfe\xe7"
    damaged = bytearray(IMAGE.read_bytes())
    entry = (int.from_bytes(damaged[4:8], "little") & ~1) - FLASH_BASE
    damaged[entry : entry + 2] = endless_loop
    image = tmp_path / "endless.bin"
    image.write_bytes(damaged)
    verdict = gate.check("--image", image, "--scenario", START, "--limits", LIMITS, "--seeds", "1")
    assert verdict.code == 1, verdict.out + verdict.err
    assert any("the image does not run its control task" in failure for failure in verdict.failures), verdict.failures


def test_tracking_is_refused_on_the_image(gate: Gate) -> None:
    tracking = PROJECT / "sim_host/scenarios/tracking.toml"
    verdict = gate.check("--image", IMAGE, "--scenario", tracking, "--limits", LIMITS)
    assert verdict.code == 2
    assert f"{tracking}:" in verdict.err and "CiA 402" in verdict.err


def test_without_the_emulated_board_one_sentence_says_what_to_build(tmp_path: Path) -> None:
    alone = tmp_path / "check_wrong_observer"
    alone.write_bytes((BIN / "check_wrong_observer").read_bytes())
    alone.chmod(0o755)
    done = subprocess.run([alone, "check", "--image", IMAGE], capture_output=True, text=True)
    assert done.returncode == 2
    assert "--target emulate_board" in done.stderr
    assert len(done.stderr.strip().splitlines()) == 1
