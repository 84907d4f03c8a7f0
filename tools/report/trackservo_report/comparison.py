# SPDX-License-Identifier: Apache-2.0
"""Rows gathered into comparisons: the same measurement, one entry per controller."""

from __future__ import annotations

from dataclasses import dataclass, field

from .display import METRIC_TITLES, case_order
from .controllers import INGREDIENTS
from .experiments import experiments, order_of
from .load import Row

WITHOUT_EFFECT = {"overshoot_above_friction_free": 0.0, "overshoot_over_friction_free": 1.0}
"""Metrics that are best where friction changes nothing: a loop that stays far below the friction-free one is not better."""


def badness(metric: str, value: float) -> float:
    """What is smaller for a better result, in the metric's unit."""
    return abs(value - WITHOUT_EFFECT[metric]) if metric in WITHOUT_EFFECT else value


def paper_mark(row: Row) -> str:
    """What must stand beside a figure of PI alone that is not the paper's; empty where it is, or where none is printed."""
    if row.reproduced is not False or row.value is None or row.paper_uncompensated is None:
        return ""
    neutral = WITHOUT_EFFECT.get(row.metric, 0.0)
    opposite = (row.value - neutral) * (row.paper_uncompensated - neutral) < 0
    return "not reproduced: opposite sign" if opposite else "not reproduced"


def count_reproduced(rows: list[Row]) -> tuple[int, int]:
    """The paper's printed figures for PI alone: reproduced, and all. Two readings of one figure are one."""
    figures: dict[tuple[str, str], bool] = {}
    for row in rows:
        if row.reproduced is not None:
            place = (row.experiment, row.case)
            figures[place] = figures.get(place, False) or row.reproduced
    return sum(figures.values()), len(figures)


@dataclass(frozen=True)
class Comparison:
    """One measurement under several controllers; the values are in `unit`."""

    experiment: str
    case: str
    plant: str
    friction: str
    axis: str
    metric: str
    unit: str
    rows: dict[str, Row] = field(default_factory=dict)

    def value(self, controller: str) -> float | None:
        """Value under a controller, None when it was not run or does not exist."""
        row = self.rows.get(controller)
        return None if row is None else row.value

    def paper(self, compensated: bool) -> float | None:
        """The paper's figure for this measurement, whichever row carries it."""
        for row in self.rows.values():
            printed = row.paper_compensated if compensated else row.paper_uncompensated
            if printed is not None:
                return printed
        return None

    def has_goal(self) -> bool:
        """True when a row of it is judged against a goal."""
        return any(row.met is not None for row in self.rows.values())

    def controllers(self) -> list[str]:
        """The controllers present, in the order of the tables."""
        known = [name for name in INGREDIENTS if name in self.rows]
        return known + [name for name in self.rows if name not in known]


def gather(rows: list[Row]) -> list[Comparison]:
    """Group rows by everything but the controller, sorted as the paper's experiments come."""
    found: dict[tuple[str, ...], Comparison] = {}
    for row in rows:
        key = (row.experiment, row.case, row.plant, row.friction, row.axis, row.metric, row.unit)
        found.setdefault(key, Comparison(*key)).rows[row.controller] = row
    return sorted(found.values(), key=_order)


def _order(item: Comparison) -> tuple[object, ...]:
    metrics = list(METRIC_TITLES)
    plant = 0 if item.plant == experiments()[item.experiment].plant else 1
    return (
        order_of(item.experiment),
        plant,
        ["lugre", "none", "maxwell_slip"].index(item.friction),
        item.axis,
        case_order(item.case),
        metrics.index(item.metric),
    )


def select(items: list[Comparison], **wanted: str) -> list[Comparison]:
    """The comparisons whose fields have the wanted values."""
    return [item for item in items if all(getattr(item, name) == value for name, value in wanted.items())]


def floor_of(item: Comparison, items: list[Comparison]) -> float | None:
    """The same measurement on the plant without friction: the smallest value any controller reached, in `unit`."""
    same = {"experiment": item.experiment, "case": item.case, "plant": item.plant, "axis": item.axis}
    values = [
        row.value
        for other in select(items, friction="none", metric=item.metric, unit=item.unit, **same)
        for row in other.rows.values()
        if row.value is not None
    ]
    return min(values) if values else None


def headline(items: list[Comparison], experiment: str, metric: str | None = None) -> list[Comparison]:
    """The comparisons that stand for an experiment: preferred plant, LuGre friction, azimuth where they exist."""
    chosen = select(items, experiment=experiment, metric=metric or experiments()[experiment].metric, friction="lugre")
    for name, value in (("plant", experiments()[experiment].plant), ("axis", "azimuth")):
        chosen = select(chosen, **{name: value}) or chosen
    return chosen


def count_goals(rows: list[Row]) -> tuple[int, int]:
    """Goals met and goals judged."""
    judged = [row for row in rows if row.met is not None]
    return sum(1 for row in judged if row.met), len(judged)
