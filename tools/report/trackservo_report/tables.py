# SPDX-License-Identifier: Apache-2.0
"""The tables of the report as plain data, shared by the page and the terminal."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from .bode import GAIN_MARGIN_GOAL_DB, PHASE_MARGIN_GOAL_DEG
from .comparison import Comparison, badness, floor_of, headline, paper_mark
from .controllers import BASELINE, COMPENSATED, DESIGNED, INGREDIENTS
from .display import (
    CONDITION_TITLES,
    FRICTION_TITLES,
    HIGHER_IS_BETTER,
    METRIC_TITLES,
    MISSING,
    case_title,
    controller_title,
    gain,
    number,
    over_seeds,
    plain_number,
    plant_title,
    pretty_units,
    span,
    unit_title,
)
from .experiments import experiment_title, experiments, study_title
from .load import Margin, Results, Row, Varied
from .verdict import Duel

COLUMNS = [BASELINE, COMPENSATED, DESIGNED]
"""Ours in the result table."""
SHARED = ["pi_vob", "pi_ftc", "pi_vob_ftc"]
"""The ingredients that are compared with PI: each alone, then both."""
LARGEST_PERCENTAGE = 1000.0
"""A change above this is against almost nothing and says nothing."""


@dataclass(frozen=True)
class Cell:
    """One number of a table: as text, exact (`value`, for tests and tooltips), and its mark against a goal."""

    text: str = MISSING
    value: float | None = None
    goal: str = ""
    met: bool | None = None
    best: bool = False
    mark: str = ""


@dataclass(frozen=True)
class ResultLine:
    """One line of the result table: the paper's figure beside ours."""

    experiment: str
    case: str
    note: str
    floor: str
    metric: str
    unit: str
    paper_before: Cell
    paper_after: Cell
    before: Cell
    after: Cell
    designed: Cell
    gain: str


def cell_of(row: Row | Varied | None) -> Cell:
    """A row's value with its spread and its goal."""
    if row is None:
        return Cell()
    text = over_seeds(row)
    if row.value is None and row.metric == "time_to_90_percent":
        text = "not reached"
    mark = paper_mark(row) if isinstance(row, Row) else ""
    return Cell(text, row.value, pretty_units(row.goal or ""), row.met, mark=mark)


def _paper_cell(value: float | None) -> Cell:
    return Cell(plain_number(value), value)


def _where(item: Comparison) -> list[str]:
    """What sets a comparison apart from the usual: other axis, other friction."""
    notes = [] if item.axis == "azimuth" else [item.axis]
    return notes + ([] if item.friction == "lugre" else [FRICTION_TITLES[item.friction] + " plant"])


def _belongs(item: Comparison) -> bool:
    """The result table holds what is judged, and what the paper printed: for the azimuth axis, with LuGre friction."""
    printed = item.paper(True) is not None or item.paper(False) is not None
    return item.has_goal() or (printed and item.friction == "lugre" and item.axis == "azimuth")


def result_lines(items: list[Comparison]) -> list[ResultLine]:
    """The result table; a controller other than the three columns gets a line of its own when it has a goal."""
    lines = []
    for item in items:
        if not _belongs(item):
            continue
        columns = [cell_of(item.rows.get(name)) for name in COLUMNS]
        lines.append(_line(item, columns, _where(item), floor_of(item, items)))
        for name in item.controllers():
            if name not in COLUMNS and item.rows[name].met is not None:
                alone = [Cell(), cell_of(item.rows[name]), Cell()]
                lines.append(_line(item, alone, [*_where(item), controller_title(name)]))
    return lines


def _line(item: Comparison, columns: list[Cell], notes: list[str], floor: float | None = None) -> ResultLine:
    before, after, designed = columns
    return ResultLine(
        experiment=experiment_title(item.experiment),
        case=case_title(item.case),
        note=", ".join(notes),
        floor="" if floor is None else f"friction-free {number(floor)}",
        metric=METRIC_TITLES[item.metric],
        unit=unit_title(item.unit),
        paper_before=_paper_cell(item.paper(False)),
        paper_after=_paper_cell(item.paper(True)),
        before=before,
        after=after,
        designed=designed,
        gain="" if item.metric in HIGHER_IS_BETTER else gain(before.value, after.value),
    )


