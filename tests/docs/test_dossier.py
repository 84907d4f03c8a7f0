# SPDX-License-Identifier: Apache-2.0
"""The safety pages name every fault that the firmware has, and quote the figures of docs/results/faults.md."""

from __future__ import annotations

import re
from pathlib import Path

DOCS = Path(__file__).resolve().parents[2] / "docs"
PAGES = ["safety.md", "safety/failure-modes.md", "safety/functions.md", "safety/techniques.md"]
INSTANTS, MOTIONS, AXES = 20, 5, 2

LIST = re.compile(r"\bfaults? (\d+(?:(?:, | and )\d+)*)")
QUOTED = re.compile(r'"([^"|]+)" ([\d,]+) ms(?:, ([\d.]+) °/s)?')

Table = list[dict[str, str]]


def text_of(page: str) -> str:
    return (DOCS / page).read_text(encoding="utf-8")


def tables(text: str) -> list[Table]:
    """Each table of a page, as rows by the name of the column."""
    found: list[Table] = []
    for block in re.findall(r"(?:^\|.*\n)+", text, re.MULTILINE):
        lines = [[cell.strip() for cell in line.strip("|").split(" | ")] for line in block.splitlines()]
        found.append([dict(zip(lines[0], line, strict=True)) for line in lines[2:]])
    return found


def rows(text: str, column: str) -> Table:
    return [row for table in tables(text) for row in table if column in row]


def matrix() -> dict[str, dict[str, str]]:
    """The rows of the fault matrix and of the common causes, with latency and limit in columns of their own."""
    found = {}
    for row in rows(text_of("results/faults.md"), "injected fault"):
        row["measured, ms"], row["allowed, ms"] = row["latency / allowed, ms"].split(" / ")
        found[row["injected fault"]] = row
    return found


def numbers_of(text: str) -> set[int]:
    """The faults that a text names by number; "faults 1 to 4" names only the first."""
    return {int(number) for numbers in LIST.findall(" ".join(text.split())) for number in re.findall(r"\d+", numbers)}


def firmware_faults() -> set[int]:
    return {int(row["number"]) for row in rows(text_of("faults.md"), "latched")}


def differences_of_quotes(text: str, measured: dict[str, dict[str, str]]) -> list[str]:
    """'"encoder stuck" 100 ms, 3 °/s': latency and, where it is given, the highest speed."""
    found = []
    for name, latency, speed in QUOTED.findall(text):
        row = measured.get(name)
        if row is None:
            found.append(f'no row "{name}"')
        elif latency.replace(",", "") != row["measured, ms"] or (speed and speed != row["fastest, °/s"]):
            found.append(f'"{name}": {latency} ms {speed}, but {row["measured, ms"]} ms {row.get("fastest, °/s", "")}')
    return found


def differences_of_tables(text: str, measured: dict[str, dict[str, str]]) -> list[str]:
    """Tables with a measured latency, whose first column is the name of a row."""
    column_there = {"longest travel in calm air, °": "travel, °"}
    found = []
    for quoted in rows(text, "measured, ms"):
        name, _, *columns = quoted
        row = measured.get(quoted[name])
        if row is None:
            found.append(f'no row "{quoted[name]}"')
            continue
        for column in columns:
            there = row[column_there.get(column, column)]
            if quoted[column] != there:
                found.append(f'"{quoted[name]}", {column}: {quoted[column]}, but {there}')
    return found


def test_every_fault_of_the_firmware_has_a_number_in_the_hazards_or_failure_modes() -> None:
    named = numbers_of(text_of("safety.md")) | numbers_of(text_of("safety/failure-modes.md"))
    named |= numbers_of(text_of("safety/functions.md"))
    faults = firmware_faults()
    assert len(faults) > 50 and faults == set(range(1, max(faults) + 1))
    assert faults - named == set(), "faults that no safety page names"
    assert named - faults == set(), "faults that the firmware does not have"


def test_quoted_figures_are_those_of_the_matrix() -> None:
    measured = matrix()
    for page in PAGES:
        assert differences_of_quotes(text_of(page), measured) == [], page
        assert differences_of_tables(text_of(page), measured) == [], page
    assert len(QUOTED.findall(text_of("safety/failure-modes.md"))) > 40
    assert len(rows(text_of("safety/functions.md"), "measured, ms")) > 25


def test_quoted_counts_of_runs_are_those_of_the_matrix() -> None:
    runs = len(matrix()) * INSTANTS * MOTIONS * AXES
    for page in ["safety.md", "safety/techniques.md"]:
        counts = {int(count.replace(",", "")) for count in re.findall(r"([\d,]+)\sinjection\sruns", text_of(page))}
        assert counts == {runs}, page
    assert f"In {runs:,} runs " in text_of("results/faults.md")
    assert f"| {len(matrix())} injected faults, {runs:,} runs |" in text_of("results.md")
