# SPDX-License-Identifier: Apache-2.0
"""The look of every figure: layout, paper lines, and colours that the page swaps for light and dark."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import plotly.graph_objects as go
from plotly.subplots import make_subplots

INK = "rgb(1,1,1)"
MUTED = "rgb(2,2,2)"
GRID = "rgb(3,3,3)"
SURFACE = "rgb(4,4,4)"
BAD = "rgb(5,5,5)"
"""Stand-ins: page.js replaces each by the page's colour for the current light or dark scheme."""

FONT = '-apple-system, "Segoe UI", Roboto, "Helvetica Neue", Arial, "Liberation Sans", sans-serif'


@dataclass(frozen=True)
class View:
    """One plot; several views of a figure are shown as tabs."""

    label: str
    plot: go.Figure


@dataclass(frozen=True)
class Figure:
    """A figure of the page: what the paper shows, what ours shows, the plots, and where its code is.

    `mark` says that the paper is not reproduced, and how.
    """

    key: str
    title: str
    views: list[View]
    paper: str = ""
    ours: str = ""
    caption: str = ""
    hints: list[str] = field(default_factory=list)
    mark: str = ""


def canvas(height: int = 400, **axes: Any) -> go.Figure:
    """An empty plot with the common look; `axes` are layout entries."""
    plot = go.Figure(layout={"template": "none"})
    return dress(plot, height, **axes)


def panels(rows: int, columns: int, height: int, titles: list[str], **options: Any) -> go.Figure:
    """An empty grid of plots with the common look."""
    plot = make_subplots(rows=rows, cols=columns, subplot_titles=titles, **options)
    plot.update_layout(template="none")
    plot.update_annotations(font={"size": 13, "color": INK}, yshift=4)
    dress(plot, height)
    plot.update_layout(margin={"t": 82})
    return plot


def dress(plot: go.Figure, height: int, **entries: Any) -> go.Figure:
    """Apply fonts, grid and legend."""
    plot.update_layout(
        height=height,
        paper_bgcolor="rgba(0,0,0,0)",
        plot_bgcolor="rgba(0,0,0,0)",
        font={"family": FONT, "size": 13, "color": INK},
        margin={"l": 66, "r": 40, "t": 58, "b": 54},
        legend={"orientation": "h", "x": 0, "y": 1.0, "yref": "container", "yanchor": "top", "font": {"size": 12.5}},
        hovermode="closest",
        hoverlabel={"bgcolor": SURFACE, "bordercolor": GRID, "font": {"family": FONT, "color": INK}},
        modebar={"orientation": "v", "bgcolor": "rgba(0,0,0,0)", "color": MUTED, "activecolor": INK},
        bargap=0.24,
        bargroupgap=0.06,
        **entries,
    )
    common = {"gridcolor": GRID, "zerolinecolor": MUTED, "zerolinewidth": 1, "linecolor": GRID, "ticks": ""}
    plot.update_xaxes(**common, title={"standoff": 8, "font": {"size": 13}}, automargin=True)
    plot.update_yaxes(**common, title={"standoff": 10, "font": {"size": 13}}, automargin=True)
    return plot


def paper_line(plot: go.Figure, value: float, text: str, **place: Any) -> None:
    """A dashed line at a figure that the paper prints, in the axis' unit."""
    plot.add_hline(
        y=value,
        line={"color": INK, "width": 1.3, "dash": "dash"},
        annotation={"text": text, "font": {"size": 11.5, "color": INK}, "bgcolor": SURFACE, "borderpad": 1},
        annotation_position="top right" if value >= 0 else "bottom right",
        **place,
    )


def paper_key(plot: go.Figure, **place: Any) -> None:
    """A legend entry for the paper's dashed lines."""
    plot.add_trace(
        go.Scatter(
            x=[None],
            y=[None],
            mode="lines",
            name="paper",
            line={"color": INK, "width": 1.3, "dash": "dash"},
            legendrank=600,
        ),
        **place,
    )
