# SPDX-License-Identifier: Apache-2.0
"""The identified friction model beside the measurements: curves for the report.

The equations are those of docs/identification.md: steady friction (5), LuGre (1) to (3) along a measured motion,
friction level and load over the joint angle.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..identify.identified import Estimate, Identified
from ..identify.recorder import HYSTERESIS, SPEED_SWEEP
from ..units import TICK_S

Real = NDArray[np.float64]
Columns = dict[str, Real]

DIRECTIONS = ("positive", "negative")
SHORTEST_LEG = 50
"""Ticks at one set-point that make a point of the Stribeck curve."""
LEG_BAND = 0.3
"""Maximum deviation of the mean speed of a leg from its set-point, as a share of it."""


@dataclass(frozen=True)
class Legs:
    """Means over the later half of each leg at a constant speed: joint rate, rad/s, and torque, N m, both signed."""

    rate_rad_s: Real
    torque_nm: Real


def legs(run: Columns) -> Legs:
    """Like the paper's measurement of the Stribeck curve, eqs (4) to (7)."""
    rates, torques = [], []
    same = (np.diff(run["reference"]) == 0) & (np.diff(run["run"]) == 0) & (np.diff(run["time_s"]) < 1.5 * TICK_S)
    edges = np.concatenate([[0], np.flatnonzero(~same) + 1, [len(run["time_s"])]])
    for first, last in zip(edges[:-1], edges[1:], strict=True):
        reference = run["reference"][first]
        if last - first < SHORTEST_LEG or reference == 0.0 or run["kind"][first] != SPEED_SWEEP:
            continue
        half = slice((first + last) // 2, last)
        span_s = TICK_S * (half.stop - half.start - 1)
        rate = (run["joint_angle_rad"][half.stop - 1] - run["joint_angle_rad"][half.start]) / span_s
        if abs(rate - reference) <= LEG_BAND * abs(reference):
            rates.append(rate)
            torques.append(run["torque_nm"][half].mean())
    return Legs(np.array(rates), np.array(torques))


def steady_friction_nm(identified: Identified, direction: str, speed_rad_s: Real, paper: bool = False) -> Real | None:
    """Eq. (5) of one direction at speeds above 0; None when a parameter of it was refused."""

    def known(estimate: Estimate) -> float | None:
        return estimate.paper if paper else estimate.value

    names = (f"coulomb_{direction}", f"breakaway_{direction}", f"stribeck_speed_{direction}", f"viscous_{direction}")
    values = [known(identified.estimates[name]) for name in names]
    if any(value is None for value in values):
        return None
    coulomb, breakaway, stribeck, viscous = (float(value or 0.0) for value in values)
    if stribeck <= 0:
        return None
    fall = np.exp(-np.square(speed_rad_s / stribeck))
    torque: Real = coulomb + (breakaway - coulomb) * fall + viscous * speed_rad_s
    return torque


def friction_points(identified: Identified, points: Legs, direction: str) -> tuple[Real, Real]:
    """Speed, rad/s, and friction, N m, of the legs of one direction: their torque without the constant load."""
    load = sum(row["value"] for row in identified.data["position"]["load_nm"] if row["term"] == "1")
    sign = 1.0 if direction == DIRECTIONS[0] else -1.0
    mine = sign * points.rate_rad_s > 0
    return sign * points.rate_rad_s[mine], sign * (points.torque_nm[mine] - load)


def over_position(identified: Identified, terms: list[dict[str, Any]], angle_rad: Real) -> Real:
    """The sum of terms of "friction_level" or "load_nm" at joint angles."""
    low, high = identified.data["position"]["travel_rad"]
    x = (2 * angle_rad - low - high) / (high - low) if high > low else np.zeros_like(angle_rad)
    shapes = {
        "1": np.ones_like(angle_rad), "cos(angle)": np.cos(angle_rad), "sin(angle)": np.sin(angle_rad),
        "cos(2 angle)": np.cos(2 * angle_rad), "sin(2 angle)": np.sin(2 * angle_rad), "P1(travel)": x,
        "P2(travel)": 0.5 * (3 * x**2 - 1),
    }  # fmt: skip
    return np.asarray(sum((row["value"] * shapes[row["term"]] for row in terms), np.zeros_like(angle_rad)))


def lugre_nm(identified: Identified, angle_rad: Real) -> Real | None:
    """LuGre friction along a motion, a sample each tick, bristles relaxed at first; None if a parameter is refused."""
    values = {name: estimate.value for name, estimate in identified.estimates.items()}
    if any(value is None for value in values.values()):
        return None
    p = {name: float(value or 0.0) for name, value in values.items()}
    rate = np.gradient(angle_rad, TICK_S)
    bristle, torque = 0.0, np.zeros(len(rate))
    for i, v in enumerate(rate):
        side = DIRECTIONS[0] if v >= 0 else DIRECTIONS[1]
        fall = np.exp(-((v / p[f"stribeck_speed_{side}"]) ** 2))
        level = p[f"coulomb_{side}"] + (p[f"breakaway_{side}"] - p[f"coulomb_{side}"]) * fall
        decay = np.exp(-p["stiffness"] * abs(v) * TICK_S / level)
        before = bristle
        bristle = np.copysign(level, v) * (1 - decay) + bristle * decay
        torque[i] = bristle + p["damping"] * (bristle - before) / (TICK_S * p["stiffness"]) + p[f"viscous_{side}"] * v
    return torque


@dataclass(frozen=True)
class Loop:
    """One period of hysteresis loops, the mean of all periods of a run; torques without their mean, N m."""

    angle_rad: Real
    measured_nm: Real
    model_nm: Real | None
    periods: int


def mean_loop(run: Columns, identified: Identified) -> Loop | None:
    """From the run with the most periods, without the first one, which leads in; None when no loops were recorded."""
    best: Loop | None = None
    for number in np.unique(run["run"][run["kind"] == HYSTERESIS]):
        part = {name: column[run["run"] == number] for name, column in run.items()}
        above = part["reference"] > 0.5 * (part["reference"].min() + part["reference"].max())
        begins = np.flatnonzero(~above[:-1] & above[1:]) + 1
        if len(begins) < 3:
            continue
        period = int(np.median(np.diff(begins)))
        starts = [int(begin) for begin in begins[1:] if begin + period <= len(part["time_s"])]
        if best is None or len(starts) > best.periods:
            best = _averaged(part, starts, period, identified)
    return best


def _averaged(part: Columns, starts: list[int], period: int, identified: Identified) -> Loop:
    def mean(column: Real) -> Real:
        return np.asarray(np.mean([column[start : start + period] for start in starts], axis=0))

    angle = part["joint_angle_rad"] - part["joint_angle_rad"].mean()
    friction, inertia = lugre_nm(identified, angle), identified.value("inertia")
    measured = mean(part["torque_nm"])
    model = None
    if friction is not None and inertia is not None:
        model = mean(friction + inertia * _smooth(np.gradient(np.gradient(angle, TICK_S), TICK_S)))
        model = model - model.mean()
    return Loop(mean(angle), measured - measured.mean(), model, len(starts))


def _smooth(column: Real, ticks: int = 11) -> Real:
    return np.convolve(column, np.hanning(ticks + 2)[1:-1] / np.hanning(ticks + 2).sum(), mode="same")


@dataclass(frozen=True)
class Whiteness:
    """Spectra of the residual, N m/sqrt(Hz), and of the residual whitened, and the autocorrelation of the latter."""

    frequency_hz: Real
    residual: Real
    whitened: Real
    lag_s: Real
    correlation: Real
    bound: float


SEGMENT = 512
LAGS = 40


def whiteness(residuals: Columns, step_s: float) -> Whiteness | None:
    """Over stretches without gap; None when none is long enough."""
    gaps = np.flatnonzero(np.diff(residuals["time_s"]) > 1.5 * step_s) + 1
    edges = np.concatenate([[0], gaps, [len(residuals["time_s"])]])
    window = np.hanning(SEGMENT)
    powers: list[tuple[Real, Real]] = []
    products, counted = np.zeros(LAGS + 1), 0
    for first, last in zip(edges[:-1], edges[1:], strict=True):
        white = residuals["whitened"][first:last]
        for start in range(0, last - first - SEGMENT + 1, SEGMENT // 2):
            part = slice(first + start, first + start + SEGMENT)
            powers.append((_power(residuals["residual_nm"][part], window), _power(residuals["whitened"][part], window)))
        if last - first > LAGS:
            products += [float(np.dot(white[: len(white) - lag], white[lag:])) for lag in range(LAGS + 1)]
            counted += last - first
    if not powers or products[0] <= 0:
        return None
    scale = 2 * step_s / np.sum(window**2)
    residual, whitened = (np.sqrt(scale * np.mean([pair[i] for pair in powers], axis=0)) for i in range(2))
    correlation = products / products[0]
    frequency, lag = np.asarray(np.fft.rfftfreq(SEGMENT, step_s), np.float64), step_s * np.arange(1.0, LAGS + 1)
    return Whiteness(
        frequency[1:], residual[1:], whitened[1:], np.asarray(lag, np.float64), correlation[1:], 1.96 / np.sqrt(counted)
    )


def _power(part: Real, window: NDArray[np.floating[Any]]) -> Real:
    return np.asarray(np.abs(np.fft.rfft((part - part.mean()) * window)) ** 2)
