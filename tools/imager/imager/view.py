# SPDX-License-Identifier: Apache-2.0
"""The scale of each picture, also when a stream changes the size of its pictures."""

from __future__ import annotations

from dataclasses import replace

import click

from .detector import check_size
from .picture import Optics, Picture

SAME_ASPECT = 0.02
"""Sizes whose ratios of the sides differ by less show the same field."""


def _same_field(shape: tuple[int, ...], first: tuple[int, ...]) -> bool:
    """Pictures of these sizes show the same field, one with smaller pixels: their sides have the same ratio."""
    return abs(shape[1] * first[0] / (shape[0] * first[1]) - 1.0) < SAME_ASPECT


class View:
    """The optics of each picture: those given are of the `first` size."""

    def __init__(self, optics: Optics) -> None:
        self._given = self._optics = optics
        self.first: tuple[int, ...] = ()
        self._shape: tuple[int, ...] = ()

    def of(self, picture: Picture) -> Optics:
        """Says so in one sentence when the size has changed; raises ImagerError for a picture that is too small."""
        shape = picture.grey.shape
        if shape != self._shape:
            check_size(shape)
            self.first = self.first or shape
            same = _same_field(shape, self.first)
            scale = self.first[1] / shape[1] if same else 1.0
            self._optics = replace(self._given, pixel_rad=scale * self._given.pixel_rad)
            if self._shape:
                why = "as the same field is seen" if same else "as the sides have another ratio: a part of the field is seen"
                click.echo(
                    f"imager: picture {picture.number} has {shape[1]} x {shape[0]} pixels instead of {self._shape[1]} x {self._shape[0]}:"
                    f" the target is searched again, with {1e6 * self._optics.pixel_rad:.5g} µrad per pixel, {why}.", err=True,
                )  # fmt: skip
            self._shape = shape
        return self._optics
