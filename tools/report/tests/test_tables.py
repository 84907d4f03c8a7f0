# SPDX-License-Identifier: Apache-2.0
"""Numbers, tables, verdicts and the terminal's table."""

from __future__ import annotations

import dataclasses
import io
from pathlib import Path

import numpy as np
import pytest
from rich.console import Console

from trackservo_report import sensitivity, tables, terminal, verdict
from trackservo_report.comparison import count_goals, floor_of, gather, headline
from trackservo_report.display import case_order, gain, number, plain_number, pretty_units, with_spread, without_seeds
from trackservo_report.load import Results, Row, load_results
from trackservo_report.traces import thin


@pytest.fixture(scope="module")
def results(folder: Path) -> Results:
    return load_results(folder)


@pytest.mark.parametrize(
    ("value", "text"),
    [(0.25, "0.250"), (0.0087123, "0.00871"), (172.4, "172"), (-3.0, "−3.00"), (0.0, "0"), (None, "–"), (0.0999996, "0.100"),
     (12345.0, "12300"), (float("nan"), "–")],
)  # fmt: skip
def test_numbers_have_three_digits(value: float | None, text: str) -> None:
    assert number(value) == text


def test_texts_are_pretty() -> None:
    assert with_spread(0.0087123, 0.00041) == "0.00871 ± 0.0004"
    assert with_spread(1.0, None) == "1.00"
    assert plain_number(56.44) == "56.44"
    assert pretty_units("<= 0.010 deg/s and 12 urad") == "≤ 0.010 °/s and 12 µrad"
    assert gain(0.25, 0.01) == "25 × smaller"
    assert gain(0.25, 0.3) == "no gain"
    assert sorted(["2 deg/s", "0.1 deg/s", "1 deg/s"], key=case_order) == ["0.1 deg/s", "1 deg/s", "2 deg/s"]


def test_a_median_is_shown_with_its_range(results: Results) -> None:
    start = next(line for line in tables.result_lines(gather(results.rows)) if line.metric == "time to 90 %")
    assert start.after.text == "12.0 (11.0…13.0)"
    assert without_seeds(start.after.text) == "12.0"
    row = next(row for row in results.rows if row.metric == "time_to_90_percent" and row.controller == "pi_vob_ftc")
    assert row.whiskers() == pytest.approx((0.96, 0.96))


def test_a_choice_made_otherwise_is_judged_by_the_same_goal(results: Results) -> None:
    weave, jitter, _ = sensitivity.sensitivity_lines(results)
    assert (weave.shipped_setting, weave.varied_setting) == ("5 m", "8 m")
    assert (weave.after_shipped.value, weave.after.value, weave.after.met) == (9.4, 16.9, False)
    assert (weave.before_shipped.value, weave.before.value, weave.before.met) == (54.9, 57.0, True)
    assert jitter.before.value is None and jitter.after.met is True
    assert sensitivity.count_varied(results) == (1, 2)


def test_a_source_has_the_share_of_the_variance_that_vanishes_with_it(results: Results) -> None:
    (line,) = sensitivity.variance_lines(results)
    assert (line.source, line.where) == ("jitter of the encoder", "Steady speed, 0.1 °/s")
    assert (line.before, line.after) == ("–", "75 %")


@pytest.mark.parametrize(("without_wind", "said"), [(0.004, True), (0.08, False)])
def test_wind_is_named_only_when_it_makes_the_error(results: Results, without_wind: float, said: bool) -> None:
    weave = next(item for item in results.sensitivity if item.controller == "pi")
    wind = dataclasses.replace(
        weave, variation="wind, rms", experiment="steady_speed", metric="peak_error", value=without_wind,
        shipped=dataclasses.replace(weave.shipped, value=0.09),
    )  # fmt: skip
    assert (sensitivity.wind_line(dataclasses.replace(results, sensitivity=[wind])) is not None) == said


def test_a_loop_that_was_tuned_for_a_study_says_so(results: Results) -> None:
    notes = {line.note for line in tables.margin_lines(results.margins) if line.controller == "pi_best"}
    assert notes == {"steady speed", "tracking a UAV, improved loop"}


def test_result_table_holds_the_paper_beside_ours(results: Results) -> None:
    lines = tables.result_lines(gather(results.rows))
    sine = next(line for line in lines if line.experiment == "Sine")
    assert (sine.paper_before.value, sine.paper_after.value) == (0.25, 0.02)
    assert sine.before.value == pytest.approx(0.2513)
    assert sine.before.met is True and sine.after.met is False
    assert sine.after.goal == "≤ 0.01"
    assert [line.case for line in lines if line.metric == "peak speed error" and line.experiment == "Steady speed"] == [
        "0.1 °/s", "0.2 °/s", "0.4 °/s", "1 °/s", "2 °/s",
    ]  # fmt: skip


