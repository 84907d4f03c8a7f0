# SPDX-License-Identifier: Apache-2.0
"""Pictures as cameras and programs write them: at their own times, of changing size, with more than 8 bits."""

from __future__ import annotations

import math
import re
import time
from fractions import Fraction
from pathlib import Path

import av
import cv2
import numpy as np
import pytest
from av.video.stream import VideoStream

from imager.centroid import find_in_window, median
from imager.detector import find
from imager.picture import Grey, UsedBits
from imager.sources import NewestPicture, open_source

from .conftest import Result, run_imager
from .pictures import HEIGHT, WIDTH, Scene, dim



def video_at(file: Path, times_s: list[float], form: str = "yuv420p", codec: str = "ffv1") -> Path:
    """Its pictures have these times, and a spot that moves by 100 columns per second."""
    scene = Scene()
    with av.open(str(file), "w") as container:
        stream = container.add_stream(codec, rate=25)
        assert isinstance(stream, VideoStream)
        stream.width, stream.height, stream.pix_fmt = WIDTH, HEIGHT, form
        stream.codec_context.time_base = Fraction(1, 1000)
        for at_s in times_s:
            frame = av.VideoFrame.from_ndarray(scene.picture(200.0 + 100.0 * at_s, 200.0), format="gray").reformat(format=form)
            frame.pts, frame.time_base = round(1000 * at_s), Fraction(1, 1000)
            container.mux(stream.encode(frame))
        container.mux(stream.encode())
    return file


def uneven() -> list[float]:
    """25 pictures in 1 s, then 5 in 1 s, then 20 in half a second."""
    return [0.04 * i for i in range(25)] + [1.0 + 0.2 * i for i in range(5)] + [2.0 + 0.025 * i for i in range(20)]


def test_a_video_is_played_at_the_times_of_its_pictures(tmp_path: Path) -> None:
    times_s = uneven()
    source = open_source(str(video_at(tmp_path / "uneven.mkv", times_s)))
    begin_s = time.monotonic()
    pictures = list(NewestPicture(source))
    assert times_s[-1] - 0.1 < time.monotonic() - begin_s < times_s[-1] + 3.0  # a loaded computer plays it later
    assert [picture.file_s for picture in pictures] == pytest.approx(times_s, abs=0.001)
    late_s = np.array([picture.exposed_s for picture in pictures]) - times_s
    assert np.all(np.diff(late_s) > -1e-6)


def test_a_time_lapse_is_slow_and_its_recording_lasts_as_long(tmp_path: Path) -> None:
    video_at(tmp_path / "lapse.mkv", [0.0, 1.0, 2.0, 3.0])
    begin_s = time.monotonic()
    result = run_imager(tmp_path, "lapse.mkv", "--no-bus", "--record", "seen.mkv")
    assert result.code == 0 and time.monotonic() - begin_s > 2.9, result
    with av.open(str(tmp_path / "seen.mkv")) as container:
        assert [frame.time for frame in container.decode(video=0)] == pytest.approx([0.0, 1.0, 2.0, 3.0], abs=0.01)


def test_a_target_is_followed_over_uneven_times(tmp_path: Path) -> None:
    """It moves by 20 columns, then by 2.5: the place expected in the next picture goes by time, not by count."""
    video_at(tmp_path / "uneven.mkv", uneven())
    result = run_imager(tmp_path, "uneven.mkv", "--no-bus", "--tracker", "none")
    assert "target found in 48 of 50 pictures, lost 0 times" in result.out, result


# --- sizes ------------------------------------------------------------------------------------------------------------


def changing(folder: Path, width: int, height: int) -> Path:
    """40 pictures of 640 x 480 pixels, then 60 of another size with the same target, as a stream that adapts its rate.

    The change comes while the target is before ground, where the correlation tracker follows it.
    """
    scene, file = Scene(horizon=240), folder / "changing.mjpeg"
    with file.open("wb") as stream:
        for i in range(100):
            picture: cv2.typing.MatLike = scene.picture(300.0 + i, 200.0 + 70.0 * math.sin(i * math.pi / 80.0))
            if i >= 40:
                picture = cv2.resize(picture, (width, height), interpolation=cv2.INTER_AREA)
            stream.write(cv2.imencode(".jpg", picture)[1].tobytes())
    return file


