# SPDX-License-Identifier: Apache-2.0
"""The page when its server, its bus or its node is not there, or goes: each test starts servers of its own."""

from __future__ import annotations

import json
import os
import signal
import socket
from contextlib import closing
from pathlib import Path

import can
import pytest
from playwright.sync_api import Browser, Page

from servoctl.link.bus import open_bus, parse_bus
from servoctl.objects.parameter import AXES

from .conftest import PARAMETERS, SERVERS, Bench, serve
from .page_bench import (
    STANDSTILL_DEG_S,
    Link,
    angle,
    bench,
    browser,
    card,
    command_and_enable,
    jog,
    opened,
    press,
    rate,
    running,
    servo,
    standing,
    take_command,
    wait_for,
    wait_for_state,
    wait_for_text,
)
from .stream_for_minutes import Look, judge, stream

__all__ = ["bench", "browser", "servo"]
SUPERVISED_S = 1.0


@pytest.mark.image
def test_the_device_stops_by_itself_when_the_server_is_killed(servo: Bench, browser: Browser) -> None:
    """A fault of the lost heartbeat follows; the page resets it when a new server is there."""
    with running(servo) as server, opened(browser, server) as page:
        command_and_enable(page)
        jog(page)
        server.process.kill()
        wait_for_text(page.locator("#trouble"), "This page commanded, so the axes stop meanwhile.")
        assert page.locator("#link").text_content() == "no server"
        assert card(page, "azimuth").locator(".angle").text_content() == "–"  # nothing old is shown as present
        last = page.evaluate("trackservo.plots.history.lastTick")  # that the server has sent
        wait_for(lambda: standing(servo)["state"] == "fault", "at rest, in the fault")
    check_reaction(servo, "server killed", last)

    with running(servo) as again, opened(browser, again) as page:
        wait_for_state(page, "fault")
        wait_for_text(card(page, "azimuth").locator(".cause"), "Cause:")
        take_command(page)
        page.get_by_role("tab", name="Faults").click()
        wait_for_text(page.locator("#faults"), "Remedy:")
        newest = page.locator("#faults details").first
        wait_for_text(newest, "heartbeat lost")
        assert newest.locator("tbody tr").count() == len(servo.json("faults")["log"]["entries"][0]["samples"]) > FEWEST_TICKS
        newest.locator("summary").click()
        assert newest.locator("thead").is_visible() and "torque N m" in (newest.locator("thead").text_content() or "")
        reset_faults(page)


FEWEST_TICKS = 10
"""Before a fault, in its table."""


def test_stop_without_a_server_is_sent_when_it_is_there_again(servo: Bench, browser: Browser) -> None:
    """By the page of a viewer, which does not claim that the axes stop."""
    with socket.create_server(("127.0.0.1", 0)) as free:
        port = str(free.getsockname()[1])
    with running(servo, "--port", port) as server, opened(browser, server) as page:
        server.process.kill()
        wait_for_text(page.locator("#trouble"), "This page only viewed: the axes may go on.")
        page.keyboard.press("Escape")
        wait_for_text(page.locator("#trouble"), "STOP could not be sent: it is sent as soon as the connection is back.")
        server.process.wait()
        with running(servo, "--port", port):
            wait_for(lambda: any("stop: STOP on page" in each for each in events(page)), "the stop")
            assert page.locator("#trouble").is_hidden() and not page.evaluate("trackservo.connection.stopWaits")


def test_a_server_that_hangs_is_noticed_and_gets_the_stop_when_it_goes_on(servo: Bench, browser: Browser) -> None:
    """Its socket stays open, as that of a link that is cut."""
    with running(servo) as server, opened(browser, server) as page:
        os.kill(server.process.pid, signal.SIGSTOP)
        try:
            wait_for_text(page.locator("#trouble"), "The page has lost its server")
            page.keyboard.press("Escape")
            wait_for_text(page.locator("#trouble"), "STOP could not be sent")
        finally:
            os.kill(server.process.pid, signal.SIGCONT)
        wait_for(lambda: any("stop: STOP on page" in each for each in events(page)), "the stop")


def test_samples_come_again_after_a_reset_of_the_node(servo: Bench, browser: Browser) -> None:
    """Which then has its own TPDOs: the live view maps them again."""
    with running(servo) as server, opened(browser, server) as page, open_bus(parse_bus(servo.bus)) as bus:
        take_command(page)
        wait_for(lambda: page.evaluate(FRESH) > FRESH_SAMPLES, "samples come")
        bus.send(can.Message(arbitration_id=0, data=[0x82, 1], is_extended_id=False))
        press(page.locator("#start-node"))
        wait_for(lambda: any("they are mapped again" in each for each in events(page)), "silence is noticed")
        begun = page.evaluate("trackservo.plots.history.lastTick")
        wait_for(lambda: page.evaluate("trackservo.plots.history.lastTick") != begun, "samples come")


