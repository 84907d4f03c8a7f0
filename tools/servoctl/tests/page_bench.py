# SPDX-License-Identifier: Apache-2.0
"""What the tests of the page share: its server, the browser, a listener on the bus, and waits for conditions.

The server and the folder of a module serve all of its tests that do not end them; the browser serves all modules. Waits
poll every 20 ms: those of Playwright double their pause up to 1 s.
"""

from __future__ import annotations

import json
import math
import os
import socket
import subprocess
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import Any
from urllib.parse import urlsplit

import can
import pytest
from playwright.sync_api import Browser, Locator, Page

from servoctl.link.bus import open_bus, parse_bus
from servoctl.link.pdo_loan import borrowed_identifiers
from servoctl.objects.parameter import AXES
from servoctl.units import RATE_COUNTS_PER_RAD_S, degrees

from .conftest import Bench, Serving, bring_to_rest

PATIENCE_S = 90.0
"""Only a failure takes so long."""
POLL_S = 0.02
IDLE = "SERVOCTL_TEST_IDLE" in os.environ
"""This computer does nothing else: the figures of the README are then required, with a servo in real time."""
STOP_S = 0.1 if IDLE else 1.0
"""From the event to the quick stop on the bus. An idle computer takes some ms, which are printed; a busy one is late. A stop
that waits for the motion or for a silent page comes later."""
PACE = "1" if IDLE else "0.5"
"""Times real time: a busy computer has twice the time for set-points, samples and heartbeats."""
STANDSTILL_DEG_S = 0.1
QUICK_STOPS = {0x201: "azimuth", 0x301: "pitch"}
"""RPDO1 and RPDO2 of node 1."""
STATES_ID = 0x181
"""TPDO1, which begins with the statusword of azimuth and is sent when that changes."""
STATE_BITS, QUICK_STOP_BITS = 0x6F, 0x07
RATES_ID = borrowed_identifiers(1)[1]
"""TPDO6 of the live view, which begins with the rate of azimuth."""


@dataclass
class Listener:
    """Quick stops on the bus, with their times by the computer's clock; and how fast azimuth was at the end of each."""

    bus: can.BusABC
    stops: list[tuple[float, str]] = field(default_factory=list)
    ends_deg_s: list[float] = field(default_factory=list)
    frames: int = 0
    end: threading.Event = field(default_factory=threading.Event)

    def run(self) -> None:
        rate_deg_s, state = math.nan, 0
        while not self.end.is_set():
            message = self.bus.recv(0.05)
            if message is None:
                continue
            self.frames += 1
            axis = QUICK_STOPS.get(message.arbitration_id)
            if axis and bytes(message.data[:2]) == b"\x02\x00":
                self.stops.append((time.time(), axis))
            elif message.arbitration_id == RATES_ID:
                rate_deg_s = degrees(int.from_bytes(message.data[:4], "little", signed=True) / RATE_COUNTS_PER_RAD_S)
            elif message.arbitration_id == STATES_ID:
                before, state = state, int.from_bytes(message.data[:2], "little") & STATE_BITS
                if before == QUICK_STOP_BITS != state:
                    self.ends_deg_s.append(rate_deg_s)

    def first_after(self, when_s: float) -> float:
        """Time until both axes had their quick stop, s."""
        end = time.monotonic() + PATIENCE_S
        while time.monotonic() < end:
            axes = {axis: seen for seen, axis in reversed(self.stops) if seen >= when_s - 0.001}
            if len(axes) == len(AXES):
                return max(axes.values()) - when_s
            time.sleep(0.005)
        raise AssertionError(f"no quick stop on the bus after the event; seen: {self.stops}")


@pytest.fixture(scope="module")
def bench(serving: Serving, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Bench]:
    """At a servo of the module, in one folder: commands and the page's server take turns on the SDO channel by
    its locks."""
    with serving(PACE) as served:
        yield Bench(served.address, tmp_path_factory.mktemp("page"))
    assert served.process.returncode == 0


@pytest.fixture
def servo(bench: Bench) -> Bench:
    """Both axes disabled and without fault."""
    bring_to_rest(bench)
    return bench


@contextmanager
def listening(bus: str) -> Iterator[Listener]:
    """Within a `with` block."""
    found = Listener(open_bus(parse_bus(bus)))
    thread = threading.Thread(target=found.run)
    thread.start()
    yield found
    found.end.set()
    thread.join()
    found.bus.shutdown()


