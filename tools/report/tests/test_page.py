# SPDX-License-Identifier: Apache-2.0
"""The page: self-contained, complete, and its numbers are those of the rows."""

from __future__ import annotations

import json
import re
from html.parser import HTMLParser
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import pytest

from trackservo_report.__main__ import main
from trackservo_report.comparison import gather
from trackservo_report.display import CONTROLLER_COLOURS
from trackservo_report.hero import HEIGHT, WIDTH
from trackservo_report.load import load_results
from trackservo_report.packing import unpacked
from trackservo_report.page import READING_GUIDE, REPOSITORY
from trackservo_report.requirements import ELSEWHERE
from trackservo_report.sections import ablation_figures, friction_figures, paper_figures, price_figures

FIGURES = [
    "fig7", "fig9", "fig11", "fig12", "fig14", "table2", "table2-curves", "fig16", "ablation", "shares", "frictions",
    "bode", "nyquist", "noise", "confidence", "stribeck", "friction-map", "whitened",
]  # fmt: skip


class Outline(HTMLParser):
    """Collects what a page would load, its element ids and its table values."""

    def __init__(self) -> None:
        super().__init__()
        self.loaded: list[str] = []
        self.links: list[str] = []
        self.ids: list[str] = []
        self.values: list[float] = []
        self.scripts: dict[str, str] = {}
        self.policy = ""
        self._script: str | None = None

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        found = {name: value or "" for name, value in attrs}
        self.ids += [found["id"]] if "id" in found else []
        self.values += [float(found["data-value"])] if "data-value" in found else []
        if tag == "a":
            self.links.append(found.get("href", ""))
        else:
            self.loaded += [found[name] for name in ("src", "href", "data", "srcset", "poster") if name in found]
        if found.get("http-equiv") == "Content-Security-Policy":
            self.policy = found["content"]
        self._script = found.get("id", f"script {len(self.scripts)}") if tag == "script" else None

    def handle_endtag(self, tag: str) -> None:
        self._script = None

    def handle_data(self, data: str) -> None:
        if self._script:
            self.scripts[self._script] = self.scripts.get(self._script, "") + data


def test_the_picture_stands_alone_as_a_file(folder: Path, tmp_path: Path) -> None:
    """What the README shows is the picture of the first screen, with its own style."""
    file = tmp_path / "images" / "picture.svg"
    assert main([str(folder), "--picture", str(file)]) == 0
    picture = ElementTree.parse(file).getroot()
    assert picture.tag.endswith("}svg") and picture.get("width") == str(WIDTH)
    assert len(picture.findall(".//{http://www.w3.org/2000/svg}polyline")) == 3
    assert "var(--" not in file.read_text(encoding="utf-8")


@pytest.fixture(scope="module")
def outline(page: str) -> Outline:
    parser = Outline()
    parser.feed(page)
    return parser


def plots(outline: Outline, key: str) -> list[dict[str, Any]]:
    """The plots of a figure, read back from the page."""
    names = [name for name in outline.scripts if re.fullmatch(f"json-{key}-\\d+", name)]
    return [json.loads(unpacked(outline.scripts[name])) for name in names]


def test_page_loads_nothing(outline: Outline, page: str) -> None:
    assert outline.loaded == ["data:,"]
    assert outline.policy.startswith("default-src 'none'")
    styles = "".join(re.findall(r"<style>(.*?)</style>", page, re.S))
    assert "@import" not in styles and "url(" not in styles


def test_page_has_no_link_out(outline: Outline) -> None:
    assert not [link for link in outline.links if "//" in link]


def test_plotly_is_there_once_and_the_page_is_small(page: str, outline: Outline) -> None:
    assert unpacked(outline.scripts["plotly"]).count("* plotly.js v") == 1
    assert "* plotly.js v" not in page  # inflated only when a plot is looked at
    assert len(page.encode()) < 3e6


def screen(page: str) -> str:
    """What stands on the first screen."""
    return page[page.index('<section id="summary">') : page.index('<section id="reading">')]