def check_reaction(servo: Bench, what: str, begun: int) -> None:
    """By the device's own supervision, from the last tick before the event to that of the fault."""
    newest = servo.json("faults")["log"]["entries"][0]
    reaction_ms = newest["tick"] - begun
    print(f"{what}: the fault '{newest['name']}' came after {reaction_ms} ms (at most {1e3 * SUPERVISED_S:.0f} ms required)")
    assert 0 < reaction_ms <= 1e3 * SUPERVISED_S


def reset_faults(page: Page) -> None:
    """Of both axes."""
    for axis in AXES:
        press(card(page, axis).get_by_role("button", name="Reset fault"))
        wait_for_state(page, "switch on disabled", axis)


@pytest.mark.parametrize("what", ["link pulled", "link mute"])
def test_a_lost_link_is_shown_as_a_gap_and_nothing_moves_when_it_is_found(servo: Bench, browser: Browser, what: str) -> None:
    with closing(Link(servo.bus)) as link, running(servo, "--bus", link.bus) as server, opened(browser, server) as page:
        command_and_enable(page)
        jog(page)
        link.mute = what == "link mute"
        if not link.mute:
            link.pull()
        wait_for_text(page.locator("#link"), "no connection")
        last = page.evaluate("trackservo.plots.history.lastTick")  # that came through the link
        wait_for(lambda: standing(servo)["state"] == "fault", "the device stops by itself")
        assert abs(standing(servo)["rate_deg_s"]) < STANDSTILL_DEG_S
        check_reaction(servo, what, last)
        page.mouse.up()
        link.mute = False
        link.plug()
        wait_for_text(page.locator("#link"), "operational")
        wait_for_state(page, "fault")
        wait_for(lambda: bool(page.evaluate("trackservo.plots.history.count > 500")), "samples come again")
        gap_s = page.evaluate(LONGEST_GAP)
        print(f"link lost and found: the plot has a gap of {gap_s:.2f} s")
        assert gap_s > 0.3
        reset_faults(page)
        assert abs(rate(page)) < STANDSTILL_DEG_S


def test_a_link_that_is_lost_for_a_moment_stops_the_axis_and_the_samples_go_on(servo: Bench, browser: Browser) -> None:
    """Found before the node misses the heartbeat: then the axis still moves, and the node is pre-operational only later."""
    with closing(Link(servo.bus)) as link, running(servo, "--bus", link.bus) as server, opened(browser, server) as page:
        command_and_enable(page)
        jog(page)
        link.pull()
        wait_for_text(page.locator("#link"), "no connection")
        page.mouse.up()
        link.plug()
        wait_for(lambda: any("the link was lost; azimuth stopped and off" in each for each in events(page)), "stopped")
        wait_for_state(page, "fault")
        wait_for(lambda: any("is operational again" in each for each in events(page)), "the node is started again")
        wait_for(lambda: page.evaluate(FRESH) > FRESH_SAMPLES, "samples come")
        reset_faults(page)
        assert abs(rate(page)) < STANDSTILL_DEG_S


def events(page: Page) -> list[str]:
    return page.locator("#events li").all_text_contents()


def test_a_link_that_is_lost_and_found_again_and_again_moves_nothing(servo: Bench, browser: Browser) -> None:
    """The plot goes on by itself each time, with a gap. The first loss switches the axis off; until then it creeps by the gyro's bias."""
    with closing(Link(servo.bus)) as link, running(servo, "--bus", link.bus) as server, opened(browser, server) as page:
        command_and_enable(page)
        wait_for(lambda: page.evaluate(FRESH) > FRESH_SAMPLES, "samples come")
        stands = []
        for _ in range(LOSSES):
            link.pull()
            wait_for_text(page.locator("#link"), "no connection")
            end_s = page.evaluate("trackservo.plots.history.end")
            link.plug()
            wait_for_text(page.locator("#link"), "operational")
            wait_for(lambda: page.evaluate("trackservo.plots.history.end") > end_s and page.evaluate(FRESH) > FRESH_SAMPLES, "samples come")
            assert page.evaluate(GAP_AFTER, end_s) > 0.1
            stands.append(angle(page))
        print(f"link lost {LOSSES} times: each is a gap in the plot; the axis stands at {min(stands)} to {max(stands)} °")
        assert max(stands) - min(stands) < MOVED_DEG
        link.pull()  # the commands know nothing of a server that has another address, and would disturb its transfers
        assert standing(servo)["state"] in ("switch on disabled", "fault")
        assert abs(standing(servo)["position_deg"] - stands[0]) < MOVED_DEG


