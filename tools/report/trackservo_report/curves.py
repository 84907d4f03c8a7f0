# SPDX-License-Identifier: Apache-2.0
"""Figures of one run against time. Those that take an `Experiment` and a plot's key draw any experiment of their kind."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import plotly.graph_objects as go

from .controllers import BASELINE, COMPENSATED
from .display import case_order, case_title, controller_colour, controller_title, number
from .experiments import experiments
from .load import Results, Run
from .theme import GRID, INK, MUTED, View, canvas, panels, paper_key, paper_line
from .traces import MAX_POINTS, Series, coarse, read_run, thin, window

DEGREES = 180.0 / np.pi
MICRORADIANS = 1e6
STEPS = ["pi", "pi_vob", "pi_vob_ftc"]
"""The order of comparison in the paper's Fig. 11."""
EXTRAS = ["pi_vob", "pi_ftc", "pi_coulomb", "pi_best", "least_error"]
"""Curves that are there but off until the reader clicks their legend entry."""


@dataclass(frozen=True)
class Curve:
    """One recorded quantity of one run: time in seconds, values in the display unit."""

    run: Run
    time: Series
    values: Series


class RunBook:
    """Finds the run for a plot and reads its columns once."""

    def __init__(self, results: Results) -> None:
        self._results = results
        self._cache: dict[str, dict[str, Series]] = {}

    def cases(self, experiment: str) -> list[str]:
        """The recorded cases of an experiment on its preferred plant, in order."""
        runs = self._candidates(experiment)
        return sorted({run.case for run in runs}, key=case_order)

    def run(self, experiment: str, case: str, controller: str, friction: str = "lugre", figure: str = "") -> Run | None:
        """The run to draw: tagged for the figure if there is one, azimuth, lowest seed."""
        runs = [
            run
            for run in self._candidates(experiment)
            if run.case == case and run.controller == controller and run.friction == friction
        ]
        return min(runs, key=lambda run: (run.figure != figure, run.axis != "azimuth", run.seed), default=None)

    def curve(self, run: Run | None, quantity: str, scale: float = 1.0) -> Curve | None:
        """A column of a run without the axis prefix, multiplied by `scale`."""
        if run is None:
            return None
        data = self._read(run, [f"{run.axis}_{quantity}"])
        return Curve(run, data["time_s"], data[f"{run.axis}_{quantity}"] * scale)

    def speed_error(self, run: Run | None) -> Curve | None:
        """Set-point less true rate, in degrees per second."""
        reference, rate = self.curve(run, "reference_rad_s", DEGREES), self.curve(run, "rate_rad_s", DEGREES)
        if reference is None or rate is None:
            return None
        return Curve(rate.run, rate.time, reference.values - rate.values)

    def _candidates(self, experiment: str) -> list[Run]:
        runs = [run for run in self._results.runs if run.experiment == experiment]
        return [run for run in runs if run.plant == experiments()[experiment].plant] or runs

    def _read(self, run: Run, columns: list[str]) -> dict[str, Series]:
        known = self._cache.setdefault(run.csv, {})
        if not set(columns) <= set(known):
            every = [f"{run.axis}_{name}" for name in _USED_COLUMNS]
            known.update(read_run(self._results.folder / run.csv, every))
        return known


_USED_COLUMNS = [
    "reference_rad_s",
    "rate_rad_s",
    "friction_nm",
    "friction_feedforward_nm",
    "disturbance_estimate_nm",
    "tracking_error_rad",
]


def _line(curve: Curve, colour: str, name: str, **style: object) -> go.Scatter:
    """A thinned line; rounded below a pixel so that the page stays small, and coarser where it is off at first."""
    points = MAX_POINTS // 2 if style.get("visible") == "legendonly" else MAX_POINTS
    time, values = thin(curve.time, curve.values, points)
    options = {"width": 1.8, "color": colour, **({"dash": style.pop("dash")} if "dash" in style else {})}
    return go.Scatter(
        x=coarse(time), y=coarse(values), mode="lines", name=name, line=options, **style
    )


def _controller_line(curve: Curve, **style: object) -> go.Scatter:
    name = curve.run.controller
    return _line(curve, controller_colour(name), controller_title(name), legendgroup=name, **style)


