# SPDX-License-Identifier: Apache-2.0
"""The page: everything rendered into one HTML file that needs nothing else."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

import jinja2
import plotly.graph_objects as go
from plotly.offline import get_plotlyjs

from . import identified, requirements, sensitivity, tables, verdict
from .comparison import Comparison, count_goals, count_reproduced, gather
from .controllers import INGREDIENTS
from .display import (
    FRICTION_TITLES,
    case_title,
    controller_colour,
    controller_title,
    pretty_units,
    without_seeds,
)
from .experiments import experiment_title
from .hero import hero, standalone
from .load import InputError, Results
from .packing import packed
from .sections import ablation_figures, friction_figures, line_of_sight_figures, paper_figures, price_figures
from .theme import Figure

REPOSITORY = Path(__file__).resolve().parents[3]

READING_GUIDE = [
    ("LuGre friction", "(1)–(3)", "firmware/control/lugre.c", "firmware/control/tests/test_lugre.c", "fig7"),
    ("steady friction", "(5)", "firmware/control/friction_feedforward.c", "firmware/control/tests/test_friction_feedforward.c", "fig14"),
    ("axis dynamics", "(6)", "sim_host/machine/plant/tracker.hpp", "sim_host/machine/plant/tests/test_plant_machine.cpp", "fig9"),
    ("bristle parameters", "(10)–(16)", "firmware/control/lugre.h", "firmware/control/tests/test_lugre.c", "shares"),
    ("identification", "(4)–(16)", "sim_host/lib/identification/joint_fit.cpp", "tests/identification/test_identify.cpp", "confidence"),
    ("disturbance observer", "section III", "firmware/control/disturbance_observer.c", "firmware/control/tests/test_disturbance_observer.c", "fig11"),
    ("speed loop", "section III", "firmware/control/speed_loop.c", "firmware/control/tests/test_speed_loop.c", "bode"),
    ("tracking loop", "section IV.C", "firmware/control/target_tracker.c", "firmware/control/tests/test_target_tracker.c", "fig16"),
]  # fmt: skip
"""(what, equation or section of the paper, block, its test, key of the figure that shows it)."""


def write_page(results: Results, file: Path) -> None:
    """Render the report and write it to `file`."""
    file.write_text(render(results, file.parent), encoding="utf-8")


def write_picture(results: Results, file: Path) -> None:
    """Write the picture of the first screen to `file`; InputError where the results hold no such runs."""
    picture = hero(results, gather(results.rows))
    if picture is None:
        raise InputError(f"{file}: the results hold no runs of the low-speed start, which the picture shows.")
    file.parent.mkdir(parents=True, exist_ok=True)
    file.write_text(standalone(picture), encoding="utf-8")


def render(results: Results, folder: Path) -> str:
    """The page's HTML; links into the source tree are relative to `folder` and left out when it is not there."""
    loader = jinja2.PackageLoader("trackservo_report", "templates")
    environment = jinja2.Environment(
        loader=loader, autoescape=jinja2.select_autoescape(["html", "j2"]), trim_blocks=True, lstrip_blocks=True,
        undefined=jinja2.StrictUndefined,
    )  # fmt: skip
    environment.filters["packed_figure"] = packed_figure
    environment.filters["pretty"] = pretty_units
    environment.filters["without_seeds"] = without_seeds
    environment.globals.update(link=lambda path: link(path, folder), known=known)
    return environment.get_template("report.html.j2").render(_context(results))


def link(path: str, folder: Path) -> str:
    """Relative address of a source file as seen from the page; empty when there is no such file."""
    target = REPOSITORY / path
    return Path(os.path.relpath(target, folder.resolve())).as_posix() if target.exists() else ""


def known(paths: list[str]) -> list[str]:
    """The source files that exist; all of them when the report runs apart from the source tree."""
    apart = not (REPOSITORY / "firmware").is_dir()
    return [path for path in paths if apart or (REPOSITORY / path).exists()]


def packed_figure(plot: go.Figure) -> str:
    """A plot's JSON, compressed."""
    return packed(plot.to_json())


