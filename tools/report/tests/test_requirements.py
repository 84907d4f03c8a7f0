# SPDX-License-Identifier: Apache-2.0
"""Requirements of the line of sight: page, terminal and documents show the same rows with the same marks."""

import re
from pathlib import Path
from typing import Any

import pytest
from markupsafe import escape

from trackservo_report.__main__ import main
from trackservo_report.load import InputError, load_results
from trackservo_report.markdown import TABLES, update_document
from trackservo_report.requirements import ELSEWHERE

REPOSITORY = Path(__file__).resolve().parents[3]


def test_both_axes_of_a_figure_share_a_line_and_the_worse_one_decides(folder: Path, changed: Any) -> None:
    good = TABLES["requirements"](load_results(folder))
    assert good is not None
    assert "| fly-by, predictive loop: 1σ, µrad | ≤ 2.5 and ≤ 3 | 2.22 and 2.75 ✓ | `sim_host node-tracking` |" in good

    def spoil(data: dict[str, Any]) -> None:
        data["requirements"][1].update(value=3.1, high=3.1, met=False)

    spoiled = TABLES["requirements"](load_results(changed(spoil)))
    assert spoiled is not None and "2.22 and 3.10 ✗" in spoiled


def test_a_target_that_is_not_found_again_is_reported(folder: Path) -> None:
    table = TABLES["requirements"](load_results(folder))
    assert table is not None
    assert "| pass at 88°, 500 m: time without the target, s | ≤ 1.153 | 4.61 ✗ | `sim_host node-tracking` |" in table
    assert "| pass at 89°, 500 m: time without the target, s | ≤ 1.5 | never again ✗ |" in table


def test_dropped_frames_have_a_line_only_where_there_are_some(folder: Path, changed: Any) -> None:
    table = TABLES["requirements"](load_results(folder))
    assert table is not None and "dropped frames" not in table

    def drop(data: dict[str, Any]) -> None:
        data["requirements"][2].update(value=3.0, met=False)

    table = TABLES["requirements"](load_results(changed(drop)))
    assert table is not None and "dropped frames | ≤ 0 | 3.00 ✗" in table


def test_page_and_terminal_show_the_rows_of_the_documents(folder: Path, page: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main([str(folder)]) == 0
    said = capsys.readouterr().out
    table = page[page.index('id="requirements-table"') :].split("</table>")[0]
    assert re.search(r"2\.22 and 2\.75 <span class=\"yes\"", table)
    assert re.search(r"4\.61 <span class=\"no\"", table)
    assert "2.22 and 2.75 ✓" in said and "4.61 ✗" in said
    assert "requirements of the line of sight met: 4 of 6" in said


def test_what_other_commands_measure_has_a_command_and_no_number(folder: Path, page: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main([str(folder)]) == 0
    said = " ".join(capsys.readouterr().out.split())
    table = TABLES["requirements"](load_results(folder))
    assert table is not None
    for item in ELSEWHERE:
        assert f"not measured here: {item.figure} ({item.required}); run {item.command}" in said
        assert f"| {item.figure} | {item.required} | in `{item.page}` | `{item.command}` |" in table
        assert str(escape(item.command)) in page
        assert (REPOSITORY / item.page).is_file()


def test_a_study_that_was_not_run_is_named_with_its_command(changed: Any, capsys: pytest.CaptureFixture[str]) -> None:
    def without(data: dict[str, Any]) -> None:
        data["requirements"] = [row for row in data["requirements"] if row["command"] != "sim_host base-motion"]

    folder = changed(without)
    assert main([str(folder)]) == 0
    assert f"not measured: sim_host base-motion --out {folder}" in capsys.readouterr().out


def test_results_of_older_programs_have_no_rows(changed: Any, capsys: pytest.CaptureFixture[str]) -> None:
    folder = changed(lambda data: data.pop("requirements"))
    assert main([str(folder)]) == 0
    assert "requirements of the line of sight met" not in capsys.readouterr().out
    assert TABLES["requirements"](load_results(folder)) is None


def test_rows_of_another_commit_renew_no_document(changed: Any, tmp_path: Path) -> None:
    document = tmp_path / "page.md"
    document.write_text("<!-- requirements -->\nold\n<!-- end requirements -->\n", encoding="utf-8")
    results = load_results(changed(lambda data: data["requirements"][0].update(git="fff0000")))
    with pytest.raises(InputError, match="fff0000"):
        update_document(results, document)


def test_check_fails_while_a_document_differs_from_the_results(folder: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    document = tmp_path / "README.md"
    document.write_text("<!-- requirements -->\n| 2.2 |\n<!-- end requirements -->\n", encoding="utf-8")
    assert main([str(folder), "--check", str(document)]) == 1
    assert f"{document}: its tables are not those of" in capsys.readouterr().err
    assert main([str(folder), "--update", str(document), "--check", str(document)]) == 0


def _tables_of(page: Path) -> dict[str, str]:
    return dict(re.findall(r"<!-- (\w+) -->\n(.*?)<!-- end \1 -->", page.read_text(encoding="utf-8"), re.DOTALL))


def test_readme_has_the_tables_of_the_result_page() -> None:
    readme, results = _tables_of(REPOSITORY / "README.md"), _tables_of(REPOSITORY / "docs/results.md")
    assert set(readme) == {"results", "requirements"}
    for name, table in readme.items():
        assert table == results[name], f"table '{name}' of README.md differs from docs/results.md; run tools/update-docs results"
