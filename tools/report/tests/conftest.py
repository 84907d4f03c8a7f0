# SPDX-License-Identifier: Apache-2.0
"""Fixtures: an invented results folder, and a way to spoil a copy of it."""

from __future__ import annotations

import json
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

HERE = Path(__file__).resolve().parent
sys.path[:0] = [str(HERE), str(HERE.parent), str(HERE.parents[1] / "servoctl")]

from make_sample import make_sample  # noqa: E402

from trackservo_report.__main__ import main  # noqa: E402

Change = Callable[[dict[str, Any]], None]


@pytest.fixture(scope="session")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A sample folder with its report written."""
    made = make_sample(tmp_path_factory.mktemp("results"))
    assert main([str(made)]) == 0
    return made


@pytest.fixture(scope="session")
def page(folder: Path) -> str:
    """The report's HTML."""
    return (folder / "report.html").read_text(encoding="utf-8")


@pytest.fixture(scope="session")
def document(folder: Path) -> dict[str, Any]:
    """The sample's results.json."""
    loaded: dict[str, Any] = json.loads((folder / "results.json").read_text(encoding="utf-8"))
    return loaded


@pytest.fixture
def changed(folder: Path, tmp_path: Path) -> Callable[[Change], Path]:
    """Gives a copy of the sample folder whose results.json went through a change."""

    def make(change: Change) -> Path:
        for name in ("runs", "margins", "identification"):
            (tmp_path / name).symlink_to(folder / name)
        data = json.loads((folder / "results.json").read_text(encoding="utf-8"))
        change(data)
        (tmp_path / "results.json").write_text(json.dumps(data), encoding="utf-8")
        return tmp_path

    return make