@pytest.fixture
def listener(bench: Bench) -> Iterator[Listener]:
    """From the beginning of the test."""
    with listening(bench.bus) as found:
        yield found


@dataclass
class Server:
    """`servoctl ui` in a process of its own."""

    process: subprocess.Popen[str]
    link: str


PATIENT_S = 60.0
"""A page may be silent for longer than a busy computer keeps a browser waiting: test_page_orders.py tries pages that are silent.
So no stop of these tests comes from silence."""


def _patient(silent_s: float) -> tuple[str, str]:
    """servoctl, whose page may be silent for so long."""
    return "-c", (
        "import sys; from servoctl import cli; from servoctl.ui import engine\n"
        f"engine.COMMANDER_SILENT_S = engine.JOG_SILENT_S = {silent_s}; sys.exit(cli.main(sys.argv[1:]))"
    )


@contextmanager
def running(servo: Bench, *options: str, silent_s: float = PATIENT_S) -> Iterator[Server]:
    """Started with the node operational, and ended with SIGTERM unless it was killed."""
    if "--demo" not in options:
        with open_bus(parse_bus(servo.bus)) as bus:
            bus.send(can.Message(arbitration_id=0, data=[0x01, 1], is_extended_id=False))
    process = servo.start("ui", "--no-browser", "--port", "0", "--json", *options, program=_patient(silent_s))
    assert process.stdout is not None and process.stderr is not None
    text = ""
    while "}" not in text:
        line = process.stdout.readline()
        assert line, process.stderr.read()
        text += line
    try:
        yield Server(process, json.loads(text)["link"])
    finally:
        process.terminate()
        try:
            process.wait(timeout=20)
        except subprocess.TimeoutExpired:
            process.kill()
            raise
        error = process.stderr.read()
        process.stdout.close()
        process.stderr.close()
        assert "Traceback" not in error, error


@pytest.fixture(scope="module")
def server(bench: Bench) -> Iterator[Server]:
    """For all tests that do not end it."""
    bring_to_rest(bench)
    with running(bench) as started:
        yield started


@pytest.fixture(scope="module")
def browser(chromium: Browser) -> Browser:
    """Each page has a context of its own."""
    return chromium


DRAW_RARELY = "window.requestAnimationFrame = draw => setTimeout(() => draw(performance.now()), 200)"
"""Without a graphics card each picture of the plots takes some 40 ms, so that they would keep every core busy."""


@contextmanager
def opened(browser: Browser, server: Server, draws_rarely: bool = True, **options: Any) -> Iterator[Page]:
    """A page that shows the node, in a context of its own. It needs no network: it asks nobody but its own server."""
    context = browser.new_context(**({"viewport": {"width": 1000, "height": 800}} | options))
    if draws_rarely:
        context.add_init_script(DRAW_RARELY)
    try:
        page = context.new_page()
        asked: list[str] = []
        page.on("request", lambda request: asked.append(request.url))
        page.set_default_timeout(1e3 * PATIENCE_S)
        page.goto(server.link)
        wait_for(lambda: page.locator("#link").text_content() == "operational", "the node is operational")
        yield page
        own = urlsplit(server.link).netloc
        elsewhere = [url for url in asked if urlsplit(url).netloc not in ("", own)]
        assert asked and not elsewhere, elsewhere
    except BaseException:
        if not page.is_closed():
            print(f"link: {page.locator('#link').get_attribute('title')}; events: {page.locator('#events li').all_text_contents()}")
        raise
    finally:
        context.close()


# --- waits ------------------------------------------------------------------------------------------------------------


def wait_for(condition: Callable[[], bool], what: str, seconds: float = PATIENCE_S) -> None:
    """Until it holds."""
    deadline = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < deadline, f"{what}: not within {seconds:g} s"
        time.sleep(POLL_S)


def wait_for_text(place: Locator, part: str) -> None:
    """Until the element contains it."""
    found = ""

    def holds() -> bool:
        nonlocal found
        found = place.text_content() or ""
        return part in found

    try:
        wait_for(holds, part)
    except AssertionError:
        raise AssertionError(f"'{part}' was awaited; the page shows '{found}'.") from None


def press(button: Locator) -> None:
    """Clicks when it is enabled."""
    wait_for(button.is_enabled, f"{button} is enabled")
    button.click()


