# SPDX-License-Identifier: Apache-2.0
"""Finding, following, losing and finding again; the accuracy of the centroid."""

from __future__ import annotations

import math

import numpy as np
import pytest

from imager.camera_frame import AGE, NODE_CLOCK, Result, payload
from imager.centroid import find_in_window
from imager.detector import find
from imager.follower import CONFIRMED, LOST, Follower, State
from imager.picture import DEFAULT_PIXEL_URAD, Optics

from .pictures import HEIGHT, WIDTH, Scene

HORIZON = 200


@pytest.mark.parametrize("contrast", [-80.0, 80.0, -35.0])
@pytest.mark.parametrize("size", [1.2, 4.0, 15.0, 30.0])
def test_an_object_on_sky_is_found_whether_bright_or_dark_small_or_large(contrast: float, size: float) -> None:
    blob = find(Scene().picture(431.3, 177.8, contrast, size))
    assert blob is not None
    assert blob.sign == math.copysign(1, contrast)
    assert math.hypot(blob.column - 431.3, blob.row - 177.8) < max(0.5, 0.1 * size)


@pytest.mark.parametrize("contrast", [-75.0, 110.0])
def test_an_object_on_clutter_is_found(contrast: float) -> None:
    for seed in range(5):
        blob = find(Scene(seed, horizon=HORIZON).picture(300.0, 350.0, contrast, 3.0))
        assert blob is not None
        assert math.hypot(blob.column - 300.0, blob.row - 350.0) < 1.5  # clutter pulls it


def test_nothing_is_followed_where_there_is_nothing() -> None:
    for seed in range(5):
        for horizon in (HEIGHT, HORIZON, 0):
            scene, follower = Scene(seed, horizon=horizon), Follower()
            assert all(follower.take(scene.picture(shift=4 * i)).quality == 0 for i in range(8))


def test_the_centroid_has_no_bias_within_a_pixel() -> None:
    scene = Scene(noise=0.3)
    for i in range(20):
        column, row = 200.0 + 0.05 * i, 150.0 + 0.037 * i
        blob = find_in_window(scene.picture(column, row, size=3.0), 200, 150, 24)
        assert blob is not None
        assert abs(blob.column - column) < 0.05
        assert abs(blob.row - row) < 0.05


@pytest.mark.parametrize(("contrast", "size", "limit_px"), [(-80.0, 3.0, 0.06), (-40.0, 5.0, 0.12), (60.0, 1.5, 0.08)])
def test_the_noise_of_the_centroid_is_what_it_states(contrast: float, size: float, limit_px: float) -> None:
    scene = Scene(noise=2.0)
    blobs = [find_in_window(scene.picture(320.4, 200.3, contrast, size), 320, 200, math.ceil(8 * size)) for _ in range(120)]
    places = np.array([(blob.column, blob.row) for blob in blobs if blob is not None])
    assert len(places) == len(blobs)
    measured = float(places.std(axis=0).max())
    stated = float(np.median([blob.noise_px for blob in blobs if blob is not None]))
    print(f"noise {measured:.4f} pixels = {measured * DEFAULT_PIXEL_URAD:.2f} µrad, stated {stated:.4f}")
    assert measured < limit_px
    assert 0.6 < stated / measured < 1.7


def follow(follower: Follower, scene: Scene, steps: int, column: float, row: float, contrast: float = -80.0) -> int:
    """Steps with a target that moves; returns how often it was found, and checks that it was found in its place."""
    found = 0
    for i in range(steps):
        x, y = column + 1.7 * i, row - 0.6 * i
        sighting = follower.take(scene.picture(x, y, contrast))
        if sighting.quality:
            found += 1
            assert math.hypot(sighting.column - x, sighting.row - y) < (4.0 if sighting.by_correlation else 0.5)
    return found


def test_a_target_is_confirmed_then_followed() -> None:
    follower = Follower()
    assert follow(follower, Scene(), 40, 200.0, 150.0) == 40 - (CONFIRMED - 1)


@pytest.mark.parametrize("tracker", ["kcf", "csrt"])
def test_a_target_is_followed_from_sky_into_clutter(tracker: str) -> None:
    follower, scene = Follower(tracker), Scene(3, horizon=HORIZON)
    found = 0
    for i in range(60):
        row = 160.0 + 1.5 * i
        sighting = follower.take(scene.picture(300.0 + i, row, -75.0))
        found += sighting.quality > 0 and math.hypot(sighting.column - 300.0 - i, sighting.row - row) < 5.0
    assert found >= 50


def test_a_lost_target_is_reported_and_found_again() -> None:
    follower, scene = Follower(), Scene()
    follow(follower, scene, 10, 200.0, 150.0)
    qualities = [follower.take(scene.picture()).quality for _ in range(LOST + 1)]
    assert qualities[-1] == 0
    assert follower.state is State.SEARCHING
    assert follow(follower, scene, 10, 450.0, 320.0) == 10 - (CONFIRMED - 1)


def test_a_short_dropout_needs_no_new_search() -> None:
    follower, scene = Follower("none"), Scene()
    follow(follower, scene, 10, 200.0, 150.0)
    for _ in range(4):
        assert follower.take(scene.picture()).quality == 0
    assert follower.state is State.FOLLOWING
    assert follow(follower, scene, 5, 200.0 + 1.7 * 14, 150.0 - 0.6 * 14) == 5


def test_a_weak_target_has_less_quality() -> None:
    def quality(contrast: float) -> int:
        blob = find_in_window(Scene(noise=4.0).picture(320, 200, contrast, 3.0), 320, 200, 24)
        return 0 if blob is None else blob.quality

    assert quality(-100.0) > quality(-45.0) > 0


def test_the_azimuth_grows_to_the_left_and_the_pitch_upwards() -> None:
    pixel = DEFAULT_PIXEL_URAD * 1e-6
    left_and_up = (0.5 * (WIDTH - 1) - 10.0, 0.5 * (HEIGHT - 1) - 20.0)
    assert Optics().error(*left_and_up, (HEIGHT, WIDTH)) == pytest.approx((10 * pixel, 20 * pixel))
    mirrored = Optics(azimuth_grows_right=True).error(*left_and_up, (HEIGHT, WIDTH))
    assert mirrored == pytest.approx((-10 * pixel, 20 * pixel))


def test_a_frame_has_counts_time_quality_and_counter() -> None:
    result = Result(123.4e-6, -45.6e-6, 0.01234, 77)
    assert payload(result, 1e-6, AGE, 258) == bytes((123, 0, 0xD2, 0xFF, 0xD2, 0x04, 77, 2))
    assert payload(result, 2e-6, AGE, 0)[:2] == bytes((62, 0))
    assert payload(Result(1.0, -1.0, 0.7, 1), 1e-6, AGE, 0)[:6] == bytes((0xFF, 0x7F, 0x01, 0x80, 0xFF, 0xFF))
    assert payload(Result(0.0, 0.0, 0.65537, 1), 1e-6, NODE_CLOCK, 0)[4:6] == bytes((1, 0))  # wraps as the clock does
    assert payload(Result(1e-3, 1e-3, 0.0, 0), 1e-6, AGE, 1)[:4] == bytes(4)  # no target, no error
