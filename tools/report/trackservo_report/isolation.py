# SPDX-License-Identifier: Apache-2.0
"""Isolation from a turning base: the curves of `sim_host base-motion`."""

from __future__ import annotations

from typing import Any

import plotly.graph_objects as go

from .studies import FEEDBACKS
from .theme import BAD, View, canvas

COLOURS = {"encoder": "#8a8f98", "fused": "#2f6fde", "gyro": "#1a9850"}
DASHES = ("solid", "dash", "dot")
"""Of the amplitudes, the largest first."""


def isolation_views(study: dict[str, Any]) -> list[View]:
    """One tab per axis."""
    return [View(axis, _curves(study, axis)) for axis in ("azimuth", "pitch")]


def _curves(study: dict[str, Any], axis: str) -> go.Figure:
    curves = [curve for curve in study["isolation"] if curve["axis"] == axis]
    amplitudes = sorted({curve["amplitude_deg"] for curve in curves}, reverse=True)
    plot = canvas(440)
    for curve in curves:
        dash = DASHES[min(amplitudes.index(curve["amplitude_deg"]), len(DASHES) - 1)]
        plot.add_trace(
            go.Scatter(
                x=curve["frequency_hz"],
                y=curve["residual_db"],
                mode="lines+markers",
                name=f"{FEEDBACKS[curve['feedback']]}, {curve['amplitude_deg']:g}°",
                line={"color": COLOURS[curve["feedback"]], "width": 1.7, "dash": dash},
                marker={"size": 5},
            )
        )
    goal = study["goal"]
    plot.add_trace(
        go.Scatter(
            x=[goal["isolation_hz"]],
            y=[goal["isolation_db"]],
            mode="markers",
            name=f"required: gyro, {goal['isolation_deg']:g}°",
            marker={"symbol": "triangle-up", "size": 11, "color": BAD},
        )
    )
    plot.update_xaxes(type="log", dtick=1, title_text="frequency of the base (Hz)")
    plot.update_yaxes(title_text="isolation of the rms angle (dB)")
    return plot
