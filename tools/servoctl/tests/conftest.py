"""A servo in a process of its own, and servoctl in others, as users run it.

SERVOCTL_TEST_DEVICE selects the servo: `sim`, the simulator (sim_host serve), or `image`, the flashed image on the
emulated board (emulate_board). The tests are the same. SIM_HOST, EMULATE_BOARD, TARGET_IMAGE, PARAMETERS_JSON,
CANOPEN_TEST_NODE and PRINT_TEST_EDS name the built programs and files; without them those of build/host and
build/stm32g474 are used. The folder for journals is a new one in every test.
"""

from __future__ import annotations

import contextlib
import io
import json
import os
import shutil
import signal
import subprocess
import sys
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest

from servoctl.cli import main

ROOT = Path(__file__).resolve().parents[3]
PACKAGE = Path(__file__).resolve().parents[1]
BUILD = ROOT / "build" / "host"
DEVICE = os.environ.get("SERVOCTL_TEST_DEVICE", "sim")
SIM_HOST = os.environ.get("SIM_HOST", str(BUILD / "bin" / "sim_host"))
EMULATE_BOARD = os.environ.get("EMULATE_BOARD", str(BUILD / "bin" / "emulate_board"))
IMAGE = os.environ.get("TARGET_IMAGE", str(ROOT / "build" / "stm32g474" / "bin" / "trackservo.bin"))
SERVERS = {"sim": [SIM_HOST, "serve"], "image": [EMULATE_BOARD, IMAGE]}
CHROMIUM = shutil.which("chromium") or "/usr/bin/chromium"
FAST = {"sim": "8", "image": "3"}
"""Times real time, for tests that need no set-points from the computer; the pace that one core can emulate."""
SIMULATOR_ONLY = {
    "test_tune_and_bode_refuse_a_simulator_that_is_faster_than_real_time": (
        "how fast the board is emulated is up to the computer; the rule itself is tried by"
        " test_set_points_are_refused_to_a_node_that_stays_faster_than_real_time"
    ),
    "test_the_fly_by_is_held_by_the_true_error_of_the_simulator": (
        "only sim_host serve has a moving target; the image follows the frames of the tests' own camera"
    ),
    "test_the_demonstration_moves_an_axis_in_one_command": "the demonstration starts a simulator of its own, never a board",
    "test_the_stream_for_minutes_judges_what_it_has_measured": "it streams from the demonstration's simulator",
    "test_a_slow_bus_has_all_signals_less_often_and_the_page_says_so": (
        "an image without a stored bit rate starts at 1 Mbit/s; test_a_slow_bus_carries_fewer_samples_and_says_so tries the rule"
    ),
}
"""Tests that do not run on the image, with the reason; docs/emulator.md lists them too."""
PARAMETERS = Path(os.environ.get("PARAMETERS_JSON", str(BUILD / "share" / "trackservo" / "parameters.json")))
TEST_NODE = os.environ.get("CANOPEN_TEST_NODE", str(BUILD / "bin" / "canopen_test_node"))
PRINT_TEST_EDS = os.environ.get("PRINT_TEST_EDS", str(BUILD / "bin" / "print_test_eds"))


def pytest_collection_modifyitems(items: list[pytest.Function]) -> None:
    """On the image: all tests but those listed."""
    for item in items:
        reason = SIMULATOR_ONLY.get(item.originalname)
        if DEVICE == "image" and reason:
            item.add_marker(pytest.mark.skip(reason=reason))


@dataclass(frozen=True)
class Result:
    """Result of a command."""

    code: int
    out: str
    err: str

    @property
    def data(self) -> Any:
        return json.loads(self.out)


