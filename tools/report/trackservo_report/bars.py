# SPDX-License-Identifier: Apache-2.0
"""Bar charts over controllers: Table 2, the ablation, the other friction, the torque noise."""

from __future__ import annotations

import math

import plotly.graph_objects as go

from .comparison import WITHOUT_EFFECT, Comparison, floor_of, headline
from .controllers import BASELINE, COMPENSATED, INGREDIENTS
from .display import (
    FRICTION_TITLES,
    METRIC_TITLES,
    case_title,
    controller_colour,
    controller_title,
    number,
    unit_title,
)
from .experiments import experiment_title, experiments, order_of
from .theme import GRID, INK, MUTED, SURFACE, View, canvas

PAPER_STYLE = {"color": INK, "width": 1.3, "dash": "dash"}
HALO = ", ".join([f"0 0 3px {SURFACE}"] * 4)
"""Keeps a number readable where a dashed line passes behind it."""
WIDEST_RATIO = 100.0
"""Largest over smallest value that a linear axis can still show."""
MAX_LABELS = 18
"""Above this many bars the numbers would be too small to read; they are under the pointer and in the table."""


def _labels(items: list[Comparison]) -> list[str]:
    """One label per comparison, unique within the chart."""
    several_axes = len({item.axis for item in items}) > 1
    several_plants = len({item.plant for item in items}) > 1
    labels = []
    for item in items:
        parts = [case_title(item.case)]
        parts += [item.axis] if several_axes else []
        parts += [item.plant] if several_plants else []
        labels.append("<br>".join(parts))
    return labels


def _add_bars(plot: go.Figure, items: list[Comparison], controller: str, of: int = 2) -> None:
    """The values of one controller, one `of` several: bars, whiskers, and above the whiskers the numbers."""
    plot.add_trace(_bar(items, controller))
    if len(items) * of <= MAX_LABELS:
        plot.add_trace(_numbers(items, controller))


def _numbers(items: list[Comparison], controller: str) -> go.Bar:
    """Invisible bars without height on the tips of the whiskers, which carry the numbers clear of them."""
    tips: list[float | None] = []
    texts = []
    for item in items:
        row, value = item.rows.get(controller), item.value(controller)
        tips.append(None if row is None or value is None else max(value, 0.0) + row.whiskers()[1])
        texts.append("" if value is None else number(value))
    return go.Bar(
        x=_labels(items),
        y=[None if tip is None else 0.0 for tip in tips],
        base=tips,
        name=f"numbers of {controller_title(controller)}",
        offsetgroup=controller,
        legendgroup=controller,
        showlegend=False,
        marker={"color": "rgba(0,0,0,0)"},
        text=texts,
        textposition="outside",
        textangle=0,
        constraintext="none",
        cliponaxis=False,
        textfont={"size": 11, "shadow": HALO},
        hoverinfo="skip",
    )


def _bar(items: list[Comparison], controller: str) -> go.Bar:
    """The values of one controller over the cases, with the spread over the seeds."""
    values = [item.value(controller) for item in items]
    rows = [item.rows.get(controller) for item in items]
    return go.Bar(
        x=_labels(items),
        y=values,
        name=controller_title(controller),
        marker={"color": controller_colour(controller)},
        offsetgroup=controller,
        legendgroup=controller,
        error_y={
            "type": "data",
            "symmetric": False,
            "array": [row.whiskers()[1] if row else 0.0 for row in rows],
            "arrayminus": [row.whiskers()[0] if row else 0.0 for row in rows],
            "thickness": 1,
            "width": 3,
            "color": INK,
        },
    )


def _paper_marks(plot: go.Figure, items: list[Comparison], compensated: bool) -> None:
    """The paper's figure of each case as a dashed line across its bars."""
    for index, item in enumerate(items):
        value = item.paper(compensated)
        if value is not None:
            plot.add_shape(type="line", x0=index - 0.45, x1=index + 0.45, y0=value, y1=value, line=PAPER_STYLE)
            if len(items) == 1:
                words = "paper, compensated" if compensated else "paper, uncompensated"
                plot.add_annotation(
                    x=index + 0.45,
                    y=value,
                    text=f"{words}: {value:g}",
                    showarrow=False,
                    xanchor="right",
                    yanchor="bottom",
                    font={"size": 11.5, "color": INK},
                )


def _paper_legend(plot: go.Figure) -> None:
    plot.add_trace(go.Scatter(x=[None], y=[None], mode="lines", name="paper", line=PAPER_STYLE))


def case_bars(items: list[Comparison], experiment: str) -> list[View]:
    """The metric that decides, case by case, with and without compensation (Table 2)."""
    chosen = headline(items, experiment)
    if not chosen:
        return []
    metric = METRIC_TITLES[chosen[0].metric]
    plot = canvas(400, xaxis_title="case", yaxis_title=f"{metric} ({unit_title(chosen[0].unit)})")
    for controller in (BASELINE, COMPENSATED):
        _add_bars(plot, chosen, controller)
    for compensated in (False, True):
        _paper_marks(plot, chosen, compensated)
    _paper_legend(plot)
    return [View(metric, plot)]


