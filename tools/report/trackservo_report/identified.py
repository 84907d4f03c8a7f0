# SPDX-License-Identifier: Apache-2.0
"""What the controllers were designed from: true and identified parameters of each axis, with their confidence."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import plotly.graph_objects as go

from .controllers import COMPENSATED
from .display import number
from .load import IdentifiedAxis, IdentifiedParameter, Results, read_json
from .theme import INK, MUTED, Figure, View, canvas, panels
from .traces import Series, read_columns

TITLES = {
    "coulomb_positive": "Tc, forward", "breakaway_positive": "Ts, forward", "stribeck_speed_positive": "θ̇s, forward",
    "viscous_positive": "σ2, forward", "coulomb_negative": "Tc, backward", "breakaway_negative": "Ts, backward",
    "stribeck_speed_negative": "θ̇s, backward", "viscous_negative": "σ2, backward",
    "stiffness": "σ0", "damping": "σ1", "inertia": "J",
}  # fmt: skip
FORWARD, BACKWARD = "rgb(42,120,214)", "rgb(235,104,52)"


@dataclass(frozen=True)
class ParameterLine:
    """One parameter of one axis, as text."""

    where: str
    title: str
    unit: str
    true: str
    identified: str
    off: str
    interval: str
    covered: bool
    paper_method: str


def parameter_lines(results: Results) -> list[ParameterLine]:
    """A line per parameter, grouped by axis."""
    return [
        _line(f"{axis.plant}, {axis.axis}", item) for axis in results.identified for item in axis.parameters
    ]  # fmt: skip


def _line(where: str, item: IdentifiedParameter) -> ParameterLine:
    return ParameterLine(
        where=where,
        title=TITLES.get(item.name, item.name),
        unit=item.unit,
        true=number(item.true),
        identified=number(item.identified),
        off=f"{100 * (item.identified / item.true - 1):+.2f} %",
        interval=f"{number(item.low)} … {number(item.high)}",
        covered=item.low <= item.true <= item.high,
        paper_method=number(item.paper_method),
    )


@dataclass(frozen=True)
class Gain:
    """Value of identification: compensated figures with wrong parameters over those with identified ones, means."""

    figures: int
    middle: float
    worst: float

    @property
    def middle_words(self) -> str:
        """'2.1 % larger'"""
        return _change_words(self.middle)

    @property
    def worst_words(self) -> str:
        """The same of the worst seed of every figure."""
        return _change_words(self.worst)


def _change_words(ratio: float) -> str:
    change = 100.0 * (ratio - 1.0)
    return f"{abs(change):.1f} % {'larger' if change > 0 else 'smaller'}" if abs(change) >= 0.05 else "the same"


def gain_over_wrong(results: Results) -> Gain | None:
    """The mean over the figures of wrong over identified; by middle and by worst seed. None when a figure is missing."""
    chosen = [
        item
        for item in results.sensitivity
        if item.shipped_setting == "identified" and item.controller == COMPENSATED and item.metric != "rms_error"
    ]
    pairs = [(item.value, item.shipped.value, item.high, item.shipped.high) for item in chosen]
    if not pairs or any(not value for pair in pairs for value in pair):
        return None
    middle = sum((wrong or 0.0) / (found or 1.0) for wrong, found, _, _ in pairs) / len(pairs)
    worst = sum((wrong or 0.0) / (found or 1.0) for _, _, wrong, found in pairs) / len(pairs)
    return Gain(len(pairs), middle, worst)


def figures(results: Results) -> list[Figure]:
    """Confidence, Stribeck curves, friction over the angle, residuals: a tab per axis."""
    if not results.identified:
        return []
    ordered = sorted(results.identified, key=lambda axis: axis.plant != "tracker")
    made = {f"{axis.plant}, {axis.axis}": _Axis(results, axis) for axis in ordered}

    def views(draw: str) -> list[View]:
        return [View(label, getattr(axis, draw)()) for label, axis in made.items()]

    hints = ["sim_host/lib/identification/joint_fit.cpp", "sim_host/lib/test_plan/test_plan.cpp"]
    return [
        Figure(
            "confidence",
            "Identified over true, with 95 % intervals",
            views("confidence"),
            caption="1 is the plant's true value. The strokes are the required limits: "
            "5 % for Tc, Ts, σ2 and J, 10 % for θ̇s and σ0, 20 % for σ1.",
            hints=hints,
        ),
        Figure(
            "stribeck",
            "Steady friction, eq. (5)",
            views("stribeck"),
            caption="Solid: the plant. Dashed: the identified curve, from runs with the plant's wind.",
            hints=["sim_host/lib/identification/stribeck_fit.cpp"],
        ),
        Figure(
            "friction-map",
            "Friction level over the joint angle",
            views("friction_map"),
            caption="Identified variation of friction once and twice per turn, caused by the seal's eccentricity.",
            hints=["sim_host/lib/identification/position_terms.cpp"],
        ),
        Figure(
            "whitened",
            "Residuals of the fit, whitened",
            views("whitened"),
            caption="Left: their distribution beside the normal one. Right: their correlation. Between the dashed "
            "lines, the noise model explains the residuals.",
            hints=["sim_host/lib/identification/noise_model.cpp"],
        ),
    ]


class _Axis:
    """The plots of one axis."""

    def __init__(self, results: Results, axis: IdentifiedAxis) -> None:
        self.axis = axis
        self.folder = results.folder / axis.folder
        self.by_name = {item.name: item for item in axis.parameters}

    def confidence(self) -> go.Figure:
        items = list(reversed(self.axis.parameters))
        share = [item.identified / item.true for item in items]
        plot = canvas(430, showlegend=False)
        limits = [_limit(item.name) for item in items]
        for sign in (-1.0, 1.0):
            plot.add_trace(
                go.Scatter(
                    x=[1.0 + sign * limit for limit in limits], y=[TITLES[item.name] for item in items], mode="markers",
                    marker={"color": MUTED, "size": 14, "symbol": "line-ns-open"}, hoverinfo="skip",
                )
            )  # fmt: skip
        plot.add_trace(
            go.Scatter(
                x=share,
                y=[TITLES[item.name] for item in items],
                mode="markers",
                marker={"color": FORWARD, "size": 8},
                error_x={
                    "type": "data",
                    "symmetric": False,
                    "array": [item.high / item.true - value for item, value in zip(items, share, strict=True)],
                    "arrayminus": [value - item.low / item.true for item, value in zip(items, share, strict=True)],
                    "color": FORWARD,
                },
            )
        )
        plot.add_vline(x=1.0, line={"color": INK, "width": 1})
        plot.update_xaxes(title_text="identified / true", range=[0.78, 1.22])
        return plot

    def stribeck(self) -> go.Figure:
        speed_rad_s = np.geomspace(1e-5, 0.5, 300)
        plot = canvas(400)
        for direction, colour in (("positive", FORWARD), ("negative", BACKWARD)):
            for kind, dash in (("true", "solid"), ("identified", "dash")):
                values = [getattr(self.by_name[f"{name}_{direction}"], kind) for name in (
                    "coulomb", "breakaway", "stribeck_speed", "viscous")]  # fmt: skip
                plot.add_trace(
                    go.Scatter(
                        x=np.degrees(speed_rad_s), y=_steady_nm(speed_rad_s, *values), mode="lines",
                        line={"color": colour, "dash": dash, "width": 3 if dash == "dash" else 1.5},
                        name=f"{'forward' if direction == 'positive' else 'backward'}, {kind}",
                    )
                )  # fmt: skip
        plot.update_xaxes(title_text="joint rate (°/s)", type="log", dtick=1)
        plot.update_yaxes(title_text="friction torque (Nm)")
        return plot

    def friction_map(self) -> go.Figure:
        position = self._result()["position"]
        angle_rad = np.linspace(*position["travel_rad"], 361)
        level = np.ones_like(angle_rad)
        for term in position["friction_level"]:
            level += term["value"] * _term(term["term"], angle_rad, position["travel_rad"])
        plot = canvas(360, showlegend=False)
        plot.add_trace(go.Scatter(x=np.degrees(angle_rad), y=level, mode="lines", line={"color": FORWARD}))
        plot.update_xaxes(title_text="joint angle (°)")
        plot.update_yaxes(title_text="friction / mean friction")
        return plot

    def whitened(self) -> go.Figure:
        values = read_columns(self.folder / "residuals.csv", ["whitened"])["whitened"]
        values = values[np.isfinite(values)] / np.std(values)
        plot = panels(1, 2, 380, ["distribution", "correlation"])
        share, edges = np.histogram(np.clip(values, -6, 6), bins=61, range=(-6, 6), density=True)
        middle = 0.5 * (edges[1:] + edges[:-1])
        plot.add_trace(go.Bar(x=middle, y=share, marker={"color": FORWARD}, name="residuals"), row=1, col=1)
        normal = np.exp(-0.5 * middle**2) / np.sqrt(2 * np.pi)
        plot.add_trace(go.Scatter(x=middle, y=normal, mode="lines", line={"color": INK}, name="normal"), row=1, col=1)
        lags = np.arange(1, 41)
        correlation = [float(np.mean(values[lag:] * values[:-lag])) for lag in lags]
        plot.add_trace(go.Bar(x=lags, y=correlation, marker={"color": BACKWARD}, name="correlation"), row=1, col=2)
        for sign in (-1, 1):
            plot.add_hline(y=sign * 0.05, line={"color": INK, "dash": "dash", "width": 1}, row=1, col=2)
        plot.update_xaxes(title_text="residual / deviation", row=1, col=1)
        plot.update_xaxes(title_text="lag (5 ms each)", row=1, col=2)
        plot.update_yaxes(range=[-0.2, 0.2], row=1, col=2)
        return plot

    def _result(self) -> dict[str, Any]:
        file = self.folder / "result.json"
        loaded: dict[str, Any] = read_json(file)
        return loaded


def _limit(name: str) -> float:
    """How far identification may be off."""
    if name == "damping":
        return 0.20
    return 0.10 if name == "stiffness" or name.startswith("stribeck_speed") else 0.05


def _steady_nm(
    speed_rad_s: Series, coulomb_nm: float, breakaway_nm: float, stribeck_rad_s: float, viscous: float
) -> Series:
    """Eq. (5) of the paper."""
    fall = np.exp(-((speed_rad_s / stribeck_rad_s) ** 2))
    return np.asarray(coulomb_nm + (breakaway_nm - coulomb_nm) * fall + viscous * speed_rad_s, dtype=np.float64)


def _term(name: str, angle_rad: Series, travel_rad: list[float]) -> Series:
    """A term of result.json's `friction_level`, over the angle."""
    middle, half = 0.5 * (travel_rad[0] + travel_rad[1]), 0.5 * (travel_rad[1] - travel_rad[0])
    x = (angle_rad - middle) / half
    known = {
        "cos(angle)": np.cos(angle_rad), "sin(angle)": np.sin(angle_rad),
        "cos(2 angle)": np.cos(2 * angle_rad), "sin(2 angle)": np.sin(2 * angle_rad),
        "P1(travel)": x, "P2(travel)": 0.5 * (3 * x**2 - 1),
    }  # fmt: skip
    if name not in known:
        raise InputError(f"friction_level: term '{name}' is not known; give one of {', '.join(known)}.")
    return np.asarray(known[name], dtype=np.float64)
