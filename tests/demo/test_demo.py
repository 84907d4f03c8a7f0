"""Output of ./tools/demo without a terminal: lines, without buffering, with the time left."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import threading
import time
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]

# The real Ninja: its output to a pipe waits in the C library's buffer, unless stdbuf makes it line-buffered.
NINJA = """\
#!/usr/bin/env python3
import os, sys, time
if "--build" not in sys.argv:
    print("cmake", *sys.argv[1:])  # goes to the log of the configuration
    sys.exit(0)
by_line = os.environ.get("_STDBUF_O") == "L"
sys.stdout.write("[0/2] Re-checking globbed directories...\\n")
for step in range(1, 21):
    sys.stdout.write(f"[{step}/20] Building CXX object a{step}.o\\n")
    if by_line:
        sys.stdout.flush()
    time.sleep(0.2 if step == 20 else 0.02)
sys.exit(int(os.environ.get("BUILD_FAILS", "0")))
"""

# Returns the demo's output at the start of the experiments.
SIM_HOST = """\
#!/bin/bash
if [[ $1 == experiments ]]; then cp "$DEMO_OUTPUT" "$DEMO_OUTPUT.seen"; fi
echo "sim_host $*"
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
        "build/host/bin/sim_host": SIM_HOST,
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


def test_the_first_line_says_how_long_it_will_take(demo: Path) -> None:
    code, text = run(demo)
    assert code == 0
    cores = len(os.sched_getaffinity(0))
    assert re.match(rf"On {cores} idle cores: a first build takes (\d+ to )?\d+ min, the experiments take (\d+ to )?\d+ min, ", text)


def test_a_quick_run_promises_less(demo: Path) -> None:
    def most(text: str) -> int:
        found = re.search(r"experiments take (?:\d+ to )?(\d+) min", text)
        assert found is not None
        return int(found.group(1))

    assert most(run(demo, "--quick")[1]) <= most(run(demo)[1])


def test_the_build_is_reported_in_lines_before_the_experiments_begin(demo: Path) -> None:
    code, text = run(demo)
    assert code == 0 and "\r" not in text
    seen = (demo / "output.txt.seen").read_text(encoding="utf-8")
    assert "== Build" in seen and re.search(r"\[ 67 %\] 19 of 20 steps, linking; about \d+ s left\n", seen)
    assert re.search(r"\[100 %\] built, took \d+ s\n", seen)


def test_a_line_is_written_when_its_step_ends_and_not_when_the_build_ends(demo: Path) -> None:
    texts: list[str] = []
    finished = threading.Event()

    def look() -> None:
        while not finished.is_set():
            file = demo / "output.txt"
            texts.append(file.read_text(encoding="utf-8") if file.exists() else "")
            time.sleep(0.02)

    observer = threading.Thread(target=look)
    observer.start()
    code, _ = run(demo)
    finished.set()
    observer.join()
    assert code == 0
    assert any("linking" in text and "built, took" not in text for text in texts)


def test_the_scan_of_fig_9_is_part_of_it(demo: Path) -> None:
    assert "sim_host fig9-scan --out build/results" in run(demo)[1]


def test_the_straight_passes_are_part_of_it(demo: Path) -> None:
    assert "sim_host passes --out build/results" in run(demo)[1]


def test_the_turning_base_is_part_of_it(demo: Path) -> None:
    assert "sim_host base-motion --out build/results" in run(demo)[1]


def test_all_cores_work(demo: Path) -> None:
    threads = min(64, len(os.sched_getaffinity(0)))
    assert run(demo)[1].count(f"--threads {threads}") == 5


def test_a_failed_build_ends_the_demo_with_its_log(demo: Path) -> None:
    code, text = run(demo, BUILD_FAILS="1")
    assert code == 1
    assert "does not build (log: " in text and "demo-build.log)" in text
    assert "== Experiments" not in text


def test_tests_are_configured_where_unity_is_there(demo: Path) -> None:
    def configured(**more: str) -> str:
        assert run(demo, **more)[0] == 0
        return (demo / "build/demo-configure.log").read_text(encoding="utf-8")

    (demo / "my_unity").mkdir()
    (demo / "my_unity/unity.c").write_text("", encoding="utf-8")
    assert "-DBUILD_TESTING=OFF" in configured(UNITY_DIR="")
    assert "-DBUILD_TESTING=OFF" not in configured(UNITY_DIR=str(demo / "my_unity"))


def progress(script: str, steps: str) -> str:
    """Output of the build progress for Ninja's lines, with a clock that advances by `script`."""
    library = ROOT / "tools/lib/build_progress.sh"
    done = subprocess.run(
        ["bash", "-euo", "pipefail", "-c", f'source "{library}"; {script}\nprintf "{steps}" | show_build_progress'],
        capture_output=True, text=True, check=True, timeout=20,
    )  # fmt: skip
    return done.stdout



def test_the_time_left_is_that_of_the_steps_so_far(tmp_path: Path) -> None:
    clock = f'count="{tmp_path}/clock"; echo 0 >"$count"; progress_now_s() {{ local n; n=$(<"$count"); echo $((n + 5)) >"$count"; echo "$n"; }}'
    steps = "".join(f"[{step}/100] x\\n" for step in range(1, 101))
    lines = progress(clock, steps).splitlines()
    # Five seconds per step, and a link like eight steps: every tenth second a line.
    assert lines[0] == "[  1 %] 2 of 100 steps"
    assert lines[4] == "[  9 %] 10 of 100 steps; about 8 min 10 s left"
    assert lines[-2].startswith("[ 91 %] 99 of 100 steps, linking; about 45 s left")
    assert lines[-1] == "[100 %] built, took 8 min 30 s"
    assert len(lines) > 45


def test_a_build_with_nothing_to_do_says_so() -> None:
    assert progress("true", "ninja: no work to do.\\n") == "[100 %] nothing to build\n"


@pytest.mark.parametrize(
    ("seconds", "words"), [(0, "1 s"), (7, "7 s"), (42, "40 s"), (90, "1 min 30 s"), (118, "2 min"), (200, "3 min 20 s")]
)
def test_durations_are_as_exact_as_an_estimate(seconds: int, words: str) -> None:
    library = ROOT / "tools/lib/build_progress.sh"
    said = subprocess.run(["bash", "-c", f'source "{library}"; duration_words {seconds}'], capture_output=True, text=True, check=True)
    assert said.stdout == words