def ablation_bars(items: list[Comparison]) -> list[View]:
    """Every controller on every experiment's own metric, one tab per experiment."""
    views = []
    for experiment in experiments():
        chosen = headline(items, experiment)
        if not chosen:
            continue
        metric, unit = experiments()[experiment].metric, unit_title(chosen[0].unit)
        plot = canvas(420, xaxis_title="case", yaxis_title=f"{METRIC_TITLES[metric]} ({unit})")
        for controller in INGREDIENTS:
            if any(controller in item.rows for item in chosen):
                _add_bars(plot, chosen, controller, len(INGREDIENTS))
        for compensated in (False, True):
            _paper_marks(plot, chosen, compensated)
        if any(item.paper(False) is not None or item.paper(True) is not None for item in chosen):
            _paper_legend(plot)
        _floor_marks(plot, chosen, items)
        _fit_scale(plot, chosen)
        views.append(View(experiment_title(experiment), plot))
    return views


def _fit_scale(plot: go.Figure, chosen: list[Comparison]) -> None:
    """A logarithmic axis where one controller would dwarf the others."""
    values = [row.value for item in chosen for row in item.rows.values() if row.value is not None]
    if values and min(values) > 0.0 and max(values) > WIDEST_RATIO * min(values):
        title = plot.layout.yaxis.title.text
        plot.update_yaxes(type="log", dtick=1, title_text=f"{title}, log scale")
        for note in plot.layout.annotations:  # unlike shapes, annotations stand at the logarithm
            note.y = math.log10(note.y)


def _floor_marks(plot: go.Figure, chosen: list[Comparison], items: list[Comparison]) -> None:
    """The friction-free value of each case as a dotted line."""
    style = {"color": MUTED, "width": 1.6, "dash": "dot"}
    found = False
    for index, item in enumerate(chosen):
        value = floor_of(item, items)
        if value is not None:
            found = True
            plot.add_shape(type="line", x0=index - 0.45, x1=index + 0.45, y0=value, y1=value, line=style)
    if found:
        plot.add_trace(go.Scatter(x=[None], y=[None], mode="lines", name="friction-free floor", line=style))


def friction_bars(items: list[Comparison]) -> list[View]:
    """The remaining share of PI's error, in %, on the feedforward's own friction model and on another one."""
    pairs = _friction_pairs(items)
    if not pairs:
        return []
    plot = canvas(440, yaxis_title="remaining error (% of PI on the same friction)")
    labels = [
        [experiment_title(item.experiment) for item, _ in pairs],
        [_group_label(item) for item, _ in pairs],
    ]
    for controller in ("pi_vob", "pi_ftc", COMPENSATED):
        for friction, place in (("lugre", 0), ("maxwell_slip", 1)):
            values = [_left_over(pair[place], controller) for pair in pairs]
            if any(value is not None for value in values):
                plot.add_trace(_friction_bar(labels, values, controller, friction))
    plot.add_hline(y=100, line={"color": MUTED, "width": 1, "dash": "dot"})
    plot.update_xaxes(tickfont={"size": 11}, tickangle=0, showdividers=True, dividercolor=GRID)
    return [View("remaining error", plot)]


def _group_label(item: Comparison) -> str:
    """The case; an invisible mark keeps equal cases of two experiments apart, which plotly would sort as one."""
    mark = "\u200b" * order_of(item.experiment)
    return case_title(item.case).replace(", ", "<br>").replace(" loop", "<br>loop") + mark


def _friction_bar(labels: list[list[str]], values: list[float | None], controller: str, friction: str) -> go.Bar:
    colour = controller_colour(controller)
    pattern = {"shape": "/", "size": 6, "solidity": 0.45, "fgcolor": colour} if friction == "maxwell_slip" else {}
    return go.Bar(
        x=labels,
        y=values,
        name=f"{controller_title(controller)}, {FRICTION_TITLES[friction]}",
        marker={
            "color": "rgba(0,0,0,0)" if pattern else colour,
            "line": {"color": colour, "width": 1},
            "pattern": pattern,
        },
        hovertemplate="%{y:.1f} %<extra>%{fullData.name}</extra>",
    )


def _friction_pairs(items: list[Comparison]) -> list[tuple[Comparison, Comparison]]:
    """Headline comparisons that exist on both frictions, where a share of PI's error makes sense."""
    pairs = []
    for experiment in experiments():
        if experiments()[experiment].metric in WITHOUT_EFFECT:
            continue
        for item in headline(items, experiment):
            for other in items:
                same = all(
                    getattr(other, name) == getattr(item, name)
                    for name in ("experiment", "case", "plant", "axis", "metric", "unit")
                )
                if same and other.friction == "maxwell_slip":
                    pairs.append((item, other))
    return pairs


def _left_over(item: Comparison, controller: str) -> float | None:
    value, baseline = item.value(controller), item.value(BASELINE)
    return None if value is None or not baseline else 100.0 * value / baseline


def torque_noise_bars(items: list[Comparison]) -> list[View]:
    """Torque noise per controller."""
    views = []
    for experiment in experiments():
        chosen = headline(items, experiment, "torque_noise")
        if not chosen:
            continue
        plot = canvas(380, xaxis_title="case", yaxis_title=f"torque noise ({unit_title(chosen[0].unit)})")
        for controller in INGREDIENTS:
            if any(controller in item.rows for item in chosen):
                _add_bars(plot, chosen, controller, len(INGREDIENTS))
        _fit_scale(plot, chosen)
        views.append(View(experiment_title(experiment), plot))
    return views
