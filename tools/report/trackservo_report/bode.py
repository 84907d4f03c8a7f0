# SPDX-License-Identifier: Apache-2.0
"""Frequency responses of the open speed loop: Bode and Nyquist plots, computed and measured."""

from __future__ import annotations

import numpy as np
import plotly.graph_objects as go

from .display import CONDITION_TITLES, controller_colour, controller_title
from .experiments import study_title
from .load import Margin, Results
from .theme import BAD, MUTED, View, panels
from .traces import Series, read_columns

COLUMNS = [
    "frequency_hz",
    "computed_magnitude_db",
    "computed_phase_deg",
    "measured_magnitude_db",
    "measured_phase_deg",
]

GAIN_MARGIN_GOAL_DB = 6.0
PHASE_MARGIN_GOAL_DEG = 40.0
NYQUIST_REACH = 2.2
"""Half-width of the Nyquist plots around the critical point."""


def _groups(results: Results) -> dict[tuple[str, str], list[Margin]]:
    """The margins of each plant and axis, azimuth of the tracker first."""
    found: dict[tuple[str, str], list[Margin]] = {}
    for margin in sorted(results.margins, key=lambda m: (m.plant != "tracker", m.plant, m.axis)):
        found.setdefault((margin.plant, margin.axis), []).append(margin)
    return found


def _title(margin: Margin) -> str:
    """The controller, and what it was tuned for if it does not serve all."""
    title = controller_title(margin.controller)
    return f"{title}, {study_title(margin.study)}" if margin.study else title


def _dash(margin: Margin, margins: list[Margin]) -> str:
    """Lines of one controller that was tuned several times differ in their dashes."""
    studies = list(dict.fromkeys(other.study for other in margins if other.controller == margin.controller))
    return ["solid", "dash", "dot", "dashdot"][studies.index(margin.study) % 4]


def _visible(margin: Margin) -> bool | str:
    """A controller that was tuned for one study only is a click in the legend away."""
    return "legendonly" if margin.study else True


def bode_views(results: Results) -> list[View]:
    """Magnitude and phase of the open loop, one tab per plant and axis."""
    return [View(f"{plant}, {axis}", _bode(results, margins)) for (plant, axis), margins in _groups(results).items()]


def nyquist_views(results: Results) -> list[View]:
    """The open loop around the critical point, one tab per plant and axis."""
    return [View(f"{plant}, {axis}", _nyquist(results, margins)) for (plant, axis), margins in _groups(results).items()]


def _conditions(margins: list[Margin]) -> list[str]:
    return [name for name in CONDITION_TITLES if any(margin.condition == name for margin in margins)]


def _bode(results: Results, margins: list[Margin]) -> go.Figure:
    conditions = _conditions(margins)
    titles = [CONDITION_TITLES[name] for name in conditions] + [""] * len(conditions)
    plot = panels(2, len(conditions), 580, titles, shared_xaxes=True, vertical_spacing=0.06, horizontal_spacing=0.08)
    shown: set[str] = set()
    for margin in margins:
        column = conditions.index(margin.condition) + 1
        data = _unwrapped(read_columns(results.folder / margin.response_csv, COLUMNS))
        for row, quantity in ((1, "magnitude_db"), (2, "phase_deg")):
            first = _title(margin) not in shown
            dash = _dash(margin, margins)
            for trace in _response(margin, data["frequency_hz"], data, quantity, first, dash):
                plot.add_trace(trace, row=row, col=column)
            shown.add(_title(margin))
    plot.update_xaxes(type="log", dtick=1)
    plot.update_xaxes(title_text="frequency (Hz)", row=2)
    plot.update_yaxes(title_text="magnitude (dB)", row=1, col=1)
    plot.update_yaxes(title_text="phase (°)", row=2, col=1)
    plot.add_hline(y=0, line={"color": MUTED, "width": 1}, row=1)
    plot.add_hline(y=-180, line={"color": MUTED, "width": 1}, row=2)
    return plot


def _response(
    margin: Margin, x: Series, data: dict[str, Series], quantity: str, first: bool, dash: str
) -> list[go.Scatter]:
    """Computed as a line, measured as open circles."""
    colour, name = controller_colour(margin.controller), _title(margin)
    group = name
    computed, measured = data[f"computed_{quantity}"], data[f"measured_{quantity}"]
    traces = [
        go.Scatter(
            x=x.astype(np.float32),
            y=computed.astype(np.float32),
            mode="lines",
            name=name,
            legendgroup=group,
            showlegend=first,
            visible=_visible(margin),
            line={"color": colour, "width": 1.7, "dash": dash},
        )
    ]
    if np.any(np.isfinite(measured)):
        traces.append(_circles(x[np.isfinite(measured)], measured[np.isfinite(measured)], margin))
    return traces


