# SPDX-License-Identifier: Apache-2.0
"""Who may talk to the page's server: requests as another site, another name, or a stranger would send them."""

from __future__ import annotations

import http.client
import json
import re
import struct
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import pytest
from websockets.exceptions import ConnectionClosed, InvalidStatus
from websockets.sync.client import ClientConnection, connect

from servoctl.errors import ConnectionFailed
from servoctl.link.device import Device
from servoctl.ui.access import Access, in_link
from servoctl.ui.engine import Engine
from servoctl.ui.server import Site, listen, web_server
from servoctl.ui.viewers import QUEUE, Viewer


def test_an_answer_reaches_a_page_that_is_behind() -> None:
    viewer = Viewer(1, "slow")
    viewer.send({"reply": 7})
    for tick in range(2 * QUEUE):
        viewer.send({"state": {"tick": tick}})
    waiting = [viewer.queue.get_nowait() for _ in range(viewer.queue.qsize())]
    assert waiting[0] == '{"reply": 7}' and len(waiting) == QUEUE


def test_samples_that_a_slow_page_does_not_get_are_counted() -> None:
    page = Viewer(1, "slow")
    batch = struct.pack("<II", 25, 8) + bytes(25 * 36)
    for _ in range(QUEUE):
        page.send_samples(batch)
    assert page.dropped == 25 * QUEUE // 2  # there is room for the other half
    for _ in range(QUEUE):
        page.send({"state": {}})
    assert page.dropped == 25 * QUEUE


def no_bus() -> Device:
    raise ConnectionFailed("there is no bus in this test.")


class Server:
    """At a port of this computer, with the rules for another address if `host` is one."""

    def __init__(self, host: str, engine: Engine | None = None) -> None:
        self._opened = listen("127.0.0.1", 0)
        self.port: int = self._opened.getsockname()[1]
        self.access = Access.of(host, self.port)
        self._server = web_server(Site(engine or Engine(no_bus, "nothing")), self.access)
        self._thread = threading.Thread(target=self._server.run, kwargs={"sockets": [self._opened]})
        self._thread.start()
        while not self._server.started:
            time.sleep(0.01)

    def get(self, path: str, host: str = "", **headers: str) -> tuple[http.client.HTTPResponse, str]:
        request = http.client.HTTPConnection("127.0.0.1", self.port, timeout=10)
        request.putrequest("GET", path, skip_host=True)
        request.putheader("Host", host or f"127.0.0.1:{self.port}")
        for name, value in headers.items():
            request.putheader(name, value)
        request.endheaders()
        answer = request.getresponse()
        return answer, answer.read().decode()

    @contextmanager
    def socket(self, origin: str | None, **headers: str) -> Iterator[ClientConnection]:
        with connect(f"ws://127.0.0.1:{self.port}/ws", origin=origin, additional_headers=headers, proxy=None) as opened:  # type: ignore[arg-type]
            yield opened

    @property
    def ours(self) -> str:
        return f"http://127.0.0.1:{self.port}"

    def end(self) -> None:
        self._server.should_exit = True
        self._thread.join()
        self._opened.close()


@pytest.fixture(scope="module")
def local() -> Iterator[Server]:
    server = Server("127.0.0.1")
    yield server
    server.end()


@pytest.fixture(scope="module")
def shared() -> Iterator[Server]:
    server = Server("0.0.0.0")
    yield server
    server.end()


def received(page: ClientConnection, key: str) -> dict[str, Any]:
    while True:
        message: dict[str, Any] = json.loads(page.recv(timeout=10))
        if key in message:
            return message


def test_this_computer_needs_no_token_and_others_do() -> None:
    assert all(Access.of(host, 1).token == "" for host in ("127.0.0.1", "localhost", "::1"))
    assert all(len(Access.of(host, 1).token) >= 16 for host in ("0.0.0.0", "192.168.1.5", "tracker.local"))
    assert Access.of("0.0.0.0", 1).token != Access.of("0.0.0.0", 1).token


def test_a_browser_leaves_port_80_out_of_the_name() -> None:
    assert Access.of("127.0.0.1", 80).refusal({"host": "127.0.0.1", "origin": "http://127.0.0.1"}) is None
    assert Access.of("127.0.0.1", 80).refusal({"host": "evil.example"}) is not None
    assert Access.of("127.0.0.2", 8642).refusal({"host": "127.0.0.2:8642"}) is None


def test_a_link_names_what_can_be_reached() -> None:
    assert [in_link(host) for host in ("127.0.0.1", "tracker.local", "::1")] == ["127.0.0.1", "tracker.local", "[::1]"]
    for host in ("0.0.0.0", "::"):  # all addresses of this computer
        assert in_link(host) not in (host, f"[{host}]", "")


@pytest.mark.parametrize("host", ["evil.example", "evil.example:{}", "127.0.0.1:1", "127.0.0.1"])
def test_another_name_for_this_server_is_refused(local: Server, host: str) -> None:
    for path in ("/", "/main.js", "/?token=", "/recordings", "/recordings/a.mcap/samples"):
        answer, text = local.get(path, host.format(local.port))
        assert answer.status == 403 and "trackservo" not in text


