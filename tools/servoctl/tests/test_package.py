"""The package as pip installs it: complete, and usable away from the checkout."""

from __future__ import annotations

import shutil
import subprocess
import sys
from pathlib import Path

from .conftest import PACKAGE


def test_pip_installs_every_module_and_the_command(tmp_path: Path) -> None:
    """Offline, so without the packages that it needs: those are this environment's."""
    source, target = tmp_path / "source", tmp_path / "target"
    shutil.copytree(PACKAGE, source, ignore=shutil.ignore_patterns("__pycache__", "build", "*.egg-info"))
    options = ["--no-index", "--no-deps", "--no-build-isolation", "--disable-pip-version-check", "--quiet"]
    subprocess.run([sys.executable, "-m", "pip", "install", *options, "--target", target, source], check=True)
    ours = {path.relative_to(PACKAGE) for path in (PACKAGE / "servoctl").rglob("*.py")}
    assert ours == {path.relative_to(target) for path in (target / "servoctl").rglob("*.py")}
    told = subprocess.run(
        [target / "bin" / "servoctl", "--help"], cwd=tmp_path, env={"PYTHONPATH": str(target)}, capture_output=True,
        text=True, check=True,
    )  # fmt: skip
    assert "faults" in told.stdout
