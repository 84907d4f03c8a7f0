# SPDX-License-Identifier: Apache-2.0
"""Synthetic pictures whose target is exactly where it is said to be."""

from __future__ import annotations

import cv2
import numpy as np
import numpy.typing as npt

from imager.picture import Grey

WIDTH, HEIGHT = 640, 480
DARK, DIM = 1000.0, 30.0
"""Levels of 12 bits: the target is less than two levels of 8 bits brighter than its background."""


class Scene:
    """A Gaussian spot in front of sky, or of clutter below `horizon` (a row)."""

    def __init__(self, seed: int = 1, noise: float = 2.0, horizon: int = HEIGHT, clutter: float = 12.0) -> None:
        self._random = np.random.default_rng(seed)
        self._noise = noise
        self.background = np.full((HEIGHT, WIDTH), 150.0)
        self.background += np.linspace(10.0, -10.0, HEIGHT)[:, None]
        if horizon < HEIGHT:
            ground = sum(
                (cv2.GaussianBlur(self._random.normal(size=(HEIGHT, WIDTH)), (0, 0), size) * size for size in (2, 4, 8, 16)),
                start=np.zeros((HEIGHT, WIDTH)),
            )
            ground *= clutter / float(ground.std())
            self.background[horizon:] = 110.0 + ground[horizon:]

    def picture(
        self, column: float | None = None, row: float = 0.0, contrast: float = -80.0, size: float = 4.0, shift: int = 0
    ) -> Grey:
        """`size` is the spot's deviation in pixels; `shift` moves the background to the right."""
        picture: npt.NDArray[np.float64] = np.roll(self.background, shift, axis=1).copy()
        if column is not None:
            across = np.exp(-0.5 * ((np.arange(WIDTH) - column) / size) ** 2)
            down = np.exp(-0.5 * ((np.arange(HEIGHT) - row) / size) ** 2)
            picture += contrast * np.outer(down, across)
        picture += self._noise * self._random.standard_normal(picture.shape, dtype=np.float32)
        return np.asarray(np.clip(np.rint(picture), 0, 255), dtype=np.uint8)


def dim(i: int) -> Grey:
    """12 bits in 16."""
    noise = np.random.default_rng(i).normal(DARK, 3.0, (HEIGHT, WIDTH))
    across = np.exp(-0.5 * ((np.arange(WIDTH) - 300.0 - i) / 4.0) ** 2)
    down = np.exp(-0.5 * ((np.arange(HEIGHT) - 200.0) / 4.0) ** 2)
    return np.asarray(np.rint(noise + DIM * np.outer(down, across)), dtype=np.uint16)
