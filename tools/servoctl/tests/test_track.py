# SPDX-License-Identifier: Apache-2.0
"""servoctl track: both axes follow what a camera on the bus sees, and stop on command."""

from __future__ import annotations

import contextlib
import csv
import json
import math
import signal
import statistics
from collections.abc import Iterator
from pathlib import Path

import pytest

from .conftest import REAL_TIME, ROOT, Bench, serve
from .still_target import StillTarget

pytestmark = pytest.mark.real_time
CAMERA = "541"
PLACE = (0.8, 2.8)
"""Joint angles (°) near the target of sim_host/scenarios/tracking.toml before it flies."""
BORROWED = ("0x1403:1", "0x1603:0", "0x1603:1", "0x1802:1", "0x1A02:1", "0x6060", "0x6860")


@contextlib.contextmanager
def camera(servo: Bench) -> Iterator[StillTarget]:
    with StillTarget(servo.bus, int(CAMERA, 16), *PLACE) as target:
        yield target


def cued(*words: str) -> tuple[str, ...]:
    return ("track", "--camera-id", CAMERA, "--cue", "0.9", "2.7", "--slew-rate", "20", *words)


def borrowed(servo: Bench) -> list[int]:
    return [row["value"] for row in servo.json("get", *BORROWED)]


def states(servo: Bench) -> list[str]:
    return [axis["state"] for axis in servo.json("state")["axes"]]


@pytest.mark.image
@pytest.mark.smoke
def test_a_still_target_is_acquired_from_the_cue_and_held(servo: Bench) -> None:
    """The frames hold the encoders' angles, so the error is that of the loops: a few µrad in wind."""
    before = borrowed(servo)
    with camera(servo):
        done = servo(*cued("--seconds", "3.5", "--plot", "error.png", "--json", "--yes"))
    assert done.code == 0 and "has not seen" not in done.err, done.err
    *lines, found = [json.loads(line) for line in done.out.splitlines()]
    assert len(lines) >= 2
    for axis in found["axes"]:
        assert axis["last_state"] == "tracking" and axis["tracking_share"] > 0.5, axis
        assert axis["rms_urad"] < 100, axis
    assert abs(lines[-1]["axes"][0]["error_urad"]) < 100
    assert found["frames"]["taken"] > 60
    assert [(servo.folder / name).stat().st_size > 1000 for name in found["files"]] == [True, True]
    assert states(servo) == ["switch on disabled"] * 2 and borrowed(servo) == before


def test_a_lost_target_is_reported_and_ctrl_c_stops_in_control(servo: Bench) -> None:
    with camera(servo) as target:
        process = servo.start(*cued("--interval", "0.2", "--json", "--yes"))
        assert process.stdout is not None
        seen = []
        for line in process.stdout:
            seen.append(json.loads(line)["axes"][0]["state"])
            if seen[-1] == "tracking":
                target.visible = False
            if seen[-1] == "lost":
                break
            assert len(seen) < 100, seen
        process.send_signal(signal.SIGINT)
        out, err = process.communicate(timeout=60)
    assert process.returncode == 0, err
    assert json.loads(out.splitlines()[-1])["axes"][0]["last_state"] == "lost"
    assert states(servo) == ["switch on disabled"] * 2


def test_a_target_outside_the_picture_is_reported(servo: Bench) -> None:
    with camera(servo) as target:
        target.visible = False
        found = servo(*cued("--seconds", "4", "--yes"))
    assert found.code == 0
    assert "the camera has not seen the target for 3 s" in found.err and "--cue" in found.err


@pytest.mark.parametrize("command", [("track",), ("follow", "path.csv")])
def test_a_plot_that_cannot_be_written_is_refused_before_the_motion(servo: Bench, command: tuple[str, ...]) -> None:
    (servo.folder / "file").write_text("")
    for plot, words in (("error.xyz", "must end with .png"), ("file/error.png", "not a folder that you may write")):
        refused = servo(*command, "--plot", plot, "--yes")
        assert refused.code == 2 and words in refused.err, refused


def test_one_axis_alone(servo: Bench) -> None:
    with camera(servo):
        servo.json("move", "azimuth", "--to", str(PLACE[0] + 0.1), "--rate", "20", "--yes")
        found = servo(*cued("--axis", "pitch", "--seconds", "2", "--json", "--yes"))
    assert found.code == 0, found.err
    axes = json.loads(found.out.splitlines()[-1])["axes"]
    assert [axis["axis"] for axis in axes] == ["pitch"] and axes[0]["last_state"] == "tracking"


