# SPDX-License-Identifier: Apache-2.0
"""The experiments' folders: their order and plots, the texts with numbers, and the refusals."""

from __future__ import annotations

import shutil
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from trackservo_report import sections
from trackservo_report.__main__ import main
from trackservo_report.comparison import gather
from trackservo_report.errors import InputError
from trackservo_report.experiments import RECIPES, STUDIES, experiments, plots, read_experiments
from trackservo_report.load import load_results
from trackservo_report.page import render
from trackservo_report.sections import paper_figures


def test_experiments_and_plots_come_in_the_order_of_the_papers_figures() -> None:
    of_the_paper = ["sine", "step_disturbed", "low_speed_start", "steady_speed", "tracking"]
    assert [name for name in experiments() if name in of_the_paper] == of_the_paper
    keys = [plot.key for plot in plots() if plot.experiment in of_the_paper]
    assert keys == ["fig7", "fig9", "fig11", "fig12", "fig14", "table2", "table2-curves", "fig16"]
    assert [plot.order for plot in plots()] == sorted(plot.order for plot in plots())
    assert {plot.recipe for plot in plots()} == set(RECIPES)


def test_texts_have_the_numbers_of_the_results(folder: Path) -> None:
    results = load_results(folder)
    figures = {figure.key: figure for figure in paper_figures(results, gather(results.rows))}
    assert "0.251 °/s with PI" in figures["fig11"].ours
    assert "56.44 µrad without and 14.86 µrad with" in figures["fig16"].paper
    assert "% less." in figures["table2"].ours
    assert not any("{" in figure.ours + figure.paper for figure in figures.values())


def test_a_text_over_cases_that_were_not_run_says_so(changed: Callable[[Any], Path]) -> None:
    place = changed(lambda data: data.update(rows=[row for row in data["rows"] if row["experiment"] != "steady_speed"]))
    results = load_results(place)
    figures = {figure.key: figure for figure in paper_figures(results, gather(results.rows))}
    assert figures["table2"].ours == "Not measured."


def test_a_plot_without_the_papers_figure_shows_ours_alone(
    changed: Callable[[Any], Path], monkeypatch: pytest.MonkeyPatch
) -> None:
    def forget_the_paper(data: dict[str, Any]) -> None:
        for row in data["rows"]:
            row.update(paper_uncompensated=None, paper_compensated=None, reproduced=None)

    results = load_results(changed(forget_the_paper))
    plot = replace(next(plot for plot in plots() if plot.key == "fig12"), paper="")
    monkeypatch.setattr(sections, "plots", lambda: [plot])
    (figure,) = paper_figures(results, gather(results.rows))
    assert "paper" not in {trace.name for trace in figure.views[0].plot.data}
    html = render(results, results.folder)
    section = html[html.index('<section class="figure" id="fig12">') :].split("</section>")[0]
    assert "<span>Ours</span><p>±" in section and "<span>Paper</span>" not in section


def test_a_new_folder_is_a_new_experiment_with_its_plots(tmp_path: Path) -> None:
    shutil.copytree(STUDIES / "sine", tmp_path / "sine")
    shutil.copytree(STUDIES / "sine", tmp_path / "slow_sine")
    file = tmp_path / "slow_sine" / "experiment.toml"
    file.write_text(file.read_text(encoding="utf-8").replace('"Sine"', '"Slow sine"').replace("order = 7\nplant", "order = 6\nplant"), encoding="utf-8")
    found = read_experiments(tmp_path)
    assert [item.title for item in found.values()] == ["Slow sine", "Sine"]
    assert {plot.experiment for plot in found["slow_sine"].plots} == {"slow_sine"}


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ('title = "Sine"', "title = 3", ["experiment.toml:2: title is not a text"]),
        ('title = "Sine"\n', "", ["experiment.toml:1: title is missing, give a text"]),
        ('recipe = "speed"', 'recipe = "spiral"', ['recipe "spiral" is unknown', "give one of: speed, ingredients"]),
        ('recipe = "speed"', 'recipe = "speed"\ncolour = "red"', ["colour is unknown, give one of: caption, code"]),
        ('ours = "The same', 'hers = "The same', ["hers is unknown"]),
        ("order = 11", 'order = "last"', ["order is not a whole number"]),
        ('title = "Sine"', 'title = "Sine', ["not valid TOML", "line 2"]),
        ("{pi_vob} with", "{pid} with", ["ours", "{pid}", "pi_vob_ftc"]),
    ],
)
def test_a_wrong_experiment_is_refused_with_line_and_remedy(tmp_path: Path, old: str, new: str, words: list[str]) -> None:
    shutil.copytree(STUDIES / "sine", tmp_path / "sine")
    file = tmp_path / "sine" / "experiment.toml"
    text = file.read_text(encoding="utf-8")
    assert old in text
    file.write_text(text.replace(old, new, 1), encoding="utf-8")
    with pytest.raises(InputError) as refused:
        read_experiments(tmp_path)
    said = str(refused.value)
    assert "\n" not in said
    for word in ["experiment.toml", *words]:
        assert word in said


def test_a_line_is_that_of_the_plot(tmp_path: Path) -> None:
    shutil.copytree(STUDIES / "sine", tmp_path / "sine")
    file = tmp_path / "sine" / "experiment.toml"
    lines = file.read_text(encoding="utf-8").splitlines()
    line = lines.index("order = 11")
    lines[line] = "order = 1.5"
    file.write_text("\n".join(lines), encoding="utf-8")
    with pytest.raises(InputError, match=rf"experiment\.toml:{line + 1}: order is not a whole number"):
        read_experiments(tmp_path)


@pytest.mark.parametrize("code", ["utf-8-sig", "utf-16"])
@pytest.mark.parametrize("end", ["\r\n", "\r"])
def test_an_experiment_is_read_as_editors_write_it(tmp_path: Path, code: str, end: str) -> None:
    shutil.copytree(STUDIES / "sine", tmp_path / "sine")
    file = tmp_path / "sine" / "experiment.toml"
    plain = read_experiments(tmp_path)
    text = file.read_text(encoding="utf-8")
    file.write_bytes(text.replace("\n", end).encode(code))
    assert read_experiments(tmp_path) == plain
    file.write_bytes(text.replace("order = 11", "order = 1.5", 1).replace("\n", end).encode(code))
    line = text[: text.index("order = 11")].count("\n") + 1
    with pytest.raises(InputError, match=rf"experiment\.toml:{line}: order is not a whole number"):
        read_experiments(tmp_path)


def test_a_folder_without_experiments_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="holds no experiment"):
        read_experiments(tmp_path)


def test_a_result_of_an_unknown_experiment_is_refused(
    changed: Callable[[Any], Path], capsys: pytest.CaptureFixture[str]
) -> None:
    place = changed(lambda data: data["rows"][2].update(experiment="wiggle"))
    capsys.readouterr()
    assert main([str(place)]) == 2
    said = capsys.readouterr().err
    assert "rows[2].experiment: 'wiggle' has no folder in sim_host/studies" in said
