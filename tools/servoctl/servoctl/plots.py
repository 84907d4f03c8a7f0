# SPDX-License-Identifier: Apache-2.0
"""The pictures: Bode plots, steps, friction and scope captures, for a file (`save`), a page (`png_of`) or a notebook, which shows
them as they are. They belong to no window, and need none."""

from __future__ import annotations

import functools
import io
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, ParamSpec

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from .errors import InputError
from .gains.frequency_response import GOOD_COHERENCE, Margins, branch
from .identify.identified import Identified
from .motion.step_test import StepRecord
from .show.capture import unit_of, without_unit
from .show.friction_curves import DIRECTIONS, Legs, friction_points, steady_friction_nm
from .units import Shown, degrees

if TYPE_CHECKING:
    from .gains.loop_test import MeasuredLoop

P = ParamSpec("P")
Real = NDArray[np.float64]

TRACES = ("#3f7fd6", "#e08a1e", "#0e9f7b", "#d4587f", "#7b5fc7", "#7c8696", "#8c6d3f", "#2bb3c0")
OPEN, CLOSED, DEMAND, MARK, GRID = "#0e9f7b", "#3f7fd6", "#7c8696", "#d4587f", "#dfe3e8"
FRICTION_COLOURS = dict(zip(DIRECTIONS, (CLOSED, MARK), strict=True))
STYLE: Any = {
    "font.size": 10, "axes.grid": True, "grid.color": GRID, "axes.edgecolor": "#9aa3af", "axes.spines.top": False,
    "axes.spines.right": False, "lines.linewidth": 1.6, "axes.titlesize": 11, "axes.titleweight": "bold",
    "axes.titlelocation": "left", "legend.frameon": False, "figure.dpi": 120, "axes.axisbelow": True,
}  # fmt: skip


def write_csv(path: Path, columns: Mapping[str, Sequence[float] | Real]) -> None:
    """One column for each name, units in the names."""
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        table = np.column_stack([np.asarray(column, dtype=float) for column in columns.values()])
        np.savetxt(path, table, delimiter=",", header=",".join(columns), comments="", fmt="%.9g")
    except OSError as error:
        raise InputError(f"{path}: cannot be written: {error.strerror}.") from error


def save(figure: Figure, path: Path) -> None:
    """As PNG, SVG or PDF, by the ending; raises InputError."""
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        figure.savefig(path)
    except OSError as error:
        raise InputError(f"{path}: cannot be written: {error.strerror}.") from error


def png_of(figure: Figure) -> bytes:
    """The picture itself, for a page."""
    buffer = io.BytesIO()
    figure.savefig(buffer, format="png")
    return buffer.getvalue()


def styled(draw: Callable[P, Figure]) -> Callable[P, Figure]:
    """In our style, wherever the figure is shown later."""

    @functools.wraps(draw)
    def drawn(*args: P.args, **kwargs: P.kwargs) -> Figure:
        with matplotlib.rc_context(STYLE):
            figure = draw(*args, **kwargs)
            figure.draw_without_rendering()  # ticks and grid take their style now
        return figure

    return drawn


def new_figure(width: float, height: float) -> Figure:
    """Inches."""
    return Figure(figsize=(width, height), layout="constrained")


def _titled(title: str, width: float, height: float) -> Figure:
    figure = new_figure(width, height)
    figure.suptitle(title, x=0.01, ha="left", fontweight="bold", fontsize=12)
    return figure


@styled
def bode_figure(title: str, measured: MeasuredLoop) -> Figure:
    """Open and closed loop over frequency, margins and bandwidth marked; hollow points are not reliable: there the open loop is
    so large that the closed loop does not show its size, or the coherence is low."""
    closed, loop, found, width_hz = measured.closed, measured.loop, measured.margins, measured.bandwidth_hz
    frequency_hz = closed.frequency_hz
    opened = branch(np.degrees(np.unwrap(np.angle(loop))), 20 * np.log10(np.abs(loop)))
    figure = _titled(title, 8.6, 8.2)
    gain, phase, trust = figure.subplots(3, 1, sharex=True, height_ratios=[3, 3, 1.1])
    for values, trusted, colour, label in ((loop, measured.sharp, OPEN, "open loop"), (closed.value, measured.good, CLOSED, "closed loop")):
        angle = np.degrees(np.unwrap(np.angle(values)))
        if label == "open loop":
            angle = opened
        _curve(gain, frequency_hz, 20 * np.log10(np.abs(values)), trusted, colour, label)
        _curve(phase, frequency_hz, angle, trusted, colour, label)
    gain.set_ylabel("magnitude (dB)")
    phase.set_ylabel("phase (°)")
    gain.axhline(0, color=DEMAND, lw=0.9)
    phase.axhline(-180, color=DEMAND, lw=0.9)
    _show_trusted_phases(phase, [np.degrees(np.unwrap(np.angle(closed.value)))[measured.good], opened[measured.sharp]])
    _mark_margins(gain, phase, found)
    if width_hz is not None:
        gain.plot([width_hz], [-3], "D", color=CLOSED, ms=6)
        gain.annotate(
            f"−3 dB at {width_hz:.1f} Hz", (width_hz, -3), (-8, -22), textcoords="offset points", ha="right", color=CLOSED
        )
    gain.legend(loc="lower left")
    trust.plot(frequency_hz, closed.coherence, ".-", color=DEMAND)
    trust.axhline(GOOD_COHERENCE, color=MARK, lw=0.9, ls="--")
    trust.set_ylim(0, 1.05)
    trust.set_ylabel("coherence")
    trust.set_xlabel("frequency (Hz)")
    trust.set_xscale("log")
    trust.set_xlim(frequency_hz[0] * 0.92, frequency_hz[-1] * 1.08)
    trust.xaxis.set_major_formatter(lambda x, _: f"{x:g}")
    return figure


