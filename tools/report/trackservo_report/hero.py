# SPDX-License-Identifier: Apache-2.0
"""The picture of the first screen: the axis starts at the lowest speed, with and without compensation. Static SVG."""

from __future__ import annotations

from dataclasses import dataclass
from html import escape

import numpy as np

from .comparison import Comparison, headline
from .controllers import BASELINE, COMPENSATED
from .curves import DEGREES, RunBook, step_time
from .display import case_title, controller_colour, number, plant_title
from .load import Results
from .traces import Series, thin, window

WIDTH, HEIGHT = 980, 292
LEFT, RIGHT, TOP, BOTTOM = 58, 14, 14, 40
BEFORE_S, AFTER_S = 0.3, 3.0
"""What is shown around the step: at rest, then as long as PI alone takes to start and a few of its errors."""
POINTS = 1200


@dataclass(frozen=True)
class Hero:
    """The picture with the words under it."""

    svg: str
    caption: str


@dataclass(frozen=True)
class _Frame:
    """Seconds after the step and speeds to places in the picture."""

    top_speed: float
    bottom_speed: float

    def x(self, time_s: float) -> float:
        return LEFT + (time_s + BEFORE_S) / (AFTER_S + BEFORE_S) * (WIDTH - LEFT - RIGHT)

    def y(self, speed: float) -> float:
        share = (speed - self.bottom_speed) / (self.top_speed - self.bottom_speed)
        return HEIGHT - BOTTOM - share * (HEIGHT - TOP - BOTTOM)


def hero(results: Results, items: list[Comparison]) -> Hero | None:
    """The start at the lowest speed; None when the folder holds no such runs."""
    book = RunBook(results)
    chosen = headline(items, "low_speed_start")
    cases = book.cases("low_speed_start")
    if not chosen or not cases or chosen[0].case != cases[0]:
        return None
    item, case = chosen[0], cases[0]
    runs = [book.run("low_speed_start", case, name, figure="fig14") for name in (BASELINE, COMPENSATED)]
    rates = [book.curve(run, "rate_rad_s", DEGREES) for run in runs]
    reference = book.curve(runs[0], "reference_rad_s", DEGREES)
    if runs[0] is None or rates[0] is None or rates[1] is None or reference is None:
        return None
    start_s, speed = step_time(reference), float(reference.values[-1])
    frame = _Frame(top_speed=2.05 * speed, bottom_speed=-0.35 * speed)
    lines = []
    for rate in rates:
        time, values = window(rate.time - start_s, rate.values, -BEFORE_S, AFTER_S)
        lines.append(_curve(frame, time, values, controller_colour(rate.run.controller)))
    times = [item.value(name) for name in (BASELINE, COMPENSATED)]
    parts = [
        f'<svg class="hero" viewBox="0 0 {WIDTH} {HEIGHT}" role="img" aria-label="Speed against time after a step to '
        f'{escape(case_title(case))}, with PI alone and with compensation">',
        _axes(frame, speed),
        _set_point(frame, speed),
        *lines,
        _label(frame, -0.25, 1.84 * speed, BASELINE, f"PI alone: 90 % after {number(times[0])} ms, disturbed by gusts"),
        _label(frame, 1.50, 1.84 * speed, COMPENSATED, f"PI + VOB + FTC: 90 % after {number(times[1])} ms, steady"),
        "</svg>",
    ]
    seeds = item.rows[BASELINE].seeds
    caption = (
        f"True speed of the azimuth axis on the {plant_title(item.plant)}, set-point 0 to {case_title(case)}, with wind, ripple and "
        f"sensor noise; one run (seed {runs[0].seed}). "
        + (f"The times are medians over {seeds} seeds." if seeds > 1 else "The times are this run's.")
    )
    return Hero("\n".join(parts), caption)


_ALONE = (
    "text{font:13px sans-serif;fill:#667083} text.name{fill:#1d2430} text.curve{font-size:15px;font-weight:600;fill:#1d2430} "
    ".grid{stroke:#e9ebee} .set{stroke:#1d2430;stroke-width:1.3;stroke-dasharray:2 3}"
)
"""The page's style sheet in its light colours, for a picture outside of the page."""


def standalone(picture: Hero) -> str:
    """The picture as a file of its own, on a white ground, for the README."""
    head = f'<svg xmlns="http://www.w3.org/2000/svg" width="{WIDTH}" height="{HEIGHT}" '
    ground = f'<style>{_ALONE}</style>\n<rect width="{WIDTH}" height="{HEIGHT}" fill="#ffffff"/>\n'
    first, rest = picture.svg.split("\n", 1)
    return first.replace("<svg ", head, 1) + "\n" + ground + rest + "\n"


def _curve(frame: _Frame, time: Series, values: Series, colour: str) -> str:
    short, thinned = thin(time, values, POINTS)
    clipped = np.clip(thinned, frame.bottom_speed, 0.84 * frame.top_speed)  # clear of the labels
    points = " ".join(f"{frame.x(t):.1f},{frame.y(v):.1f}" for t, v in zip(short, clipped, strict=True))
    return f'<polyline points="{points}" fill="none" stroke="{colour}" stroke-width="2" stroke-linejoin="round"/>'


def _set_point(frame: _Frame, speed: float) -> str:
    corners = [(-BEFORE_S, 0.0), (0.0, 0.0), (0.0, speed), (AFTER_S, speed)]
    points = " ".join(f"{frame.x(t):.1f},{frame.y(v):.1f}" for t, v in corners)
    place = f'x="{frame.x(-0.02):.1f}" y="{frame.y(speed) + 4:.1f}" text-anchor="end"'
    return f'<polyline class="set" points="{points}" fill="none"/><text class="tick" {place}>set-point</text>'


def _axes(frame: _Frame, speed: float) -> str:
    parts = []
    for tick in (0.0, 0.5, 1.0, 1.5):
        y, value = frame.y(tick * speed), tick * speed
        parts.append(f'<line class="grid" x1="{LEFT}" x2="{WIDTH - RIGHT}" y1="{y:.1f}" y2="{y:.1f}"/>')
        parts.append(f'<text class="tick" x="{LEFT - 8}" y="{y + 4:.1f}" text-anchor="end">{value:g}</text>')
    for time_s in np.arange(0.0, AFTER_S + 0.01, 0.5):
        x = frame.x(float(time_s))
        parts.append(f'<line class="grid" x1="{x:.1f}" x2="{x:.1f}" y1="{TOP}" y2="{HEIGHT - BOTTOM}"/>')
        parts.append(f'<text class="tick" x="{x:.1f}" y="{HEIGHT - BOTTOM + 17}" text-anchor="middle">{time_s:g}</text>')
    middle = 0.5 * (TOP + HEIGHT - BOTTOM)
    parts.append(f'<text class="name" x="{0.5 * (LEFT + WIDTH):.0f}" y="{HEIGHT - 6}" text-anchor="middle">time after the step (s)</text>')
    parts.append(f'<text class="name" transform="translate(14 {middle:.0f}) rotate(-90)" text-anchor="middle">speed (°/s)</text>')
    return "".join(parts)


def _label(frame: _Frame, time_s: float, speed: float, controller: str, text: str) -> str:
    x, y, colour = frame.x(time_s), frame.y(speed), controller_colour(controller)
    swatch = f'<line x1="{x:.1f}" x2="{x + 22:.1f}" y1="{y - 5:.1f}" y2="{y - 5:.1f}" stroke="{colour}" stroke-width="3"/>'
    return f'{swatch}<text class="curve" x="{x + 30:.1f}" y="{y:.1f}">{escape(text)}</text>'
