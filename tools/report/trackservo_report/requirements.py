# SPDX-License-Identifier: Apache-2.0
"""Requirements of the line of sight: what the studies measured beside what was required, and what other commands measure."""

from __future__ import annotations

from dataclasses import dataclass

from .display import MISSING, number, pretty_units, unit_title
from .load import Requirement

METRIC_TITLES = {
    "sigma": "1σ",
    "sigma_over_right_age": "1σ ÷ 1σ with the right age",
    "time_lost": "time without the target",
    "torque_step": "largest change of the torque in a tick",
    "frames_dropped": "dropped frames",
    "isolation": "isolation, of the rms angle",
    "gain_margin": "gain margin",
    "phase_margin": "phase margin",
}
"""Names for readers; another metric is shown by its own name."""

COUNTED = "frames_dropped"
"""Required of every run: it has a line only where it is missed."""

STUDIES = ("sim_host node-tracking", "sim_host base-motion")
"""The commands that ./tools/demo --all runs for these rows."""


@dataclass(frozen=True)
class Elsewhere:
    """A figure that another command measures, and the page that has it; no number of it stands in the report."""

    figure: str
    required: str
    command: str
    page: str


ELSEWHERE = (
    Elsewhere(
        "fly-by and pass on the emulated board, flashed image", "within the bound of test_board_motion",
        "TESTS_SIZE=large ctest --preset host -R test_board_tracking -V", "docs/results/node-tracking.md",
    ),
    Elsewhere(
        "fly-by through rendered pictures and the imager", "1σ ≤ 10 µrad, never lost",
        "cd tools/imager; IMAGER_TEST_SPEED=1 IMAGER_TEST_SECONDS=60 IMAGER_TEST_SEEDS='1 2 3 4 5' ../../build/venv/bin/python -m pytest -s tests/test_through_pixels.py", "docs/imager.md",
    ),
    Elsewhere(
        "set-points in force after sampling; load of tick and deferred task", "≤ 100 µs; ≤ 30 %",
        "ctest --preset host -R '^test_board$' -V", "docs/board.md",
    ),
)  # fmt: skip


@dataclass(frozen=True)
class RequirementLine:
    """One figure, both axes where it has them: texts, marks, and the command that measured it."""

    case: str
    metric: str
    unit: str
    goal: str
    value: str
    met: bool
    seeds: int
    command: str


def count_met(rows: list[Requirement]) -> tuple[int, int]:
    """Requirements met, and all."""
    return sum(row.met for row in rows), len(rows)


def missing_studies(rows: list[Requirement]) -> list[str]:
    """Commands of the demo that have no row here."""
    present = {row.command for row in rows}
    return [command for command in STUDIES if command not in present]


def requirement_lines(rows: list[Requirement]) -> list[RequirementLine]:
    """The rows as they are read: azimuth and pitch of a figure in one line."""
    groups: dict[tuple[str, str, str, str], list[Requirement]] = {}
    for row in rows:
        if row.metric != COUNTED or not row.met:
            groups.setdefault((row.command, row.case, row.metric, row.unit), []).append(row)
    return [_line(group) for group in groups.values()]


def _line(group: list[Requirement]) -> RequirementLine:
    first = group[0]
    goals = [pretty_units(row.goal) for row in group]
    return RequirementLine(
        case=pretty_units(first.case).replace(" deg", "°"),
        metric=METRIC_TITLES.get(first.metric, first.metric.replace("_", " ")),
        unit="" if first.unit in ("1", "ratio") else unit_title(first.unit),
        goal=goals[0] if len(set(goals)) == 1 else " and ".join(goals),
        value=" and ".join(_worst(row) for row in group),
        met=all(row.met for row in group),
        seeds=first.seeds,
        command=first.command,
    )


def _worst(row: Requirement) -> str:
    if row.value is None:
        return "never again" if row.metric == "time_lost" else MISSING
    return number(row.value)


def sentence(line: RequirementLine) -> str:
    """'pass at 88°: time without the target 4.61 s, required ≤ 1.15'."""
    return f"{line.case}: {line.metric} {line.value}{' ' + line.unit if line.unit else ''}, required {line.goal}"