def test_the_first_screen_has_a_picture_that_needs_no_script(page: str) -> None:
    picture = re.search(r'<svg class="hero".*?</svg>', screen(page), re.S)
    assert picture is not None
    for name in ("pi", "pi_vob_ftc"):
        curve = re.search(f'<polyline points="([^"]*)" fill="none" stroke="{CONTROLLER_COLOURS[name]}"', picture.group())
        assert curve is not None and len(curve.group(1).split()) > 100
        places = [tuple(map(float, pair.split(","))) for pair in curve.group(1).split()]
        assert all(0 <= x <= WIDTH and 0 <= y <= HEIGHT for x, y in places)
    assert "90 % after 172 ms" in picture.group() and "90 % after 12.0 ms" in picture.group()


def test_a_folder_without_the_start_has_no_picture(changed: Any) -> None:
    place = changed(
        lambda data: data.update(runs=[run for run in data["runs"] if run["experiment"] != "low_speed_start"])
    )
    assert main([str(place)]) == 0
    assert "<svg" not in (place / "report.html").read_text(encoding="utf-8")


def test_the_first_screen_says_what_for_how_well_and_what_is_missing(page: str) -> None:
    words = screen(page)
    for word in ("brushed DC motors", "encoder", "gyro", "simulated", "no board has been powered", "no real camera has been tried"):
        assert word in words
    assert re.search(r"<b>\d+ of \d+ goals</b> met", words)


def test_every_tile_says_which_machine_it_is_of(page: str) -> None:
    tiles = re.findall(r'<div class="tile" data-plant="([^"]*)">\s*<div class="what">([^<]*)</div>.*?class="machine">([^<]*)<', page, re.S)
    assert len(tiles) == 4
    assert all(plant == shown for plant, _, shown in tiles)
    assert {plant for plant, what, _ in tiles if "sine" in what} == {"paper&#39;s simulated plant"}
    assert {plant for plant, what, _ in tiles if "sine" not in what} == {"tracker plant"}


def test_a_figure_of_the_opposite_sign_is_marked_wherever_it_is_counted(page: str) -> None:
    assert "Fig. 9 has the opposite sign" in screen(page)
    assert "1 of the 2 figures that the paper prints for PI alone are reproduced" in screen(page)
    figure = page[page.index('<section class="figure" id="fig9">') :]
    assert "≠ not reproduced: opposite sign" in figure[: figure.index("</h3>")]
    table = page[page.index('id="result-table"') : page.index('<section id="line-of-sight">')]
    assert re.search(r'data-value="-10.6">.*?class="differs"[^>]*>≠</span>', table)
    assert table.count('class="differs"') == 2  # both readings, nothing else


def test_a_figure_that_is_reproduced_has_no_mark(changed: Any) -> None:
    def reproduce(data: dict[str, Any]) -> None:
        for row in data["rows"]:
            if row["reproduced"] is False:
                row.update(reproduced=True, value=row["paper_uncompensated"])

    place = changed(reproduce)
    assert main([str(place)]) == 0
    page = (place / "report.html").read_text(encoding="utf-8")
    assert "differs\"" not in page and "not reproduced" not in page.replace("is not reproduced", "")


def test_results_of_an_older_program_are_shown_without_marks(changed: Any) -> None:
    place = changed(lambda data: [row.pop("reproduced") for row in data["rows"]])
    assert main([str(place)]) == 0
    assert 'class="differs"' not in (place / "report.html").read_text(encoding="utf-8")


def test_all_but_the_summary_and_its_table_is_folded(page: str) -> None:
    sections = re.findall(r'<section id="(\w+)">\n(.*)', page)
    assert [name for name, first in sections if first != '<details class="fold">'] == ["summary", "reading", "results"]
    assert len(sections) == 11
    assert "<details open" not in page and 'class="fold" open' not in page


