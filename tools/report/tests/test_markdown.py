"""Marked tables of documents are renewed from the results."""

from pathlib import Path

import pytest

from trackservo_report.load import InputError, load_results
from trackservo_report.markdown import TABLES, update_document


def test_every_marked_table_is_renewed_and_the_rest_kept(folder: Path, tmp_path: Path) -> None:
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


def test_renewing_twice_changes_nothing(folder: Path, tmp_path: Path) -> None:
    results = load_results(folder)
    document = tmp_path / "page.md"
    document.write_text("<!-- results -->\n<!-- end results -->\n", encoding="utf-8")
    update_document(results, document)
    once = document.read_text(encoding="utf-8")
    update_document(results, document)
    assert document.read_text(encoding="utf-8") == once
    assert "paper: compensated" in once


def test_unknown_table_is_refused_with_its_name(folder: Path, tmp_path: Path) -> None:
    document = tmp_path / "page.md"
    document.write_text("<!-- nonsense -->\n<!-- end nonsense -->\n", encoding="utf-8")
    with pytest.raises(InputError, match="nonsense"):
        update_document(load_results(folder), document)
