# SPDX-License-Identifier: Apache-2.0
"""Orders that wait for their turn, and pages that fall silent: a server in this process, and pages that are only sockets."""

from __future__ import annotations

import base64
import contextlib
import errno
import json
import math
import os
import socket
import threading
import time
from collections.abc import Iterator
from contextlib import closing, contextmanager
from pathlib import Path
from typing import Any

import can
import pytest
from websockets.sync.client import ClientConnection, connect
from websockets.typing import Origin

from servoctl.drive.drive import Drive
from servoctl.errors import ConnectionFailed, MotionError
from servoctl.gains import tuning
from servoctl.identify.identification import Identification
from servoctl.link.bus import open_bus, parse_bus
from servoctl.link.device import Device
from servoctl.link.signal_stream import SignalStream
from servoctl.link.stop_frames import StopFrames
from servoctl.objects.parameter import Parameter, Value
from servoctl.ui import engine
from servoctl.ui.access import Access
from servoctl.ui.engine import Engine
from servoctl.ui.held_axis import HeldAxis
from servoctl.ui.jobs import Jobs
from servoctl.ui.server import MOST_READINGS, Site, listen, web_server

from .conftest import Bench
from .page_bench import STANDSTILL_DEG_S, STOP_S, Link, check_stopped, listening, standing, wait_for

pytestmark = pytest.mark.real_time
SLOW_S = 1.0
"""Of a job that others wait for."""
AFTERWARDS_S = 0.5
"""So long nothing may happen after a stop."""
SILENT_S = 1.0
LONGER_S = 2.0
OFF = "switch on disabled"
ENABLED = "operation enabled"
REFUSED_S = 8.0
"""Two attempts of 2 s to reach the node at most."""


class Socket:
    """What a page says and hears, without a browser; it says that it is there only if `beats`."""

    def __init__(self, opened: ClientConnection) -> None:
        self._opened = opened
        self._number = 0
        self._replies: dict[int, dict[str, Any]] = {}
        self.beats = True
        self.events: list[str] = []
        for loop in (self._hear, self._beat):
            threading.Thread(target=loop, daemon=True).start()

    def _hear(self) -> None:
        with contextlib.suppress(Exception):
            for text in self._opened:
                message = json.loads(text) if isinstance(text, str) else {}
                self.events += [event["text"] for event in message.get("events", ())]
                if "reply" in message:
                    self._replies[message["reply"]] = message

    def _beat(self) -> None:
        with contextlib.suppress(Exception):
            while True:
                if self.beats:
                    self._opened.send(json.dumps({"do": "beat"}))
                time.sleep(0.1)

    def send(self, what: str, **values: Any) -> int:
        """A request; its number."""
        self._number += 1
        self._opened.send(json.dumps({"id": self._number, "do": what} | values))
        return self._number

    def answer(self, number: int) -> dict[str, Any]:
        """To a request."""
        wait_for(lambda: number in self._replies, f"an answer to request {number}")
        return self._replies[number]

    def ask(self, what: str, **values: Any) -> Any:
        """A request that must be granted."""
        answer = self.answer(self.send(what, **values))
        assert "error" not in answer, answer
        return answer["result"]

    def crash(self) -> None:
        """As a tab that crashes: without a word."""
        self._opened.socket.shutdown(socket.SHUT_RDWR)