@pytest.mark.parametrize("key", ["table2", "ablation"])
def test_numbers_of_bars_stand_on_their_whiskers(key: str, outline: Outline) -> None:
    checked = 0
    for plot in plots(outline, key):
        bars = {trace["offsetgroup"]: trace for trace in plot["data"] if trace["type"] == "bar" and "error_y" in trace}
        for trace in plot["data"]:
            if trace["type"] == "bar" and "base" in trace:
                bar = bars[trace["offsetgroup"]]
                assert "text" not in bar
                for tip, value, reach in zip(trace["base"], bar["y"], bar["error_y"]["array"], strict=True):
                    assert value is None or tip == pytest.approx(max(value, 0.0) + reach)
                    checked += value is not None
    assert checked >= 10


def test_the_worth_of_identification_is_a_percentage(changed: Any) -> None:
    def wrong(data: dict[str, Any]) -> None:
        item = next(item for item in data["sensitivity"] if item["controller"] == "pi_vob_ftc")
        item.update(shipped_setting="identified", varied_setting="each off by 15 %")  # 16.9 for 9.4

    place = changed(wrong)
    assert main([str(place)]) == 0
    page = (place / "report.html").read_text(encoding="utf-8")
    assert "the 1 compensated figures" in page and "are on average 79.8 % larger" in page
    assert "as a share of itself" not in page


def test_no_button_sends_a_chart_away(outline: Outline) -> None:
    settings = [text for text in outline.scripts.values() if "modeBarButtons:" in text and len(text) < 20000]
    assert len(settings) == 1
    assert "sendChartToCloud" not in settings[0] and 'plotlyServerURL: ""' in settings[0]


@pytest.mark.parametrize("key", FIGURES)
def test_every_figure_is_present_with_data_and_axis_titles(key: str, outline: Outline) -> None:
    assert key in outline.ids
    found = plots(outline, key)
    assert found
    for plot in found:
        assert plot["data"]
        axes = [value for name, value in plot["layout"].items() if re.fullmatch(r"[xy]axis\d*", name)]
        titles = [axis.get("title", {}).get("text", "") for axis in axes]
        assert any(titles) and all("(" in text or text in TITLES_WITHOUT_UNIT for text in titles if text)


TITLES_WITHOUT_UNIT = {
    "case", "commanded speed", "real part", "imaginary part", "identified / true", "friction / mean friction",
    "residual / deviation",
}  # fmt: skip


def test_every_result_is_in_the_page_exactly(outline: Outline, document: dict[str, Any]) -> None:
    shown = set(outline.values)
    for row in document["rows"]:
        compared = (
            row["metric"] not in ("torque_noise", "reduction")
            and row["friction"] != "none"
            and row["axis"] == "azimuth"
        )
        if row["value"] is not None and (compared or row["met"] is not None):
            assert row["value"] in shown, row
        if row["met"] is not None and row["paper_compensated"] is not None:
            assert row["paper_compensated"] in shown


def test_margins_are_in_the_page(outline: Outline, document: dict[str, Any]) -> None:
    shown = set(outline.values)
    for margin in document["margins"]:
        for name in ("gain_margin_db", "phase_margin_deg", "measured_gain_margin_db", "measured_phase_margin_deg"):
            assert margin[name] is None or margin[name] in shown


def test_identified_parameters_stand_beside_the_true_ones(page: str, document: dict[str, Any]) -> None:
    table = re.search(r'<table id="identified-table">.*?</table>', page, re.S)
    assert table is not None
    rows = [re.findall(r"<td[^>]*>(.*?)</td>", row) for row in re.findall(r"<tr>(<td.*?)</tr>", table.group(), re.S)]
    assert len(rows) == sum(len(axis["parameters"]) for axis in document["identified"])
    assert rows[0] == ["Tc, forward", "Nm", "10.0", "10.1", "+1.00 %", "9.70 … 10.5", "20.0"]
    assert table.group().count('class="no"') == len(document["identified"])  # the inertia's interval misses


def test_every_assumption_is_listed_and_escaped(page: str, document: dict[str, Any]) -> None:
    assert "chosen &lt; break-away 14 Nm &amp; said so" in page
    for plant in document["plants"]:
        for item in plant["assumptions"]:
            assert item["topic"] in page


