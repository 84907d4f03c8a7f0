# SPDX-License-Identifier: Apache-2.0
"""Tables of the studies that are run on demand."""

import json
from pathlib import Path
from typing import Any

import pytest

from trackservo_report.load import InputError, load_results
from trackservo_report.markdown import TABLES, update_document
from trackservo_report.sections import line_of_sight_figures


def test_identification_value_shows_means_ranges_and_the_paired_gain(folder: Path) -> None:
    table = TABLES["beliefs"](load_results(folder))
    assert table is not None
    assert (
        "| Sine, 1 °/s, 0.1 Hz: peak speed error, °/s | 0.00500 (0.00400…0.00600) | 0.00450 (0.00400…0.00500) "
        "| 0.00600 (0.00500…0.00700) | −16.7 ± 2.0 |"
    ) in table
    assert "| **−0.167 ± 0.020** (sum) |" in table
    assert "| figure | identified | exact | each off by 15 % |" in table


def test_random_plants_show_what_fails_and_what_the_paper_has_not(folder: Path) -> None:
    table = TABLES["random_plants"](load_results(folder))
    assert table is not None
    assert "1,000 plants like `tracker`, with 84 numbers each off by up to 30 %. **4 fail**" in table
    assert "The pitch error does so on 3 plants, one of the axes on 5." in table.replace("\n", " ")
    assert "Plants without result, because their runs ended early: 1." in table.replace("\n", " ")
    assert "| Azimuth, 0.1 °/s | 0.00900 | 0.0130 | 0.0170 | 0.0160 | 3 of 1,000 |" in table
    assert "| Pitch, 3 °/s | 0.0100 | 0.0140 | 0.0180 | – | 0 of 1,000 |" in table
    assert "| Azimuth | 1 of 1,000 | 2 of 1,000 | 7.2 dB, 40° | 0.50 % |" in table
    assert "| 985 | 1.21 | 1.29 |" in table
    assert "| all | correlation with the error | −0.50 |" in table


def test_a_study_that_was_not_run_leaves_its_table_alone(changed: Any, tmp_path: Path) -> None:
    document = tmp_path / "page.md"
    document.write_text("<!-- beliefs -->\nunchanged\n<!-- end beliefs -->\n", encoding="utf-8")
    update_document(load_results(changed(lambda data: None)), document)
    assert document.read_text(encoding="utf-8") == "<!-- beliefs -->\nunchanged\n<!-- end beliefs -->\n"


def test_a_file_of_another_program_is_refused(changed: Any) -> None:
    results = load_results(changed(lambda data: None))
    (results.folder / "beliefs.json").write_text(json.dumps({"generator": {"program": "other"}}), encoding="utf-8")
    with pytest.raises(InputError, match="beliefs.json"):
        TABLES["beliefs"](results)


def test_a_turning_base_has_a_column_for_each_of_its_axes_and_marks(folder: Path) -> None:
    table = TABLES["base_tracking"](load_results(folder))
    assert table is not None
    assert "| 60° | 1° at 0.3 Hz | 2.10 and 1.50 ✓ | – | 20.00 and 1.50 ✗ |" in table


def test_isolation_shows_the_rms_and_the_base_frequency_alone(folder: Path) -> None:
    table = TABLES["base_isolation"](load_results(folder))
    assert table is not None
    assert "| azimuth, gyro | 0.5° | 59 (74) | 41 (50) |" in table
    assert "| pitch, encoder | 0.5° | 0 (0) | −1 (−1) |" in table


def test_margins_over_the_pitch_stand_beside_those_of_gains_that_stay(folder: Path) -> None:
    table = TABLES["base_margins"](load_results(folder))
    assert table is not None
    assert "| 89° | sliding | 12.1 / 11.8 | 49.7 / 49.2 | 6.4 dB, 35.1° |" in table


def test_the_isolation_is_a_figure_of_the_page_with_a_tab_for_each_axis(folder: Path, changed: Any) -> None:
    figures = line_of_sight_figures(load_results(folder))
    assert [[view.label for view in figure.views] for figure in figures] == [["azimuth", "pitch"]]
    curve = figures[0].views[0].plot.data[1]
    assert (curve.name, list(curve.y)) == ("gyro, 0.5°", [59.0, 41.0])
    results = load_results(changed(lambda data: None))
    assert line_of_sight_figures(results) == []
    assert TABLES["base_isolation"](results) is None


def test_tracking_in_the_node_stands_beside_its_reference(folder: Path) -> None:
    table = TABLES["node_tracking"](load_results(folder))
    assert table is not None
    assert "| fly-by, predictive loop | 2.20 and 2.70 | – | never | 1.25 |" in table
    assert "| pass at 88°, 500 m up | – | – | not found again | 1.25 |" in table
    assert "| fly-by, 1 s without the target | 2.30 and 2.80 | – | 0.17 s | 1.25 |" in table
    assert "| fly-by, stated age +10 ms wrong | 2.10 and 2.60 | 2.00 and 2.40 | never | 1.25 |" in table