def _show_trusted_phases(phase: Axes, trusted: Sequence[Real]) -> None:
    """Points that are not reliable may lie anywhere: they do not affect the scales."""
    angles = np.concatenate([*trusted, [-180.0]])
    phase.set_ylim(float(angles.min()) - 25, float(angles.max()) + 25)


def _curve(axes: Axes, x: Real, y: Real, good: NDArray[np.bool_], colour: str, label: str) -> None:
    axes.plot(x, np.where(good, y, np.nan), "-", color=colour, label=label)
    axes.plot(x[good], y[good], "o", color=colour, ms=3.2)
    axes.plot(x[~good], y[~good], "o", color=colour, ms=3.6, mfc="white", mew=0.8, alpha=0.6)


def _mark_margins(gain: Axes, phase: Axes, found: Margins) -> None:
    if found.crossover_hz is not None and found.phase_margin_deg is not None:
        gain.axvline(found.crossover_hz, color=MARK, lw=0.9, ls=":")
        phase.axvline(found.crossover_hz, color=MARK, lw=0.9, ls=":")
        phase.plot([found.crossover_hz] * 2, [-180, found.phase_margin_deg - 180], color=MARK, lw=2.4)
        phase.annotate(
            f"phase margin {found.phase_margin_deg:.1f}°\nat {found.crossover_hz:.1f} Hz",
            (found.crossover_hz, found.phase_margin_deg - 180), (-8, -30), textcoords="offset points", ha="right", color=MARK,
        )  # fmt: skip
    if found.phase_crossover_hz is not None and found.gain_margin_db is not None:
        phase.axvline(found.phase_crossover_hz, color=MARK, lw=0.9, ls=":")
        gain.plot([found.phase_crossover_hz] * 2, [-found.gain_margin_db, 0], color=MARK, lw=2.4)
        gain.annotate(
            f"gain margin {found.gain_margin_db:.1f} dB\nat {found.phase_crossover_hz:.0f} Hz",
            (found.phase_crossover_hz, 0), (-6, 24), textcoords="offset points", ha="right", color=MARK,
        )  # fmt: skip


@styled
def steps_figure(title: str, records: Sequence[StepRecord]) -> Figure:
    """Demand and answer over time, one panel for each step."""
    figure = _titled(title, 5.2 * len(records) + 0.6, 4.4)
    grid = figure.subplots(1, len(records), squeeze=False)
    for axes, (name, time_s, demand, answer, numbers) in zip(grid[0], records, strict=True):
        axes.set_title(name)
        axes.plot(1e3 * time_s, degrees(1) * answer, color=CLOSED, label="measured (606C)")
        axes.plot(1e3 * time_s, degrees(1) * demand, color=DEMAND, lw=1.3, label="demanded (606B)")
        band = 0.05 * abs(numbers.to_rad_s - numbers.from_rad_s)
        low, high = (degrees(numbers.to_rad_s + side * band) for side in (-1, 1))
        axes.axhspan(low, high, color=OPEN, alpha=0.13, lw=0, label="±5 %")
        if numbers.settling_s is not None:
            axes.axvline(1e3 * numbers.settling_s, color=MARK, lw=1.0, ls=":")
            axes.annotate(
                f"settled {1e3 * numbers.settling_s:.0f} ms", (1e3 * numbers.settling_s, 0.03), (4, 0),
                xycoords=("data", "axes fraction"), textcoords="offset points", color=MARK,
            )  # fmt: skip
        axes.set_xlabel("time after the step (ms)")
        axes.set_ylabel("rate (°/s)")
    grid[0][0].legend(loc="best")
    return figure


