# SPDX-License-Identifier: Apache-2.0
"""Tables of the results as Markdown, and their places in the project's documents.

A document says where a table goes with a pair of comments, `<!-- results -->` and `<!-- end results -->`; what stands
between them is replaced. So no number in a document is typed by hand. A table whose study was not run stays as it is.
"""

from __future__ import annotations

import re
import textwrap
from collections.abc import Callable
from pathlib import Path
from typing import Any

from .comparison import Comparison, gather, select
from .controllers import INGREDIENTS
from .display import (
    CONDITION_TITLES,
    FRICTION_TITLES,
    METRIC_TITLES,
    case_title,
    controller_title,
    number,
    over_seeds,
    unit_title,
)
from .experiments import experiment_title, experiments, study_title
from .load import InputError, Results
from .requirements import ELSEWHERE, requirement_lines
from .sensitivity import sensitivity_lines, variance_lines
from .studies import (
    base_tracking_rows,
    identification_value_rows,
    isolation_rows,
    node_tracking_rows,
    pitch_margin_rows,
    random_plants_rows,
    read_base_motion,
    read_identification_value,
    read_node_tracking,
    read_random_plants,
    stability_rows,
    worst_rows,
)
from .tables import Cell, result_lines

PAGE_WIDTH = 120
"""Columns of a page's text."""


def _table(head: list[str], rows: list[list[str]]) -> str:
    lines = ["| " + " | ".join(head) + " |", "|" + "---|" * len(head)]
    return "\n".join(lines + ["| " + " | ".join(row) + " |" for row in rows])


def _wrapped(text: str) -> str:
    return textwrap.fill(text, PAGE_WIDTH, break_long_words=False, break_on_hyphens=False)


def _judged(cell: Cell) -> str:
    mark = {True: " ✓", False: " ✗", None: ""}[cell.met]
    goal = f" (goal {cell.goal})" if cell.goal else ""
    return f"{cell.text}{mark}{goal}" + (f" ≠ paper, **{cell.mark}**" if cell.mark else "")


def results_table(results: Results) -> str:
    """The result table: the paper's figures beside ours."""
    rows = [
        [
            f"{line.experiment}, {line.case}: {line.metric}, {line.unit}",
            line.paper_before.text,
            line.paper_after.text,
            _judged(line.before),
            _judged(line.after),
            _judged(line.designed),
        ]
        for line in result_lines(gather(results.rows))
    ]
    return _table(["experiment", "paper: PI", "paper: compensated", "ours: PI", "ours: PI + VOB + FTC", "ours: least error"], rows)


def requirements_table(results: Results) -> str | None:
    """Requirements of the line of sight, then the figures of other commands; nothing where no study was run."""
    lines = requirement_lines(results.requirements)
    rows = [
        [f"{line.case}: {line.metric}" + (f", {line.unit}" if line.unit else ""), line.goal, f"{line.value} {'✓' if line.met else '✗'}", f"`{line.command}`"]
        for line in lines
    ]
    rows += [[item.figure, item.required, f"in `{item.page}`", f"`{item.command}`"] for item in ELSEWHERE]
    return _table(["figure", "required", "measured, worst seed", "measured by"], rows) if lines else None


def _ingredient_row(item: Comparison) -> list[str]:
    values = [item.rows.get(name) for name in INGREDIENTS]
    title = f"{experiment_title(item.experiment)}, {case_title(item.case)}: {METRIC_TITLES[item.metric]}"
    friction = FRICTION_TITLES[item.friction]
    return [f"{title}, {unit_title(item.unit)}", friction] + [number(row.value) if row else "–" for row in values]


def ingredients_table(results: Results) -> str:
    """Every controller, every experiment, every friction of the plant; azimuth."""
    items = select(gather(results.rows), axis="azimuth")
    wanted = [item for item in items if item.metric in (experiments()[item.experiment].metric, "overshoot")]
    head = ["experiment", "plant's friction", *map(controller_title, INGREDIENTS)]
    return _table(head, [_ingredient_row(item) for item in wanted])


def pitch_table(results: Results) -> str:
    """The other axis: what is judged on azimuth; LuGre, and for tracking the friction-free floor beside it."""
    pitch = select(gather(results.rows), axis="pitch")
    wanted = [item for item in pitch if item.metric in (experiments()[item.experiment].metric, "overshoot")]
    free = {(item.experiment, item.case): item for item in wanted if item.friction == "none"}
    rows = []
    for item in wanted:
        if item.friction != "lugre":
            continue
        title = f"{experiment_title(item.experiment)}, {case_title(item.case)}: {METRIC_TITLES[item.metric]}"
        floor = free.get((item.experiment, item.case)) if item.experiment == "tracking" else None
        shown = [(item, "pi"), (item, "pi_vob_ftc"), (floor, "pi_vob_ftc")]
        values = [source.rows.get(name) if source else None for source, name in shown]
        rows.append([f"{title}, {unit_title(item.unit)}"] + [over_seeds(row) if row else "–" for row in values])
    return _table(["experiment, pitch", "PI", "PI + VOB + FTC", "PI + VOB + FTC, friction-free"], rows)


def noise_table(results: Results) -> str:
    """Torque noise of every controller at steady speed; azimuth, LuGre."""
    items = select(gather(results.rows), axis="azimuth", metric="torque_noise", friction="lugre")
    items = [item for item in items if item.experiment in ("steady_speed", "tracking")]
    head = ["experiment", *map(controller_title, INGREDIENTS)]
    rows = []
    for item in items:
        values = [item.rows.get(name) for name in INGREDIENTS]
        title = f"{experiment_title(item.experiment)}, {case_title(item.case)}, {unit_title(item.unit)}"
        rows.append([title] + [over_seeds(row) if row else "–" for row in values])
    return _table(head, rows)


