"""The figures of the page in order, each headed with the paper's result and ours."""

from __future__ import annotations

from . import bars, bode, curves
from .comparison import BASELINE, COMPENSATED, Comparison, headline, paper_mark
from .display import number, plain_number, span, unit_title
from .load import Results
from .studies import read_fig9_scan
from .theme import Figure

LUGRE = ["firmware/control/lugre.c", "firmware/control/friction_feedforward.c"]
OBSERVER = ["firmware/control/disturbance_observer.c"]
LOOP = ["firmware/control/speed_loop.c", "firmware/control/pi_controller.c"]
TRACKER = ["firmware/control/target_tracker.c"]


def _first(items: list[Comparison], experiment: str) -> Comparison | None:
    chosen = headline(items, experiment)
    return chosen[0] if chosen else None


def _pair(item: Comparison | None) -> tuple[float | None, float | None]:
    return (None, None) if item is None else (item.paper(False), item.paper(True))


def _said(item: Comparison | None, controller: str) -> str:
    """A value with its unit, e.g. '0.251 °/s'."""
    if item is None or item.value(controller) is None:
        return "not measured"
    unit = unit_title(item.unit)
    return f"{number(item.value(controller))} {unit}" if unit != "%" else f"{number(item.value(controller))} %"


def paper_figures(results: Results, items: list[Comparison]) -> list[Figure]:
    """The counterparts of the paper's Figs 7, 9, 11, 12, 14 and 16 and of Table 2."""
    book = curves.RunBook(results)
    first_sine, *more_sine = _sine_figures(book, items)
    return [
        first_sine,
        _step_figure(results, book, items),
        *more_sine,
        _start_figure(book, items),
        *_steady_figures(book, items),
        _tracking_figure(book, items),
    ]


def _sine_figures(book: curves.RunBook, items: list[Comparison]) -> list[Figure]:
    sine = _first(items, "sine")
    return [
        Figure(
            "fig7",
            "Fig. 7 — a slow sine under PI alone",
            curves.sine_speed(book),
            paper="Set-point 1 °/s at 0.1 Hz. Friction disturbs the speed while it is low and around each reversal.",
            ours=f"The same sine on the paper's own simulated plant. Peak speed error {_said(sine, BASELINE)}.",
            caption="Compare the speed with the set-point at its peaks and around its zeros. With the published numbers "
            "σ0/J is only 13 s⁻², so the seal acts mostly as a spring and never slides for long.",
            hints=["sim_host/scenarios/sine.toml", *LUGRE[:1], *LOOP],
        ),
        Figure(
            "fig11",
            "Fig. 11 — the ingredients one by one",
            curves.sine_ingredients(book),
            paper="(a) PI, (b) with the disturbance observer, (c) with observer and friction compensation. "
            "The observer reduces the effect of friction at low speed; only both together remove it.",
            ours=f"Peak error {_said(sine, 'pi')} with PI, {_said(sine, 'pi_vob')} with the observer, "
            f"{_said(sine, COMPENSATED)} with both.",
            caption="Right column: the same curves around a reversal, where they differ.",
            hints=[*OBSERVER, *LUGRE],
        ),
        Figure(
            "fig12",
            "Fig. 12 — speed error on the sine",
            curves.sine_error(book, _pair(sine)),
            paper="About ±0.25 °/s without compensation, about ±0.02 °/s with observer and friction compensation.",
            ours=f"±{_said(sine, BASELINE)} without, ±{_said(sine, COMPENSATED)} with. "
            "The error is the set-point minus the plant's true rate.",
            caption="Dashed: the paper's figures. Shaded: the settling time, which does not count. "
            "Click a name in the legend to add the other controllers.",
            hints=["sim_host/scenarios/sine.toml", *LUGRE, *OBSERVER],
        ),
    ]


def _step_figure(results: Results, book: curves.RunBook, items: list[Comparison]) -> Figure:
    step = _first(items, "step_disturbed")
    ratio = next(iter(headline(items, "step_disturbed", "overshoot_over_friction_free")), None)
    scan = read_fig9_scan(results.folder)
    return Figure(
        "fig9",
        "Fig. 9 — a step with a disturbance",
        curves.step_response(book) + ([curves.fig9_scan(scan)] if scan else []),
        paper="Step to 1 °/s with a 0.02 °/s, 2 Hz disturbance: “the overshoot increases by 25 %” against the friction-free model, "
        "with repeated oscillation. That is +25 points, or × 1.25.",
        ours=f"Against the friction-free plant: {_said(step, BASELINE)} (× {_value(ratio, BASELINE)}) with PI, "
        f"{_said(step, COMPENSATED)} (× {_value(ratio, COMPENSATED)}) with observer and friction compensation.",
        caption="The dashed curve is the same loop on a plant without friction."
        + (" The second tab shows random sets of the numbers that the paper does not print." if scan else ""),
        hints=["sim_host/scenarios/step_disturbed.toml", "sim_host/studies/fig9_scan.cpp", *LUGRE, *LOOP],
        mark=paper_mark(step.rows[BASELINE]) if step and BASELINE in step.rows else "",
    )