def unmet_goals(rows: list[Row]) -> list[str]:
    """One sentence per goal that was not met."""
    return [
        f"{experiment_title(row.experiment)}, {case_title(row.case)}, {controller_title(row.controller)}"
        + ("" if row.axis == "azimuth" else f", {row.axis}")
        + ("" if row.friction == "lugre" else f", {FRICTION_TITLES[row.friction]} plant")
        + f": {METRIC_TITLES[row.metric]} {cell_of(row).text} {unit_title(row.unit)}, goal {pretty_units(row.goal or '')}"
        for row in rows
        if row.met is False
    ]


def unreproduced(rows: list[Row]) -> list[str]:
    """One sentence per printed figure of the paper that PI alone does not show here."""
    return [
        f"{experiment_title(row.experiment)}, {case_title(row.case)}: {METRIC_TITLES[row.metric]} "
        f"{cell_of(row).text}{'' if row.unit == 'ratio' else ' ' + unit_title(row.unit)}, "
        f"paper {plain_number(row.paper_uncompensated)}; {paper_mark(row)}"
        for row in rows
        if paper_mark(row)
    ]


@dataclass(frozen=True)
class AblationLine:
    """One measurement under every controller, the best one marked."""

    experiment: str
    case: str
    metric: str
    unit: str
    cells: list[Cell]


def ablation_lines(items: list[Comparison], friction: str) -> list[AblationLine]:
    """Every error metric on one friction, a column per controller of `INGREDIENTS`."""
    lines = []
    for item in items:
        if item.friction != friction or item.metric in ("torque_noise", "reduction") or len(item.rows) < 2:
            continue
        notes = [] if item.axis == "azimuth" else [item.axis]
        lines.append(
            AblationLine(
                experiment=experiment_title(item.experiment),
                case=", ".join([case_title(item.case), *notes]),
                metric=METRIC_TITLES[item.metric],
                unit=unit_title(item.unit),
                cells=_marked_cells(item),
            )
        )
    return lines


def _marked_cells(item: Comparison) -> list[Cell]:
    """Cells in the order of `INGREDIENTS`, the best one marked."""
    values = [badness(item.metric, row.value) for row in item.rows.values() if row.value is not None]
    cells = []
    for name in INGREDIENTS:
        cell = cell_of(item.rows.get(name))
        best = cell.value is not None and badness(item.metric, cell.value) == min(values)
        cells.append(Cell(cell.text, cell.value, best=best, mark=cell.mark))
    return cells


@dataclass(frozen=True)
class Table2Column:
    """Table 2 at one speed, in the unit of the rows."""

    case: str
    paper_before: Cell
    paper_after: Cell
    before: Cell
    after: Cell
    paper_reduction: Cell
    reduction: Cell


def table2(items: list[Comparison]) -> tuple[str, list[Table2Column]]:
    """The paper's Table 2 with our rows under it: unit and one column per speed."""
    chosen = headline(items, "steady_speed")
    columns = []
    for item in chosen:
        before, after = cell_of(item.rows.get(BASELINE)), cell_of(item.rows.get(COMPENSATED))
        columns.append(
            Table2Column(
                case_title(item.case),
                _paper_cell(item.paper(False)),
                _paper_cell(item.paper(True)),
                before,
                after,
                _reduction(item.paper(False), item.paper(True)),
                _reduction(before.value, after.value),
            )
        )
    return (unit_title(chosen[0].unit) if chosen else "", columns)


def _reduction(before: float | None, after: float | None) -> Cell:
    if not before or after is None:
        return Cell()
    share = 100.0 * (1.0 - after / before)
    return Cell(f"{share:.1f} %".replace("-", "−"), share)


@dataclass(frozen=True)
class MarginLine:
    """Margins of one loop; dB, degrees and hertz."""

    where: str
    controller: str
    note: str
    condition: str
    cells: list[Cell]


def margin_lines(margins: list[Margin]) -> list[MarginLine]:
    """The margins, judged: at least 6 dB and 40 degrees, computed and measured."""
    order = {name: index for index, name in enumerate(INGREDIENTS)}
    ordered = sorted(margins, key=lambda m: (m.plant != "tracker", m.plant, m.axis, order.get(m.controller, 99)))
    return [
        MarginLine(
            where=f"{margin.plant}, {margin.axis}",
            controller=margin.controller,
            note=study_title(margin.study) if margin.study else "",
            condition=CONDITION_TITLES[margin.condition],
            cells=[
                _judged(margin.gain_margin_db, GAIN_MARGIN_GOAL_DB),
                _judged(margin.measured_gain_margin_db, GAIN_MARGIN_GOAL_DB),
                _judged(margin.phase_margin_deg, PHASE_MARGIN_GOAL_DEG),
                _judged(margin.measured_phase_margin_deg, PHASE_MARGIN_GOAL_DEG),
                Cell(number(margin.crossover_hz), margin.crossover_hz),
                Cell(number(margin.closed_loop_bandwidth_hz), margin.closed_loop_bandwidth_hz),
            ],
        )
        for margin in ordered
    ]