@styled
def starts_figure(title: str, starts: Mapping[str, Mapping[str, StepRecord]], shown_s: float = 0.6) -> Figure:
    """Starts from rest, one panel for each name of `starts`, in it the same start with one controller after the other: the paper's
    Fig. 14. Rates are positive in the direction of the start; the dotted line is the set-point."""
    figure = _titled(title, 3.9 * len(starts) + 0.6, 4.0)
    grid = figure.subplots(1, len(starts), squeeze=False)
    for axes, (name, answers) in zip(grid[0], starts.items(), strict=True):
        axes.set_title(name)
        for (label, (_, time_s, demand, answer, numbers)), colour in zip(answers.items(), (DEMAND, *TRACES), strict=False):
            shown = degrees(1) * np.sign(numbers.to_rad_s)
            axes.plot(1e3 * time_s, shown * answer, lw=0.9, color=colour, label=label)
            axes.plot(1e3 * time_s, shown * demand, ":", lw=1.2, color="black")
            axes.set_ylim(-0.25 * shown * numbers.to_rad_s, 1.6 * shown * numbers.to_rad_s)
        axes.set_xlim(-40, 1e3 * shown_s)
        axes.set_xlabel("time after the step (ms)")
    grid[0][0].set_ylabel("rate in the direction of the start (°/s)")
    grid[0][0].legend(loc="upper right")
    return figure


@styled
def friction_figure(identified: Identified, points: Legs) -> Figure:
    """The Stribeck curve: the mean torque of each leg at a constant speed, and the identified model, eq. (5), in both directions."""
    figure = new_figure(9, 4.6)
    axes = figure.subplots()
    for direction, colour in FRICTION_COLOURS.items():
        speed, friction = friction_points(identified, points, direction)
        axes.plot(speed, friction, "o", ms=3.5, alpha=0.6, color=colour, label=f"mean torque of a leg, {direction}")
        low, high = (speed.min(), speed.max()) if speed.size else (1e-4, 0.3)
        grid = np.geomspace(low / 2, high, 300)
        for paper, style, label in ((False, "-", "identified"), (True, ":", "paper's method")):
            curve = steady_friction_nm(identified, direction, grid, paper)
            if curve is not None:
                axes.plot(grid, curve, style, color=colour, label=f"{label}, {direction}")
    axes.set_xscale("log")
    axes.set_ylim(bottom=0, top=max(1.0, 1.6 * _largest_friction_nm(identified)))
    axes.set_xlabel("joint speed (rad/s)")
    axes.set_ylabel("friction torque (N m)")
    axes.legend(ncols=2, fontsize=8.5, frameon=True, edgecolor="none")  # over the points
    return figure


def _largest_friction_nm(identified: Identified) -> float:
    """Of the model, within the speeds of a sweep."""
    curves = [steady_friction_nm(identified, direction, np.geomspace(1e-5, 0.3, 50)) for direction in DIRECTIONS]
    return max((float(curve.max()) for curve in curves if curve is not None), default=10.0)


@styled
def traces_figure(title: str, time_s: Real, traces: Mapping[str, Real], trigger_s: float | None = None) -> Figure:
    """One panel for each unit (that of the names' ends, angles and rates in degrees), all over time in s."""
    groups: dict[str, list[str]] = {}
    for name in traces:
        groups.setdefault(unit_of(name), []).append(name)
    figure = _titled(title, 9, 1.2 + 2.4 * len(groups))
    grid = figure.subplots(len(groups), 1, sharex=True, squeeze=False)
    for axes, (unit, names) in zip(grid[:, 0], groups.items(), strict=True):
        for position, name in enumerate(names):
            # Later ones are thinner, so that overlapping curves stay visible.
            shown, width = Shown(unit).factor * traces[name], max(0.8, 2.4 - 0.8 * position)
            axes.plot(time_s, shown, label=without_unit(name), lw=width, color=TRACES[position])
        axes.set_ylabel(Shown(unit).unit or "value")
        axes.legend(loc="upper left", bbox_to_anchor=(1.0, 1.0), fontsize=8.5)
        if trigger_s is not None:
            axes.axvline(trigger_s, color=MARK, lw=0.9, ls=":")
    grid[-1, 0].set_xlabel("time (s)")
    return figure


@styled
def errors_figure(
    title: str, time_s: Real, errors_urad: Mapping[str, Real], states: Mapping[str, Sequence[tuple[float, float]]] | None = None
) -> Figure:
    """Errors (µrad) over time (s), one panel for each name; spans of time with a state are shaded."""
    figure = _titled(title, 9, 1.0 + 2.6 * len(errors_urad))
    grid = figure.subplots(len(errors_urad), 1, sharex=True, squeeze=False)
    for axes, (name, error) in zip(grid[:, 0], errors_urad.items(), strict=True):
        axes.set_title(name)
        axes.plot(time_s, error, lw=0.9, color=CLOSED)
        if len(error):
            shown = float(np.percentile(np.abs(error), 98.0))  # the first ms of an acquisition are far outside
            axes.set_ylim(-1.6 * shown - 1.0, 1.6 * shown + 1.0)
        for number, (state, spans) in enumerate((states or {}).items()):
            for index, (begin, end) in enumerate(spans):
                label = None if index else state
                axes.axvspan(begin, end, color=TRACES[number + 1], alpha=0.18, lw=0, label=label)
        axes.set_ylabel("error (µrad)")
        if states:
            axes.legend(loc="upper left", bbox_to_anchor=(1.0, 1.0), fontsize=8.5)
    grid[-1, 0].set_xlabel("time (s)")
    return figure
