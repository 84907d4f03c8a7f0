# SPDX-License-Identifier: Apache-2.0
"""The steps of docs/ci, executed as GitHub, GitLab and podman would: each line runs, in order.

Environment: GATE_TREE, the tree in which they run (this one); GATE_WRAP, a command before each shell (none), for
example "chroot ROOT env HOME=/root", with GATE_SHELL_TREE, the path of the tree in that shell.
"""

from __future__ import annotations

import json
import os
import shlex
import shutil
import subprocess
from pathlib import Path
from typing import Any

import pytest
import yaml
from conftest import PROJECT

TREE = Path(os.environ.get("GATE_TREE", PROJECT))
WRAP = shlex.split(os.environ.get("GATE_WRAP", ""))
SHELL_TREE = os.environ.get("GATE_SHELL_TREE", str(TREE))
CI = PROJECT / "docs/ci"
USED = {"actions/checkout", "actions/cache/restore", "actions/cache/save", "actions/upload-artifact"}
PATIENCE_S = 3000
pytestmark = pytest.mark.xdist_group("the tree")  # they build in it


def run(script: str, environment: dict[str, str] | None = None) -> str:
    """One step: its own shell in the tree, which ends at the first failure."""
    text = f"cd {shlex.quote(SHELL_TREE)}\nset -eo pipefail\n{script}"
    command = [*WRAP, "bash", "-c", text]
    if "apt-get" in script and not WRAP and os.geteuid() != 0:
        command = ["sudo", "-n", *command]
    done = subprocess.run(
        command, capture_output=True, text=True, cwd=TREE, timeout=PATIENCE_S, env={**os.environ, **(environment or {})}
    )
    assert done.returncode == 0, f"{script}\n{done.stdout[-4000:]}\n{done.stderr[-4000:]}"
    return done.stdout


def load(name: str) -> dict[str, Any]:
    content: dict[str, Any] = yaml.safe_load((CI / name).read_text())
    return content


@pytest.fixture(autouse=True)
def no_files_of_earlier_runs() -> None:
    for name in ("gate", "gate-image", "gate-baseline"):
        shutil.rmtree(TREE / "build" / name, ignore_errors=True)


def expect_artefacts() -> None:
    for folder in ("gate", "gate-image"):
        for file in ("results.json", "report.html", "junit.xml"):
            assert (TREE / "build" / folder / file).stat().st_size > 1000, f"{folder}/{file}"
    assert (TREE / "build/gate-baseline/results.json").exists()
    image = json.loads((TREE / "build/gate-image/results.json").read_text())
    assert image["device"] == "image build/stm32g474/bin/trackservo.bin"
    assert {row["scenario"] for row in image["figures"]} == {"board_steady_speed", "board_low_speed_start", "board_sine"}


def test_the_steps_of_the_workflow_for_github_run() -> None:
    job = load("github.yml")["jobs"]["gate"]
    assert job["container"] == "debian:12"
    assert job["defaults"]["run"]["shell"] == "bash"
    for step in job["steps"]:
        assert set(step) <= {"name", "run", "uses", "with", "if"}, step
        if step.get("name") == "Check the firmware":
            check = step["run"]
            assert "\nsince " not in run(check)
        elif "run" in step:
            run(step["run"])
        else:
            assert step["uses"].rsplit("@", 1)[0] in USED
    expect_artefacts()
    uploaded = job["steps"][-1]["with"]["path"].split()
    assert all((TREE / path).is_dir() for path in uploaded)

    assert "\nsince build/gate-baseline/results.json" in run(check), "the next run is compared with the one kept"


def test_the_script_for_gitlab_runs() -> None:
    job = load("gitlab.yml")["gate"]
    assert job["image"] == "debian:12"
    run("\n".join(job["script"]), {"CI_COMMIT_BRANCH": "main", "CI_DEFAULT_BRANCH": "main"})
    expect_artefacts()
    for path in (*job["artifacts"]["paths"], *job["artifacts"]["reports"]["junit"]):
        assert (TREE / path).exists(), path


def test_the_run_lines_of_the_container_file_run() -> None:
    lines = [line for line in (CI / "Containerfile").read_text().splitlines() if line and not line.startswith("#")]
    words = [line.split(maxsplit=1) for line in lines]
    assert words[0] == ["FROM", "debian:12"]
    assert {word[0] for word in words} == {"FROM", "RUN", "WORKDIR", "COPY", "ENTRYPOINT"}
    for instruction, text in words:
        if instruction == "RUN":
            run(text)
    assert ["build"] == (PROJECT / ".dockerignore").read_text().split(), "COPY takes no build of the host's along"
