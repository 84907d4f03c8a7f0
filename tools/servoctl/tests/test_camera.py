# SPDX-License-Identifier: Apache-2.0
"""servoctl camera calibrate: a camera that is turned, mirrored or scaled, before a target that stands still."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator

import numpy as np
import pytest

from servoctl.errors import MotionError
from servoctl.motion.camera_fit import Pose, fit_camera, image_of

from .conftest import Bench
from .still_target import StillTarget

real_time = pytest.mark.real_time
CAMERA = "541"
PLACE = (0.8, 2.8)
OBJECTS = ("0x3071:1", "0x3071:2", "0x3071:7", "0x3071:8")
STANDS_URAD = 20.0
"""For so much an axis stands elsewhere after the steps."""
BORESIGHT = ("0x3071:3", "0x3071:4")
CALIBRATE = ("camera", "calibrate", "--camera-id", CAMERA, "--json", "--yes")


def values(servo: Bench, *objects: str) -> list[float]:
    return [row["value"] for row in servo.json("get", *(objects or OBJECTS))]


def point(servo: Bench) -> None:
    for axis, angle in zip(("azimuth", "pitch"), PLACE, strict=True):
        servo.json("move", axis, "--to", str(angle + 0.05), "--rate", "20", "--yes")


@pytest.fixture
def turned(request: pytest.FixtureRequest, servo: Bench) -> Iterator[StillTarget]:
    """A camera whose picture is turned, mirrored and scaled, and one frame of the angles, 20 ms, older than it states."""
    with StillTarget(servo.bus, int(CAMERA, 16), *PLACE) as target:
        target.roll_deg, target.mirrored, count_urad = request.param
        target.count_rad, target.older_angles = 1e-6 * count_urad, 1
        yield target


TURNED = [(180.0, False, 1.0), (90.0, False, 2.0), (0.0, True, 1.0), (-120.0, True, 0.5), (50.0, False, 1.0)]


@real_time  # the image beside a busy computer does not keep the camera's time: test_board_tracking has them there
@pytest.mark.alone  # beside other tests frames come too late to be judged before the target has left the picture
@pytest.mark.parametrize("turned", TURNED, indirect=True)
def test_a_wrong_picture_stops_tracking_and_is_named(servo: Bench, turned: StillTarget) -> None:
    point(servo)
    wrong = servo("track", "--camera-id", CAMERA, "--seconds", "2", "--json", "--yes")
    assert "camera calibrate" in wrong.err, wrong.err
    roll = re.search(r"turned by (\d+)°", wrong.err)  # the age is wrong, too; one direction does not tell a mirror
    assert ("mirrored" in wrong.err or roll) if turned.mirrored else roll, wrong.err
    assert turned.mirrored or not roll or float(roll[1]) == pytest.approx(abs(turned.roll_deg), abs=15.0)


@real_time
@pytest.mark.alone
@pytest.mark.parametrize(
    "turned", [TURNED[1], *(pytest.param(way, marks=pytest.mark.image) for way in (TURNED[0], TURNED[3]))], indirect=True
)
def test_a_camera_is_calibrated_before_a_still_target(servo: Bench, turned: StillTarget) -> None:
    before = values(servo)
    point(servo)
    found = servo.json(*CALIBRATE)
    assert found["scale_rad"] == pytest.approx(turned.count_rad, rel=0.01)
    assert found["mirrored"] is turned.mirrored
    wanted = -turned.roll_deg if not turned.mirrored else turned.roll_deg
    assert math.remainder(found["roll_deg"] - wanted, 360.0) == pytest.approx(0.0, abs=0.5)
    assert found["delay_ms"] == pytest.approx(20.0, abs=12.0)  # of two programs on a computer that is not real-time
    right = servo("track", "--camera-id", CAMERA, "--seconds", "3", "--json", "--yes")
    assert '"last_state":"tracking"' in right.out.replace(" ", "").splitlines()[-1] and "calibrate" not in right.err
    assert servo("undo").code == 0
    assert values(servo) == before


@real_time
@pytest.mark.alone
def test_a_laser_that_is_pointed_at_the_target_is_the_boresight(servo: Bench) -> None:
    before = values(servo, *BORESIGHT)
    with StillTarget(servo.bus, int(CAMERA, 16), *PLACE) as target:
        target.count_rad *= 2.0
        point(servo)
        shown = servo(*(word for word in CALIBRATE if word != "--json"), "--boresight", "--delay", "0")
        assert re.search(r"boresight x \(3071:3\) .* ± .* 0\.0 µrad", shown.out), shown
        found = values(servo, *BORESIGHT)
        again = servo.json(*CALIBRATE, "--no-write")
    for now, kept in zip(again["target_urad"], found, strict=True):
        assert now == pytest.approx(1e6 * kept, abs=STANDS_URAD), (again, found)
    assert servo("undo").code == 0
    assert values(servo, *BORESIGHT) == before


@real_time
def test_what_cannot_be_calibrated_is_refused_and_nothing_is_written(servo: Bench) -> None:
    before = values(servo)
    with StillTarget(servo.bus, int(CAMERA, 16), *PLACE) as target:
        target.roll_deg = 180.0
        point(servo)
        dry = servo.json(*CALIBRATE[:-1], "--dry-run")
        assert dry["dry_run"] and dry["plan"]["step_deg"] == pytest.approx(0.2)
        only = servo.json(*CALIBRATE, "--no-write")
        assert only["changes"] == [] and abs(only["roll_deg"]) == pytest.approx(180.0, abs=0.5)
        far = servo(*CALIBRATE, "--step", "2")
        assert far.code == 6 and "stay in the picture" in far.err and "--step" in far.err, far
        target.visible = False
        blind = servo(*CALIBRATE)
        assert blind.code == 6 and "does not see the target" in blind.err, blind
    silent = servo(*CALIBRATE)
    assert silent.code == 6 and "541" in silent.err, silent
    beyond = servo(*CALIBRATE, "--step", "120")
    assert beyond.code == 2 and "would move to" in beyond.err, beyond
    assert values(servo) == before


def poses(roll: float, mirrored: bool, scale: float, pitch: float, noise_rad: float, seed: int = 0) -> list[Pose]:
    """The steps of the command, 3.5 mrad, with a noise on angles and picture."""
    draw = np.random.default_rng(seed)
    target = (0.1 + 2e-3 / math.cos(pitch), pitch + 3e-3)
    found = []
    for azimuth, elevation in [(0, 0), (1, 0), (-1, 0), (0, 1), (0, -1), (0, 0)] * 2:
        at = 0.1 + 3.5e-3 * azimuth / math.cos(pitch), pitch + 3.5e-3 * elevation
        x, y = image_of(target, *at)
        back = complex(x, y) * complex(math.cos(roll), -math.sin(roll)) / scale
        seen = (-back.real if mirrored else back.real) + draw.normal() * noise_rad / scale, back.imag + draw.normal() * noise_rad / scale
        found.append(Pose(at[0] + draw.normal() * noise_rad, at[1] + draw.normal() * noise_rad, *seen))
    return found


@pytest.mark.parametrize("pitch", [-0.3, 0.0, 1.2])
@pytest.mark.parametrize(("roll", "mirrored", "scale"), [(0.0, False, 1e-6), (3.0, False, 2e-6), (-2.0, True, 1e-5), (1.5, True, 5e-7)])
def test_the_fit_is_exact_without_noise(roll: float, mirrored: bool, scale: float, pitch: float) -> None:
    fit = fit_camera(poses(roll, mirrored, scale, pitch, 0.0))
    assert fit.scale_rad == pytest.approx(scale, rel=1e-6) and fit.mirrored is mirrored
    assert fit.roll_rad == pytest.approx(roll, abs=1e-6)
    assert fit.at_first == pytest.approx(image_of((0.1 + 2e-3 / math.cos(pitch), pitch + 3e-3), 0.1, pitch), rel=1e-6)
    assert fit.anisotropy < 1e-6


def test_the_intervals_hold_nineteen_times_of_twenty() -> None:
    runs = [fit_camera(poses(1.0, True, 1e-6, 0.7, 3e-6, seed)) for seed in range(400)]
    scale = np.mean([abs(fit.scale_rad - 1e-6) < fit.scale_half for fit in runs])
    roll = np.mean([abs(fit.roll_rad - 1.0) < fit.roll_half for fit in runs])
    assert 0.92 < scale < 0.98 and 0.92 < roll < 0.98
    place = image_of((0.1 + 2e-3 / math.cos(0.7), 0.7 + 3e-3), 0.1, 0.7)
    for axis in range(2):
        assert np.mean([abs(fit.at_first[axis] - place[axis]) < fit.at_first_half[axis] for fit in runs]) > 0.92


def test_pictures_that_do_not_answer_are_no_fit() -> None:
    still = [Pose(at.azimuth_rad, at.pitch_rad, 100.0, 200.0) for at in poses(0.0, False, 1e-6, 0.0, 0.0)]
    line = [Pose(at.azimuth_rad, at.pitch_rad, at.x, 0.0) for at in poses(0.0, False, 1e-6, 0.0, 0.0)]
    for wrong in (still, line, still[:3]):
        with pytest.raises(MotionError):
            fit_camera(wrong)