# --- what a person does and reads -------------------------------------------------------------------------------------


def card(page: Page, axis: str) -> Locator:
    """That of the axis."""
    return page.locator(f"article[data-axis={axis}]")


def take_command(page: Page) -> None:
    """When the page before is gone."""
    wait_for_text(page.locator("#who"), "nobody commands")
    press(page.get_by_role("button", name="Take command"))
    wait_for_text(page.locator("#who"), "this page commands")


def command_and_enable(page: Page, axis: str = "azimuth") -> None:
    """Takes command too."""
    take_command(page)
    enable(page, axis)


def enable(page: Page, axis: str = "azimuth") -> None:
    """By the button."""
    press(card(page, axis).get_by_role("button", name="Enable"))
    wait_for_state(page, "operation enabled", axis)


def wait_for_state(page: Page, state: str, axis: str = "azimuth") -> None:
    """As the card shows it."""
    wait_for_text(card(page, axis).locator(".state"), state)


def rate(page: Page, axis: str = "azimuth") -> float:
    """As the card shows it, °/s."""
    return float((card(page, axis).locator(".rate").text_content() or "").split()[0])


def angle(page: Page, axis: str = "azimuth") -> float:
    """As the card shows it, °."""
    return float(card(page, axis).locator(".angle").text_content() or "nan")


def standing(servo: Bench, axis: str = "azimuth") -> dict[str, Any]:
    """State of an axis by the command."""
    found: dict[str, Any] = servo.json("state", axis)["axes"][0]
    return found


def jog(page: Page, axis: str = "azimuth") -> None:
    """Holds the button with the mouse until the axis moves."""
    plus = card(page, axis).locator(".plus")
    wait_for(plus.is_enabled, "the axis can be jogged")
    plus.hover()
    page.mouse.down()
    wait_for(lambda: abs(rate(page, axis)) > 1.0, "the axis jogs")


def remember(page: Page, event: str) -> None:
    """The page notes when an event came, by the event's own time: what handles it first may take some ms."""
    noted = "event => { window.seen ??= performance.timeOrigin + event.timeStamp; }"
    page.evaluate(f"window.seen = null; addEventListener('{event}', {noted}, true)")


def seen(page: Page) -> float:
    """Time of the event, s."""
    return float(page.evaluate("window.seen")) / 1e3


def check_stopped(servo: Bench, what: str, listener: Listener, when_s: float) -> None:
    """At rest by 6085, then off; the time from the event to the bus."""
    delay_s = listener.first_after(when_s)
    print(f"{what}: quick stop on the bus after {1e3 * delay_s:.0f} ms")
    assert delay_s < STOP_S
    wait_for(lambda: standing(servo)["state"] == "switch on disabled", "off")
    assert abs(standing(servo)["rate_deg_s"]) < STANDSTILL_DEG_S


class Link:
    """A cable to the servo that can be pulled: a TCP connection through this program."""

    def __init__(self, bus: str) -> None:
        _, host, port = bus.split(":")
        self._target = (host, int(port))
        self._server = socket.create_server(("127.0.0.1", 0))
        self.bus = f"slcan-tcp:127.0.0.1:{self._server.getsockname()[1]}"
        self._sockets: list[socket.socket] = []
        self.whole = True
        self.mute = False
        """All that is sent vanishes, and nobody is told."""
        threading.Thread(target=self._accept, daemon=True).start()

    def _accept(self) -> None:
        while True:
            try:
                here, _ = self._server.accept()
            except OSError:
                return
            if not self.whole:
                here.close()
                continue
            try:
                there = socket.create_connection(self._target)
            except OSError:
                here.close()
                continue
            self._sockets += [here, there]
            for each in (here, there):
                each.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
            for one, other in ((here, there), (there, here)):
                threading.Thread(target=self._copy, args=(one, other), daemon=True).start()

    def _copy(self, one: socket.socket, other: socket.socket) -> None:
        try:
            while data := one.recv(1 << 15):
                if not self.mute:
                    other.sendall(data)
        except OSError:
            pass
        for end_of_it in (one, other):
            end_of_it.close()

    def pull(self) -> None:
        self.whole = False
        for each in self._sockets:
            try:
                each.shutdown(socket.SHUT_RDWR)
            except OSError:
                pass
        self._sockets.clear()

    def plug(self) -> None:
        self.whole = True

    def close(self) -> None:
        self.pull()
        self._server.close()