def test_every_goal_is_a_cell_of_the_result_table(results: Results) -> None:
    lines = tables.result_lines(gather(results.rows))
    marks = [cell.met for line in lines for cell in (line.before, line.after, line.designed) if cell.met is not None]
    met, judged = count_goals(results.rows)
    assert (marks.count(True), len(marks)) == (met, judged)
    assert len(tables.unmet_goals(results.rows)) == judged - met


def test_a_goal_of_another_controller_gets_its_own_line(results: Results) -> None:
    rows = [
        dataclasses.replace(row, goal="<= 1", met=True)
        if row.controller == "pi_best" and row.experiment == "sine"
        else row
        for row in results.rows
    ]
    lines = tables.result_lines(gather(rows))
    assert any("best PI" in line.note and line.after.met for line in lines)


def test_friction_free_run_is_the_floor(results: Results) -> None:
    items = gather(results.rows)
    assert floor_of(headline(items, "tracking")[0], items) == 7.9


def test_table2_gives_reductions(results: Results) -> None:
    unit, columns = tables.table2(gather(results.rows))
    assert unit == "°/s" and len(columns) == 5
    assert columns[0].paper_reduction.text == "81.4 %"
    assert columns[0].reduction.value == pytest.approx(89.0)


def test_margins_are_judged_by_six_decibels_and_forty_degrees(results: Results) -> None:
    weak = dataclasses.replace(
        results.margins[0], gain_margin_db=5.9, phase_margin_deg=40.0, measured_gain_margin_db=None
    )
    cells = tables.margin_lines([weak])[0].cells
    assert cells[0].met is False and cells[1].met is None and cells[2].met is True


def _row(
    controller: str, value: float | None, spread: float = 0.0, metric: str = "peak_error", unit: str = "deg/s"
) -> Row:
    return Row(
        experiment="sine", case="c", plant="tracker", friction="maxwell_slip", controller=controller, axis="azimuth",
        metric=metric, unit=unit, statistic="mean", value=value, spread=spread, low=value, high=value, seeds=5,
        paper_uncompensated=None, paper_compensated=None, goal=None, met=None,
    )  # fmt: skip


@pytest.mark.parametrize(
    ("own", "rival", "spread", "outcome"),
    [(1.2, 1.0, 0.05, "loses"), (1.2, 1.0, 0.3, "level"), (0.5, 1.0, 0.05, "wins"), (1.01, 1.0, 0.0, "level")],
)
def test_a_loss_is_larger_than_the_spread(own: float, rival: float, spread: float, outcome: str) -> None:
    fought = verdict.duels(gather([_row("pi_ftc", own, spread), _row("pi", rival, spread)]))
    assert [duel.outcome for duel in fought] == [outcome]


def test_never_reaching_ninety_percent_is_a_loss() -> None:
    rows = [
        _row("pi_ftc", None, metric="time_to_90_percent", unit="ms"),
        _row("pi", 30.0, metric="time_to_90_percent", unit="ms"),
    ]
    assert [duel.outcome for duel in verdict.duels(gather(rows))] == ["loses"]
    assert "not reached" in tables.loss_sentence(verdict.duels(gather(rows))[0])


def test_thinning_keeps_peaks_and_order() -> None:
    time = np.arange(100_000) * 1e-3
    values = np.sin(time)
    values[54_321] = 9.0
    short, thinned = thin(time, values, 2000)
    assert short.size <= 2002 and thinned.max() == 9.0
    assert np.all(np.diff(short) > 0) and short[0] == time[0] and short[-1] == time[-1]


@pytest.mark.parametrize("width", [100, 140])
def test_terminal_table_fits_and_ends_with_the_counts(results: Results, width: int) -> None:
    stream = io.StringIO()
    terminal.print_results(results, Path("report.html"), Console(file=stream, width=width))
    lines = stream.getvalue().splitlines()
    assert max(map(len, lines)) <= width
    met, judged = count_goals(results.rows)
    assert lines[-1] == f"goals met: {met} of {judged}"
    assert any("0.251 ✓" in line and "0.0101 ✗" in line for line in lines)
    assert not any("…" in line for line in lines)


def test_overshoot_far_below_friction_free_is_not_better() -> None:
    rows = [
        _row("pi_ftc", -0.1, metric="overshoot_above_friction_free", unit="points"),
        _row("pi_coulomb", -54.9, metric="overshoot_above_friction_free", unit="points"),
    ]
    items = gather(rows)
    assert [duel.outcome for duel in verdict.duels(items)] == ["wins"]
    assert [cell.best for cell in tables.ablation_lines(items, "maxwell_slip")[0].cells][2] is True


def test_several_losses_come_with_the_worst_of_the_own_metric_first() -> None:
    rows = [_row("pi_ftc", 2.0, metric="rms_error"), _row("pi", 0.1, metric="rms_error")]
    rows += [_row("pi_ftc", 2.0), _row("pi", 1.0)]
    ranked = sorted(verdict.duels(gather(rows)), key=verdict.Duel.rank)
    assert [duel.comparison.metric for duel in ranked] == ["peak_error", "rms_error"]