class Bench:
    """A bus address, and servoctl on it."""

    def __init__(self, bus: str, folder: Path, parameters: Path = PARAMETERS) -> None:
        self.bus = bus
        self.folder = folder
        self.environment = {
            **os.environ,
            "PYTHONPATH": str(PACKAGE),
            "SERVOCTL_BUS": bus,
            "SERVOCTL_STATE": str(folder / "state"),
            "SERVOCTL_PARAMETERS": str(parameters),
            "XDG_CACHE_HOME": str(folder / "cache"),
            "XDG_RUNTIME_DIR": str(folder),  # other tests on this computer keep their locks separate
            "COLUMNS": "160",
        }

    def command(self, *arguments: str) -> list[str]:
        return [sys.executable, "-m", "servoctl", *arguments]

    def start(self, *arguments: str) -> subprocess.Popen[str]:
        return subprocess.Popen(
            self.command(*arguments), cwd=self.folder, env=self.environment, text=True,
            stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
        )  # fmt: skip

    def __call__(self, *arguments: str, timeout: float = 120) -> Result:
        process = self.start(*arguments)
        out, err = process.communicate(timeout=timeout)
        assert "Traceback" not in err, err
        return Result(process.returncode, out, err)

    def here(self, *arguments: str) -> Result:
        """In this process, which saves starting a new one; in the same environment."""
        out, err = io.StringIO(), io.StringIO()
        heard = {number: signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM)}
        with (
            pytest.MonkeyPatch.context() as patch,
            contextlib.redirect_stdout(out),
            contextlib.redirect_stderr(err),
        ):
            patch.chdir(self.folder)
            for name in os.environ.keys() - self.environment.keys():
                patch.delenv(name)
            for name, value in self.environment.items():
                patch.setenv(name, value)
            try:
                code = main(list(arguments))
            finally:
                for number, handler in heard.items():
                    signal.signal(number, handler)
        return Result(code, out.getvalue(), err.getvalue())

    def json(self, *arguments: str) -> Any:
        ours = self.environment["PYTHONPATH"] == str(PACKAGE)
        result = (self.here if ours else self)(*arguments, "--json")
        assert result.code == 0, result.err
        return result.data

    def value(self, name: str) -> Any:
        return self.json("get", name)[0]["value"]


@contextlib.contextmanager
def serving(speed: str = "1", *options: str) -> Iterator[tuple[str, subprocess.Popen[str]]]:
    """A running servo, `speed` times real time: its address, its process."""
    if DEVICE not in SERVERS:
        pytest.exit(f"SERVOCTL_TEST_DEVICE is '{DEVICE}': give one of {', '.join(SERVERS)}.", returncode=4)
    process = subprocess.Popen(
        [*SERVERS[DEVICE], "--until-stdin-ends", "--bus", "slcan-tcp:0", "--speed", speed, *options],
        stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True,
    )  # fmt: skip
    assert process.stdout is not None and process.stdin is not None
    address, reported = (process.stdout.readline().strip() for _ in range(2))
    if reported.startswith("target: "):
        reported = process.stdout.readline().strip()
    assert reported == "ready", f"{SERVERS[DEVICE]} says: {address} {reported}"
    yield address, process
    process.stdin.close()
    process.wait(timeout=10)


@pytest.fixture(scope="session")
def served() -> Iterator[str]:
    """The address of a servo in real time."""
    with serving() as (address, process):
        yield address
    assert process.returncode == 0  # otherwise the image has violated the chip's rules


@pytest.fixture(scope="session")
def chromium() -> Iterator[Any]:
    """Headless, for all tests of the page: to start it takes longer than some of them."""
    from playwright.sync_api import sync_playwright  # only for the tests of the page

    with sync_playwright() as play:
        opened = play.chromium.launch(executable_path=CHROMIUM, args=["--no-sandbox"])
        yield opened
        opened.close()


@pytest.fixture
def servo(served: str, tmp_path: Path) -> Bench:
    """servoctl at the servo, both axes disabled and without fault."""
    bench = Bench(served, tmp_path)
    bring_to_rest(bench)
    return bench


def bring_to_rest(bench: Bench) -> None:
    """Both axes disabled and without fault, nothing staged."""
    for axis in ("azimuth", "pitch"):
        bench.here("undo", "--staged", "--axis", axis)
        state = bench.json("state", axis)["axes"][0]["state"]
        if state in ("fault", "fault reaction active"):
            bench.here("state", axis, "reset")
        elif state != "switch on disabled":
            bench.here("state", axis, "disable")


@pytest.fixture
def test_node(tmp_path: Path) -> Iterator[Bench]:
    """servoctl at the small test device of tests/canopen, node 5, which has no schema hash and no staged set."""
    description = tmp_path / "test_device.json"
    description.write_bytes(subprocess.run([PRINT_TEST_EDS, "--json"], stdout=subprocess.PIPE, check=True).stdout)
    process = subprocess.Popen([TEST_NODE, "5"], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
    assert process.stdout is not None and process.stdin is not None
    bench = Bench(process.stdout.readline().strip(), tmp_path, description)
    bench.environment["SERVOCTL_NODE"] = "5"
    yield bench
    process.stdin.close()
    process.wait(timeout=10)


@pytest.fixture
def eventually() -> Callable[[Callable[[], bool], float], None]:
    """Waits until something holds."""
    import time

    def wait(condition: Callable[[], bool], seconds: float) -> None:
        end = time.monotonic() + seconds
        while not condition():
            assert time.monotonic() < end, f"not within {seconds} s"
            time.sleep(0.1)

    return wait
