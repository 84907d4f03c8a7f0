# SPDX-License-Identifier: Apache-2.0
"""Reading and checking of the results folder; every fault becomes an `InputError` of one sentence."""

from __future__ import annotations

import json
from dataclasses import dataclass, fields
from importlib import resources
from pathlib import Path
from typing import Any, TypeVar

import jsonschema

from .errors import InputError
from .experiments import experiments
from .text import json_of, read_text


@dataclass(frozen=True, kw_only=True)
class Figure:
    """A number over the seeds, in its row's unit: mean or median, standard deviation, smallest and largest."""

    statistic: str
    value: float | None
    spread: float | None
    low: float | None
    high: float | None
    seeds: int

    def whiskers(self) -> tuple[float, float]:
        """How far the seeds reach below and above: the standard deviation of a mean, the range of a median."""
        if self.statistic == "median" and None not in (self.value, self.low, self.high):
            return self.value - self.low, self.high - self.value
        return self.spread or 0.0, self.spread or 0.0


@dataclass(frozen=True, kw_only=True)
class Row(Figure):
    """One result; its numbers and the paper's are in `unit`."""

    experiment: str
    case: str
    plant: str
    friction: str
    controller: str
    axis: str
    metric: str
    unit: str
    paper_uncompensated: float | None
    paper_compensated: float | None
    goal: str | None
    met: bool | None
    reproduced: bool | None = None


@dataclass(frozen=True)
class Requirement:
    """A requirement beside what `command` measured, in `unit`; `value` is that of the worst seed. Without axis: of both together."""

    command: str
    git: str
    plant: str
    case: str
    axis: str | None
    metric: str
    unit: str
    statistic: str
    value: float | None
    low: float | None
    high: float | None
    seeds: int
    goal: str
    met: bool


@dataclass(frozen=True, kw_only=True)
class Varied(Figure):
    """One result with one choice changed, beside the shipped one; both in `unit`."""

    variation: str
    kind: str
    shipped_setting: str
    varied_setting: str
    experiment: str
    case: str
    plant: str
    controller: str
    axis: str
    metric: str
    unit: str
    shipped: Figure
    goal: str | None
    met: bool | None


@dataclass(frozen=True)
class Run:
    """One recorded run; `csv` is relative to the folder, `settling_s` is in seconds."""

    experiment: str
    case: str
    plant: str
    friction: str
    controller: str
    axis: str
    seed: int
    csv: str
    figure: str | None
    settling_s: float


@dataclass(frozen=True)
class Margin:
    """Stability margins of one loop: dB, degrees and hertz as the names say."""

    plant: str
    controller: str
    study: str | None
    axis: str
    condition: str
    gain_margin_db: float | None
    phase_margin_deg: float | None
    crossover_hz: float | None
    closed_loop_bandwidth_hz: float | None
    measured_gain_margin_db: float | None
    measured_phase_margin_deg: float | None
    response_csv: str


@dataclass(frozen=True)
class IdentifiedParameter:
    """A parameter of an axis in `unit`: the plant's, the identified one with its 95 % interval, the paper's method's."""

    name: str
    unit: str
    true: float
    identified: float
    low: float
    high: float
    paper_method: float | None


@dataclass(frozen=True)
class IdentifiedAxis:
    """What identification found of an axis; `folder` holds result.json and residuals.csv, relative to the results."""

    plant: str
    axis: str
    seed: int
    first_look_s: float
    recorded_s: float
    parameters: list[IdentifiedParameter]
    breakaway: dict[str, dict[str, float]]
    folder: str


@dataclass(frozen=True)
class Results:
    """The whole folder, checked; `generator`, `plants`, `controllers` as in results.schema.json."""

    folder: Path
    generator: dict[str, Any]
    plants: list[dict[str, Any]]
    controllers: list[dict[str, Any]]
    identified: list[IdentifiedAxis]
    rows: list[Row]
    sensitivity: list[Varied]
    runs: list[Run]
    margins: list[Margin]
    benchmark: dict[str, Any] | None
    requirements: list[Requirement]


Record = TypeVar("Record", Figure, Row, Run, Margin, IdentifiedParameter, Requirement)