def _unwrapped(data: dict[str, Series]) -> dict[str, Series]:
    """The phases without jumps of 360 degrees; the measured one on the branch of the computed one."""
    computed = np.unwrap(data["computed_phase_deg"], period=360.0)
    measured = data["measured_phase_deg"]
    measured = measured + 360.0 * np.round((computed - measured) / 360.0)
    return {**data, "computed_phase_deg": computed, "measured_phase_deg": measured}


def _circles(x: Series, y: Series, margin: Margin) -> go.Scatter:
    name = _title(margin)
    marker = {
        "symbol": "circle-open", "size": 6, "color": controller_colour(margin.controller), "line": {"width": 1.4},
    }  # fmt: skip
    return go.Scatter(
        x=x.astype(np.float32),
        y=y.astype(np.float32),
        mode="markers",
        name=f"{name}, measured",
        legendgroup=name,
        showlegend=False,
        visible=_visible(margin),
        marker=marker,
    )


def _nyquist(results: Results, margins: list[Margin]) -> go.Figure:
    conditions = _conditions(margins)
    plot = panels(1, len(conditions), 500, [CONDITION_TITLES[name] for name in conditions], horizontal_spacing=0.08)
    shown: set[str] = set()
    for margin in margins:
        column = conditions.index(margin.condition) + 1
        data = read_columns(results.folder / margin.response_csv, COLUMNS)
        colour, name = controller_colour(margin.controller), _title(margin)
        real, imaginary = _complex(data["computed_magnitude_db"], data["computed_phase_deg"])
        line = go.Scatter(
            x=real.astype(np.float32),
            y=imaginary.astype(np.float32),
            mode="lines",
            name=name,
            legendgroup=name,
            showlegend=name not in shown,
            visible=_visible(margin),
            line={"color": colour, "width": 1.7, "dash": _dash(margin, margins)},
            customdata=data["frequency_hz"].astype(np.float32),
            hovertemplate="%{customdata:.2f} Hz<extra>%{fullData.name}</extra>",
        )
        plot.add_trace(line, row=1, col=column)
        shown.add(name)
        _measured_points(plot, margin, data, column)
    for column in range(1, len(conditions) + 1):
        _keep_out(plot, column)
    plot.update_xaxes(title_text="real part", range=[-NYQUIST_REACH, 0.6])
    plot.update_yaxes(range=[-NYQUIST_REACH, 0.8])
    plot.update_yaxes(title_text="imaginary part", col=1)
    for column in range(1, len(conditions) + 1):
        axis = "x" if column == 1 else f"x{column}"
        plot.update_yaxes(scaleanchor=axis, row=1, col=column)
    return plot


def _measured_points(plot: go.Figure, margin: Margin, data: dict[str, Series], column: int) -> None:
    have = np.isfinite(data["measured_magnitude_db"]) & np.isfinite(data["measured_phase_deg"])
    if np.any(have):
        real, imaginary = _complex(data["measured_magnitude_db"][have], data["measured_phase_deg"][have])
        plot.add_trace(_circles(real, imaginary, margin), row=1, col=column)


def _complex(magnitude_db: Series, phase_deg: Series) -> tuple[Series, Series]:
    """Real and imaginary part; far points are pulled in to the plot's surroundings so that the scale stays."""
    magnitude = np.minimum(10.0 ** (magnitude_db / 20.0), 50.0)
    phase = np.radians(phase_deg)
    return magnitude * np.cos(phase), magnitude * np.sin(phase)


def _keep_out(plot: go.Figure, column: int) -> None:
    """The unit circle, and in red what a curve with both margins does not touch."""
    angle = np.linspace(0, 2 * np.pi, 181)
    circle = {"color": MUTED, "width": 1, "dash": "dot"}
    unit = go.Scatter(x=np.cos(angle), y=np.sin(angle), mode="lines", line=circle, hoverinfo="skip", showlegend=False)
    plot.add_trace(unit, row=1, col=column)
    arc = np.radians(np.linspace(180 - PHASE_MARGIN_GOAL_DEG, 180 + PHASE_MARGIN_GOAL_DEG, 41))
    tip = -(10 ** (-GAIN_MARGIN_GOAL_DB / 20))
    for x, y in ((np.cos(arc), np.sin(arc)), (np.array([-1.0, tip]), np.zeros(2))):
        forbidden = go.Scatter(
            x=x,
            y=y,
            mode="lines",
            name="margin goals",
            legendgroup="goal",
            line={"color": BAD, "width": 3},
            showlegend=column == 1 and x.size > 2,
            hoverinfo="skip",
        )
        plot.add_trace(forbidden, row=1, col=column)
    critical = {"symbol": "x", "size": 8, "color": BAD}
    plot.add_trace(
        go.Scatter(x=[-1], y=[0], mode="markers", marker=critical, showlegend=False, hovertext="−1"), row=1, col=column
    )
