# SPDX-License-Identifier: Apache-2.0
"""The notebook that commissions the simulated tracker, run as a reader would run it; with the short test plans of
short_identify.py."""

from __future__ import annotations

import base64
import json
import math
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from .conftest import PACKAGE, SIM_HOST, Bench
from .test_identify import PROGRAMS

NOTEBOOK = PACKAGE / "notebooks/commission.ipynb"
FIGURES = ("friction", "tune", "starts")
"""The cells whose results are pictures."""
LEAST_PICTURE = 20_000
"""Bytes; an empty one has some thousand."""
RESULTS = """
import json, math
machine_data = found.identified.data["machine"]
print(json.dumps({
    "pitch_deg": machine_data["other_axis_deg"],
    "inertia": {"low": found.identified.estimates["inertia"].low, "high": found.identified.estimates["inertia"].high},
    "kept": tuned.kept, "phase_margin_deg": tuned.measured.margins.phase_margin_deg,
    "behind_mdeg": behind.loc["0.1 °/s"].tolist(),
    "rate_deg_s": float(frame["azimuth_rate_deg_s"].max()),
    "limits": int(figures["kept"].notna().sum()), "not_met": int(figures["kept"].eq(False).sum()),
}))
"""


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """Where the notebook runs: without a bus, so that it starts the simulator."""
    bench = Bench("", tmp_path)
    for name, value in (bench.environment | PROGRAMS | {"SHORT_REAL_DESIGN": "1", "SIM_HOST": SIM_HOST}).items():
        monkeypatch.setenv(name, value)
    for name in ("IPYTHONDIR", "JUPYTER_CONFIG_DIR", "JUPYTER_DATA_DIR", "JUPYTER_RUNTIME_DIR"):
        monkeypatch.setenv(name, str(tmp_path / name.lower()))
    monkeypatch.delenv("SERVOCTL_BUS")
    yield tmp_path


def pictures(cell: Any) -> list[bytes]:
    return [base64.b64decode(output["data"]["image/png"]) for output in cell["outputs"] if "image/png" in output.get("data", {})]


@pytest.mark.real_time
@pytest.mark.alone  # its kernel, the simulator and the design fill both cores of a small machine
def test_the_notebook_commissions_the_simulated_tracker(folder: Path) -> None:
    import nbformat
    from nbclient import NotebookClient

    notebook: Any = nbformat.read(NOTEBOOK, as_version=4)  # type: ignore[no-untyped-call]
    assert not any(cell.get("outputs") or cell.get("execution_count") for cell in notebook.cells), "commit it without outputs"
    notebook.cells.append(nbformat.v4.new_code_cell(RESULTS))  # type: ignore[no-untyped-call]
    NotebookClient(notebook, timeout=400, kernel_name="python3", resources={"metadata": {"path": str(folder)}}).execute()

    cells = {cell["id"]: cell for cell in notebook.cells}
    for name in FIGURES:
        assert [len(picture) > LEAST_PICTURE for picture in pictures(cells[name])] == [True], name
    found = json.loads(notebook.cells[-1]["outputs"][-1]["text"])
    true = 3.0 + 3.0 * math.cos(math.radians(found["pitch_deg"])) ** 2  # sim_host/plants/tracker.toml
    assert found["inertia"]["low"] <= true <= found["inertia"]["high"], found
    assert found["kept"] and 40.0 < found["phase_margin_deg"] < 60.0, found
    alone, compensated = found["behind_mdeg"]
    assert compensated < 0.25 * alone, found
    assert found["rate_deg_s"] == pytest.approx(0.5, abs=0.05)
    assert found["limits"] == 74 and found["not_met"] < 30, found  # sim_host/limits/tracker.toml, for gains of another design