LOSSES = 20
MOVED_DEG = 0.02
FRESH_SAMPLES = 50
FRESH = """(h => { let n = 0; while (n + 1 < h.count && h.time[h.count - 1 - n] - h.time[h.count - 2 - n] < 0.1) n++; return n; })
           (trackservo.plots.history)"""
"""Samples since the last gap."""
GAP_AFTER = """end => (h => { const n = h.time.subarray(0, h.count).indexOf(end); return n < 0 ? 0 : h.time[n + 1] - h.time[n]; })
                      (trackservo.plots.history)"""
"""From the sample at this time to the next one, s."""
LONGEST_GAP = """(h => { const t = [...h.time.subarray(0, h.count)];
                         return Math.max(...t.slice(1).map((x, i) => x - t[i])); })(trackservo.plots.history)"""


def test_one_clear_sentence_without_a_bus_and_for_a_wrong_node(servo: Bench, browser: Browser) -> None:
    for options, sentence in (
        (("--bus", "slcan-tcp:127.0.0.1:9"), "connection refused"),
        (("--node", "77"), "node 77 does not answer"),
    ):
        with running(servo, *options) as server:
            page = browser.new_context().new_page()
            page.goto(server.link)
            wait_for_text(page.locator("#trouble"), sentence)
            assert card(page, "azimuth").get_by_role("button", name="Enable").is_disabled()
            page.context.close()


def test_firmware_of_another_release_is_said_and_streams_moves_and_stops(servo: Bench, browser: Browser) -> None:
    content = json.loads(PARAMETERS.read_text(encoding="utf-8"))
    content["schema_hash"] ^= 1
    other = servo.folder / "other.json"
    other.write_text(json.dumps(content), encoding="utf-8")
    with running(servo, "--parameters", str(other)) as server, opened(browser, server) as page:
        wait_for_text(page.locator("#trouble"), f"the hash of {other} is {content['schema_hash']:08X}. Give the parameters.json")
        wait_for(lambda: page.evaluate(FRESH) > FRESH_SAMPLES, "samples come")
        press(page.locator("#gain-read"))
        wait_for_text(page.locator("#toast"), "the names of the device's objects are unknown")
        assert not page.locator("#gains tbody tr").count()
        command_and_enable(page)
        jog(page)
        page.keyboard.press("Escape")
        wait_for_state(page, "switch on disabled")


def test_a_slow_bus_has_all_signals_less_often_and_the_page_says_so(tmp_path: Path, browser: Browser) -> None:
    with serve("1", "--bit-rate", "250000", server=SERVERS["sim"]) as served, running(Bench(served.address, tmp_path), "--bitrate", "250000") as server:
        page = browser.new_context().new_page()
        page.goto(server.link)
        wait_for_text(page.locator("#link"), "pre-operational")
        take_command(page)
        press(page.locator("#start-node"))
        wait_for_text(page.locator("#stream-note"), "8 signals at 200 Hz: 1000 Hz need 1 Mbit/s, this bus has 250 kbit/s.")
        wait_for(lambda: page.evaluate(FRESH) > FRESH_SAMPLES, "samples come")
        assert page.evaluate("trackservo.plots.history.period") == 0.005
        page.context.close()


def test_the_stream_for_minutes_judges_what_it_has_measured(browser: Browser) -> None:
    """The demonstration moves an axis by itself. It runs for seconds here; how fast this computer draws does not count."""
    looks = stream(browser, 0.05)
    assert looks[-1].samples > looks[0].samples + 500 and looks[-1].frames > looks[0].frames
    assert looks[-1].server_mb > 10.0 and looks[-1].page_mb > HISTORY_MB
    good = [Look(time_s, 32 * time_s, 1000 * time_s, 0, 5.0, 80.0) for time_s in (0, 10, 60, 70)]
    assert judge(good) == []
    bad = [*good, Look(80, good[-1].frames + 200, 79900, 3, 6.0, 90.0)]
    assert [sentence.split()[0] for sentence in judge(bad)] == ["3", "79900", "20.0", "the", "the"]


HISTORY_MB = 1e-6 * 120_000 * (8 + 8 * 4)
"""Room for the times and eight signals of two minutes."""
