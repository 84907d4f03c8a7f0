# SPDX-License-Identifier: Apache-2.0
"""The figures of the page in order: those of the experiments, as their experiment.toml describes them, and the others."""

from __future__ import annotations

from . import bars, bode, curves, isolation
from .comparison import Comparison, headline, paper_mark
from .controllers import BASELINE, COMPENSATED, INGREDIENTS
from .display import number, plain_number, span, unit_title
from .experiments import Plot, plots
from .load import Results
from .studies import read_base_motion
from .theme import Figure, View

LUGRE = ["firmware/control/lugre.c", "firmware/control/friction_feedforward.c"]
OBSERVER = ["firmware/control/disturbance_observer.c"]
LOOP = ["firmware/control/speed_loop.c", "firmware/control/pi_controller.c"]


class _Said:
    """What a controller reached in an experiment, for the texts of experiment.toml.

    {pi} is the value of the first case with its unit, {pi:METRIC} another metric's number, {pi:range} the smallest to
    the largest over the cases, {pi:unit} the unit, {pi:reduction} how much less than PI alone, in %.
    """

    def __init__(self, items: list[Comparison], experiment: str, controller: str) -> None:
        self._items, self._experiment, self._controller = items, experiment, controller

    def __format__(self, wanted: str) -> str:
        chosen = headline(self._items, self._experiment)
        if wanted in ("range", "unit", "reduction"):
            return self._over_cases(chosen, wanted)
        if wanted:
            first = next(iter(headline(self._items, self._experiment, wanted)), None)
            return number(first.value(self._controller) if first else None)
        value = chosen[0].value(self._controller) if chosen else None
        if value is None:
            return "not measured"
        unit = unit_title(chosen[0].unit)
        return f"{number(value)} {unit}"

    def _over_cases(self, chosen: list[Comparison], wanted: str) -> str:
        both = [item for item in chosen if item.value(BASELINE) and item.value(COMPENSATED) is not None]
        if not both:
            raise _NotMeasured
        if wanted == "unit":
            return unit_title(both[0].unit)
        values = [item.value(self._controller) or 0.0 for item in both]
        if wanted == "range":
            return span(values)
        baselines = [item.value(BASELINE) or 1.0 for item in both]
        return span([100.0 * (1.0 - value / base) for value, base in zip(values, baselines, strict=True)], 0)


class _Printed:
    """The paper's figure of the first case: {paper:uncompensated}, {paper:compensated}."""

    def __init__(self, item: Comparison | None) -> None:
        self._item = item

    def __format__(self, wanted: str) -> str:
        return plain_number(self._item.paper(wanted == "compensated") if self._item else None)


class _NotMeasured(Exception):
    """A text needs values that the results do not have."""


def _filled(text: str, items: list[Comparison], experiment: str) -> str:
    """A text of experiment.toml with the numbers of the results."""
    said = {name: _Said(items, experiment, name) for name in INGREDIENTS}
    first = next(iter(headline(items, experiment)), None)
    try:
        return text.format(paper=_Printed(first), **said)
    except _NotMeasured:
        return "Not measured."


def _printed(items: list[Comparison], experiment: str) -> dict[str, tuple[float | None, float | None]]:
    return {item.case: (item.paper(False), item.paper(True)) for item in headline(items, experiment)}


def _views(plot: Plot, results: Results, book: curves.RunBook, items: list[Comparison]) -> list[View]:
    """The plot as its recipe draws it."""
    name, key = plot.experiment, plot.key
    printed = _printed(items, name)
    if plot.recipe == "speed":
        return curves.speed(book, name, key)
    if plot.recipe == "ingredients":
        return curves.ingredients(book, name, key)
    if plot.recipe == "speed_error":
        return curves.speed_error(book, name, key, printed, plot.from_settled)
    if plot.recipe == "step_response":
        return curves.step_response(book, name, key)
    if plot.recipe == "start_up":
        return curves.start_up(book, name, key)
    if plot.recipe == "bars":
        return bars.case_bars(items, name)
    ours = {
        (item.case, controller): value
        for item in headline(items, name)
        for controller in (BASELINE, COMPENSATED)
        if (value := item.value(controller)) is not None
    }
    return curves.tracking_error(book, name, key, next(iter(printed.values()), (None, None)), ours)


