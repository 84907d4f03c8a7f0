# SPDX-License-Identifier: Apache-2.0
"""The pictures: Bode plots, steps and scope captures, saved as PNG with the numbers as CSV beside them."""

from __future__ import annotations

import io
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import matplotlib
import numpy as np
from numpy.typing import NDArray

from .capture import unit_of, without_unit
from .errors import InputError
from .frequency_response import GOOD_COHERENCE, Margins, branch
from .step_response import StepNumbers
from .units import Shown, degrees

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402 - after the choice of the back end
from matplotlib.axes import Axes  # noqa: E402
from matplotlib.figure import Figure  # noqa: E402

Real = NDArray[np.float64]
Complex = NDArray[np.complex128]

TRACES = ("#3f7fd6", "#e08a1e", "#0e9f7b", "#d4587f", "#7b5fc7", "#7c8696", "#8c6d3f", "#2bb3c0")
OPEN, CLOSED, DEMAND, MARK, GRID = "#0e9f7b", "#3f7fd6", "#7c8696", "#d4587f", "#dfe3e8"
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


def _save(figure: Figure, path: Path) -> None:
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        figure.savefig(path)
    except OSError as error:
        raise InputError(f"{path}: cannot be written: {error.strerror}.") from error
    finally:
        plt.close(figure)


def png_of(figure: Figure) -> bytes:
    """The picture itself, for a page."""
    buffer = io.BytesIO()
    figure.savefig(buffer, format="png")
    plt.close(figure)
    return buffer.getvalue()


def plot_bode(
    path: Path, title: str, frequency_hz: Real, closed: Complex, loop: Complex, coherence: Real, sharp: NDArray[np.bool_],
    found: Margins, bandwidth_hz: float | None,
) -> None:  # fmt: skip
    """Open and closed loop over frequency (Hz), margins and bandwidth marked; hollow points are not reliable.

    `sharp` marks where the open loop is known; elsewhere it is so large that the closed loop does not show its size.
    """
    good = coherence >= GOOD_COHERENCE
    opened = branch(np.degrees(np.unwrap(np.angle(loop))), 20 * np.log10(np.abs(loop)))
    with plt.rc_context(STYLE):
        figure, (gain, phase, trust) = plt.subplots(
            3, 1, figsize=(8.6, 8.2), sharex=True, height_ratios=[3, 3, 1.1], layout="constrained"
        )
        figure.suptitle(title, x=0.01, ha="left", fontweight="bold", fontsize=12)
        for values, trusted, colour, label in ((loop, sharp, OPEN, "open loop"), (closed, good, CLOSED, "closed loop")):
            angle = np.degrees(np.unwrap(np.angle(values)))
            if label == "open loop":
                angle = opened
            _curve(gain, frequency_hz, 20 * np.log10(np.abs(values)), trusted, colour, label)
            _curve(phase, frequency_hz, angle, trusted, colour, label)
        gain.set_ylabel("magnitude (dB)")
        phase.set_ylabel("phase (°)")
        gain.axhline(0, color=DEMAND, lw=0.9)
        phase.axhline(-180, color=DEMAND, lw=0.9)
        _show_trusted_phases(phase, [np.degrees(np.unwrap(np.angle(closed)))[good], opened[sharp]])
        _mark_margins(gain, phase, found)
        if bandwidth_hz is not None:
            gain.plot([bandwidth_hz], [-3], "D", color=CLOSED, ms=6)
            gain.annotate(
                f"−3 dB at {bandwidth_hz:.1f} Hz",
                (bandwidth_hz, -3),
                (-8, -22),
                textcoords="offset points",
                ha="right",
                color=CLOSED,
            )
        gain.legend(loc="lower left")
        trust.plot(frequency_hz, coherence, ".-", color=DEMAND)
        trust.axhline(GOOD_COHERENCE, color=MARK, lw=0.9, ls="--")
        trust.set_ylim(0, 1.05)
        trust.set_ylabel("coherence")
        trust.set_xlabel("frequency (Hz)")
        trust.set_xscale("log")
        trust.set_xlim(frequency_hz[0] * 0.92, frequency_hz[-1] * 1.08)
        trust.xaxis.set_major_formatter(matplotlib.ticker.FuncFormatter(lambda x, _: f"{x:g}"))
        _save(figure, path)


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


def plot_steps(path: Path, title: str, records: Sequence[tuple[str, Real, Real, Real, StepNumbers]]) -> None:
    """Demand and answer (rad/s) over time (s), one panel for each (name, time, demand, answer, numbers)."""
    with plt.rc_context(STYLE):
        figure, grid = plt.subplots(
            1, len(records), figsize=(5.2 * len(records) + 0.6, 4.4), squeeze=False, layout="constrained"
        )
        figure.suptitle(title, x=0.01, ha="left", fontweight="bold", fontsize=12)
        for axes, (name, time_s, demand, answer, numbers) in zip(grid[0], records, strict=True):
            axes.set_title(name)
            axes.plot(1e3 * time_s, degrees(1) * answer, color=CLOSED, label="measured (606C)")
            axes.plot(1e3 * time_s, degrees(1) * demand, color=DEMAND, lw=1.3, label="demanded (606B)")
            band = 0.05 * abs(numbers.to_rad_s - numbers.from_rad_s)
            axes.axhspan(
                degrees(numbers.to_rad_s - band),
                degrees(numbers.to_rad_s + band),
                color=OPEN,
                alpha=0.13,
                lw=0,
                label="±5 %",
            )
            if numbers.settling_s is not None:
                axes.axvline(1e3 * numbers.settling_s, color=MARK, lw=1.0, ls=":")
                axes.annotate(
                    f"settled {1e3 * numbers.settling_s:.0f} ms",
                    (1e3 * numbers.settling_s, 0.03),
                    (4, 0),
                    xycoords=("data", "axes fraction"),
                    textcoords="offset points",
                    color=MARK,
                )
            axes.set_xlabel("time after the step (ms)")
            axes.set_ylabel("rate (°/s)")
        grid[0][0].legend(loc="best")
        _save(figure, path)


def plot_traces(
    path: Path, title: str, time_s: Real, traces: Mapping[str, Real], trigger_s: float | None = None
) -> None:
    """One panel for each unit (that of the names' ends, angles and rates in degrees), all over time in s."""
    groups: dict[str, list[str]] = {}
    for name in traces:
        groups.setdefault(unit_of(name), []).append(name)
    with plt.rc_context(STYLE):
        figure, grid = plt.subplots(
            len(groups), 1, figsize=(9, 1.2 + 2.4 * len(groups)), sharex=True, squeeze=False, layout="constrained"
        )
        figure.suptitle(title, x=0.01, ha="left", fontweight="bold", fontsize=12)
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
        _save(figure, path)


def plot_errors(
    path: Path, title: str, time_s: Real, errors_urad: Mapping[str, Real], states: Mapping[str, Sequence[tuple[float, float]]] | None = None
) -> None:  # fmt: skip
    """Errors (µrad) over time (s), one panel for each name; spans of time with a state are shaded."""
    with plt.rc_context(STYLE):
        figure, grid = plt.subplots(
            len(errors_urad), 1, figsize=(9, 1.0 + 2.6 * len(errors_urad)), sharex=True, squeeze=False, layout="constrained"
        )
        figure.suptitle(title, x=0.01, ha="left", fontweight="bold", fontsize=12)
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
        _save(figure, path)