class Server:
    """The page's server at a servo."""

    def __init__(self, bus: str) -> None:
        self.engine = Engine(lambda: Device(parse_bus(bus), 1), "the servo")
        self._opened = listen("127.0.0.1", 0)
        self._address = f"127.0.0.1:{self._opened.getsockname()[1]}"
        access = Access.of("127.0.0.1", self._opened.getsockname()[1])
        self._server = web_server(Site(self.engine, None), access)
        self._thread = threading.Thread(target=self._server.run, kwargs={"sockets": [self._opened]})
        self._thread.start()
        wait_for(lambda: bool(self.engine.state()["link"]["up"] and self.engine.state()["axes"]), "the node")

    @contextmanager
    def page(self, commands: bool = True) -> Iterator[Socket]:
        """One that commands, or views."""
        with connect(f"ws://{self._address}/ws", origin=Origin(f"http://{self._address}"), proxy=None) as opened:
            page = Socket(opened)
            if commands:
                page.ask("take")
            yield page

    def be_slow(self) -> threading.Event:
        """A job that takes SLOW_S after the event, which the caller sets, and runs already."""
        begun, go = threading.Event(), threading.Event()

        def job(_jobs: Jobs) -> None:
            begun.set()
            go.wait(30.0)
            time.sleep(SLOW_S)

        self.engine.submit(job)
        assert begun.wait(30.0)
        return go

    def states(self) -> list[str]:
        """Of the axes, read now."""
        return [str(axis["state"]) for axis in self.engine.submit(lambda _jobs: self.engine.state()["axes"]).result(30.0)]

    def axis(self) -> dict[str, Any]:
        """Azimuth, as the page shows it."""
        found: dict[str, Any] = next(iter(self.engine.state()["axes"]), {"rate_deg_s": math.inf, "state": "", "doing": ""})
        return found

    def stopped(self) -> bool:
        """Somebody has stopped the axes, and this is not done yet."""
        device = self.engine._device
        return device is not None and device.stopped.is_set()

    def stays_off(self, page: Socket | None = None) -> None:
        """Both axes are off, and stay so."""
        wait_for(lambda: not self.engine.anything_held, "nothing is held")
        time.sleep(AFTERWARDS_S)
        assert self.states() == [OFF, OFF], page.events if page else ""
        assert not self.engine.anything_held

    def close(self) -> None:
        self._server.should_exit = True
        self._thread.join()
        self._opened.close()


@pytest.fixture
def server(servo: Bench, monkeypatch: pytest.MonkeyPatch) -> Iterator[Server]:
    """At the servo, both axes off."""
    surround(servo, monkeypatch)
    with closing(Server(servo.bus)) as started:
        yield started


def surround(servo: Bench, monkeypatch: pytest.MonkeyPatch) -> None:
    """The server's folders and locks are those of the commands."""
    for name, value in servo.environment.items():
        monkeypatch.setenv(name, value)


@pytest.mark.parametrize("order", [{"do": "enable", "axis": 0}, {"do": "step", "axis": 0, "amplitude_deg_s": 1.0, "hold_s": 0.3}])
def test_what_waits_when_stop_comes_is_refused(server: Server, order: dict[str, Any]) -> None:
    with server.page() as page:
        go = server.be_slow()
        ordered = page.send(order["do"], **{key: value for key, value in order.items() if key != "do"})
        page.send("stop")  # both are in one packet: neither may overtake the other
        go.set()
        error = page.answer(ordered)["error"]
        assert error == "not done: the axes were stopped before its turn came (STOP on page 1)."
        server.stays_off(page)


def test_a_running_step_is_stopped(servo: Bench, server: Server) -> None:
    with server.page() as page, listening(servo.bus) as listener:
        stepping = page.send("step", axis=0, amplitude_deg_s=1.0, hold_s=4.0)
        wait_for(lambda: abs(server.axis()["rate_deg_s"] or 0.0) > 0.5, "the card shows that the step runs")
        azimuth, pitch = server.engine.state()["axes"]
        assert azimuth["state"] == ENABLED and azimuth["doing"].startswith("is measured: step: ")
        assert pitch["rate_deg_s"] is None and pitch["doing"] == "is not read meanwhile"
        begun = time.time()
        page.send("stop")
        check_stopped(servo, "stop during a step", listener, begun)
        assert "error" in page.answer(stepping)
        server.stays_off(page)