def paper_figures(results: Results, items: list[Comparison]) -> list[Figure]:
    """The plots of all experiments: the counterparts of the paper's figures, each headed with its result and ours."""
    book = curves.RunBook(results)
    return [_figure(plot, results, book, items) for plot in plots()]


def _figure(plot: Plot, results: Results, book: curves.RunBook, items: list[Comparison]) -> Figure:
    views = _views(plot, results, book, items)
    return Figure(
        plot.key,
        plot.title,
        views,
        paper=_filled(plot.paper, items, plot.experiment),
        ours=_filled(plot.ours, items, plot.experiment),
        caption=plot.caption,
        hints=[f"sim_host/studies/{plot.experiment}/{file}" for file in ("experiment.toml", "scenario.toml")] + plot.code,
        mark=_mark(plot, items),
    )


def _mark(plot: Plot, items: list[Comparison]) -> str:
    """Whether PI alone does not reproduce the paper's figure; stands beside the figure of the experiment itself."""
    first = next(iter(headline(items, plot.experiment)), None)
    return paper_mark(first.rows[BASELINE]) if first and BASELINE in first.rows else ""


def ablation_figures(results: Results, items: list[Comparison]) -> list[Figure]:
    """What each ingredient gains, and which block compensates friction."""
    return [
        Figure(
            "ablation",
            "Each experiment, ingredient by ingredient",
            bars.ablation_bars(items),
            caption="Grey is the tuned baseline. Blue adds the observer, amber the feedforward, green both. Purple is the "
            "Coulomb feedforward that drives usually have, rose the best PI within the same margins. "
            "Dashed: the paper. Dotted: the plant without friction.",
            hints=[*LUGRE, *OBSERVER],
        ),
        Figure(
            "shares",
            "What compensates friction at start-up",
            curves.friction_shares(curves.RunBook(results)),
            caption="Left: the observer compensates friction and load, which it sees only through the speed error. Right: the "
            "feedforward compensates the friction from the command on. The observer then compensates the load "
            "and the error of the identified parameters.",
            hints=[*LUGRE, *OBSERVER],
        ),
    ]


def friction_figures(items: list[Comparison]) -> list[Figure]:
    """Compensation on its own friction model and on another one."""
    return [
        Figure(
            "frictions",
            "Remaining error on both friction models",
            bars.friction_bars(items),
            caption="Full bars: the seal behaves as LuGre. Hatched: generalised Maxwell-slip with load and temperature drift, "
            "which the feedforward does not model. 100 % is PI alone on the same friction; "
            "a bar above the line is worse than no compensation.",
            hints=LUGRE[:1],
        )
    ]


def line_of_sight_figures(results: Results) -> list[Figure]:
    """Isolation from a turning base; nothing where it was not measured."""
    study = read_base_motion(results.folder)
    if study is None:
        return []
    return [
        Figure(
            "isolation",
            "Isolation from a base that turns",
            isolation.isolation_views(study),
            caption="Angle of the base over that of the axis, both as rms without drift, at set-point 0 and without wind. "
            "0 dB: the axis turns with the base. With the gyro only friction moves the axis; small amplitudes are "
            "limited by the gyro's noise. The encoder alone holds the joint, not the line of sight. "
            "Triangle: required of the gyro.",
            hints=["firmware/control/rate_fusion.c", *LOOP, "sim_host/studies/base_motion/base_motion.cpp"],
        )
    ]


def price_figures(results: Results, items: list[Comparison]) -> list[Figure]:
    """Stability margins and torque noise."""
    return [
        Figure(
            "bode",
            "Bode plot of the open speed loop",
            bode.bode_views(results),
            caption="Lines: computed with the tick's delay. Circles: measured on the running loop. The feedforward lies "
            "outside the loop and has no effect here; the observer has. At rest (pre-sliding) the sign function of the "
            "Coulomb feedforward reacts to noise, so its circles scatter. Click a best PI in the legend to show it.",
            hints=[*LOOP, *OBSERVER],
        ),
        Figure(
            "nyquist",
            "Nyquist plot around the critical point",
            bode.nyquist_views(results),
            caption="A loop that stays outside the red line has at least 6 dB and 40° of margin. The cross marks −1.",
            hints=[*LOOP, *OBSERVER],
        ),
        Figure(
            "noise",
            "Torque noise",
            bars.torque_noise_bars(items),
            caption="Sensor noise that the loop turns into motor torque: the cost of rejecting disturbances.",
            hints=OBSERVER,
        ),
    ]