def test_goal_count_is_in_the_summary(page: str, document: dict[str, Any]) -> None:
    judged = [row["met"] for row in document["rows"] if row["met"] is not None]
    assert f"<strong>{sum(judged)} of {len(judged)}</strong>" in page


def test_losses_on_the_other_friction_are_said(page: str) -> None:
    verdict = page[page.index('data-friction="maxwell_slip"') :]
    assert "<b>loses 5</b>" in verdict[:600]
    assert "with PI + FTC against" in verdict[:2000]


def test_paper_values_are_dashed_lines(outline: Outline) -> None:
    heights = {shape["y0"] for plot in plots(outline, "fig12") for shape in plot["layout"]["shapes"]}
    assert {0.25, -0.25, 0.02, -0.02} <= heights
    heights = {shape["y0"] for plot in plots(outline, "fig16") for shape in plot["layout"]["shapes"]}
    assert {56.44, -56.44, 14.86, -14.86} <= heights


def test_a_controller_has_one_colour_everywhere(outline: Outline) -> None:
    colours: dict[str, set[str]] = {}
    for key in ("fig9", "fig11", "fig12", "fig14", "fig16", "table2", "ablation", "bode", "nyquist", "noise"):
        for plot in plots(outline, key):
            for trace in plot["data"]:
                style = trace["marker"] if trace["type"] == "bar" else trace.get("line", {})
                if trace.get("name", "").startswith("PI") and "friction-free" not in trace["name"] and "color" in style:
                    colours.setdefault(trace["name"], set()).add(style["color"])
    assert len(colours) >= 4
    assert all(len(used) == 1 for used in colours.values())


def test_anchors_lead_somewhere(outline: Outline, folder: Path) -> None:
    for link in outline.links:
        target = link[1:] in outline.ids if link.startswith("#") else (folder / link.replace("%20", " ")).exists()
        assert target, link


def test_every_source_file_that_the_page_names_exists(page: str, outline: Outline, folder: Path) -> None:
    named = {path for _, _, block, test, _ in READING_GUIDE for path in (block, test)}
    results = load_results(folder)
    items = gather(results.rows)
    figures = [*paper_figures(results, items), *ablation_figures(results, items), *friction_figures(items)]
    named |= {path for figure in [*figures, *price_figures(results, items)] for path in figure.hints}
    commands = {item.command for item in ELSEWHERE}
    named |= {path for path in re.findall(r"<code>([\w./-]+)</code>", page) if "/" in path and path not in commands}
    assert len(named) > 20
    for path in named:
        assert (REPOSITORY / path).exists(), path
        assert any(link.endswith(path) for link in outline.links), path


def test_every_run_is_listed_once_by_its_first_seed(outline: Outline, document: dict[str, Any]) -> None:
    listed = [link for link in outline.links if link.startswith("runs/")]
    first: dict[tuple[str, ...], str] = {}
    for run in document["runs"]:
        first.setdefault(tuple(run[name] for name in ("experiment", "case", "plant", "friction", "controller")), run["csv"])
    assert sorted(listed) == sorted(set(first.values()))


def test_a_missed_goal_of_the_sensitivity_is_marked(page: str) -> None:
    section = page[page.index('id="sensitivity-table"') :]
    assert re.search(r'data-value="16.9">16.9<span class="spread"> ± 0.7</span> <span class="no"', section)


def test_a_folder_without_sensitivity_says_so(changed: Any) -> None:
    place = changed(lambda data: data.update(sensitivity=[]))
    assert main([str(place)]) == 0
    assert "holds no sensitivity study" in (place / "report.html").read_text(encoding="utf-8")


def test_quick_results_are_marked(changed: Any) -> None:
    place = changed(lambda data: data["generator"].update(quick=True))
    assert main([str(place)]) == 0
    assert "these numbers are not results" in (place / "report.html").read_text(encoding="utf-8")


def test_the_page_is_reproducible(folder: Path, page: str) -> None:
    assert main([str(folder)]) == 0
    assert (folder / "report.html").read_text(encoding="utf-8") == page
