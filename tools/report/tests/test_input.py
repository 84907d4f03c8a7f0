# SPDX-License-Identifier: Apache-2.0
"""Bad input: exit code 2 and one sentence that names the file and the reason."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import jsonschema
import pytest

from trackservo_report.__main__ import main
from trackservo_report.load import schema

PACKAGE = Path(__file__).resolve().parents[1]


def refused(folder: Path, capsys: pytest.CaptureFixture[str], *words: str) -> None:
    """The folder is refused with one line that holds all of `words`."""
    capsys.readouterr()
    assert main([str(folder)]) == 2
    text = capsys.readouterr().err
    assert text.count("\n") == 1
    for word in words:
        assert word in text


def test_missing_folder_is_named(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    refused(tmp_path / "nowhere", capsys, "nowhere", "no such folder")


def test_missing_results_are_named(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    refused(tmp_path, capsys, "results.json", "not found")


def test_broken_json_is_named_with_its_line(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "results.json").write_text('{\n "schema_version": 1,\n oops', encoding="utf-8")
    refused(tmp_path, capsys, "results.json:3", "invalid JSON")


def test_nan_is_not_json(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "results.json").write_text('{"schema_version": NaN}', encoding="utf-8")
    refused(tmp_path, capsys, "results.json", "NaN")


def test_bytes_that_are_not_text_are_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "results.json").write_bytes(b"\xff\xfe\x00")
    refused(tmp_path, capsys, "results.json", "is not UTF-16")


def drop(*path: Any) -> Callable[[dict[str, Any]], None]:
    """A change that removes an entry."""

    def change(data: Any) -> None:
        for part in path[:-1]:
            data = data[part]
        del data[path[-1]]

    return change


def put(value: Any, *path: Any) -> Callable[[dict[str, Any]], None]:
    """A change that sets an entry."""

    def change(data: Any) -> None:
        for part in path[:-1]:
            data = data[part]
        data[path[-1]] = value

    return change


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (drop("rows"), ["'rows' is a required property"]),
        (drop("rows", 3, "unit"), ["rows[3]", "'unit' is a required property"]),
        (put("much", "rows", 0, "value"), ["rows[0].value", "'much'"]),
        (put("wiggle", "rows", 2, "metric"), ["rows[2].metric", "wiggle"]),
        (drop("sensitivity", 0, "shipped"), ["sensitivity[0]", "'shipped' is a required property"]),
        (put("other", "sensitivity", 1, "plant"), ["sensitivity[1].plant", "'other'", "plants"]),
        (put("dahl", "runs", 1, "friction"), ["runs[1].friction", "dahl"]),
        (put(2, "schema_version"), ["schema_version", "1 was expected"]),
        (put([], "rows"), ["rows"]),
        (put("other", "rows", 0, "plant"), ["rows[0].plant", "'other'", "plants"]),
        (put("pid", "margins", 0, "controller"), ["margins[0].controller", "'pid'", "controllers"]),
        (put("runs/none.csv", "runs", 0, "csv"), ["runs/none.csv", "not found"]),
        (put("margins/none.csv", "margins", 0, "response_csv"), ["margins/none.csv", "not found"]),
    ],
)
def test_bad_entries_are_named(
    change: Callable[[dict[str, Any]], None],
    words: list[str],
    changed: Callable[[Any], Path],
    capsys: pytest.CaptureFixture[str],
) -> None:
    refused(changed(change), capsys, *words)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("", ["time_s is missing"]),
        ("time_s,azimuth_rate_rad_s\n0,1\n1,1\n", ["azimuth_reference_rad_s is missing"]),
        (None, ["a value that is not a finite number"]),
        ("GARBLE", ["not a table of numbers"]),
        ("SHORT", ["fewer than two lines"]),
        ("BACK", ["time_s does not rise"]),
    ],
)
def test_bad_run_files_are_named(
    text: str | None, words: list[str], folder: Path, changed: Callable[[Any], Path], capsys: pytest.CaptureFixture[str]
) -> None:
    place = changed(put("bad.csv", "runs", 0, "csv"))
    first = json.loads((folder / "results.json").read_text(encoding="utf-8"))["runs"][0]["csv"]
    lines = (folder / first).read_text(encoding="utf-8").splitlines()
    zeros = ",".join(["0"] * lines[0].count(","))
    spoiled = {
        None: [*lines[:4], "9," + zeros[:-1] + "nan"],
        "GARBLE": [*lines[:4], "a,b"],
        "SHORT": lines[:2],
        "BACK": [*lines[:4], "-1," + zeros],
    }
    content = spoiled.get(text, [text or ""])
    if text is None:
        cells = ["9"] + ["nan"] * lines[0].count(",")
        content = [*lines[:4], ",".join(cells)]
    (place / "bad.csv").write_text("\n".join(content), encoding="utf-8")
    refused(place, capsys, "bad.csv", *words)


def test_unmet_goals_are_no_error(changed: Callable[[Any], Path]) -> None:
    def fail_all(data: dict[str, Any]) -> None:
        for row in data["rows"]:
            row["met"] = False if row["goal"] else None

    assert main([str(changed(fail_all))]) == 0


def test_a_folder_without_runs_and_margins_still_gives_a_page(changed: Callable[[Any], Path]) -> None:
    def strip(data: dict[str, Any]) -> None:
        data.update(runs=[], margins=[], benchmark=None, rows=data["rows"][:1])

    place = changed(strip)
    assert main([str(place)]) == 0
    assert "holds no data for this figure" in (place / "report.html").read_text(encoding="utf-8")


def test_an_unwritable_page_is_reported(folder: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    shutil.copytree(folder, tmp_path / "copy")
    (tmp_path / "copy" / "report.html").unlink()
    (tmp_path / "copy" / "report.html").mkdir()
    refused(tmp_path / "copy", capsys, "report.html", "cannot be written")


def test_schema_is_valid_and_describes_every_field() -> None:
    jsonschema.Draft202012Validator.check_schema(schema())

    def visit(node: dict[str, Any], path: str) -> None:
        for name, child in node.get("properties", {}).items():
            assert "description" in child or "$ref" in child, f"{path}.{name}"
            visit(child, f"{path}.{name}")
        if "items" in node:
            visit(node["items"], path + "[]")

    visit(schema(), "")


def test_runs_as_a_module_and_piped(folder: Path) -> None:
    command = [sys.executable, "-m", "trackservo_report", str(folder)]
    paths = os.pathsep.join((str(PACKAGE), str(PACKAGE.parent / "servoctl")))
    done = subprocess.run(command, env={**os.environ, "PYTHONPATH": paths}, capture_output=True, text=True, check=False)
    assert done.returncode == 0
    assert "\x1b[" not in done.stdout
    table = [line for line in done.stdout.splitlines() if not line.startswith("report:")]
    assert max(len(line) for line in table) <= 100