@pytest.mark.parametrize("tracker", ["kcf", "csrt"])
@pytest.mark.parametrize(("width", "height", "words"), [
    (320, 240, "with 22.998 µrad per pixel, as the same field is seen"),
    (640, 360, "with 11.499 µrad per pixel, as the sides have another ratio"),
])  # fmt: skip
def test_pictures_that_change_their_size(tmp_path: Path, tracker: str, width: int, height: int, words: str) -> None:
    changing(tmp_path, width, height)
    result: Result = run_imager(tmp_path, "changing.mjpeg", "--no-bus", "--tracker", tracker, "--record", "seen.avi")
    assert result.code == 0, result
    assert result.err.startswith(f"imager: picture 41 has {width} x {height} pixels instead of 640 x 480: the target is searched again,")
    assert words in result.err and result.err.count("\n") == 1
    assert "pictures: 100" in result.out
    recorded = cv2.VideoCapture(str(tmp_path / "seen.avi"))
    sizes = []
    while (read := recorded.read())[0]:
        sizes.append(read[1].shape[:2])
    assert sizes == [(480, 640)] * 100
    found = re.search(r"target found in (\d+) of 100 pictures", result.out)
    assert found is not None and int(found.group(1)) > (50 if words.endswith("seen") else 35)


# --- more than 8 bits -------------------------------------------------------------------------------------------------


def seen(result: Result) -> None:
    assert result.code == 0 and "target found in 10 of 12 pictures, lost 0 times" in result.out, result


@pytest.mark.parametrize("ending", [".png", ".tiff", ".pgm"])
@pytest.mark.parametrize("shift", [0, 4])
def test_a_dim_target_is_found_in_a_folder_of_pictures(tmp_path: Path, ending: str, shift: int) -> None:
    """The 12 bits are the low or the high ones of 16."""
    (tmp_path / "night").mkdir()
    for i in range(12):
        assert cv2.imwrite(str(tmp_path / f"night/{i}{ending}"), dim(i) << shift)
    seen(run_imager(tmp_path, "night", "--no-bus", "--rate", "50", "--record", "seen.avi"))


def test_a_dim_target_is_found_in_the_pages_of_a_tiff(tmp_path: Path) -> None:
    assert cv2.imwritemulti(str(tmp_path / "night.tif"), [dim(i) for i in range(12)])
    seen(run_imager(tmp_path, "night.tif", "--no-bus", "--rate", "50"))


@pytest.mark.parametrize(("form", "codec", "coarser"), [("yuv420p10le", "ffv1", 2), ("gray12le", "ffv1", 0), ("yuv422p12le", "ffv1", 0)])
def test_a_dim_target_is_found_in_a_video_of_10_and_12_bits(tmp_path: Path, form: str, codec: str, coarser: int) -> None:
    with av.open(str(tmp_path / "night.mkv"), "w") as container:
        stream = container.add_stream(codec, rate=50)
        assert isinstance(stream, VideoStream)
        stream.width, stream.height, stream.pix_fmt = WIDTH, HEIGHT, form
        for i in range(12):
            frame = av.VideoFrame(WIDTH, HEIGHT, form)
            for plane in frame.planes:
                plane.update(np.full(plane.buffer_size // 2, 2048 >> coarser, np.uint16).tobytes())
            luma = frame.planes[0]
            rows = np.zeros((HEIGHT, luma.line_size // 2), np.uint16)
            rows[:, :WIDTH] = dim(i) >> coarser
            luma.update(rows.tobytes())
            container.mux(stream.encode(frame))
        container.mux(stream.encode())
    seen(run_imager(tmp_path, "night.mkv", "--no-bus"))


def test_bits_that_are_never_used_do_not_count_as_steps() -> None:
    used = UsedBits()
    assert used.take(np.array([[0, 16, 48]], dtype=np.uint16)).tolist() == [[0, 1, 3]]
    assert used.take(np.array([[4, 16, 48]], dtype=np.uint16)).tolist() == [[1, 4, 12]]
    assert used.take(np.array([[16, 48]], dtype=np.uint16)).tolist() == [[4, 12]]


@pytest.mark.parametrize("most", [4000, 65536])
def test_the_median_of_16_bits_is_that_of_the_sorted_values(most: int) -> None:
    window = np.random.default_rng(most).integers(0, most, (31, 33)).astype(np.uint16)
    found = median(window, 7)
    expected = np.median(np.lib.stride_tricks.sliding_window_view(np.pad(window, 3, mode="edge"), (7, 7)), axis=(2, 3))
    assert np.max(np.abs(found.astype(float) - expected)) <= (0 if most <= 4096 else 15)


def test_a_bright_pedestal_hides_no_dim_target() -> None:
    picture = np.asarray(dim(0) + np.uint16(60000), dtype=np.uint16)
    found = find(picture)
    assert found is not None and abs(found.column - 300.0) < 1.0
    assert find_in_window(picture, 300.0, 200.0, 24) is not None


def test_pixels_of_another_kind_are_refused(tmp_path: Path) -> None:
    assert cv2.imwrite(str(tmp_path / "float.tiff"), np.zeros((HEIGHT, WIDTH), dtype=np.float32))
    result = run_imager(tmp_path, "float.tiff", "--no-bus")
    assert result.code == 2 and "'float.tiff': a picture has pixels of float32; expected whole numbers of 8 or 16 bits" in result.err
