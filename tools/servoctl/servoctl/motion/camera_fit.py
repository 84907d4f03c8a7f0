# SPDX-License-Identifier: Apache-2.0
"""How a camera sits on the line of sight: the fit of what it saw of a still target from several joint angles.

With the counts m of a picture (3070:1, :2), the target's true place in the image of the line of sight is B m. B holds
two scales, a roll and a shear; the node has one scale (3071:1), a roll (3071:2), and whether x is mirrored (3071:7):

    B = scale R(roll) P,   P = 1 or, mirrored, diag(-1, 1)

The place follows from the joint angles and the target's direction, which is estimated, too (a pinhole camera on azimuth
and pitch, as in firmware/control/line_of_sight.h). Gauss-Newton from a target in the line of sight of the first pose.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..errors import MotionError

Real = NDArray[np.float64]

T_95 = (12.71, 4.30, 3.18, 2.78, 2.57, 2.45, 2.36, 2.31, 2.26, 2.23, 2.20, 2.18, 2.16, 2.14, 2.13, 2.12, 2.11, 2.10, 2.09, 2.09)
"""Student's t, two-sided 95 %, by degrees of freedom from 1 on; 1.96 has no end."""
_ITERATIONS = 6
_FEWEST = 4


@dataclass(frozen=True)
class Pose:
    """Joint angles (rad), and the mean of the counts that the camera saw there."""

    azimuth_rad: float
    pitch_rad: float
    x: float
    y: float


@dataclass(frozen=True)
class CameraFit:
    """The mounting, with half the 95 % intervals; `anisotropy` is the larger scale over the smaller one, minus 1."""

    scale_rad: float
    roll_rad: float
    mirrored: bool
    scale_half: float
    roll_half: float
    anisotropy: float
    rms_rad: float
    """What the fit leaves, root mean square of a coordinate."""
    at_first: tuple[float, float]
    """The target's place at the first pose along azimuth and pitch, rad."""
    at_first_half: tuple[float, float]
    """The noise of the first pose included."""


def image_of(target: Sequence[float] | Real, azimuth_rad: float, pitch_rad: float) -> tuple[float, float]:
    """Where a target at joint angles is in the image of the line of sight, rad (tangents)."""
    turn = target[0] - azimuth_rad
    c_t, s_t, c, s = math.cos(target[1]), math.sin(target[1]), math.cos(pitch_rad), math.sin(pitch_rad)
    ahead = c_t * math.cos(turn) * c + s_t * s
    return c_t * math.sin(turn) / ahead, (s_t * c - c_t * math.cos(turn) * s) / ahead


def _residuals(unknown: Real, poses: Sequence[Pose]) -> Real:
    found = []
    for pose in poses:
        x, y = image_of(unknown[4:6], pose.azimuth_rad, pose.pitch_rad)
        found += [unknown[0] * pose.x + unknown[1] * pose.y - x, unknown[2] * pose.x + unknown[3] * pose.y - y]
    return np.array(found)


def _mounting(unknown: Real) -> tuple[float, float, bool, float]:
    """Scale, roll, mirrored, anisotropy of B."""
    b = unknown[:4].reshape(2, 2)
    mirrored = float(np.linalg.det(b)) < 0.0
    turned = b @ np.diag([-1.0, 1.0]) if mirrored else b
    roll = math.atan2(turned[1, 0] - turned[0, 1], turned[0, 0] + turned[1, 1])
    sizes = np.linalg.svd(b, compute_uv=False)
    return math.sqrt(sizes[0] * sizes[1]), roll, mirrored, float(sizes[0] / sizes[1]) - 1.0


def fit_camera(poses: Sequence[Pose]) -> CameraFit:
    """Raises MotionError when the pictures do not tell the mounting: they did not move with the axes."""
    if len(poses) < _FEWEST:
        raise MotionError(f"{len(poses)} places of the axes do not tell how the camera sits: at least {_FEWEST} are needed.")
    counts = np.array([(p.x, p.y) for p in poses])
    spread = np.linalg.svd(counts - counts.mean(axis=0), compute_uv=False)
    if spread[1] < 0.05 * spread[0] or spread[0] == 0.0:
        raise MotionError(
            "the target's place in the picture did not move with both axes: is it the target that was meant, and is its"
            " picture live?"
        )
    places = np.array([image_of((poses[0].azimuth_rad, poses[0].pitch_rad), p.azimuth_rad, p.pitch_rad) for p in poses])
    first, *_ = np.linalg.lstsq(counts - counts[0], places, rcond=None)
    at = counts[0] @ first
    unknown = np.array([*first.T.ravel(), poses[0].azimuth_rad + at[0] / math.cos(poses[0].pitch_rad), poses[0].pitch_rad + at[1]])
    unit = np.array([1e-9] * 4 + [1e-7] * 2)
    for _ in range(_ITERATIONS):
        left = _residuals(unknown, poses)
        slope = np.array([(_residuals(unknown + step, poses) - left) / step.max() for step in np.diag(unit)]).T
        move, *_ = np.linalg.lstsq(slope / unit_scale(slope), -left, rcond=None)
        unknown = unknown + move / unit_scale(slope)
    left = _residuals(unknown, poses)
    freedom = len(left) - len(unknown)
    variance = float(left @ left) / freedom
    scaled = slope / unit_scale(slope)
    covariance = variance * np.linalg.inv(scaled.T @ scaled) / np.outer(unit_scale(slope), unit_scale(slope))
    scale, roll, mirrored, anisotropy = _mounting(unknown)
    by = np.array([
        [(a - b) / step.max() for a, b in zip(_mounting(unknown + step)[:2], (scale, roll), strict=True)] for step in np.diag(unit)
    ])  # fmt: skip
    t = T_95[freedom - 1] if freedom <= len(T_95) else 2.0
    half = t * np.sqrt(np.diag(by.T @ covariance @ by))
    at_first = image_of(unknown[4:6], poses[0].azimuth_rad, poses[0].pitch_rad)
    at_by = np.array([
        [(a - b) / step.max() for a, b in zip(image_of((unknown + step)[4:6], poses[0].azimuth_rad, poses[0].pitch_rad), at_first, strict=True)]
        for step in np.diag(unit)
    ])  # fmt: skip
    at_half = t * np.sqrt(np.diag(at_by.T @ covariance @ at_by) + variance)
    return CameraFit(
        scale, roll, mirrored, float(half[0]), float(half[1]), anisotropy, math.sqrt(variance), at_first, (float(at_half[0]), float(at_half[1]))
    )


def unit_scale(slope: Real) -> Real:
    """Norm of each column: counts and angles differ by six decades."""
    return np.asarray(np.linalg.norm(slope, axis=0))