def _context(results: Results) -> dict[str, Any]:
    """Everything that the template shows."""
    items = gather(results.rows)
    met, judged = count_goals(results.rows)
    reproduced, printed = count_reproduced(results.rows)
    duels = verdict.duels(items)
    return {
        "results": results,
        "plotly": packed(get_plotlyjs()),
        "hero": hero(results, items),
        "reproduced": reproduced,
        "printed": printed,
        "unreproduced": tables.unreproduced(results.rows),
        "met": met,
        "judged": judged,
        "unmet": tables.unmet_goals(results.rows),
        "requirement_lines": requirements.requirement_lines(results.requirements),
        "requirements_met": requirements.count_met(results.requirements),
        "missing_studies": requirements.missing_studies(results.requirements),
        "elsewhere": requirements.ELSEWHERE,
        "unmet_requirements": [requirements.sentence(line) for line in requirements.requirement_lines(results.requirements) if not line.met],
        "tiles": tables.tiles(items),
        "lines": tables.result_lines(items),
        "table2": tables.table2(items),
        "controllers": _controllers(results),
        "ingredients": [(name, controller_title(name)) for name in INGREDIENTS],
        "shares": tables.share_lines(items),
        "shared": tables.SHARED,
        "frictions": _frictions(items, duels),
        "margin_lines": tables.margin_lines(results.margins),
        "identified_lines": identified.parameter_lines(results),
        "identified_gain": identified.gain_over_wrong(results),
        "sensitivity": sensitivity.sensitivity_lines(results),
        "variance": sensitivity.variance_lines(results),
        "wind": sensitivity.wind_line(results),
        "run_groups": _run_groups(results),
        "friction_parameters": dict(tables.friction_parameters(results)),
        "guide": _guide(),
        "colour": controller_colour,
        "controller_title": controller_title,
        **_figures(results, items),
    }


def _run_groups(results: Results) -> dict[str, dict[tuple[str, str, str, str], dict[int, str]]]:
    """Every CSV once: per experiment and (case, plant, friction, controller) the file of each seed."""
    groups: dict[str, dict[tuple[str, str, str, str], dict[int, str]]] = {}
    for run in results.runs:
        place = (case_title(run.case), run.plant, FRICTION_TITLES[run.friction], controller_title(run.controller))
        groups.setdefault(experiment_title(run.experiment), {}).setdefault(place, {})[run.seed] = run.csv
    return groups


def _guide() -> list[tuple[str, str, list[str], list[str], str]]:
    """The reading guide with the files that exist."""
    return [(what, where, known([block]), known([test]), key) for what, where, block, test, key in READING_GUIDE]


def _figures(results: Results, items: list[Comparison]) -> dict[str, list[Figure]]:
    return {
        "paper_figures": paper_figures(results, items),
        "ablation_figures": ablation_figures(results, items),
        "friction_figures": friction_figures(items),
        "price_figures": price_figures(results, items),
        "line_of_sight_figures": line_of_sight_figures(results),
        "identified_figures": identified.figures(results),
    }


def _controllers(results: Results) -> list[tuple[str, str, str]]:
    """(name, short title, what is on) in the order of the tables."""
    order = {name: index for index, name in enumerate(INGREDIENTS)}
    known = sorted(results.controllers, key=lambda item: order.get(item["name"], 99))
    return [(item["name"], controller_title(item["name"]), item["text"]) for item in known]


def _frictions(items: list[Comparison], duels: list[verdict.Duel]) -> list[dict[str, Any]]:
    """Per friction of the plant: the table over the controllers and the count of wins and losses."""
    found = []
    for friction in ("lugre", "maxwell_slip"):
        fought = [duel for duel in duels if duel.comparison.friction == friction]
        lines = tables.ablation_lines(items, friction)
        if lines:
            found.append(
                {
                    "name": friction,
                    "title": FRICTION_TITLES[friction],
                    "lines": lines,
                    "score": {
                        kind: sum(duel.outcome == kind for duel in fought) for kind in ("wins", "level", "loses")
                    },
                    "losses": [
                        tables.loss_sentence(duel, name_plant=False)
                        for duel in sorted(fought, key=verdict.Duel.rank)
                        if duel.outcome == "loses"
                    ],
                    "rivals": _rivals(fought),
                }
            )
    return found


def _rivals(fought: list[verdict.Duel]) -> list[tuple[str, str, dict[str, int]]]:
    """Per pair of controllers: how often the LuGre one wins, is level, loses."""
    return [
        (
            lugre,
            rival,
            {
                kind: sum(d.outcome == kind for d in fought if (d.lugre, d.rival) == (lugre, rival))
                for kind in ("wins", "level", "loses")
            },
        )
        for lugre, rival in verdict.RIVALS
        if any((d.lugre, d.rival) == (lugre, rival) for d in fought)
    ]
