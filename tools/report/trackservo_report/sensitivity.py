# SPDX-License-Identifier: Apache-2.0
"""What if we had chosen otherwise: figures with one choice changed or one source of error off, as plain data."""

from __future__ import annotations

from dataclasses import dataclass

from .controllers import BASELINE, COMPENSATED
from .display import FRICTION_TITLES, METRIC_TITLES, MISSING, case_title, over_seeds, unit_title
from .experiments import experiment_title
from .load import Results, Varied
from .tables import Cell, cell_of


@dataclass(frozen=True)
class SensitivityLine:
    """One figure with one choice changed: shipped and varied, with PI alone and with compensation."""

    variation: str
    kind: str
    shipped_setting: str
    varied_setting: str
    experiment: str
    case: str
    metric: str
    unit: str
    before_shipped: Cell
    before: Cell
    after_shipped: Cell
    after: Cell


def sensitivity_lines(results: Results) -> list[SensitivityLine]:
    """What if we had chosen otherwise: a line per variation and figure, both controllers side by side."""
    found: dict[tuple[str, ...], dict[str, Varied]] = {}
    for item in results.sensitivity:
        key = (
            item.variation, item.kind, item.shipped_setting, item.varied_setting, item.experiment, item.case, item.metric, item.unit,
        )  # fmt: skip
        found.setdefault(key, {})[item.controller] = item
    return [
        SensitivityLine(
            variation=variation,
            kind=kind,
            shipped_setting=FRICTION_TITLES.get(shipped, shipped),
            varied_setting=FRICTION_TITLES.get(varied, varied),
            experiment=experiment_title(experiment),
            case=case_title(case),
            metric=METRIC_TITLES[metric],
            unit=unit_title(unit),
            **_shipped_and_varied(pair, BASELINE, "before"),
            **_shipped_and_varied(pair, COMPENSATED, "after"),
        )
        for (variation, kind, shipped, varied, experiment, case, metric, unit), pair in found.items()
    ]


def wind_line(results: Results) -> SensitivityLine | None:
    """Steady speed without wind, when PI alone then keeps less than half of its error."""
    for line in sensitivity_lines(results):
        steady = line.variation.startswith("wind,") and line.experiment == experiment_title("steady_speed")
        before, shipped = line.before.value, line.before_shipped.value
        if steady and line.metric == METRIC_TITLES["peak_error"] and before and shipped and before < 0.5 * shipped:
            return line
    return None


@dataclass(frozen=True)
class VarianceLine:
    """What part of an error's variance vanishes when one source is switched off, in %."""

    source: str
    where: str
    before: str
    after: str


def variance_lines(results: Results) -> list[VarianceLine]:
    """What the rms errors consist of: one line per source and case. A negative share: the error grows without it."""
    return [
        VarianceLine(
            line.variation.split(",")[0],
            f"{line.experiment}, {line.case}",
            _variance_share(line.before_shipped, line.before),
            _variance_share(line.after_shipped, line.after),
        )
        for line in sensitivity_lines(results)
        if line.kind == "source" and line.metric == METRIC_TITLES["rms_error"]
    ]


def _variance_share(shipped: Cell, varied: Cell) -> str:
    if not shipped.value or varied.value is None:
        return MISSING
    return f"{100.0 * (1.0 - (varied.value / shipped.value) ** 2):.0f} %".replace("-", "−").replace("−0 %", "0 %")


def count_varied(results: Results) -> tuple[int, int]:
    """Goals that compensation misses with one choice changed, and how many are judged."""
    judged = [line.after.met for line in sensitivity_lines(results) if line.after.met is not None]
    return judged.count(False), len(judged)


def _shipped_and_varied(pair: dict[str, Varied], controller: str, name: str) -> dict[str, Cell]:
    item = pair.get(controller)
    shipped = Cell() if item is None else Cell(over_seeds(item.shipped), item.shipped.value)
    return {f"{name}_shipped": shipped, name: cell_of(item)}
