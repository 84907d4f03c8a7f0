# SPDX-License-Identifier: Apache-2.0
"""Marked tables of documents are renewed from the results."""

import re
from pathlib import Path
from typing import Any

import pytest

from trackservo_report.load import InputError, load_results
from trackservo_report.markdown import TABLES, update_document


def test_every_marked_table_is_renewed_and_the_rest_unchanged(folder: Path, tmp_path: Path) -> None:
    results = load_results(folder)
    document = tmp_path / "page.md"
    marks = "\n".join(f"before {name}\n<!-- {name} -->\nold\n<!-- end {name} -->" for name in TABLES)
    document.write_text(marks + "\nafter\n", encoding="utf-8")
    update_document(results, document)
    text = document.read_text(encoding="utf-8")
    assert "old" not in text
    assert text.endswith("\nafter\n")
    for name, table in TABLES.items():
        assert f"before {name}\n<!-- {name} -->\n{table(results)}\n<!-- end {name} -->" in text


def test_the_result_pages_hold_every_table_once() -> None:
    docs = Path(__file__).resolve().parents[3] / "docs"
    pages = [docs / "results.md", *sorted((docs / "results").glob("*.md"))]
    marks = [name for page in pages for name in re.findall(r"<!-- (\w+) -->", page.read_text(encoding="utf-8"))]
    assert sorted(marks) == sorted(TABLES)


def test_renewing_twice_changes_nothing(folder: Path, tmp_path: Path) -> None:
    results = load_results(folder)
    document = tmp_path / "page.md"
    document.write_text("<!-- results -->\n<!-- end results -->\n", encoding="utf-8")
    update_document(results, document)
    once = document.read_text(encoding="utf-8")
    update_document(results, document)
    assert document.read_text(encoding="utf-8") == once
    assert "paper: compensated" in once


def test_a_missed_goal_stands_in_the_sensitivity_table(folder: Path) -> None:
    table = TABLES["sensitivity"](load_results(folder))
    assert "| weave of the UAV: 5 m → **8 m** | Tracking a UAV, paper loop: tracking error 1σ, µrad |" in table
    assert "16.9 ± 0.7 ✗ (goal ≤ 12)" in table


def test_a_quick_run_renews_no_document(changed: Any, tmp_path: Path) -> None:
    document = tmp_path / "page.md"
    document.write_text("<!-- results -->\nold\n<!-- end results -->\n", encoding="utf-8")
    results = load_results(changed(lambda data: data["generator"].update(quick=True)))
    with pytest.raises(InputError, match="quick"):
        update_document(results, document)
    assert "old" in document.read_text(encoding="utf-8")


def test_unknown_table_is_refused_with_its_name(folder: Path, tmp_path: Path) -> None:
    document = tmp_path / "page.md"
    document.write_text("<!-- nonsense -->\n<!-- end nonsense -->\n", encoding="utf-8")
    with pytest.raises(InputError, match="nonsense"):
        update_document(load_results(folder), document)
