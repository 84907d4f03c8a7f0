# SPDX-License-Identifier: Apache-2.0
"""The package as pip installs it: complete, and usable away from the checkout and from any build."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
import sysconfig
from pathlib import Path

import pytest

from .conftest import PACKAGE

GAIN = "azimuth.speed_loop.proportional_gain"


class Installed:
    """The command of a wheel, in a virtual environment and a folder of its own; nothing in the environment helps it."""

    def __init__(self, folder: Path, environment: Path, bus: str = "") -> None:
        self.folder = folder
        self.command = environment / "bin" / "servoctl"
        self.surroundings = {"PATH": os.environ["PATH"], "HOME": str(folder), "XDG_RUNTIME_DIR": str(folder)}
        if bus:
            self.surroundings["SERVOCTL_BUS"] = bus

    def __call__(self, *words: str) -> str:
        done = subprocess.run(
            [self.command, *words], cwd=self.folder, env=self.surroundings, text=True, capture_output=True, timeout=120
        )
        assert done.returncode == 0, (words, done.stderr)
        return done.stdout


@pytest.fixture(scope="session")
def wheel(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Built offline, with the setuptools of this environment."""
    folder = tmp_path_factory.mktemp("wheel")
    shutil.copytree(PACKAGE, folder / "source", ignore=shutil.ignore_patterns("__pycache__", "build", "*.egg-info"))
    options = ["--no-index", "--no-deps", "--no-build-isolation", "--disable-pip-version-check", "--quiet"]
    subprocess.run([sys.executable, "-m", "pip", "wheel", *options, "--wheel-dir", folder, folder / "source"], check=True)
    shutil.rmtree(folder / "source")
    (found,) = folder.glob("servoctl-*.whl")
    return found


@pytest.fixture(scope="session")
def environment(wheel: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The wheel in a clean virtual environment; the packages that it needs are those of the tests' environment."""
    folder = tmp_path_factory.mktemp("installed") / "venv"
    subprocess.run([sys.executable, "-m", "venv", folder], check=True)
    python = folder / "bin" / "python"
    options = ["--no-index", "--no-deps", "--disable-pip-version-check", "--quiet"]
    subprocess.run([python, "-m", "pip", "install", *options, wheel], check=True)
    where = subprocess.run(
        [python, "-c", "import sysconfig; print(sysconfig.get_path('purelib'))"], check=True, text=True, stdout=subprocess.PIPE
    )
    (Path(where.stdout.strip()) / "needed.pth").write_text(sysconfig.get_path("purelib") + "\n")
    return folder


def test_the_wheel_has_every_file_of_the_package(environment: Path) -> None:
    (package,) = environment.glob("lib/python*/site-packages/servoctl")
    files = {path.relative_to(PACKAGE / "servoctl") for path in (PACKAGE / "servoctl").rglob("*") if path.is_file()}
    licence = Path("ui/page/uplot/LICENSE")  # with the other licences
    ours = {path for path in files if "__pycache__" not in path.parts} - {licence}
    assert ours == {
        path.relative_to(package) for path in package.rglob("*") if path.is_file() and "__pycache__" not in path.parts
    }
    assert {Path("descriptions/parameters.json"), Path("ui/page/uplot/uPlot.esm.js"), Path("ui/page/uplot/uPlot.min.css")} <= ours
    (licences,) = package.parent.glob("servoctl-*.dist-info/licenses")
    assert (licences / "LICENSE").is_file() and (licences / "servoctl" / licence).is_file()


def test_what_needs_no_device_works_from_the_wheel_in_any_folder(environment: Path, tmp_path: Path) -> None:
    servoctl = Installed(tmp_path, environment)
    assert "N m s/rad" in servoctl("explain", GAIN)
    assert "over-speed" in servoctl("explain", "0x8481")
    assert "faults" in servoctl("--help")


@pytest.mark.real_time
def test_the_wheel_knows_the_device_without_a_build_around(environment: Path, served: str, tmp_path: Path) -> None:
    servoctl = Installed(tmp_path, environment, served)
    info = json.loads(servoctl("info", "--json"))
    assert info["schema_fits"] and info["parameters"].startswith(str(environment))
    before = json.loads(servoctl("get", GAIN, "--json"))[0]["value"]
    assert json.loads(servoctl("set", GAIN, str(before + 1), "--json"))[0]["value"] == before + 1
    assert json.loads(servoctl("undo", "--json"))[0]["value"] == before
    assert "azimuth" in servoctl("monitor", "--for", "1")
    assert "no error" in servoctl("faults") or "over-speed" in servoctl("faults")