def _reference(curve: Curve, **style: object) -> go.Scatter:
    return _line(curve, INK, "set-point", dash="dot", legendgroup="reference", legendrank=500, **style)


def _settling(plot: go.Figure, run: Run, **place: object) -> None:
    """Shade the time that the error metrics leave out."""
    if run.settling_s > 0:
        plot.add_vrect(x0=0, x1=run.settling_s, fillcolor=GRID, opacity=0.35, line_width=0, layer="below", **place)


def step_time(reference: Curve) -> float:
    """When the set-point first changes, in seconds; the start of the run when it is there from the beginning."""
    moved = np.flatnonzero(np.abs(reference.values - reference.values[0]) > 1e-9)
    return float(reference.time[moved[0]]) if moved.size else float(reference.time[0])


def _reversal_time(reference: Curve, after: float) -> float | None:
    """When the set-point first changes sign after a time, in seconds."""
    signs = np.sign(reference.values)
    changes = reference.time[1:][(signs[1:] * signs[:-1] <= 0) & (reference.time[1:] > max(after, 1.0))]
    return float(changes[0]) if changes.size else None


def speed(book: RunBook, experiment: str, key: str) -> list[View]:
    """Set-point and speed under PI alone (Fig. 7)."""
    views = []
    for case in book.cases(experiment):
        run = book.run(experiment, case, BASELINE, figure=key)
        rate, reference = book.curve(run, "rate_rad_s", DEGREES), book.curve(run, "reference_rad_s", DEGREES)
        if rate and reference:
            plot = canvas(380, xaxis_title="time (s)", yaxis_title="speed (°/s)")
            plot.add_trace(_controller_line(rate))
            plot.add_trace(_reference(reference))
            views.append(View(case_title(case), plot))
    return views


def ingredients(book: RunBook, experiment: str, key: str) -> list[View]:
    """The speed under PI, PI + VOB and PI + VOB + FTC, whole and around a reversal (Fig. 11)."""
    views = []
    for case in book.cases(experiment):
        runs = [run for name in STEPS if (run := book.run(experiment, case, name, figure=key))]
        if not runs:
            continue
        titles = [text for run in runs for text in (controller_title(run.controller), "around a reversal")]
        plot = panels(len(runs), 2, 250 * len(runs) + 60, titles, column_widths=[0.6, 0.4], vertical_spacing=0.5 / 6)
        for row, run in enumerate(runs, start=1):
            _ingredient_row(plot, book, run, row)
        plot.update_xaxes(title_text="time (s)", row=len(runs))
        views.append(View(case_title(case), plot))
    return views


def _ingredient_row(plot: go.Figure, book: RunBook, run: Run, row: int) -> None:
    rate, reference = book.curve(run, "rate_rad_s", DEGREES), book.curve(run, "reference_rad_s", DEGREES)
    if not rate or not reference:
        return
    plot.add_trace(_controller_line(rate), row=row, col=1)
    plot.add_trace(_reference(reference, showlegend=row == 1), row=row, col=1)
    plot.update_yaxes(title_text="speed (°/s)", row=row, col=1)
    middle = _reversal_time(reference, run.settling_s)
    if middle is None:
        return
    for curve, draw in ((rate, _controller_line), (reference, _reference)):
        near = Curve(run, *window(curve.time, curve.values, middle - 0.8, middle + 0.8))
        plot.add_trace(draw(near, showlegend=False), row=row, col=2)
    plot.update_yaxes(range=[-0.5, 0.5], row=row, col=2)


Printed = dict[str, tuple[float | None, float | None]]
"""What the paper prints for a case, without and with compensation."""


def speed_error(book: RunBook, experiment: str, key: str, paper: Printed, from_settled: bool) -> list[View]:
    """The speed error with and without compensation (Fig. 12, Table 2); `paper` in °/s."""
    views = []
    for case in book.cases(experiment):
        plot = canvas(420, xaxis_title="time (s)", yaxis_title="speed error (°/s)")
        if _error_lines(plot, book, experiment, case, key):
            printed = [value for value in paper.get(case, ()) if value is not None]
            if printed:
                paper_key(plot)
            for value in printed:
                paper_line(plot, value, f"paper ±{value:g} °/s")
                paper_line(plot, -value, "")
            if from_settled:
                _fit_settled(plot, book, experiment, case)
            views.append(View(case_title(case), plot))
    return views