def test_a_target_that_is_too_fast_is_said_with_the_time_until_it_is_reached(servo: Bench) -> None:
    """7 mrad beside the line of sight, with at most 0.1 °/s for the azimuth: 4 s."""
    with camera(servo):
        servo.json("move", "azimuth", "--to", str(PLACE[0] + 0.4), "--rate", "20", "--yes")
        servo.json("move", "pitch", "--to", str(PLACE[1]), "--rate", "20", "--yes")
        before = servo.json("get", "0x607F")[0]["value"]
        servo.json("set", "0x607F", str(round(1e6 * math.radians(0.1))))
        try:
            done = servo("track", "--camera-id", CAMERA, "--interval", "0.2", "--seconds", "6", "--json", "--yes")
        finally:
            servo.json("set", "0x607F", str(before))
    assert done.code == 0, done.err
    lines = [json.loads(line) for line in done.out.splitlines()][:-1]
    said = [(line["time_s"], line["back_in_s"]) for line in lines if line["back_in_s"] is not None]
    back_s = next(line["time_s"] for line in lines if line["time_s"] > said[-1][0] and line["back_in_s"] is None)
    assert 3.0 < back_s < 4.5, said
    # The first predictions know the target's speed from a few frames only; those of the last 2 s are of the settled one.
    settled = [(at, back) for at, back in said if at > back_s - 2.0]
    assert len(settled) >= 4, said
    assert [at + back for at, back in settled] == pytest.approx([back_s] * len(settled), abs=0.5), said
    assert lines[-1]["back_in_s"] is None and lines[-1]["axes"][0]["state"] == "tracking"


def test_without_frames_nothing_moves(servo: Bench) -> None:
    before = [axis["position_deg"] for axis in servo.json("state")["axes"]]
    for words, reported in (
        (cued("--seconds", "3", "--yes"), "identifier 541"),
        (("track", "--yes"), "--camera-id"),
    ):
        refused = servo(*words)
        assert refused.code == 6 and "no frame of the camera arrives" in refused.err and reported in refused.err, refused
    assert servo("track", "--dry-run").code == 0
    assert servo("track").code == 2  # nobody has confirmed
    for words, reported in (
        (("--camera-id", "601"), "not an identifier"), (("--cue", "0", "300"), "607D"), (("--seconds", "0"), "0.001 or more"),
    ):  # fmt: skip
        refused = servo("track", *words, "--yes")
        assert refused.code == 2 and reported in refused.err, refused
    after = [axis["position_deg"] for axis in servo.json("state")["axes"]]
    assert after == pytest.approx(before, abs=0.05)


def test_frames_that_the_node_drops_are_reported_with_the_reason(servo: Bench) -> None:
    with camera(servo) as target:
        target.impossible = True
        refused = servo(*cued("--seconds", "3", "--yes"))
    assert refused.code == 6 and "drops every frame of the camera" in refused.err and "quality" in refused.err, refused


def test_a_device_without_the_mode_is_refused(test_node: Bench) -> None:
    refused = test_node("track", "--yes")
    assert refused.code == 6 and "no mode of operation for tracking (bit 16 of 6502" in refused.err


@pytest.mark.image
def test_the_fly_by_is_held_by_the_true_error(tmp_path: Path) -> None:
    """Frames of the simulated camera; what counts is what the line of sight truly misses."""
    truth = tmp_path / "truth.csv"
    scenario = ROOT / "sim_host" / "scenarios" / "tracking.toml"
    with serve(REAL_TIME, "--target", str(scenario), "--truth", str(truth)) as served:
        done = Bench(served.address, tmp_path)(*cued("--seconds", str(6 / float(REAL_TIME)), "--json", "--yes"))
    assert done.code == 0, done.err
    found = json.loads(done.out.splitlines()[-1])
    assert [axis["last_state"] for axis in found["axes"]] == ["tracking"] * 2
    with truth.open() as stream:
        rows = [row for row in csv.DictReader(stream) if 3.0 < float(row["flight_s"]) < 5.5]
    for name in ("cross_elevation_error_urad", "elevation_error_urad"):
        assert statistics.pstdev(float(row[name]) for row in rows) < 5.0


def test_a_cue_takes_the_azimuth_that_lasts_longest_and_says_it_before_it_moves(servo: Bench) -> None:
    """The travel is ±278°."""
    for words, angle in ((("270", "2.7"), "-90.000°"), (("100", "2.7"), "100.000°"), (("100", "2.7", "--cue-rate", "5"), "-260.000°")):
        shown = servo("track", "--cue", *words, "--dry-run")
        assert shown.code == 0 and f"first to azimuth {angle}" in shown.out, shown
        assert ("which lasts longer" in shown.out) == (angle != "100.000°"), shown.out
    refused = servo("track", "--cue-rate", "5", "--dry-run")
    assert refused.code == 2 and "give --cue, too" in refused.err