def margins_table(results: Results) -> str:
    """Margins of every controller, computed and measured; azimuth."""
    rows = [
        [
            margin.plant,
            controller_title(margin.controller) + (f", {study_title(margin.study)}" if margin.study else ""),
            CONDITION_TITLES[margin.condition],
            f"{number(margin.gain_margin_db)} / {number(margin.measured_gain_margin_db)}",
            f"{number(margin.phase_margin_deg)} / {number(margin.measured_phase_margin_deg)}",
            number(margin.crossover_hz),
            number(margin.closed_loop_bandwidth_hz),
        ]
        for margin in results.margins
        if margin.axis == "azimuth"
    ]
    head = [
        "plant", "controller", "seal", "gain margin, dB (computed / measured)",
        "phase margin, ° (computed / measured)", "crossover, Hz", "bandwidth, Hz",
    ]  # fmt: skip
    return _table(head, rows)


def sensitivity_table(results: Results) -> str:
    """What if we had chosen otherwise: shipped figure, figure with one choice changed, goal; azimuth, LuGre."""
    rows = [
        [
            f"{line.variation}: {line.shipped_setting} → **{line.varied_setting}**",
            f"{line.experiment}, {line.case}: {line.metric}, {line.unit}",
            line.before_shipped.text,
            _judged(line.before),
            line.after_shipped.text,
            _judged(line.after),
        ]
        for line in sensitivity_lines(results)
    ]
    head = ["choice: shipped → varied", "figure", "PI: shipped", "PI: varied", "PI + VOB + FTC: shipped", "PI + VOB + FTC: varied"]
    return _table(head, rows)


def variance_table(results: Results) -> str:
    """Composition of the errors at steady speed; azimuth, LuGre."""
    rows = [[line.source, line.where, line.before, line.after] for line in variance_lines(results)]
    return _table(["source that is switched off", "where", "share of PI's variance", "share of PI + VOB + FTC's variance"], rows)


def identification_value_table(results: Results) -> str | None:
    """Value of identification; nothing where it was not measured."""
    study = read_identification_value(results.folder)
    return _table(*identification_value_rows(study)) if study else None


def random_plants_table(results: Results) -> str | None:
    """Random plants: errors, stability, the worst; nothing where the study was not run."""
    tried = read_random_plants(results.folder)
    if tried is None:
        return None
    setup = tried["generator"]
    said = (
        f"{setup['plants']:,} plants like `{setup['plant']}`, with {setup['numbers']} numbers each off by up to "
        f"{100 * setup['share']:g} %. **{tried['failing']} fail**: an axis is unstable, or the azimuth error exceeds the "
        "paper's at one of the speeds."
    )
    if "above_paper" in tried:
        said += f" The pitch error does so on {tried['pitch']['above_paper']} plants, one of the axes on {tried['above_paper']}."
    if tried.get("without_result"):
        said += f" Plants without result, because their runs ended early: {len(tried['without_result'])}."
    tables = [_table(*rows(tried)) for rows in (random_plants_rows, stability_rows, worst_rows)]
    return "\n\n".join([_wrapped(said), *tables])


def node_tracking_table(results: Results) -> str | None:
    """Tracking in the running node; nothing where it was not run."""
    study = read_node_tracking(results.folder)
    return _table(*node_tracking_rows(study)) if study else None


def _base_motion_table(rows: Callable[[dict[str, Any]], tuple[list[str], list[list[str]]]]) -> Callable[[Results], str | None]:
    """A table of the turning base; nothing where it was not run."""

    def table(results: Results) -> str | None:
        study = read_base_motion(results.folder)
        return _table(*rows(study)) if study else None

    return table


TABLES: dict[str, Callable[[Results], str | None]] = {
    "results": results_table,
    "requirements": requirements_table,
    "ingredients": ingredients_table,
    "pitch": pitch_table,
    "noise": noise_table,
    "margins": margins_table,
    "sensitivity": sensitivity_table,
    "variance": variance_table,
    "beliefs": identification_value_table,
    "random_plants": random_plants_table,
    "node_tracking": node_tracking_table,
    "base_tracking": _base_motion_table(base_tracking_rows),
    "base_isolation": _base_motion_table(isolation_rows),
    "base_margins": _base_motion_table(pitch_margin_rows),
}


def update_document(results: Results, file: Path) -> None:
    """Renew every marked table of a Markdown file that can be; an unknown mark and a quick run are an `InputError`."""
    file.write_text(renewed_document(results, file), encoding="utf-8")


def differing_documents(results: Results, files: list[Path]) -> list[Path]:
    """The documents whose marked tables are not those of the results."""
    return [file for file in files if renewed_document(results, file) != file.read_text(encoding="utf-8")]


def renewed_document(results: Results, file: Path) -> str:
    """The file's text with the tables of the results."""
    if results.generator["quick"]:
        raise InputError(f"{file}: not renewed from a quick run; run ./tools/demo --all first.")
    others = {row.git for row in results.requirements} - {results.generator["git"]}
    if others:
        raise InputError(
            f"{results.folder / 'results.json'}: the rows of requirements are of git {', '.join(sorted(others))}, the "
            f"experiments of {results.generator['git']}; run ./tools/demo --all."
        )
    text = file.read_text(encoding="utf-8")
    pattern = re.compile(r"<!-- (\w+) -->\n.*?<!-- end \1 -->", re.DOTALL)

    def renewed(found: re.Match[str]) -> str:
        name = found.group(1)
        if name not in TABLES:
            raise InputError(f"{file}: there is no table '{name}'; known are {', '.join(TABLES)}.")
        table = TABLES[name](results)
        return f"<!-- {name} -->\n{table}\n<!-- end {name} -->" if table else found.group()

    return pattern.sub(renewed, text)