def test_a_stop_without_a_node_is_kept_until_the_node_answers(servo: Bench, monkeypatch: pytest.MonkeyPatch) -> None:
    for name, value in servo.environment.items():
        monkeypatch.setenv(name, value)
    servo.json("state", "azimuth", "enable")
    answers: list[bool] = []

    def connect() -> Device:
        if not answers:
            raise ConnectionFailed("no node in this test.")
        return Device(parse_bus(servo.bus), 1)

    alone = Engine(connect, "the servo")
    alone.start()
    try:
        alone.stop("STOP on page 1")
        said = "STOP on page 1: there is no connection to the node; the axes are stopped as soon as there is one"
        assert [event["text"] for event in alone.events(0)] == [said]
        answers.append(True)
        wait_for(lambda: any(event["text"].startswith("stop: STOP on page 1; ") for event in alone.events(0)), "the stop")
        assert standing(servo)["state"] == OFF
    finally:
        alone.close()


def test_samples_that_were_lost_are_counted_over_all_streams(server: Server) -> None:
    with server.page() as page:
        stream = server.engine._stream
        assert isinstance(stream, SignalStream)
        before = server.engine.state()["stream"]["missing"]
        stream._gatherer.missing += LOST
        assert server.engine.state()["stream"]["missing"] >= before + LOST
        page.ask("choose", choice="pitch")
        assert server.engine._stream is not stream and server.engine.state()["stream"]["missing"] >= before + LOST


LOST = 7


def test_an_order_after_a_stop_is_carried_out_and_a_reading_before_it_too(server: Server) -> None:
    with server.page() as page:
        go = server.be_slow()
        reading = page.send("plan", axis=0, relative=True, angle_deg=1.0, rate_deg_s=1.0)
        page.send("stop")
        enabling = page.send("enable", axis=0)
        go.set()
        assert "error" not in page.answer(reading) and "error" not in page.answer(enabling)
        wait_for(lambda: server.states()[0] == ENABLED, "enabled")


def test_an_order_comes_before_the_readings_that_wait_and_a_page_has_some_of_them(server: Server) -> None:
    done: list[str] = []
    with server.page(commands=False) as viewer:
        go = server.be_slow()
        answers = [viewer.send("faults") for _ in range(MOST_READINGS + 2)]
        for asked in answers[MOST_READINGS:]:
            assert viewer.answer(asked)["error"] == f"this page waits for {MOST_READINGS} answers already: ask again when they are there."
        reading = server.engine.submit(lambda _jobs: done.append("reading"))
        order = server.engine.submit(lambda _jobs: done.append("order"), server.engine.order())
        go.set()
        for each in (reading, order):
            each.result(30.0)
        assert done == ["order", "reading"]
        for asked in answers[:MOST_READINGS]:
            assert "result" in viewer.answer(asked)
        assert viewer.ask("faults")


def test_what_waits_when_its_page_has_released_command_is_refused(server: Server) -> None:
    with server.page() as page:
        go = server.be_slow()
        ordered = page.send("enable", axis=0)
        page.send("release")
        go.set()
        assert "not done: " in page.answer(ordered)["error"]
        server.stays_off(page)


def test_an_order_whose_page_no_longer_commands_is_refused(server: Server) -> None:
    go = server.be_slow()
    commands = [True]
    future = server.engine.submit(lambda jobs: jobs.enable(0), server.engine.order(lambda: commands[0]))
    commands.clear()
    commands.append(False)
    go.set()
    assert "no longer commands" in str(future.exception(30.0))
    server.stays_off()


@pytest.mark.parametrize("when", ["before its turn", "while it runs"])
def test_a_page_that_crashes_while_it_enables_leaves_nothing_enabled(
    server: Server, monkeypatch: pytest.MonkeyPatch, when: str
) -> None:
    begun, gone = threading.Event(), threading.Event()
    enter = HeldAxis.enter

    def slow(held: HeldAxis) -> None:
        begun.set()
        assert gone.wait(30.0)
        enter(held)

    monkeypatch.setattr(HeldAxis, "enter", slow)
    with server.page() as page:
        go = server.be_slow() if when == "before its turn" else None
        page.send("enable", axis=0)
        if go is None:
            assert begun.wait(30.0)
        else:
            wait_for(lambda: server.engine.anything_held, "the order waits")
        page.crash()
        wait_for(lambda: server.engine._commander_seen_s is None, "the server knows that it is gone")
        gone.set()
        if go is not None:
            go.set()
        server.stays_off()