def _error_lines(plot: go.Figure, book: RunBook, experiment: str, case: str, figure: str) -> bool:
    """PI and compensated speed error, the other controllers switched off; True when something was drawn."""
    run = None
    for name in [BASELINE, COMPENSATED, *EXTRAS]:
        found = book.run(experiment, case, name, figure=figure)
        error = book.speed_error(found)
        if error:
            run = found
            plot.add_trace(_controller_line(error, visible="legendonly" if name in EXTRAS else True))
    if run:
        _settling(plot, run)
    return run is not None


def _fit_settled(plot: go.Figure, book: RunBook, experiment: str, case: str) -> None:
    """Scale the error axis to the settled part; the start-up peak is as large as the speed itself."""
    error = book.speed_error(book.run(experiment, case, BASELINE))
    if error:
        settled = np.abs(error.values[error.time >= error.run.settling_s])
        if settled.size:
            reach = 1.5 * max(float(settled.max()), 0.1)
            plot.update_yaxes(range=[-reach, reach])


def step_response(book: RunBook, experiment: str, key: str) -> list[View]:
    """The disturbed step with friction, without friction, and compensated (Fig. 9)."""
    views = []
    for case in book.cases(experiment):
        run = book.run(experiment, case, BASELINE, figure=key)
        reference = book.curve(run, "reference_rad_s", DEGREES)
        if run is None or reference is None:
            continue
        plot = canvas(430, xaxis_title="time (s)", yaxis_title="speed (°/s)")
        free = book.curve(book.run(experiment, case, BASELINE, "none", key), "rate_rad_s", DEGREES)
        if free:
            plot.add_trace(_line(free, MUTED, "PI, friction-free", dash="dash"))
        for name in [BASELINE, COMPENSATED, *EXTRAS]:
            rate = book.curve(book.run(experiment, case, name, figure=key), "rate_rad_s", DEGREES)
            if rate:
                plot.add_trace(_controller_line(rate, visible="legendonly" if name in EXTRAS else True))
        plot.add_trace(_reference(reference))
        start = step_time(reference)
        plot.update_xaxes(range=[start - 0.2, min(start + 6.0, float(reference.time[-1]))])
        views.append(View(case_title(case), plot))
    return views


def start_up(book: RunBook, experiment: str, key: str) -> list[View]:
    """Start from rest at each speed, with the first half second in view (Fig. 14)."""
    cases = book.cases(experiment)
    if not cases:
        return []
    plot = panels(1, len(cases), 400, [case_title(case) for case in cases], horizontal_spacing=0.07)
    shown: set[str] = set()
    for column, case in enumerate(cases, start=1):
        _start_panel(plot, book, experiment, key, case, column, shown)
    plot.update_xaxes(title_text="time after the step (ms)")
    plot.update_yaxes(title_text="speed (°/s)", col=1)
    return [View("start-up", plot)] if shown else []


def _start_panel(
    plot: go.Figure, book: RunBook, experiment: str, key: str, case: str, column: int, shown: set[str]
) -> None:
    names = [BASELINE, COMPENSATED, *EXTRAS]
    for name in names:
        run = book.run(experiment, case, name, figure=key)
        rate, reference = book.curve(run, "rate_rad_s", DEGREES), book.curve(run, "reference_rad_s", DEGREES)
        if run is None or rate is None or reference is None:
            continue
        start = step_time(reference)
        near = _after(rate, start)
        off = "legendonly" if name in EXTRAS else True
        plot.add_trace(_controller_line(near, visible=off, showlegend=name not in shown), row=1, col=column)
        if name == BASELINE:
            plot.add_trace(_reference(_after(reference, start), showlegend=name not in shown), row=1, col=column)
            top = float(reference.values[-1])
            plot.add_hline(y=0.9 * top, line={"color": MUTED, "width": 1, "dash": "dot"}, row=1, col=column)
            plot.update_yaxes(range=[-0.25 * top, 2.0 * top], row=1, col=column)
        shown.add(name)
    plot.update_xaxes(range=[-40, 460], row=1, col=column)


