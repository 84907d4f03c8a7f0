# SPDX-License-Identifier: Apache-2.0
"""A camera of Video4Linux: what is asked of it, and what it gives. A stand-in for OpenCV's takes the place of a real one."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
import pytest

from imager.camera import CameraMode, CameraSource
from imager.detector import find
from imager.errors import ImagerError

from .conftest import run_imager
from .pictures import dim

SIZES = {"YUYV": [(640, 480)], "MJPG": [(640, 480), (1920, 1080)], "Y16 ": [(640, 480)]}
RATES_HZ = (25.0, 50.0)


class _Driver:
    """Takes what it has and leaves the rest as it is. Pictures of 8 bits in three channels, unless told not to convert."""

    def __init__(self) -> None:
        self.is_open, self.converts, self.number = False, True, 0
        self.format, self.size, self.rate_hz = "YUYV", [640, 480], 25.0

    def open(self, *_: object) -> bool:
        self.is_open = True
        return True

    def release(self) -> None:
        self.is_open = False

    def get(self, what: int) -> float:
        return {
            cv2.CAP_PROP_FOURCC: float(cv2.VideoWriter.fourcc(*self.format)),
            cv2.CAP_PROP_FRAME_WIDTH: float(self.size[0]),
            cv2.CAP_PROP_FRAME_HEIGHT: float(self.size[1]),
            cv2.CAP_PROP_FPS: self.rate_hz,
        }.get(what, 0.0)

    def set(self, what: int, value: float) -> bool:
        if what == cv2.CAP_PROP_CONVERT_RGB:
            self.converts = value != 0.0
        elif what == cv2.CAP_PROP_FOURCC:
            self.format = {float(cv2.VideoWriter.fourcc(*name)): name for name in SIZES}.get(value, self.format)
        elif what in (cv2.CAP_PROP_FRAME_WIDTH, cv2.CAP_PROP_FRAME_HEIGHT):
            side = what == cv2.CAP_PROP_FRAME_HEIGHT
            self.size[side] = min((size[side] for size in SIZES[self.format]), key=lambda has: abs(has - value))
        elif what == cv2.CAP_PROP_FPS:
            self.rate_hz = min(RATES_HZ, key=lambda has: abs(has - value))
        return True

    def grab(self) -> bool:
        return True

    def retrieve(self) -> tuple[bool, cv2.typing.MatLike]:
        self.number += 1
        picture = dim(self.number)
        return True, cv2.cvtColor((picture >> 8).astype(np.uint8), cv2.COLOR_GRAY2BGR) if self.converts else picture


@pytest.fixture
def drivers(monkeypatch: pytest.MonkeyPatch) -> list[_Driver]:
    """Those that were opened."""
    opened: list[_Driver] = []

    def open_driver() -> _Driver:
        opened.append(_Driver())
        return opened[-1]

    monkeypatch.setattr(cv2, "VideoCapture", open_driver)
    return opened


def camera(mode: CameraMode) -> CameraSource:
    return CameraSource(0, "0", mode, "a camera")


def test_a_camera_of_16_bits_gives_them_all(drivers: list[_Driver]) -> None:
    picture = camera(CameraMode(pixel_format="Y16")).read()
    assert picture is not None and picture.grey.dtype == np.uint16
    found = find(picture.grey)
    assert found is not None and abs(found.column - 301.0) < 1.0 and abs(found.row - 200.0) < 1.0


def test_the_size_is_one_of_the_pixel_format(drivers: list[_Driver]) -> None:
    source = camera(CameraMode((1920, 1080), 50.0, "MJPG"))
    assert (drivers[0].format, drivers[0].size, source.rate_hz) == ("MJPG", [1920, 1080], 50.0)


@pytest.mark.parametrize(
    ("mode", "sentence"),
    [
        (CameraMode(size_px=(1920, 1080)), "has not the size 1920x1080, but 640x480;"),
        (CameraMode(pixel_format="GREY"), "has not the pixel format 'GREY' with this size and rate;"),
        (CameraMode(rate_hz=200.0), "has not 200 pictures per second, but 50;"),
    ],
)
def test_a_mode_that_a_camera_has_not_is_refused(drivers: list[_Driver], mode: CameraMode, sentence: str) -> None:
    with pytest.raises(ImagerError, match=sentence):
        camera(mode)
    assert not drivers[0].is_open


def test_a_format_that_opencv_cannot_convert_is_named(drivers: list[_Driver], monkeypatch: pytest.MonkeyPatch) -> None:
    source = camera(CameraMode())

    def retrieve() -> tuple[bool, cv2.typing.MatLike]:
        raise cv2.error("reshape")

    monkeypatch.setattr(drivers[0], "retrieve", retrieve)
    with pytest.raises(ImagerError, match="cannot be decoded; choose another --pixel-format"):
        source.read()


@pytest.mark.parametrize(
    ("options", "sentence"),
    [
        (("--size", "1920x1080"), "--size is for a camera; 'flight.mkv' has pictures of its own."),
        (("--pixel-format", "MJPG"), "--pixel-format is for a camera; 'flight.mkv' has pictures of its own."),
        (("--rate", "50"), "--rate is for a camera or a folder of pictures; 'flight.mkv' has times of its own."),
        (("--size", "1920"), "'1920' is not a size; expected WIDTHxHEIGHT in pixels, as 1920x1080."),
        (("--size", "640x0"), "'640x0' is not a size;"),
        (("--pixel-format", "M"), "'M' is not a pixel format; expected its name, as MJPG, YUYV, GREY or Y16."),
    ],
)
def test_what_is_not_asked_of_a_camera_is_refused(tmp_path: Path, options: tuple[str, ...], sentence: str) -> None:
    (tmp_path / "flight.mkv").touch()
    result = run_imager(tmp_path, "flight.mkv", "--no-bus", *options)
    assert result.code == 2 and sentence in result.err, result