def test_an_unexpected_error_stops_the_axes_and_is_shown_as_a_lost_connection(
    server: Server, monkeypatch: pytest.MonkeyPatch
) -> None:
    poll = Engine._poll
    errors = [KeyError("a fault of servoctl")]

    def fail(engine: Engine, device: Device) -> None:
        if errors and engine._held:
            raise errors.pop()
        poll(engine, device)

    with server.page() as page:
        monkeypatch.setattr(Engine, "_poll", fail)
        page.ask("enable", axis=0)
        lost = "connection lost: internal error of servoctl: KeyError('a fault of servoctl')."
        wait_for(lambda: lost in page.events, "the sentence")
        wait_for(lambda: bool(server.engine.state()["link"]["up"] and server.engine.state()["axes"]), "the node again")
        server.stays_off(page)


def test_the_camera_is_given_back_when_a_lost_link_is_found(server: Server, monkeypatch: pytest.MonkeyPatch) -> None:
    poll = Engine._poll
    mapped: list[int] = []

    def fail(engine: Engine, device: Device) -> None:
        if not mapped:
            engine.map_camera(device, 0x541)
            mapped.append(device.read_int(0x1403, 1))
            raise ConnectionResetError("the adapter was pulled")
        poll(engine, device)

    def by_node(_jobs: Jobs) -> int:
        return server.engine._device.read_int(0x1403, 1)  # type: ignore[union-attr]

    before = server.engine.submit(by_node).result(30.0)
    monkeypatch.setattr(Engine, "_poll", fail)
    wait_for(lambda: mapped == [0x541], "the frames of the camera")
    wait_for(lambda: bool(server.engine.state()["link"]["up"] and server.engine.state()["axes"]), "the node again")
    assert server.engine.submit(by_node).result(30.0) == before


def test_a_stop_by_sdo_alone_is_said(server: Server, monkeypatch: pytest.MonkeyPatch) -> None:
    """A master has mapped RPDO1 for itself, and the link is lost and found."""
    poll = Engine._poll
    found: list[int] = []

    def fail(engine: Engine, device: Device) -> None:
        if not found:
            found.append(device.read_int(0x1400, 1))
            device.write_int(0x1400, 1, found[0] | 0x80000000, 4)
            raise ConnectionResetError("the adapter was pulled")
        poll(engine, device)

    with server.page() as page:
        monkeypatch.setattr(Engine, "_poll", fail)
        wait_for(lambda: any("a stop goes by SDO" in text for text in page.events), "the sentence")
    server.engine.submit(lambda jobs: jobs._device.write_int(0x1400, 1, found[0], 4)).result(30.0)


def test_a_motion_that_was_planned_for_another_place_is_refused(servo: Bench, server: Server) -> None:
    """Between the plan and the reader's "Move" the axis was moved."""
    with server.page() as page:
        page.ask("enable", axis=0)
        motion = {"axis": 0, "rate_deg_s": 5.0}
        plan = page.ask("plan", relative=True, angle_deg=2.0, **motion)
        swing(page)
        wait_for(lambda: abs((server.axis()["position_deg"] or 0.0) - plan["from_deg"]) > 1.0, "elsewhere")
        page.ask("hold", axis=0)
        here_deg = standing(servo)["position_deg"]
        for what, angle_deg in (("move", plan["target_deg"]), ("swing", 2.0)):
            refused = page.answer(page.send(what, angle_deg=angle_deg, from_deg=plan["from_deg"], **motion))["error"]
            assert refused.startswith("azimuth has moved since this was planned, from ") and refused.endswith("nothing moves; plan it again.")
        assert abs(standing(servo)["position_deg"] - here_deg) < 0.1
        again = page.ask("plan", relative=True, angle_deg=2.0, **motion)
        page.ask("move", angle_deg=again["target_deg"], from_deg=again["from_deg"], **motion)
        wait_for(lambda: abs(standing(servo)["position_deg"] - again["target_deg"]) < 0.01, "arrives")