def load_results(folder: Path) -> Results:
    """Read `folder`/results.json, check it against the schema and check that every CSV it names is there."""
    file = folder / "results.json"
    data = read_json(file)
    _check_schema(file, data)
    results = Results(
        folder=folder,
        generator=data["generator"],
        plants=data["plants"],
        controllers=data["controllers"],
        identified=[_identified(item) for item in data["identified"]],
        rows=_records(Row, data["rows"]),
        sensitivity=[_varied(item) for item in data["sensitivity"]],
        runs=_records(Run, data["runs"]),
        margins=_records(Margin, data["margins"]),
        benchmark=data["benchmark"],
        requirements=_records(Requirement, data.get("requirements", [])),
    )
    _check_names(file, results)
    _check_files(results)
    return results


def _records(kind: type[Record], items: list[dict[str, Any]]) -> list[Record]:
    names = [field.name for field in fields(kind)]
    return [kind(**{name: item[name] for name in names if name in item}) for item in items]


def _varied(item: dict[str, Any]) -> Varied:
    shipped = _records(Figure, [item["shipped"]])[0]
    names = [field.name for field in fields(Varied) if field.name != "shipped"]
    return Varied(shipped=shipped, **{name: item[name] for name in names})


def _identified(item: dict[str, Any]) -> IdentifiedAxis:
    names = [field.name for field in fields(IdentifiedAxis) if field.name != "parameters"]
    parameters = _records(IdentifiedParameter, item["parameters"])
    return IdentifiedAxis(parameters=parameters, **{name: item[name] for name in names})


def read_json(file: Path) -> Any:
    """The JSON in a results folder's file; every fault is an `InputError`."""
    if not file.parent.is_dir():
        raise InputError(f"{file.parent}: no such folder; run 'sim_host experiments --out {file.parent}' first.")
    if not file.is_file():
        raise InputError(f"{file}: not found; run 'sim_host experiments --out {file.parent}' first.")
    return json_of(read_text(file))


def schema() -> dict[str, Any]:
    """The format of results.json, as JSON Schema."""
    text = resources.files(__package__).joinpath("results.schema.json").read_text(encoding="utf-8")
    loaded: dict[str, Any] = json.loads(text)
    return loaded


def _check_schema(file: Path, data: Any) -> None:
    validator = jsonschema.Draft202012Validator(schema())
    error = jsonschema.exceptions.best_match(validator.iter_errors(data))
    if error is not None:
        place = "".join(f"[{part}]" if isinstance(part, int) else f".{part}" for part in error.absolute_path)
        message = error.message if len(error.message) < 200 else error.message[:200] + " ..."
        raise InputError(f"{file}: {place.lstrip('.') or 'the document'}: {message}.")


def _check_names(file: Path, results: Results) -> None:
    """Every plant and controller that is used must be described, and every experiment have its folder."""
    plants = {plant["name"] for plant in results.plants}
    controllers = {controller["name"] for controller in results.controllers}
    groups: dict[str, list[Any]] = {
        "rows": results.rows,
        "sensitivity": results.sensitivity,
        "runs": results.runs,
        "margins": results.margins,
    }
    for group, items in groups.items():
        for index, item in enumerate(items):
            experiment = getattr(item, "experiment", None)
            if experiment is not None and experiment not in experiments():
                raise InputError(
                    f"{file}: {group}[{index}].experiment: '{experiment}' has no folder in sim_host/studies; "
                    f"known are {', '.join(experiments())}."
                )
            if item.plant not in plants:
                raise InputError(f"{file}: {group}[{index}].plant: '{item.plant}' is not listed under plants.")
            if item.controller not in controllers:
                raise InputError(
                    f"{file}: {group}[{index}].controller: '{item.controller}' is not listed under controllers."
                )


def _check_files(results: Results) -> None:
    """Every CSV that results.json names must exist."""
    identified = [f"{axis.folder}/{file}" for axis in results.identified for file in ("result.json", "residuals.csv")]
    for name in [run.csv for run in results.runs] + [margin.response_csv for margin in results.margins] + identified:
        if not (results.folder / name).is_file():
            raise InputError(f"{results.folder / name}: named in results.json but not found.")
