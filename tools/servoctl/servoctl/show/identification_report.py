# SPDX-License-Identifier: Apache-2.0
"""The report of an identification: parameters with intervals, and the measurements beside the model."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from ..identify.commissioning import Outcome
from ..identify.identified import Identified
from ..objects.journal import now
from ..objects.parameter import Parameter, Value
from ..plots import CLOSED, DEMAND, MARK, OPEN, friction_figure, new_figure, png_of, styled
from ..units import degrees
from .friction_curves import Columns, Legs, Loop, Whiteness, legs, mean_loop, over_position, whiteness
from .number_table import read_columns
from .page import PageTable, Section, write_page

MAX_POINTS = 4000


def write_identification_report(
    path: Path, axis: str, identified: Identified, plant: Mapping[Parameter, Value], recording: Path, residuals: Path,
    outcome: Outcome,
) -> None:  # fmt: skip
    """One HTML file; reads the recording and the residuals again, as used by the fit."""
    run, left = read_columns(recording), read_columns(residuals)
    data = identified.data
    sections = [
        _parameters(identified),
        _plant(plant),
        _stribeck(identified, legs(run)),
        _position(identified),
        _hysteresis(identified, run),
        _residuals(left, float(data["noise"]["step_s"])),
        _break_aways(outcome),
        _checks(data),
    ]
    notes = [f"Not determined: {message}" for _, message in identified.refused]
    notes += identified.warnings or ["No structural resonance was found."] * path.with_name("structure.csv").exists()
    notes += [f"The paper's method lacks data for {text}." for text in data["paper_method_missing"]]
    notes += [f"Run {number} lost {100 * share:.2g} % of its ticks." for number, share in outcome.incomplete_runs()]
    lead = (
        f"{now()}; {data['recorded_s']:.0f} s in {data['runs']} runs, including moves; {outcome.recording.missing}"
        " ticks were lost in transmission. Intervals are 95 % intervals."
    )
    write_page(path, f"Identification of {axis}", lead, [section for section in sections if section], notes)


def _number(value: float | None, digits: int = 5) -> str:
    return "–" if value is None or not np.isfinite(value) else f"{value:.{digits}g}"


def _parameters(identified: Identified) -> Section:
    rows, bad = [], []
    for position, estimate in enumerate(identified.estimates.values()):
        if estimate.value is None:
            bad.append(position)
        half = f"±{estimate.percent:.1f} %" if estimate.percent is not None else "–"
        interval = f"{_number(estimate.low)} … {_number(estimate.high)}"
        value = _number(estimate.value) if estimate.value is not None else "not determined"
        rows.append((estimate.title, value, interval, half, _number(estimate.paper), estimate.unit))
    text = (
        "Paper's method: from mean torques at constant speeds and a slope, eqs (4) to (16). Wind and noise bias"
        " it."
    )
    table = PageTable(("parameter", "value", "95 % interval", "half width", "paper's method", "unit"), rows, bad)
    return Section("Parameters", text, table)


def _plant(plant: Mapping[Parameter, Value]) -> Section | None:
    if not plant:
        return None
    rows = [(p.where, p.title, _number(float(value)), p.unit) for p, value in plant.items()]
    text = (
        "The device checks gains against these values before they count. 'servoctl restore' of the gains file and"
        " 'servoctl tune' write them with --unlock."
    )
    return Section("Plant for the check of gains", text, PageTable(("index", "parameter", "value", "unit"), rows, []))


def _stribeck(identified: Identified, points: Legs) -> Section:
    text = (
        "Each point is the mean torque of one leg at constant speed, minus the constant load, as in the paper."
        " Gusts move single points by several N m. The curves are eq. (5)."
    )
    return Section("Stribeck curve", text, picture=png_of(friction_figure(identified, points)))


def _position(identified: Identified) -> Section:
    position = identified.data["position"]
    rows = [
        (what, row["term"], _number(row["value"], 3), " … ".join(_number(end, 3) for end in row["interval_95"]))
        for what, key in (("friction level", "friction_level"), ("load, N m", "load_nm")) for row in position[key]
    ]  # fmt: skip
    text = (
        "Friction level: how the seal's eccentricity raises and lowers the friction. Load: imbalance and cables."
    )
    return Section("Over the joint angle", text, PageTable(("what", "term", "value", "95 % interval"), rows), png_of(_over_angle(identified)))


@styled
def _over_angle(identified: Identified) -> Figure:
    position = identified.data["position"]
    low, high = position["travel_rad"]
    angle = np.linspace(low, high, 300)
    figure = new_figure(9, 3.6)
    level, load = figure.subplots(1, 2)
    level.plot(degrees(1) * angle, 1 + over_position(identified, position["friction_level"], angle), color=OPEN)
    level.set_ylabel("friction level (1: mean)")
    load.plot(degrees(1) * angle, over_position(identified, position["load_nm"], angle), color=CLOSED)
    load.set_ylabel("load torque (N m)")
    for axes in (level, load):
        axes.set_xlabel("joint angle (°)")
    return figure


def _hysteresis(identified: Identified, run: Columns) -> Section | None:
    loop = mean_loop(run, identified)
    if loop is None:
        return None
    text = (
        "Motor torque over angle in hysteresis loops, averaged over the periods to remove wind. The model is"
        " LuGre friction plus inertia times acceleration, computed from the measured angle."
    )
    return Section("Hysteresis loop", text, picture=png_of(_loop_figure(loop)))


@styled
def _loop_figure(loop: Loop) -> Figure:
    figure = new_figure(7, 4.6)
    axes = figure.subplots()
    axes.plot(1e3 * loop.angle_rad, loop.measured_nm, color=CLOSED, label=f"measured, mean of {loop.periods} loops")
    if loop.model_nm is not None:
        label = "identified model along the measured motion"
        axes.plot(1e3 * loop.angle_rad, loop.model_nm, "--", color=MARK, label=label)
    axes.set_xlabel("joint angle (mrad)")
    axes.set_ylabel("torque without its mean (N m)")
    axes.legend(loc="upper left", fontsize=8.5)
    return figure


def _residuals(left: Columns, step_s: float) -> Section | None:
    found = whiteness(left, step_s)
    if found is None:
        return None
    beyond = int(np.count_nonzero(np.abs(found.correlation) > found.bound))
    text = (
        "The residual is the torque that the model does not explain, mainly wind. The noise model whitens it: the"
        " flatter its spectrum and the closer its autocorrelation to the dashed bounds, the better the intervals."
        f" {beyond} of {len(found.correlation)} lags exceed the bounds; chance alone gives one in twenty."
    )
    return Section("Residuals", text, picture=png_of(_residuals_figure(left, found)))


@styled
def _residuals_figure(left: Columns, found: Whiteness) -> Figure:
    every = max(1, len(left["time_s"]) // MAX_POINTS)
    figure = new_figure(9, 6.4)
    grid = figure.subplot_mosaic([["time", "time"], ["spectrum", "white"]])
    grid["time"].plot(left["time_s"][::every], left["residual_nm"][::every], ".", ms=2, color=DEMAND)
    grid["time"].set(xlabel="time (s)", ylabel="residual (N m)")
    grid["spectrum"].loglog(found.frequency_hz, found.residual, color=DEMAND, label="residual: wind, noise (N m/√Hz)")
    grid["spectrum"].loglog(found.frequency_hz, found.whitened, color=OPEN, label="whitened (1/√Hz)")
    grid["spectrum"].set(xlabel="frequency (Hz)", ylabel="spectral density")
    grid["spectrum"].legend(fontsize=8.5)
    grid["white"].stem(1e3 * found.lag_s, found.correlation, basefmt=" ", markerfmt=".")
    for bound in (-found.bound, found.bound):
        grid["white"].axhline(bound, color=MARK, lw=0.9, ls="--")
    reach = max(0.1, 1.2 * float(np.max(np.abs(found.correlation))))
    grid["white"].set(xlabel="lag (ms)", ylabel="autocorrelation of whitened", ylim=(-reach, reach))
    return figure


def _break_aways(outcome: Outcome) -> Section | None:
    if not outcome.break_aways:
        return None
    rows = [
        (f"{degrees(b.angle_rad):.1f}", b.direction, str(b.count), _number(b.mean_nm, 4), _number(b.deviation_nm, 3))
        for b in outcome.break_aways
    ]
    text = "Motor torque at which the axis began to slide, as measured by the device; it includes load and wind."
    columns = ("at °", "direction", "break-aways", "mean, N m", "standard deviation, N m")
    return Section("Break-away", text, PageTable(columns, rows))


def _checks(data: dict[str, Any]) -> Section:
    checks, noise, gyro = data["checks"], data["noise"], data["checks"]["gyro"]
    ratios = f"{checks['damping_ratio']:.3g}; the paper assumes {checks['damping_ratio_of_the_paper']:.3g}"
    residual, white = _number(noise["residual_rms_nm"], 3), _number(noise["innovation_nm"], 3)
    reported = f"scale error {gyro['scale_error']:.2g}, delay {1e3 * gyro['delay_s']:.2g} ms"
    rows = [
        ("damping ratio in pre-sliding", ratios),
        ("σ1 by eq. (15)", f"{_number(checks['damping_by_eq_15_nm_s_rad'])} N m s/rad"),
        ("residual, rms", f"{residual} N m; {white} N m when whitened"),
        ("torque to motion delay", f"{1e3 * checks['delay_s']:.3g} ms"),
        ("gyro", reported if gyro["used"] else "not used"),
        ("converged", "yes" if checks["converged"] else "no"),
    ]  # fmt: skip
    return Section("Checks", table=PageTable(("what", "found"), rows))