def endless_program(monkeypatch: pytest.MonkeyPatch, folder: Path) -> Path:
    """In place of `identify`; the file to which it writes its number when it runs."""
    program, begun = folder / "identify", folder / "begun"
    program.write_text(f"#!/bin/sh\necho $$ > {begun}.new\nmv {begun}.new {begun}\nexec sleep 600\n")
    program.chmod(0o755)
    monkeypatch.setenv("TRACKSERVO_IDENTIFY", str(program))
    return begun


def test_a_program_that_computes_keeps_nobody_waiting(
    servo: Bench, server: Server, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    """A viewer's dry run whose program does not end: states stay fresh; an order and a stop leave it."""
    begun = endless_program(monkeypatch, tmp_path)
    with server.page() as page, server.page(commands=False) as viewer:
        for leaves, why in (("start_node", "the page that commands has given an order: ask again"), ("stop", "the axes were stopped")):
            asked = viewer.send("dry_run", axis=0, step="look")
            wait_for(begun.exists, "the program runs")
            number = int(begun.read_text())
            begun.unlink()
            servo.json("state", "pitch", "enable")
            wait_for(lambda: server.engine.state()["axes"][1]["state"] == ENABLED, "what another master does is shown")
            page.ask(leaves)
            assert viewer.answer(asked)["error"] == f"left, because {why}."
            wait_for(lambda number=number: not Path(f"/proc/{number}").exists(), "the program has ended")  # type: ignore[misc]
            servo.json("state", "pitch", "disable")


def test_a_fit_is_left_by_a_stop_and_leaves_no_file(server: Server, monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """Of the page that has begun it: the recording stays, and the step can be taken up again."""
    begun = endless_program(monkeypatch, tmp_path)
    monkeypatch.setenv("SERVOCTL_STATE", str(tmp_path))
    monkeypatch.setattr(Identification, "is_done", lambda *_: True)
    with server.page() as page:
        name = page.ask("begin", axis=0, low_deg=-100.0, high_deg=100.0)
        folder = tmp_path / "commissioning" / name
        files = set(folder.iterdir())
        asked = page.send("look", name=name)
        wait_for(begun.exists, "the fit runs")
        wait_for(lambda: server.engine.state()["busy"] == "fits the first look …", "the page shows it")
        page.ask("stop")
        assert page.answer(asked)["error"] == "left, because the axes were stopped."
        wait_for(lambda: not Path(f"/proc/{begun.read_text().strip()}").exists(), "the program has ended")
        assert set(folder.iterdir()) == files and server.engine.state()["busy"] == ""


def test_a_full_disk_is_a_sentence_and_the_axis_goes_on(server: Server) -> None:
    def fail(_jobs: Jobs) -> None:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    with server.page() as page:
        page.ask("enable", axis=0)
        future = server.engine.submit(fail, server.engine.order())
        assert isinstance(future.exception(30.0), OSError)
        assert server.engine.state()["link"]["up"] and server.axis()["state"] == ENABLED, page.events
        page.ask("disable", axis=0)


def test_an_axis_that_no_plan_has_named_does_not_follow(server: Server) -> None:
    with server.page() as page:
        page.ask("enable", axis=0)
        planned = {f"{plan['axis']}_from_deg": plan["here_deg"] for plan in page.ask("plan_follow")}
        page.ask("enable", axis=1)
        refused = page.answer(page.send("follow", camera_id="541", **planned))["error"]
        assert refused == "other axes are enabled than when this was planned: nothing moves; plan it again."


def test_a_choice_that_is_none_is_refused_and_the_signals_stay(server: Server) -> None:
    with server.page() as page:
        assert page.answer(page.send("choose", choice="all"))["error"] == "there is no choice of signals 'all'."
        assert server.engine.state()["stream"]["choice"] == "both" and server.states() == [OFF, OFF]


def test_a_stop_that_a_lost_link_cuts_short_is_done_when_it_is_found(
    servo: Bench, server: Server, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The axis is held by another master, whom the lost link does not stop."""
    servo.json("state", "azimuth", "enable")
    quick_stop, lost = Drive.quick_stop, ["once"]

    def fail(drive: Drive) -> None:
        if lost:
            lost.clear()
            raise ConnectionResetError("the adapter was pulled")
        quick_stop(drive)

    monkeypatch.setattr(Drive, "quick_stop", fail)
    monkeypatch.setattr(StopFrames, "send", lambda _frames: None)
    with server.page() as page:
        page.send("stop")
        wait_for(lambda: any("connection lost" in event for event in page.events), "the link is lost")
        wait_for(lambda: any("azimuth stopped and off" in event for event in page.events), "the stop")
        assert standing(servo)["state"] == OFF


def test_a_silent_node_keeps_nothing_waiting(servo: Bench, monkeypatch: pytest.MonkeyPatch) -> None:
    """Each step that ends a motion would wait for an answer, eight seconds for an axis, and so would who asks meanwhile."""
    surround(servo, monkeypatch)
    with closing(Link(servo.bus)) as link, closing(Server(link.bus)) as server, server.page() as page:
        for axis in (0, 1):
            page.ask("enable", axis=axis)
        link.mute = True
        wait_for(lambda: any("connection lost" in event for event in page.events), "the silence is noticed")
        begun = time.monotonic()
        assert "does not answer" in page.answer(page.send("reset", axis=0))["error"]
        took_s = time.monotonic() - begun
        print(f"silent node: an order was refused after {took_s:.1f} s")
        assert took_s < REFUSED_S
        link.mute = False
        wait_for(lambda: bool(server.engine.state()["link"]["up"]), "the node is found again")
        wait_for(lambda: any("the link was lost; azimuth and pitch stopped and off" in event or "nothing was enabled" in event
                             for event in page.events), "the stop")


def test_an_axis_that_does_not_come_to_rest_is_switched_off_and_said(servo: Bench, server: Server, monkeypatch: pytest.MonkeyPatch) -> None:
    """As in a limit cycle: the ramp ends, and the rate is never that of standstill."""

    def never(drive: Drive, _timeout_s: float = 0.0) -> None:
        raise MotionError(f"{drive.name} still moves.")

    with server.page() as page:
        page.ask("enable", axis=0)
        monkeypatch.setattr(Drive, "wait_for_standstill", never)
        assert page.answer(page.send("disable", axis=0))["error"] == "azimuth still moves."
        assert not any("azimuth disabled" in event for event in page.events)
        assert standing(servo)["state"] == OFF


def test_a_disable_that_a_silent_node_does_not_answer_is_an_error_and_a_stop_follows(servo: Bench, monkeypatch: pytest.MonkeyPatch) -> None:
    surround(servo, monkeypatch)
    with closing(Link(servo.bus)) as link, closing(Server(link.bus)) as server, server.page() as page:
        page.ask("enable", axis=0)
        link.mute = True
        assert "does not answer" in page.answer(page.send("disable", axis=0))["error"]
        link.mute = False
        wait_for(lambda: any("stop: the link was lost" in event for event in page.events), "the stop")
        assert not any("azimuth disabled" in event for event in page.events)


def test_the_state_tells_how_old_it_is(server: Server) -> None:
    server.be_slow().set()
    wait_for(lambda: server.engine.state()["axes_age_s"] > SLOW_S / 2, "it gets old")
    wait_for(lambda: server.engine.state()["axes_age_s"] < SLOW_S / 2, "it is read again")


def nmt(servo: Bench, command: int) -> None:
    """From another master."""
    with open_bus(parse_bus(servo.bus)) as bus:
        bus.send(can.Message(arbitration_id=0, data=[command, 1], is_extended_id=False))


def test_an_axis_that_no_frame_can_stop_any_more_is_stopped(servo: Bench, server: Server) -> None:
    """Another master makes the node pre-operational, in which it takes no PDO."""
    with server.page() as page:
        page.ask("enable", axis=0)
        swing(page)
        nmt(servo, 0x80)
        wait_for(lambda: any("the node left 'operational'" in event and "azimuth stopped and off" in event for event in page.events), "the stop")
        server.stays_off(page)


def test_a_node_that_is_stopped_is_said_and_started(servo: Bench, server: Server) -> None:
    with server.page() as page:
        nmt(servo, 0x02)
        wait_for(lambda: "node 1 is stopped by NMT" in server.engine.state()["link"]["text"], "it is said")
        page.ask("start_node")
        wait_for(lambda: bool(server.engine.state()["link"]["up"]), "it answers again")


def test_the_choice_that_is_in_force_leaves_no_hole_in_a_recording(server: Server) -> None:
    with server.page() as page:
        page.ask("start_node")
        wait_for(lambda: server.engine._stream is not None, "samples come")
        page.ask("record")
        stream = server.engine._stream
        page.ask("choose", choice="both")
        assert server.engine._stream is stream
        page.ask("end_recording")


def test_gains_are_read_again_when_another_program_has_changed_them_meanwhile(
    servo: Bench, server: Server, monkeypatch: pytest.MonkeyPatch
) -> None:
    gain = "azimuth.speed_loop.proportional_gain"
    before, staged, read = servo.value(gain), [f"{gain}=700"], Device.read

    def read_and_stage(device: Device, parameter: Parameter) -> Value:
        if staged and threading.current_thread().name == "bus":
            assert servo.start("set", staged.pop(), "--stage").wait(timeout=60) == 0
        return read(device, parameter)

    with server.page() as page:
        monkeypatch.setattr(Device, "read", read_and_stage)
        found = next(row for row in page.ask("gains", axis=0)["rows"] if row["name"] == gain)
        assert float(found["value"]) == 700.0 and found["active"] is None and found["stored"] is None
        servo("undo", "--staged", "--axis", "azimuth")
        assert servo.value(gain) == before


def test_gains_are_not_written_while_another_servoctl_writes_some(servo: Bench, server: Server, monkeypatch: pytest.MonkeyPatch) -> None:
    """What one has staged would be put into effect by the other."""
    monkeypatch.setattr(tuning, "TURN_S", 0.1)
    gain = "azimuth.speed_loop.proportional_gain"
    before = servo.value(gain)
    with server.page() as page, closing(server.engine.submit(lambda jobs: jobs._device.turns.lock("gains")).result(30.0)) as lock:
        with lock.held():
            refused = page.answer(page.send("apply", values={gain: "700"}))["error"]
            assert refused == "another servoctl is writing gains: write yours when it has finished."
        assert servo.value(gain) == before
        page.ask("apply", values={gain: "700"})
        page.ask("undo")
        assert servo.value(gain) == before


def test_a_gains_file_that_is_too_long_is_refused_and_a_wrong_one_named(server: Server) -> None:
    with server.page(commands=False) as viewer:
        for text, said in (("x = 1\n" * 20_000, "long.toml is no gains file: it has 120 kB"), ("a = 1\na = 2\n", "long.toml:2: invalid TOML")):
            content = base64.b64encode(text.encode()).decode()
            assert said in viewer.answer(viewer.send("compare", name="long.toml", base64=content))["error"]
        assert "this page only views" in viewer.answer(viewer.send("restore", name="long.toml", base64=content))["error"]
        assert "invalid request" in viewer.answer(viewer.send("plan", axis=1e400, angle_deg=1, rate_deg_s=1))["error"]


def test_a_server_that_ends_stops_no_axis_of_others(servo: Bench, monkeypatch: pytest.MonkeyPatch) -> None:
    surround(servo, monkeypatch)
    servo.json("state", "azimuth", "enable")
    with closing(Server(servo.bus)):
        pass
    assert standing(servo)["state"] == ENABLED


# --- pages that fall silent ---------------------------------------------------------------------------------------------


def test_a_page_that_stays_silent_and_orders_again_is_stopped_again(server: Server, monkeypatch: pytest.MonkeyPatch) -> None:
    """As when its timer has failed: what it orders after the first stop is supervised, too. A busy computer takes a second to
    enable an axis."""
    monkeypatch.setattr(engine, "COMMANDER_SILENT_S", 2 * LONGER_S)
    said = "stop: the page that commands is silent; azimuth stopped and off"
    with server.page() as page:
        page.beats = False
        for stops in (1, 2):
            page.ask("enable", axis=0)
            swing(page)
            wait_for(lambda stops=stops: page.events.count(said) == stops, f"stop {stops}")  # type: ignore[misc]
        server.stays_off(page)


def swing(page: Socket) -> None:
    """Azimuth moves back and forth."""
    motion = {"axis": 0, "angle_deg": 20.0, "rate_deg_s": 5.0}
    page.ask("swing", from_deg=page.ask("plan", relative=True, **motion)["from_deg"], **motion)


def test_command_is_taken_from_a_page_that_is_silent_and_from_no_other(server: Server) -> None:
    with server.page() as page, server.page(commands=False) as other:
        assert "ask there to release it" in other.answer(other.send("take"))["error"]
        page.beats = False
        wait_for(lambda: server.engine.commander_is_silent, "the page is silent")
        other.ask("take")
        assert "this page only views" in page.answer(page.send("enable", axis=0))["error"]
        other.ask("enable", axis=0)
        server.engine.stop("the test ends")


def jogging(server: Server, page: Socket) -> None:
    """Azimuth turns, and the page goes on to say that it is there, but not that the button is held."""
    page.ask("enable", axis=0)
    page.ask("jog", axis=0, rate_deg_s=5.0)


def test_a_jog_without_a_word_ends_on_its_ramp(server: Server, monkeypatch: pytest.MonkeyPatch) -> None:
    """Before the quick stop, which comes after twice as long; a busy computer is late by less than the longer time here."""
    monkeypatch.setattr(engine, "JOG_SILENT_S", LONGER_S)
    with server.page() as page:
        jogging(server, page)
        held = server.engine._held[0]
        wait_for(lambda: held.jog_seen_s is None, "the jog ends")
        wait_for(lambda: abs(server.axis()["rate_deg_s"]) < STANDSTILL_DEG_S, "stands")
        assert server.axis()["state"] == ENABLED and not any("silent" in event for event in page.events), page.events


def test_a_jog_is_stopped_at_once_when_the_bus_is_busy(server: Server) -> None:
    """The ramp waits for its turn; the quick stop does not."""
    with server.page() as page:
        jogging(server, page)
        server.be_slow().set()
        wait_for(lambda: "stop: azimuth jogged, and the page is silent; azimuth stopped and off" in page.events, "the stop")
        server.stays_off(page)


def test_a_motion_stops_when_its_page_says_nothing_for_a_second(servo: Bench, server: Server) -> None:
    """As when its computer sleeps, or its link is lost without a word: the socket stays open, and nothing comes."""
    with server.page() as page, listening(servo.bus) as listener:
        page.ask("enable", axis=0)
        swing(page)
        time.sleep(2 * SILENT_S)
        assert server.axis()["doing"], page.events  # it goes on as long as the page is there
        page.beats = False
        begun = time.time()
        silent_s = listener.first_after(begun)
        print(f"silent page: quick stop on the bus after {silent_s:.2f} s")
        assert silent_s < SILENT_S + STOP_S
        wait_for(lambda: "stop: the page that commands is silent; azimuth stopped and off" in page.events, "the stop is said")
        server.stays_off(page)
