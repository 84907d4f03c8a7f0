# SPDX-License-Identifier: Apache-2.0
"""The result table in the terminal; readable at 100 columns and when piped."""

from __future__ import annotations

import sys
from pathlib import Path

from rich import box
from rich.console import Console
from rich.padding import Padding
from rich.table import Table
from rich.text import Text

from .comparison import count_goals, gather
from .display import without_seeds
from .load import Results
from .requirements import ELSEWHERE, RequirementLine, count_met, missing_studies, requirement_lines
from .sensitivity import count_varied
from .tables import Cell, ResultLine, loss_sentence, result_lines, unmet_goals, unreproduced
from .verdict import Duel, duels

PIPED_WIDTH = 100
QUICK_WORDS = "quick run: one seed, short search for the best PI, no sensitivity; a first look, not results"


def make_console() -> Console:
    """Standard output: as wide as the terminal, `PIPED_WIDTH` columns and without colour when piped."""
    if hasattr(sys.stdout, "reconfigure"):
        sys.stdout.reconfigure(errors="replace")
    return Console(highlight=False) if sys.stdout.isatty() else Console(highlight=False, width=PIPED_WIDTH)


def print_results(results: Results, page: Path, console: Console) -> None:
    """The table, the goals that are not met, where LuGre loses, and the counts."""
    items = gather(results.rows)
    console.print(_table(result_lines(items)))
    _print_requirements(results, console)
    if results.generator["quick"]:
        console.print(QUICK_WORDS, style="yellow")
    for sentence in unmet_goals(results.rows):
        console.print(Text("✗ not met: " + sentence, style="red"))
    for sentence in unreproduced(results.rows):
        console.print(Text("≠ paper: " + sentence, style="yellow"))
    fought = duels(items)
    losses = [duel for duel in fought if duel.outcome == "loses"]
    if fought:
        console.print(
            f"LuGre compensation loses {len(losses)} of {len(fought)} comparisons with other controllers (see the report)."
        )
    on_other_model = [duel for duel in losses if duel.comparison.friction == "maxwell_slip"]
    for duel in sorted(on_other_model, key=Duel.rank)[:3]:
        console.print(Padding(loss_sentence(duel), (0, 0, 0, 2)))
    missed, varied = count_varied(results)
    if varied:
        console.print(
            f"With one choice changed or one source off, compensation misses {missed} of {varied} goals "
            "(“What if we had chosen otherwise” in the report)."
        )
    console.print(f"report: {page}", soft_wrap=True)
    kept, required = count_met(results.requirements)
    if required:
        console.print(f"requirements of the line of sight met: {kept} of {required}", style="bold green" if kept == required else "bold yellow")
    met, judged = count_goals(results.rows)
    console.print(f"goals met: {met} of {judged}", style="bold green" if met == judged else "bold yellow")


def _print_requirements(results: Results, console: Console) -> None:
    """The line of sight: what the studies measured, what they did not, and what other commands measure."""
    lines = requirement_lines(results.requirements)
    if lines:
        console.print(_requirements_table(lines))
    for command in missing_studies(results.requirements):
        console.print(Text(f"not measured: {command} --out {results.folder}", style="yellow"), soft_wrap=True)
    for item in ELSEWHERE:
        console.print(Text(f"not measured here: {item.figure} ({item.required}); run {item.command}", style="dim"))


def _requirements_table(lines: list[RequirementLine]) -> Table:
    table = Table(box=box.SIMPLE_HEAD, pad_edge=False, padding=(0, 1), collapse_padding=True, title_justify="left")
    table.add_column("line of sight", min_width=28)
    table.add_column("figure")
    table.add_column("unit", no_wrap=True)
    table.add_column("required", no_wrap=True)
    table.add_column("worst seed", justify="right", no_wrap=True)
    previous = ""
    for line in lines:
        case = line.case if line.case != previous else ""
        previous = line.case
        mark, style = ("✓", "green") if line.met else ("✗", "red")
        table.add_row(Text(case), Text(line.metric), line.unit, line.goal, Text(f"{line.value} {mark}", style=style))
    return table


def _table(lines: list[ResultLine]) -> Table:
    table = Table(box=box.SIMPLE_HEAD, pad_edge=False, padding=(0, 1), collapse_padding=True, title_justify="left")
    table.add_column("experiment", min_width=28)
    table.add_column("unit", no_wrap=True)
    for heading in ("paper\nPI", "paper\ncomp."):
        table.add_column(heading, justify="right", no_wrap=True, style="dim")
    for heading in ("ours\nPI", "ours\nPI+VOB+FTC", "ours, least\nerror"):
        table.add_column(heading, justify="right", no_wrap=True)
    table.add_column("goals")
    previous = ""
    for line in lines:
        if line.experiment != previous:
            table.add_row(Text(line.experiment, style="bold"))
            previous = line.experiment
        table.add_row(
            _label(line), line.unit, line.paper_before.text, line.paper_after.text, _marked(line.before),
            _marked(line.after), _marked(line.designed), _goals(line),
        )  # fmt: skip
    return table


def _label(line: ResultLine) -> Padding:
    note = f" ({line.note})" if line.note else ""
    return Padding(Text(f"{line.case}: {line.metric}{note}"), (0, 0, 0, 2))


def _marked(cell: Cell) -> Text:
    """The mean or median (the spread is on the page) and the mark of its goal."""
    mark, style = {True: ("✓", "green"), False: ("✗", "red"), None: (" ", "")}[cell.met]
    if cell.mark:
        mark, style = "≠", "yellow"
    return Text(f"{without_seeds(cell.text)} {mark}", style=style)


def _goals(line: ResultLine) -> str:
    goals = "; ".join(goal for goal in (line.before.goal, line.after.goal, line.designed.goal) if goal)
    return f"{goals}\n({line.floor})" if line.floor else goals