def _value(item: Comparison | None, controller: str) -> str:
    return number(item.value(controller) if item else None)


def _start_figure(book: curves.RunBook, items: list[Comparison]) -> Figure:
    start = _first(items, "low_speed_start")
    return Figure(
        "fig14",
        "Fig. 14 — start from rest at low speed",
        curves.start_up(book),
        paper="At 0.1, 0.2 and 1 °/s: an obvious start delay without compensation, with slip at 0.1 °/s, "
        "and a quick start with it. No times are printed.",
        ours=f"At the lowest speed the axis arrives at 90 % and stays there after {_said(start, BASELINE)} with PI and after "
        f"{_said(start, COMPENSATED)} with observer and friction compensation (medians over the seeds).",
        caption="Dotted grey: 90 % of the set-point. The feedforward applies the break-away torque in the tick of the command; "
        "PI must integrate up to it first.",
        hints=["sim_host/scenarios/low_speed_start.toml", *LUGRE],
    )


def _steady_figures(book: curves.RunBook, items: list[Comparison]) -> list[Figure]:
    chosen = headline(items, "steady_speed")
    paper = {item.case: _pair(item) for item in chosen}
    return [
        Figure(
            "table2",
            "Table 2 — peak error at steady speed",
            bars.steady_speed_bars(items),
            paper="0.078 to 0.095 °/s without, 0.014 to 0.018 °/s with compensation: 81 to 82 % less at every speed.",
            ours=_steady_words(chosen),
            caption="Dashed: the paper's values, without and with compensation. Whiskers: standard deviation over the seeds.",
            hints=["sim_host/scenarios/steady_speed.toml", *OBSERVER, *LUGRE],
        ),
        Figure(
            "table2-curves",
            "Behind Table 2 — the error against time",
            curves.steady_errors(book, paper),
            paper="The paper prints no curves for this table, only the errors at steady speed.",
            ours="One run per speed; the peak after the shaded settling time, averaged over the seeds, is the value in the table.",
            caption="At steady speed friction hardly changes. Ripple, wind and noise remain, and only the observer acts on them.",
            hints=OBSERVER,
        ),
    ]


def _steady_words(chosen: list[Comparison]) -> str:
    """The range over the speeds, without and with compensation."""
    pairs = [
        (before, after)
        for item in chosen
        if (before := item.value(BASELINE)) and (after := item.value(COMPENSATED)) is not None
    ]
    if not pairs:
        return "Not measured."
    unit = unit_title(chosen[0].unit)
    reduction = span([100.0 * (1.0 - after / before) for before, after in pairs], 0)
    return (
        f"{span([before for before, _ in pairs])} {unit} with PI alone, {span([after for _, after in pairs])} {unit} "
        f"with observer and friction compensation: {reduction} % less."
    )


def _tracking_figure(book: curves.RunBook, items: list[Comparison]) -> Figure:
    chosen = headline(items, "tracking")
    first = _first(items, "tracking")
    ours = {
        (item.case, name): value
        for item in chosen
        for name in (BASELINE, COMPENSATED)
        if (value := item.value(name)) is not None
    }
    before, after = _pair(first)
    return Figure(
        "fig16",
        "Fig. 16 — line-of-sight error while tracking",
        curves.tracking_error(book, _pair(first), ours),
        paper=f"A UAV at 20 m/s, 1σ {plain_number(before)} µrad without and {plain_number(after)} µrad with compensation.",
        ours=f"1σ {_said(first, BASELINE)} with PI and {_said(first, COMPENSATED)} with observer and friction "
        "compensation, with the paper's 2 Hz tracking loop; the improved loop is the other tab.",
        caption="Both panels have the same scale. Dashed: the paper's ±1σ. The legend also has the same loop on a plant "
        "without friction; friction does not cause the error that remains there.",
        hints=["sim_host/scenarios/tracking.toml", *TRACKER, *LUGRE],
    )


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
