# SPDX-License-Identifier: Apache-2.0
"""Output of ./tools/demo without a terminal: what is under way is said while it lasts, and a failed build ends it."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]

# The real Ninja: its output to a pipe waits in the C library's buffer, unless stdbuf makes it line-buffered. On a fresh
# clone its first step has the number 0.
NINJA = """\
#!/usr/bin/env python3
import os, shutil, sys, time
if "--build" not in sys.argv:
    sys.exit(0)
by_line = os.environ.get("_STDBUF_O") == "L"
sys.stdout.write("[0/2] Re-checking globbed directories...\\n")
for step in range(1, 21):
    sys.stdout.write(f"[{step}/20] Building CXX object a{step}.o\\n")
    if by_line:
        sys.stdout.flush()
    time.sleep(1 if step == 20 else 0.02)
shutil.copy(os.environ["DEMO_OUTPUT"], os.environ["DEMO_OUTPUT"] + ".while_building")
sys.exit(int(os.environ.get("BUILD_FAILS", "0")))
"""


@pytest.fixture
def demo(tmp_path: Path) -> Path:
    """A copy of the demo whose tools are stand-ins that take no time."""
    (tmp_path / "tools").mkdir()
    shutil.copy(ROOT / "tools/demo", tmp_path / "tools/demo")
    shutil.copytree(ROOT / "tools/lib", tmp_path / "tools/lib")
    stand_ins = {
        "tools/setup": "#!/bin/bash\n",
        "bin/cmake": NINJA,
        "build/host/bin/sim_host": '#!/bin/bash\necho "sim_host $*"\n',
        "build/venv/bin/python": "#!/bin/bash\necho report\n",
    }
    for name, text in stand_ins.items():
        file = tmp_path / name
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(text, encoding="utf-8")
        file.chmod(0o755)
    return tmp_path


def run(demo: Path, *options: str, **more: str) -> tuple[int, str]:
    """Exit code and what the demo wrote into a file."""
    output = demo / "output.txt"
    environment = {**os.environ, "PATH": f"{demo / 'bin'}:{os.environ['PATH']}", "DEMO_OUTPUT": str(output), **more}
    with output.open("w") as stream:
        done = subprocess.run(
            [demo / "tools/demo", *options], stdout=stream, stderr=subprocess.STDOUT, env=environment, check=False, timeout=60
        )
    return done.returncode, output.read_text(encoding="utf-8")


def test_time_and_build_are_reported_while_they_last_and_all_results_are_made(demo: Path) -> None:
    code, text = run(demo, "--all")
    assert code == 0 and "\r" not in text
    assert re.match(r"On \d+ idle cores: a first build takes (\d+ to )?\d+ min, the experiments take (\d+ to )?\d+ min, ", text)
    while_building = (demo / "output.txt.while_building").read_text(encoding="utf-8")
    assert re.search(r"\[ 95 %\] 19 of 20 steps, linking; about \d+ s left\n", while_building)
    for study in ("node-tracking", "base-motion"):
        assert f"sim_host {study} --out build/results" in text


def test_a_failed_build_ends_the_demo_with_its_log(demo: Path) -> None:
    code, text = run(demo, BUILD_FAILS="1")
    assert code == 1
    assert "does not build (log: " in text and "demo-build.log)" in text
    assert "== Experiments" not in text