def _after(curve: Curve, start: float) -> Curve:
    """The curve from just before a step to 1.5 s after it, time in milliseconds after the step."""
    time, values = window(curve.time, curve.values, start - 0.1, start + 1.5)
    return Curve(curve.run, (time - start) * 1e3, values)


def friction_shares(book: RunBook) -> list[View]:
    """Which block compensates the friction torque at start-up: the feedforward or the observer."""
    views = []
    for case in book.cases("low_speed_start"):
        runs = [run for name in ["pi_vob", COMPENSATED] if (run := book.run("low_speed_start", case, name))]
        if not runs:
            continue
        titles = [controller_title(run.controller) for run in runs]
        plot = panels(1, len(runs), 380, titles, shared_yaxes=True, horizontal_spacing=0.04)
        for column, run in enumerate(runs, start=1):
            _share_panel(plot, book, run, column)
        plot.update_xaxes(title_text="time after the step (ms)", range=[-40, 460])
        plot.update_yaxes(title_text="torque (N·m)", col=1)
        views.append(View(case_title(case), plot))
    return views


def _share_panel(plot: go.Figure, book: RunBook, run: Run, column: int) -> None:
    reference = book.curve(run, "reference_rad_s")
    parts = [
        ("friction_nm", INK, "true friction", "dot"),
        ("friction_feedforward_nm", controller_colour("pi_ftc"), "feedforward", "solid"),
        ("disturbance_estimate_nm", controller_colour("pi_vob"), "observer's estimate", "solid"),
    ]
    for quantity, colour, name, dash in parts:
        curve = book.curve(run, quantity)
        if curve and reference:
            near = _after(curve, step_time(reference))
            plot.add_trace(
                _line(near, colour, name, dash=dash, legendgroup=name, showlegend=column == 1), row=1, col=column
            )


def tracking_error(
    book: RunBook,
    experiment: str,
    key: str,
    paper: tuple[float | None, float | None],
    ours: dict[tuple[str, str], float],
) -> list[View]:
    """Line-of-sight error without and with compensation (Fig. 16); `paper` and `ours` (by case, controller) in µrad."""
    views = []
    for case in book.cases(experiment):
        names = [name for name in (BASELINE, COMPENSATED) if book.run(experiment, case, name, figure=key)]
        if not names:
            continue
        plot = panels(
            len(names),
            1,
            270 * len(names) + 60,
            [controller_title(name) for name in names],
            shared_xaxes=True,
            shared_yaxes="all",
            vertical_spacing=0.1,
        )
        for row, name in enumerate(names, start=1):
            printed = paper[0] if name == BASELINE else paper[1]
            _tracking_panel(plot, book, experiment, key, case, name, row, printed, ours.get((case, name)))
        paper_key(plot, row=1, col=1)
        plot.update_xaxes(title_text="time (s)", row=len(names))
        plot.update_yaxes(title_text="line-of-sight error (µrad)")
        views.append(View(case_title(case), plot))
    return views


def _tracking_panel(
    plot: go.Figure, book: RunBook, experiment: str, key: str, case: str, name: str, row: int,
    printed: float | None, sigma: float | None,
) -> None:
    run = book.run(experiment, case, name, figure=key)
    error = book.curve(run, "tracking_error_rad", MICRORADIANS)
    if error is None or run is None:
        return
    plot.add_trace(_controller_line(error), row=row, col=1)
    free = book.curve(book.run(experiment, case, name, "none", key), "tracking_error_rad", MICRORADIANS)
    if free:
        line = _line(free, MUTED, "same, friction-free", legendgroup="free", visible="legendonly", showlegend=row == 1)
        plot.add_trace(line, row=row, col=1)
    if printed is not None:
        paper_line(plot, printed, f"paper 1σ {printed:g} µrad", row=row, col=1)
        paper_line(plot, -printed, "", row=row, col=1)
    if sigma is not None:
        plot.layout.annotations[row - 1].text += f" — ours 1σ {number(sigma)} µrad"
    _settling(plot, run, row=row, col=1)
    settled = np.abs(error.values[error.time >= run.settling_s])
    if row == 1 and settled.size:
        reach = 1.15 * float(settled.max())
        plot.update_yaxes(range=[-reach, reach])