def test_the_page_is_given_with_its_rules(local: Server) -> None:
    answer, text = local.get("/")
    assert answer.status == 200 and "trackservo" in text
    assert "default-src 'self'" in (answer.getheader("content-security-policy") or "")
    assert local.get("/", Origin="http://evil.example")[0].status == 403


def test_a_screen_reader_does_not_read_every_angle(local: Server) -> None:
    """They change ten times a second, and an output is read aloud unless it is silenced."""
    outputs = re.findall(r"<output[^>]*>", local.get("/")[1])
    assert outputs and all('aria-live="off"' in output for output in outputs), outputs


@pytest.mark.parametrize("origin", [None, "http://evil.example", "null", "https://127.0.0.1:{}", "http://127.0.0.1:80"])
def test_the_socket_refuses_another_origin_or_none(local: Server, origin: str | None) -> None:
    with pytest.raises(InvalidStatus), local.socket(origin.format(local.port) if origin else None):
        pass


def test_our_own_page_only_views_at_first(local: Server) -> None:
    with local.socket(local.ours) as page:
        assert received(page, "state")["state"]["pages"]["commander"] is None
        page.send(json.dumps({"id": 1, "do": "enable", "axis": 0}))
        assert "take command first" in received(page, "reply")["error"]


def test_a_second_page_cannot_take_command_and_reads_who_has_it(local: Server) -> None:
    with local.socket(local.ours) as first, local.socket(local.ours) as second:
        for page in (first, second):
            page.send(json.dumps({"id": 1, "do": "take"}))
            answer = received(page, "reply")
            assert ("commands since" in answer.get("error", "")) == (page is second)
        first.close()
        time.sleep(0.2)
        second.send(json.dumps({"id": 2, "do": "take"}))
        assert "error" not in received(second, "reply")


def test_an_unexpected_error_of_the_bus_thread_is_a_sentence_on_the_page_and_the_thread_goes_on() -> None:
    attempts = []

    def fail() -> Device:
        attempts.append(0)
        raise KeyError("a fault of servoctl")

    server = Server("127.0.0.1", Engine(fail, "nothing"))
    try:
        with server.socket(server.ours) as page:
            shown = ""
            while "internal error" not in shown or len(attempts) < 3:
                link = received(page, "state")["state"]["link"]
                assert not link["up"]
                shown = link["text"]
            assert shown == "internal error of servoctl: KeyError('a fault of servoctl')."
            page.send(json.dumps({"id": 1, "do": "faults"}))
            assert "no connection: internal error" in received(page, "reply")["error"]
    finally:
        server.end()


@pytest.mark.parametrize(
    "message",
    [{}, {"do": "fly"}, {"do": "jog", "axis": 7, "rate_deg_s": 1}, {"do": "jog", "axis": 0, "rate_deg_s": "nan"},
     {"do": "jog"}, {"do": "apply", "values": 3}, {"do": "plan", "axis": 0}, {"do": "enable", "axis": 0}],
)  # fmt: skip
def test_an_invalid_request_is_answered_with_a_sentence(local: Server, message: dict[str, Any]) -> None:
    with local.socket(local.ours) as page:
        page.send(json.dumps({"id": 1, "do": "take"}))
        assert "error" not in received(page, "reply")
        page.send(json.dumps({"id": 2} | message))
        assert received(page, "reply")["error"].endswith(".")


@pytest.mark.parametrize(
    "text",
    ["", "[]", "no JSON", "[" * 100000, b"\0", '{"do": "held"}', '{"do": "held", "axis": []}', '{"do": "held", "axis": 1e400}'],
)
def test_what_is_no_request_closes_its_socket_and_nothing_else(
    local: Server, capfd: pytest.CaptureFixture[str], text: str | bytes
) -> None:
    with local.socket(local.ours) as page:
        page.send(json.dumps({"id": 1, "do": "take"}))
        assert "error" not in received(page, "reply")
        page.send(text)
        with pytest.raises(ConnectionClosed):
            while True:
                page.recv(timeout=10)
    with local.socket(local.ours) as page:
        assert received(page, "state")["state"]["pages"]["commander"] is None
    assert "Traceback" not in capfd.readouterr().err


def test_another_computer_needs_the_token_for_the_page_and_for_the_socket(shared: Server) -> None:
    host = f"192.168.1.5:{shared.port}"
    assert shared.get("/", host)[0].status == 403
    assert shared.get("/?token=wrong", host)[0].status == 403
    answer, _ = shared.get(f"/?token={shared.access.token}", host)
    assert answer.status == 307 and answer.getheader("location") == "/"
    cookie = (answer.getheader("set-cookie") or "").split(";")[0]
    assert "SameSite=strict" in (answer.getheader("set-cookie") or "")
    assert shared.get("/", host, Cookie=cookie)[0].status == 200
    with pytest.raises(InvalidStatus), shared.socket(shared.ours):
        pass
    with pytest.raises(InvalidStatus), shared.socket("http://evil.example", Cookie=cookie):
        pass
    with shared.socket(shared.ours, Cookie=cookie) as page:
        assert received(page, "state")