def _judged(value: float | None, least: float) -> Cell:
    return Cell() if value is None else Cell(f"{value:.1f}", value, met=value >= least)


@dataclass(frozen=True)
class Tile:
    """One number of the summary: PI alone, ours, and the paper's compensated figure, in `unit`."""

    title: str
    plant: str
    unit: str
    before: float
    after: float
    before_text: str
    after_text: str
    paper: float | None
    paper_text: str
    gain: str


def tiles(items: list[Comparison]) -> list[Tile]:
    """What compensation gains, one tile per experiment that can be said in two numbers."""
    wanted = sorted((item for item in experiments().values() if item.tile), key=lambda item: item.tile_order)
    found = []
    for experiment in wanted:
        chosen = headline(items, experiment.name)
        tile = _tile(chosen[0], experiment.tile) if chosen else None
        found += [tile] if tile else []
    return found


def _tile(item: Comparison, title: str) -> Tile | None:
    before, after = item.value(BASELINE), item.value(COMPENSATED)
    if before is None or after is None or before <= 0:
        return None
    return Tile(
        title.format(case=case_title(item.case)),
        plant_title(item.plant),
        unit_title(item.unit),
        before,
        after,
        number(before),
        number(after),
        item.paper(True),
        plain_number(item.paper(True)),
        gain(before, after),
    )


@dataclass(frozen=True)
class ShareLine:
    """What ingredients leave of PI's value on one experiment, smallest to largest over its cases."""

    experiment: str
    metric: str
    cells: list[str]


def share_lines(items: list[Comparison]) -> list[ShareLine]:
    """One line per experiment: what VOB alone, FTC alone and both leave of PI's value, in %."""
    return [
        ShareLine(
            experiment_title(experiment),
            METRIC_TITLES[experiments()[experiment].metric],
            [_share(headline(items, experiment), name) for name in SHARED],
        )
        for experiment in experiments()
        if headline(items, experiment)
    ]


def _share(chosen: list[Comparison], controller: str) -> str:
    """'11–15 %' over the cases."""
    shares = [
        100.0 * value / base
        for item in chosen
        if (base := item.value(BASELINE)) and base > 0 and (value := item.value(controller)) is not None
    ]
    return span(shares, 2) + " %" if shares else MISSING


def loss_sentence(duel: Duel, name_plant: bool = True) -> str:
    """One loss in words, numbers in the row's unit; without the plant's friction under a heading that names it."""
    item = duel.comparison
    own, other = cell_of(item.rows[duel.lugre]), cell_of(item.rows[duel.rival])
    change = duel.change_percent()
    worse = f" ({change:+.0f}\u00a0%)" if change is not None and abs(change) < LARGEST_PERCENTAGE else ""
    axis = "" if item.axis == "azimuth" else f", {item.axis}"
    return (
        (f"{FRICTION_TITLES[item.friction]} plant: " if name_plant else "")
        + f"{experiment_title(item.experiment)}, {case_title(item.case)}{axis}: {METRIC_TITLES[item.metric]} {own.text} {unit_title(item.unit)} with "
        f"{controller_title(duel.lugre)} against {other.text} {unit_title(item.unit)} with "
        f"{controller_title(duel.rival)}{worse}."
    )


def friction_parameters(results: Results) -> list[tuple[str, list[tuple[str, list[str]]]]]:
    """The plants' true friction: per plant the lines (parameter, value per axis), nested names joined."""
    tables = []
    for plant in results.plants:
        flat = {axis: _flatten(values) for axis, values in plant["friction"].items()}
        names = list(dict.fromkeys(name for values in flat.values() for name in values))
        lines = [(name, [flat[axis].get(name, MISSING) for axis in flat]) for name in names]
        tables.append((str(plant["name"]), [("parameter", list(flat)), *lines]))
    return tables


def _flatten(values: dict[str, Any], prefix: str = "") -> dict[str, str]:
    flat: dict[str, str] = {}
    for name, value in values.items():
        if isinstance(value, dict):
            flat.update(_flatten(value, f"{prefix}{name}."))
        elif isinstance(value, (int, float)) and not isinstance(value, bool):
            flat[prefix + name] = plain_number(float(value))
        else:
            flat[prefix + name] = str(value)
    return flat
