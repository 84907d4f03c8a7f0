"""Tables of the studies that are run on demand."""

import json
from pathlib import Path
from typing import Any

import pytest

from trackservo_report.load import InputError, load_results
from trackservo_report.markdown import TABLES, update_document


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
