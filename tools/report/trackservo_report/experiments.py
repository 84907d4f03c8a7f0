# SPDX-License-Identifier: Apache-2.0
"""The experiments of the paper, as the folders in sim_host/studies describe them: one experiment.toml each.

A folder with an experiment.toml is an experiment; no list names them. `sim_host experiments` reads the same file and
checks what it uses; what only the report uses is checked here.
"""

from __future__ import annotations

import functools
import re
import tomllib
from dataclasses import dataclass, field
from pathlib import Path
from string import Formatter
from typing import Any, NoReturn

from .controllers import INGREDIENTS
from .errors import InputError
from .text import read_text

STUDIES = Path(__file__).resolve().parents[3] / "sim_host" / "studies"

RECIPES = ("speed", "ingredients", "speed_error", "step_response", "start_up", "bars", "tracking_error")
"""How a plot is drawn; sections.py has a function for each."""


@dataclass(frozen=True)
class Plot:
    """One figure of the page; `order` is its place, the number of the paper's figure."""

    experiment: str
    key: str
    order: int
    title: str
    recipe: str
    paper: str
    ours: str
    caption: str
    code: list[str]
    from_settled: bool = False


@dataclass(frozen=True)
class Experiment:
    """What the report must know of an experiment: names, plant, the metric that decides, its tile and its plots."""

    name: str
    title: str
    order: int
    plant: str
    metric: str
    tile: str = ""
    tile_order: int = 0
    plots: list[Plot] = field(default_factory=list)


@functools.cache
def experiments() -> dict[str, Experiment]:
    """All experiments by name, in their order."""
    return read_experiments(STUDIES)


def read_experiments(folder: Path) -> dict[str, Experiment]:
    """The experiments in the sub-folders of `folder`; every fault is an `InputError`."""
    found = [_read(file) for file in folder.glob("*/experiment.toml")]
    if not found:
        raise InputError(f"{folder}: holds no experiment; run the report from a checkout of trackservo.")
    return {item.name: item for item in sorted(found, key=lambda item: (item.order, item.name))}


def experiment_title(name: str) -> str:
    """The name of an experiment for readers."""
    known = experiments().get(name)
    return known.title if known else name


def study_title(study: str) -> str:
    """The short name of a study such as 'tracking on tracker, improved loop'."""
    experiment, _, place = study.partition(" on ")
    _, comma, loop = place.partition(", ")
    return experiment_title(experiment).lower().replace("uav", "UAV") + comma + loop


def order_of(name: str) -> int:
    """Place of an experiment among all."""
    return list(experiments()).index(name)


def plots() -> list[Plot]:
    """The plots of all experiments in the order of the page."""
    return sorted((plot for item in experiments().values() for plot in item.plots), key=lambda plot: plot.order)


class _Table:
    """A table of the file: gives checked values, refuses with file, line and what would be right."""

    def __init__(self, file: Path, values: dict[str, Any], line: int) -> None:
        self._file, self._values, self._line = file, values, line

    def get(self, key: str, kind: type, default: Any = None) -> Any:
        """The value of a key; without a default it must be there."""
        value = self._values.get(key, default)
        if value is None:
            self.refuse(key, f"is missing, give {_WORDS[kind]}")
        if not isinstance(value, kind) or (kind is int and isinstance(value, bool)):
            self.refuse(key, f"is not {_WORDS[kind]}")
        return value

    def refuse(self, key: str, reason: str) -> NoReturn:
        """Raise an `InputError` at the line of the key, or of its table where the key is absent."""
        lines = [line for _, line in read_text(self._file).lines()]
        own = (number for number in range(self._line, len(lines) + 1) if re.match(rf"{key}\s*=", lines[number - 1]))
        line = next(own, self._line) if key in self._values else self._line
        raise InputError(f"{self._file}:{line}: {key} {reason}.")

    def refuse_unknown(self, known: set[str]) -> None:
        """Refuse the first key that is not known."""
        for key in self._values:
            if key not in known:
                self.refuse(key, f"is unknown, give one of: {', '.join(sorted(known))}")


_WORDS = {str: "a text", int: "a whole number", list: "a list", bool: "true or false"}


def _read(file: Path) -> Experiment:
    source = read_text(file)
    try:
        data = tomllib.loads(source.text)
    except (ValueError, RecursionError) as error:
        raise InputError(f"{file}: not valid TOML: {error}.") from error
    top = _Table(file, data, 1)
    name = file.parent.name
    heads = [number for number, line in source.lines() if line.strip() == "[[plot]]"]
    tables = zip(top.get("plot", list, []), heads, strict=True)
    return Experiment(
        name=name,
        title=top.get("title", str),
        order=top.get("order", int),
        plant=top.get("plant", str),
        metric=top.get("metric", str),
        tile=top.get("tile", str, ""),
        tile_order=top.get("tile_order", int, 0),
        plots=[_plot(name, _Table(file, values, line)) for values, line in tables],
    )


def _check_fields(table: _Table, key: str) -> None:
    """Refuse a text with a field that sections.py does not fill."""
    known = ("paper", *INGREDIENTS)
    try:
        fields = [name for _, name, _, _ in Formatter().parse(table.get(key, str, "")) if name is not None]
    except ValueError as error:
        table.refuse(key, f"has a wrong brace ({error})")
    for name in fields:
        if name not in known:
            table.refuse(key, f"has the field {{{name}}}, give one of: {', '.join(known)}")


def _plot(experiment: str, table: _Table) -> Plot:
    table.refuse_unknown(set(Plot.__dataclass_fields__) - {"experiment"})
    recipe = table.get("recipe", str)
    if recipe not in RECIPES:
        table.refuse("recipe", f'"{recipe}" is unknown, give one of: {", ".join(RECIPES)}')
    for key in ("paper", "ours"):
        _check_fields(table, key)
    return Plot(
        experiment=experiment,
        key=table.get("key", str),
        order=table.get("order", int),
        title=table.get("title", str),
        recipe=recipe,
        paper=table.get("paper", str, ""),
        ours=table.get("ours", str),
        caption=table.get("caption", str, ""),
        code=table.get("code", list, []),
        from_settled=table.get("from_settled", bool, False),
    )
