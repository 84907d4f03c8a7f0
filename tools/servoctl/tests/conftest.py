# SPDX-License-Identifier: Apache-2.0
"""A servo in a process of its own, and servoctl in others, as users run it.

SERVOCTL_TEST_DEVICE selects the servo: `sim`, the simulator (sim_host serve), or `image`, the flashed image on the
emulated board (emulate_board), with which those marked `image` run. SIM_HOST, EMULATE_BOARD, TARGET_IMAGE,
PARAMETERS_JSON, CANOPEN_TEST_NODE and PRINT_TEST_EDS name the built programs and files; without them those of build/host
and build/stm32g474 are used. The folder for journals is a new one in every test.
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
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest

from servoctl.cli import main
from servoctl.objects import schema

ROOT = Path(__file__).resolve().parents[3]
PACKAGE = Path(__file__).resolve().parents[1]
BUILD = ROOT / "build" / "host"
DEVICE = os.environ.get("SERVOCTL_TEST_DEVICE", "sim")
SIM_HOST = os.environ.get("SIM_HOST", str(BUILD / "bin" / "sim_host"))
EMULATE_BOARD = os.environ.get("EMULATE_BOARD", str(BUILD / "bin" / "emulate_board"))
IMAGE = os.environ.get("TARGET_IMAGE", str(ROOT / "build" / "stm32g474" / "bin" / "trackservo.bin"))
SERVERS = {"sim": [SIM_HOST, "serve"], "image": [EMULATE_BOARD, IMAGE]}
CHROMIUM = shutil.which("chromium") or "/usr/bin/chromium"
FAST = {"sim": "4", "image": "3"}[DEVICE] if DEVICE in SERVERS else ""
"""Times real time, for tests that need no set-points from the computer; the pace that one core can emulate."""
REAL_TIME = {"sim": "1", "image": "0.5"}[DEVICE] if DEVICE in SERVERS else ""
"""For tests that send set-points: cores that emulate boards have less time for the set-points."""
PARAMETERS = Path(os.environ.get("PARAMETERS_JSON", str(BUILD / "share" / "trackservo" / "parameters.json")))
TEST_NODE = os.environ.get("CANOPEN_TEST_NODE", str(BUILD / "bin" / "canopen_test_node"))
PRINT_TEST_EDS = os.environ.get("PRINT_TEST_EDS", str(BUILD / "bin" / "print_test_eds"))


def pytest_configure(config: pytest.Config) -> None:
    """The marks of these tests."""
    config.addinivalue_line("markers", "real_time: the servo runs in real time, because the computer sends it set-points or frames")
    config.addinivalue_line("markers", "alone: measures a time to milliseconds, with no test beside it")
    config.addinivalue_line("markers", "image: at the image too: a row of each function of the client that talks to the node")
    config.addinivalue_line("markers", "smoke: one of the few tests that see the most, for './tools/test clients'; the gate has none")
    config.addinivalue_line("markers", "smoke_image: of these, one for each client, which './tools/test clients' runs with the image")
    if DEVICE not in SERVERS:
        pytest.exit(f"SERVOCTL_TEST_DEVICE is '{DEVICE}': give one of {', '.join(SERVERS)}.", returncode=4)


@pytest.hookimpl(tryfirst=True)  # before xdist reads the groups
def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Function]) -> None:
    """At the image: those that are marked so; variants of a function see the same at the simulator. With --dist loadgroup all
    tests with a browser run one after the other, and begin first: they share it, and its server."""
    with_browser = [item for item in items if {"chromium", "firefox"} & set(item.fixturenames)]
    for item in with_browser:
        item.add_marker(pytest.mark.xdist_group("browser"))
    items.sort(key=lambda item: item not in with_browser)
    if DEVICE != "image":
        return
    chosen = [item for item in items if item.get_closest_marker("image")]
    config.hook.pytest_deselected(items=[item for item in items if item not in chosen])
    items[:] = chosen


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

    def command(self, *arguments: str, program: Sequence[str] = ("-m", "servoctl")) -> list[str]:
        return [sys.executable, *program, *arguments]

    def start(self, *arguments: str, program: Sequence[str] = ("-m", "servoctl")) -> subprocess.Popen[str]:
        return subprocess.Popen(
            self.command(*arguments, program=program), cwd=self.folder, env=self.environment, text=True,
            stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
        )  # fmt: skip

    def __call__(self, *arguments: str) -> Result:
        """In this process, which saves starting a new one, unless another copy of servoctl is meant."""
        if self.environment["PYTHONPATH"] != str(PACKAGE):
            process = self.start(*arguments)
            out, err = process.communicate(timeout=120)
            result = Result(process.returncode, out, err)
        else:
            result = self._here(*arguments)
        assert "Traceback" not in result.err and "internal error" not in result.err, result.err
        return result

    def _here(self, *arguments: str) -> Result:
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
        result = self(*arguments, "--json")
        assert result.code == 0, result.err
        return result.data

    def value(self, name: str) -> Any:
        return self.json("get", name)[0]["value"]


class Served:
    """A running servo. While it is paused, its time stands still and the computer is free for others."""

    def __init__(self, address: str, process: subprocess.Popen[str]) -> None:
        self.address = address
        self.process = process

    @contextlib.contextmanager
    def resumed(self) -> Iterator[str]:
        """Within a `with` block it runs; its address."""
        self.process.send_signal(signal.SIGCONT)
        try:
            yield self.address
        finally:
            self.pause()

    def pause(self) -> None:
        """Until somebody resumes it."""
        self.process.send_signal(signal.SIGSTOP)


@contextlib.contextmanager
def serve(speed: str = "1", *options: str, server: Sequence[str] = ()) -> Iterator[Served]:
    """A running servo, `speed` times real time."""
    command = [*(server or SERVERS[DEVICE]), "--until-stdin-ends", "--bus", "slcan-tcp:0", "--speed", speed, *options]
    process = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
    assert process.stdout is not None and process.stdin is not None
    address, reported = (process.stdout.readline().strip() for _ in range(2))
    if reported.startswith("target: "):
        reported = process.stdout.readline().strip()
    assert reported == "ready", f"{command} says: {address} {reported}"
    yield Served(address, process)
    process.send_signal(signal.SIGCONT)
    process.stdin.close()
    process.wait(timeout=10)
    process.stdout.close()


Serving = Callable[..., contextlib.AbstractContextManager[Served]]


@pytest.fixture(scope="session")
def serving() -> Serving:
    """Starts servos."""
    return serve


def shared(speed: str) -> Iterator[Served]:
    """Paused while no test uses it."""
    with serve(speed) as served:
        served.pause()
        yield served
    assert served.process.returncode == 0  # otherwise the image has violated the chip's rules


@pytest.fixture(scope="session")
def served_fast(serving: Serving) -> Iterator[Served]:
    """A servo that is FAST."""
    yield from shared(FAST)


@pytest.fixture(scope="session")
def served_in_real_time(serving: Serving) -> Iterator[Served]:
    """Another one."""
    yield from shared(REAL_TIME)


@pytest.fixture
def served(request: pytest.FixtureRequest, serving: Serving) -> Iterator[str]:
    """The address of a servo, which is FAST unless the test is marked real_time."""
    name = "served_in_real_time" if request.node.get_closest_marker("real_time") else "served_fast"
    chosen: Served = request.getfixturevalue(name)
    with chosen.resumed() as address:
        yield address


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
        bench("undo", "--staged", "--axis", axis)
    for axis, state in ((each["axis"], each["state"]) for each in bench.json("state")["axes"]):
        if state in ("fault", "fault reaction active"):
            bench("state", axis, "reset")
        elif state != "switch on disabled":
            bench("state", axis, "disable")


@pytest.fixture
def elsewhere(servo: Bench, monkeypatch: pytest.MonkeyPatch) -> Bench:
    """servoctl away from any build, released for firmware of another schema hash, with nothing that names a table."""
    shutil.rmtree(servo.folder / "cache", ignore_errors=True)
    folder = Path(shutil.copytree(schema.CARRIED.parent, servo.folder / "descriptions"))
    carried = folder / "parameters.json"
    content = json.loads(carried.read_text())
    content["schema_hash"] ^= 2
    carried.write_text(json.dumps(content))
    monkeypatch.setattr(schema, "CARRIED", carried)
    monkeypatch.setattr(schema, "starts", lambda: (servo.folder, folder))
    del servo.environment["SERVOCTL_PARAMETERS"]
    return servo


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
    process.stdout.close()


Eventually = Callable[[Callable[[], bool], float], None]


@pytest.fixture
def eventually() -> Eventually:
    """Waits until something holds."""

    def wait(condition: Callable[[], bool], seconds: float) -> None:
        end = time.monotonic() + seconds
        while not condition():
            assert time.monotonic() < end, f"not within {seconds} s"
            time.sleep(0.02)

    return wait
