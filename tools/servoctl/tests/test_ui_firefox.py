# SPDX-License-Identifier: Apache-2.0
"""The page in Firefox, by its own controls: it shows samples, takes command, enables, jogs, moves and stops. What the page does
is tested in Chromium; here the other browser's engine draws it and reports keys and pointers."""

from __future__ import annotations

import json
import shutil
import subprocess
import tempfile
import time
from collections.abc import Iterator
from typing import Any

import pytest
from websockets.sync.client import ClientConnection, connect

from .conftest import Bench
from .page_bench import PATIENCE_S, Server, bench, server, servo, standing, wait_for

__all__ = ["bench", "server", "servo"]
FIREFOX = shutil.which("firefox-esr") or shutil.which("firefox") or "/usr/bin/firefox-esr"
LISTENS = "WebDriver BiDi listening on "
FEWEST_SAMPLES = 500
MOVED_DEG = 1.0
ESCAPE = "\ue00c"


class Firefox:
    """A tab, driven by WebDriver BiDi (a W3C draft), which Firefox speaks without a driver."""

    def __init__(self, socket: ClientConnection) -> None:
        self._socket = socket
        self._number = 0
        self._ask("session.new", capabilities={})
        self._page = str(self._ask("browsingContext.getTree")["contexts"][0]["context"])

    def _ask(self, method: str, **params: Any) -> dict[str, Any]:
        self._number += 1
        self._socket.send(json.dumps({"id": self._number, "method": method, "params": params}))
        while (answer := json.loads(self._socket.recv(PATIENCE_S))).get("id") != self._number:
            pass
        assert answer["type"] == "success", answer
        result: dict[str, Any] = answer["result"]
        return result

    def open(self, link: str) -> None:
        self._ask("browsingContext.navigate", context=self._page, url=link, wait="complete")

    def read(self, expression: str) -> Any:
        """Its value, by way of JSON."""
        found = self._ask("script.evaluate", expression=f"JSON.stringify({expression})", target={"context": self._page}, awaitPromise=True)
        assert found["type"] == "success", found
        return json.loads(found["result"].get("value", "null"))

    def text(self, selector: str) -> str:
        """Of an element."""
        return str(self.read(f"document.querySelector({json.dumps(selector)}).textContent"))

    def point(self, selector: str, *actions: str) -> None:
        """At the middle of an element: "down", "up", or both."""
        element = self._ask("browsingContext.locateNodes", context=self._page, locator={"type": "css", "value": selector})["nodes"][0]
        origin = {"type": "element", "element": {"sharedId": element["sharedId"]}}
        self.read(f"document.querySelector({json.dumps(selector)}).scrollIntoView({{ block: 'center' }}) ?? null")
        steps = [{"type": "pointerMove", "x": 0, "y": 0, "origin": origin}]
        self._act("pointer", steps + [{"type": {"down": "pointerDown", "up": "pointerUp"}[each], "button": 0} for each in actions])

    def press(self, selector: str) -> None:
        """A click, when the element is enabled."""
        wait_for(lambda: not self.read(f"document.querySelector({json.dumps(selector)}).disabled"), f"{selector} is enabled")
        self.point(selector, "down", "up")

    def key(self, value: str) -> None:
        """Down and up."""
        self._act("key", [{"type": kind, "value": value} for kind in ("keyDown", "keyUp")])

    def _act(self, kind: str, actions: list[dict[str, Any]]) -> None:
        self._ask("input.performActions", context=self._page, actions=[{"type": kind, "id": kind, "actions": actions}])


@pytest.fixture
def firefox() -> Iterator[Firefox]:
    """Headless, with a profile of its own."""
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as profile:
        command = [FIREFOX, "--headless", "--no-remote", "--profile", profile, "--remote-debugging-port", "0", "about:blank"]
        process = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
        assert process.stderr is not None
        try:
            said = next((line for line in process.stderr if line.startswith(LISTENS)), "")
            assert said, "Firefox does not listen"
            with connect(f"{said.removeprefix(LISTENS).strip()}/session", proxy=None, max_size=None) as socket:
                yield Firefox(socket)
        finally:
            process.terminate()
            process.wait(timeout=20)
            process.stderr.close()


def holds(page: Firefox, selector: str, part: str) -> None:
    """Waits until the element contains the text."""
    wait_for(lambda: part in page.text(selector), f"'{part}' in {selector}")


AZIMUTH = "article[data-axis=azimuth] "


def test_firefox_shows_commands_jogs_moves_and_stops(servo: Bench, server: Server, firefox: Firefox) -> None:
    page = firefox
    page.open(server.link)
    holds(page, "#link", "operational")
    wait_for(lambda: page.read("trackservo.plots.history?.count ?? 0") > FEWEST_SAMPLES, "samples")
    holds(page, "#who", "nobody commands")
    page.press("#command")
    holds(page, "#who", "this page commands")
    page.press(AZIMUTH + ".enable")
    holds(page, AZIMUTH + ".state", "operation enabled")

    begun = standing(servo)["position_deg"]
    page.point(AZIMUTH + ".plus", "down")
    wait_for(lambda: standing(servo)["position_deg"] - begun > MOVED_DEG, "it jogs while the button is held")
    page.point(AZIMUTH + ".plus", "up")
    wait_for(lambda: abs(standing(servo)["rate_deg_s"]) < 0.1, "it stands when the button is released")

    page.point(AZIMUTH + ".plus", "down")
    wait_for(lambda: standing(servo)["rate_deg_s"] > MOVED_DEG, "it jogs")
    page.key(ESCAPE)
    holds(page, AZIMUTH + ".state", "switch on disabled")
    frames, now = page.read("trackservo.plots.frames"), time.monotonic()
    time.sleep(2.0)
    drawn = (page.read("trackservo.plots.frames") - frames) / (time.monotonic() - now)
    print(f"Firefox draws {drawn:.0f} pictures per second")
    assert drawn > 0.0
