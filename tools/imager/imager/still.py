# SPDX-License-Identifier: Apache-2.0
"""Pictures in files of their own (PNG, TIFF, PGM ...): a folder of them, or the pages of one TIFF file."""

from __future__ import annotations

import re
import time
from collections.abc import Iterator
from pathlib import Path

import cv2

from .errors import ImagerError
from .picture import Picture, UsedBits, grey_of

ENDINGS = (".png", ".tif", ".tiff", ".pgm", ".bmp", ".jpg", ".jpeg")
PAGED = (".tif", ".tiff")


def is_still(path: Path) -> bool:
    """A folder, or a file with one of the ENDINGS."""
    return path.is_dir() or path.suffix.lower() in ENDINGS


def _in_order(name: str) -> list[tuple[int, str]]:
    """9.png comes before 10.png."""
    return [(int(part), "") if part.isdecimal() else (0, part) for part in re.split(r"(\d+)", name)]


def _files(path: Path) -> list[Path]:
    if not path.is_dir():
        return [path]
    found = [file for file in path.iterdir() if file.suffix.lower() in ENDINGS and file.is_file()]
    if not found:
        raise ImagerError(f"the folder '{path}' has no pictures; expected files that end with {', '.join(ENDINGS)}.")
    return sorted(found, key=lambda file: _in_order(file.name))


def _pages(file: Path) -> Iterator[cv2.typing.MatLike]:
    """With all their bits; raises ImagerError for a file that is no picture."""
    pages = cv2.imcount(str(file)) if file.suffix.lower() in PAGED else 1
    for page in range(max(1, pages)):
        good, values = cv2.imreadmulti(str(file), page, 1, flags=cv2.IMREAD_UNCHANGED)
        if not good:
            raise ImagerError(f"'{file}' is not a picture that OpenCV can read; remove or convert it.")
        yield values[0]


class StillSource:
    """Shows them at `rate_hz`: the files say no times."""

    node_clock = False
    waits = True
    is_playlist = False
    damage = ""

    def __init__(self, path: Path, rate_hz: float) -> None:
        self.rate_hz = rate_hz
        self._pictures = ((file, page) for file in _files(path) for page in _pages(file))
        self._used_bits = UsedBits()
        self._due_s: float | None = None
        self._number = 0

    def read(self) -> Picture | None:
        """The next picture, when it is due; None at the end."""
        file, values = next(self._pictures, (None, None))
        if file is None or values is None:
            return None
        grey = self._used_bits.take(grey_of(values, f"'{file}'"))
        now_s = time.monotonic()
        self._due_s = now_s if self._due_s is None else max(now_s, self._due_s + 1.0 / self.rate_hz)
        time.sleep(self._due_s - now_s)
        self._number += 1
        return Picture(grey, self._number, self._due_s, time.monotonic())

    def close(self) -> None:
        """Nothing is open between pictures."""
