# SPDX-License-Identifier: Apache-2.0
"""A gains file judged by `sim_host check`: firmware and gains on a simulated machine, the figures against limits (docs/ci.md)."""

from __future__ import annotations

import subprocess
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ..errors import InputError
from ..show.text_file import json_of, read_text
from ..sim_host import find_simulator

RESULTS = "results.json"
_FORMAT = "trackservo check 1"
_KEPT, _NOT_KEPT = 0, 1
"""Exit codes; others come with a sentence."""
_NAME = "sim_host: "


@dataclass(frozen=True)
class GainCheck:
    """Whether every limit is met, the figures as in results.json (docs/ci.md), and the program's warnings."""

    kept: bool
    figures: list[dict[str, Any]]
    warnings: list[str]


def check_gains(
    gains: Path, limits: Path | None = None, plant: Path | None = None, scenarios: Sequence[Path] = (), seeds: Sequence[int] = (),
    out: Path | None = None,
) -> GainCheck:  # fmt: skip
    """Runs `sim_host check` with these gains, which takes some seconds of each core. Without files of the user: the shipped
    tracker, its limits, the shipped scenarios, seeds 1 to 20. results.json and report.html are kept in `out`, where they must
    not exist.

    Raises InputError when the program is not found or refuses a file.
    """
    with tempfile.TemporaryDirectory() as work:
        folder = out or Path(work) / "check"
        words = ["--gains", str(gains), "--out", str(folder)]
        words += ["--limits", str(limits)] if limits else []
        words += ["--plant", str(plant)] if plant else []
        words += [word for scenario in scenarios for word in ("--scenario", str(scenario))]
        words += ["--seeds", *(str(seed) for seed in seeds)] if seeds else []
        warnings = _run(words)
        path = folder / RESULTS
        data = json_of(read_text(path))
    if not isinstance(data, dict) or data.get("format") != _FORMAT:
        raise InputError(f"{path}: not a result of 'sim_host check': the simulator and servoctl are of different versions.")
    return GainCheck(bool(data["kept"]), list(data["figures"]), warnings)


def _run(words: Sequence[str]) -> list[str]:
    """The warnings."""
    program = find_simulator()
    try:
        done = subprocess.run([str(program), "check", *words], stdin=subprocess.DEVNULL, capture_output=True, text=True)
    except OSError as error:
        raise InputError(f"{program}: cannot be run: {error.strerror}.") from error
    said = [line.removeprefix(_NAME) for line in done.stderr.splitlines() if line.strip() and not line.startswith(("[", "Run with"))]
    warnings = [line.removeprefix("warning: ") for line in said if line.startswith("warning: ")]
    if done.returncode not in (_KEPT, _NOT_KEPT):
        reason = " ".join(line for line in said if not line.startswith("warning: "))
        raise InputError(f"'sim_host check' failed: {reason or f'it ended with {done.returncode} without a message'}.".replace("..", "."))
    return warnings
